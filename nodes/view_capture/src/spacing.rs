//! Which images of a sweep become views.

use crate::sweep_plan::SweepPlan;

/// Distance from the end of a sweep at which its last view is taken, rad: the wrist slows down there, and comes to rest some
/// 0.1 s later.
const END_RAD: f64 = 0.02;

/// A view's place in its sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Number of the view among those that were taken, from 0.
    pub index: u32,
    /// Whether it is the last view of its sweep.
    pub is_last: bool,
}

/// Which part of a sweep the wrist is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Leg {
    /// To the beginning of the range.
    Approach,
    /// From the beginning of the range to its end.
    Range,
}

/// Chooses which images of a sweep become views, by the wrist angle at each image's stamp. The range is divided into equal
/// intervals; the first image in each interval becomes a view, in either direction of the turn. If no image falls into an
/// interval, that view is missing, and the places of the other views stay the same.
#[derive(Debug, Clone)]
pub struct Spacing {
    plan: SweepPlan,
    leg: Leg,
    /// Bit k: the view that is k intervals from the beginning of the range was taken.
    taken_places: u64,
    taken: u32,
    is_over: bool,
}

impl Spacing {
    /// Before the first image, with the wrist at the beginning of the range.
    pub fn new(plan: &SweepPlan) -> Self {
        Self {
            plan: plan.clone(),
            leg: Leg::Range,
            taken_places: 0,
            taken: 0,
            is_over: false,
        }
    }

    /// Before the first image, with the wrist within the range, on its way to the beginning.
    pub fn from_within(plan: &SweepPlan) -> Self {
        Self {
            leg: Leg::Approach,
            ..Self::new(plan)
        }
    }

    /// The wrist has come to the beginning of the range, and goes through it from now on.
    pub fn begin_range(&mut self) {
        self.leg = Leg::Range;
    }

    /// Whether the wrist is on its way to the beginning of the range.
    pub fn is_approach(&self) -> bool {
        self.leg == Leg::Approach
    }

    /// How many views the plan has.
    pub fn planned(&self) -> u32 {
        self.plan.count
    }

    /// How many views were taken.
    pub fn taken(&self) -> u32 {
        self.taken
    }

    /// The place of an image that was taken at `angle_rad`; `None` where the image is not chosen.
    pub fn take(&mut self, angle_rad: f64) -> Option<Place> {
        let turned_rad = (angle_rad - self.plan.from_rad) * self.plan.direction();
        if self.is_over || turned_rad.is_nan() {
            return None;
        }
        let step_rad = self.plan.step_rad();
        let intervals = match self.leg {
            Leg::Approach => ((turned_rad - END_RAD) / step_rad).ceil(),
            Leg::Range => (turned_rad / step_rad).floor(),
        };
        // The last view is due in any case.
        let is_last = self.leg == Leg::Range && turned_rad >= self.plan.range_rad() - END_RAD;
        let place = 1_u64
            .checked_shl(intervals.max(0.0) as u32)
            .unwrap_or(1 << 63);
        if self.taken_places & place != 0 && !is_last {
            return None;
        }
        self.taken_places |= place;
        self.is_over = is_last;
        let index = self.taken;
        self.taken += 1;
        Some(Place { index, is_last })
    }
}

#[cfg(test)]
mod tests;
