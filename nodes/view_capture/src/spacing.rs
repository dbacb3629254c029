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

/// Chooses images by the wrist's angle at their stamps: the first image of each interval of the plan. An interval without an
/// image has no view, and does not shift the others.
#[derive(Debug, Clone)]
pub struct Spacing {
    plan: SweepPlan,
    /// The next view is taken from here on, rad after the start.
    due_rad: f64,
    taken: u32,
}

impl Spacing {
    /// Before the first image.
    pub fn new(plan: &SweepPlan) -> Self {
        Self {
            plan: plan.clone(),
            // Wherever the wrist is at the beginning.
            due_rad: f64::NEG_INFINITY,
            taken: 0,
        }
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
        let is_last = turned_rad >= self.plan.range_rad() - END_RAD;
        // The last view is due in any case; a NaN is no angle.
        let is_due = turned_rad >= self.due_rad || is_last;
        if !is_due || self.due_rad == f64::INFINITY {
            return None;
        }
        let step_rad = self.plan.step_rad();
        let intervals = (turned_rad / step_rad).floor().max(0.0) + 1.0;
        self.due_rad = if is_last {
            f64::INFINITY
        } else {
            intervals * step_rad
        };
        let index = self.taken;
        self.taken += 1;
        Some(Place { index, is_last })
    }
}

#[cfg(test)]
mod tests;
