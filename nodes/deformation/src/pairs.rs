//! Which object a classification is of: the two come over links of their own, in any order.

use msg::deformable_cobot::{Classification, ObjectCloud};
use msg::progress::Progress;

/// The newest of each.
#[derive(Default)]
pub struct Pairs {
    object: Option<ObjectCloud>,
    answer: Option<Classification>,
    progress: Progress,
}

impl Pairs {
    /// Notes an object; gives it with its classification where that was waiting for it.
    pub fn on_object(&mut self, object: ObjectCloud) -> Option<(ObjectCloud, Classification)> {
        self.object = Some(object);
        self.pair()
    }

    /// Notes a classification; gives it with its object where that has come.
    pub fn on_answer(&mut self, answer: Classification) -> Option<(ObjectCloud, Classification)> {
        self.answer = Some(answer);
        self.pair()
    }

    /// Each pair once, and none that is older than one before.
    fn pair(&mut self) -> Option<(ObjectCloud, Classification)> {
        let (object, answer) = (self.object.as_ref()?, self.answer.as_ref()?);
        let is_same = object.scan_id == answer.scan_id
            && object.view_count == answer.view_count
            && object.complete == answer.complete;
        let is_new = is_same
            && self
                .progress
                .advance(&object.scan_id, object.view_count, object.complete);
        is_new.then(|| (object.clone(), answer.clone()))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn object(scan_id: &str, view_count: u32) -> ObjectCloud {
        ObjectCloud {
            scan_id: scan_id.into(),
            view_count,
            ..Default::default()
        }
    }

    fn answer(scan_id: &str, view_count: u32) -> Classification {
        Classification {
            scan_id: scan_id.into(),
            view_count,
            ..Default::default()
        }
    }

    #[test]
    fn the_two_of_a_view_meet_once_in_either_order() {
        let mut pairs = Pairs::default();
        assert!(pairs.on_object(object("a", 1)).is_none());
        assert_eq!(pairs.on_answer(answer("a", 1)).unwrap().0.view_count, 1);
        assert!(pairs.on_answer(answer("a", 1)).is_none(), "said again");
        assert!(pairs.on_answer(answer("a", 2)).is_none());
        assert_eq!(pairs.on_object(object("a", 2)).unwrap().1.view_count, 2);
        assert!(pairs.on_object(object("b", 2)).is_none());
    }
}
