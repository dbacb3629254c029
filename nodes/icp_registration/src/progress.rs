//! Which view of which scan comes next.

use icp_registration::Parameters;
use msg::deformable_cobot::{RegisteredCloud, View};

use crate::scan::Scan;

/// The scan that is under way on the topic of views.
pub struct Progress {
    parameters: Parameters,
    current: Option<Current>,
}

struct Current {
    scan: Scan,
    /// Index of the view that comes next; none comes any more once the scan ended, well or not.
    next: Option<u32>,
    /// Set while all that came of a scan is one view from its middle: perhaps the latched last word of a scan that
    /// ended before this node was started.
    first_seen: Option<u32>,
}

impl Progress {
    /// Before the first scan.
    pub fn new(parameters: Parameters) -> Self {
        Self {
            parameters,
            current: None,
        }
    }

    /// Registers by these from the next scan on.
    pub fn set_parameters(&mut self, parameters: &Parameters) {
        self.parameters.clone_from(parameters);
    }

    /// Forgets the scan under way, and takes no more views of it.
    pub fn abandon(&mut self) {
        if let Some(current) = &mut self.current {
            current.next = None;
            current.first_seen = None;
        }
    }

    /// What there is to publish after a view; nothing for one that came before.
    pub fn on_view(&mut self, view: View) -> Option<RegisteredCloud> {
        let is_new = self
            .current
            .as_ref()
            .is_none_or(|current| current.scan.scan_id != view.scan_id);
        if is_new {
            let scan = Scan::new(self.parameters.clone(), view.scan_id.clone(), view.count);
            // They were checked at the start.
            let scan = scan.inspect_err(|error| log::error!("{error}")).ok()?;
            let from_the_middle = view.index > 0 && view.kind != View::FAILED;
            let first_seen = from_the_middle.then_some(view.index);
            self.current = Some(Current {
                scan,
                next: Some(0),
                first_seen,
            });
            if from_the_middle {
                log::warn!(
                    "scan {}: its beginning was missed; waiting for another scan",
                    view.scan_id
                );
                return None;
            }
        }
        self.current.as_mut()?.on_view(&view)
    }

    /// Does what waited for the answer to the latest view.
    pub fn prepare(&mut self) {
        if let Some(current) = &mut self.current {
            current.scan.prepare();
        }
    }
}

impl Current {
    fn on_view(&mut self, view: &View) -> Option<RegisteredCloud> {
        let next = self.next?;
        if view.kind == View::FAILED {
            self.scan.pass_on(view);
        } else if view.index < next || self.first_seen == Some(view.index) {
            return None;
        } else if view.index > next {
            let missing = next + 1;
            self.scan.fail(&format!(
                "view {missing} of {} never came; was this node started late?",
                view.count
            ));
        } else if view.kind == View::END {
            self.scan.close();
        } else {
            // A sweep knows only at its last view how many there were.
            self.scan.count = view.count;
            self.scan.add(view);
        }
        self.next = (!self.scan.is_complete()).then_some(next + 1);
        Some(self.scan.message())
    }
}

#[cfg(test)]
mod tests;
