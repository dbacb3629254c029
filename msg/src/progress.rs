//! How far a scan has come.

/// The newest message of the newest scan that a stage has heard of.
#[derive(Debug, Default)]
pub struct Progress {
    scan_id: String,
    view_count: u32,
    complete: bool,
}

impl Progress {
    /// Notes a message; `false` where it says nothing new. Latched messages come again each second, and a stage that was
    /// started again says its last ones once more.
    pub fn advance(&mut self, scan_id: &str, view_count: u32, complete: bool) -> bool {
        let is_new =
            self.scan_id != scan_id || (complete, view_count) > (self.complete, self.view_count);
        if is_new {
            *self = Self {
                scan_id: scan_id.into(),
                view_count,
                complete,
            };
        }
        is_new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_of_a_scan_counts_once() {
        let mut progress = Progress::default();
        for (view_count, complete) in [(1, false), (2, false), (3, true)] {
            assert!(progress.advance("a", view_count, complete));
            assert!(!progress.advance("a", view_count, complete));
        }
        assert!(!progress.advance("a", 2, false));
        assert!(progress.advance("b", 1, false));
    }

    #[test]
    fn an_end_without_another_view_is_news_and_the_last() {
        let mut progress = Progress::default();
        assert!(progress.advance("a", 2, false));
        assert!(progress.advance("a", 2, true));
        assert!(!progress.advance("a", 2, true));
        // A failure may come with fewer views than were there before it.
        assert!(progress.advance("b", 2, false));
        assert!(progress.advance("b", 0, true));
    }
}
