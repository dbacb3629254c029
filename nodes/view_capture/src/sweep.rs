//! Groups the views of a wrist that somebody else turns into scans.
//!
//! A scan is a run of rests in one direction with as many distinct angles as it has views. A rest that reverses the
//! direction begins a new run at the turning point. A run is handed out from its third view on, and then view by view. A wrist
//! that only moves to the start of a scan, or back from its end, makes two rests, and so begins no scan by mistake.

use crate::rests::RestView;

/// What makes a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRules {
    /// Views of a scan.
    pub view_count: usize,
    /// Least angle between views, rad.
    pub separation_rad: f64,
}

/// A view with its place in a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanView<C> {
    /// Number of the scan; another number while views of the one before are missing: that one was given up.
    pub scan: u64,
    /// Of the view in its scan, from 0.
    pub index: usize,
    /// Views that the scan will have.
    pub count: usize,
    /// The view.
    pub view: RestView<C>,
}

/// Follows the views of all rests.
#[derive(Debug)]
pub struct Sweep<C> {
    rules: SweepRules,
    run: Vec<RestView<C>>,
    /// How many views of the run were handed out.
    handed_out: usize,
    scan: u64,
}

impl<C: Clone> Sweep<C> {
    /// Starts with nothing seen.
    pub fn new(rules: SweepRules) -> Self {
        Self {
            rules,
            run: Vec::new(),
            handed_out: 0,
            scan: 0,
        }
    }

    /// Gives the run up, as after a jump in time.
    pub fn reset(&mut self) {
        self.restart_with(Vec::new());
    }

    /// Follows other rules from now on, and gives the run up that was begun by the old ones.
    pub fn set_rules(&mut self, rules: SweepRules) {
        if rules != self.rules {
            self.rules = rules;
            self.reset();
        }
    }

    /// Takes the view of a rest; gives those that can be handed out now: none, this one, or also those before.
    pub fn add(&mut self, view: RestView<C>) -> Vec<ScanView<C>> {
        if self.is_same_place(&view) {
            // A twitch. The newer look counts, unless the older was handed out or ended a scan.
            if self.handed_out == 0
                && let Some(last) = self.run.last_mut()
            {
                *last = view;
            }
            return Vec::new();
        }
        if self.turns_back(&view) {
            let turning_point = self.run.split_off(self.run.len() - 1);
            self.restart_with(turning_point);
        }
        self.run.push(view);
        self.hand_out()
    }

    fn is_same_place(&self, view: &RestView<C>) -> bool {
        !view.moved
            || self.run.last().is_some_and(|last| {
                (view.angle_rad - last.angle_rad).abs() < self.rules.separation_rad
            })
    }

    fn turns_back(&self, view: &RestView<C>) -> bool {
        match &self.run[..] {
            [first, .., last] => {
                (last.angle_rad - first.angle_rad) * (view.angle_rad - last.angle_rad) < 0.0
            }
            _ => false,
        }
    }

    fn hand_out(&mut self) -> Vec<ScanView<C>> {
        let count = self.rules.view_count;
        if self.run.len() < count.min(3) {
            return Vec::new();
        }
        let fresh = self.run.iter().enumerate().skip(self.handed_out);
        let views = fresh
            .map(|(index, view)| ScanView {
                scan: self.scan,
                index,
                count,
                view: view.clone(),
            })
            .collect();
        self.handed_out = self.run.len();
        if self.run.len() >= count {
            self.reset();
        }
        views
    }

    fn restart_with(&mut self, run: Vec<RestView<C>>) {
        self.run = run;
        self.handed_out = 0;
        self.scan += 1;
    }
}

#[cfg(test)]
mod tests;
