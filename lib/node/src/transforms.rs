//! The transform tree (REP 105) of /tf and /tf_static, remembered for a minute.

use nalgebra::Isometry3;
use std::collections::{HashMap, VecDeque};
use thiserror::Error;

/// How long a moving transform is remembered: longer than a scan of many views.
const MEMORY_NS: i64 = 60_000_000_000;

/// A stamp so far before the newest one belongs to another past.
const JUMP_NS: i64 = 1_000_000_000;

/// A chain of frames longer than this is a loop.
const DEPTH_MAX: usize = 100;

/// Why a transform is not known.
#[derive(Debug, Error, PartialEq)]
pub enum TransformError {
    /// The frame has never been heard of.
    #[error("TF has no frame '{0}'; is robot_state_publisher (or camera_mount) running?")]
    UnknownFrame(String),
    /// The frames are in different trees.
    #[error("TF does not connect '{target_frame}' with '{source_frame}'")]
    Disconnected {
        /// Frame wanted.
        target_frame: String,
        /// Frame given.
        source_frame: String,
    },
    /// The moment lies before what is remembered.
    #[error(
        "TF of '{frame}' begins {late_s:.3} s after the stamp; are the computers' clocks in step?"
    )]
    TooOld {
        /// Frame whose transform is missing.
        frame: String,
        /// Time from the stamp to the first sample.
        late_s: f64,
    },
    /// The moment lies after what was heard.
    #[error("TF of '{frame}' ends {early_s:.3} s before the stamp; is it still published?")]
    NotYet {
        /// Frame whose transform is missing.
        frame: String,
        /// Time from the last sample to the stamp.
        early_s: f64,
    },
}

/// Transforms by time. Frames are named without a leading slash.
#[derive(Debug, Default)]
pub struct TransformBuffer {
    frames: HashMap<String, Frame>,
}

#[derive(Debug)]
struct Frame {
    parent: String,
    fixed: bool,
    /// Ascending stamps, nanoseconds.
    samples: VecDeque<(i64, Isometry3<f64>)>,
}

impl TransformBuffer {
    /// Adds parent_from_child at a stamp; `fixed` ones hold at all times.
    pub fn insert(
        &mut self,
        parent: &str,
        child: &str,
        stamp_ns: i64,
        parent_from_child: Isometry3<f64>,
        fixed: bool,
    ) {
        let frame = self
            .frames
            .entry(bare(child).into())
            .or_insert_with(|| Frame {
                parent: String::new(),
                fixed,
                samples: VecDeque::new(),
            });
        if frame.parent != bare(parent) || frame.fixed != fixed || fixed {
            frame.samples.clear();
            frame.parent = bare(parent).into();
            frame.fixed = fixed;
        }
        frame.insert(stamp_ns, parent_from_child);
    }

    /// Forgets everything that moves. What is fixed stays: it does not depend on time.
    pub fn forget_motion(&mut self) {
        self.frames.retain(|_, frame| frame.fixed);
    }

    /// target_from_source at a moment, interpolated between the samples around it. As in tf2, only what lies between the
    /// frames and their nearest common ancestor has to be known then.
    ///
    /// # Errors
    /// Names the frame whose transform is not known at the moment.
    pub fn lookup(
        &self,
        target: &str,
        source: &str,
        stamp_ns: i64,
    ) -> Result<Isometry3<f64>, TransformError> {
        let (above_target, above_source) = (self.lineage(target)?, self.lineage(source)?);
        let common = above_source
            .iter()
            .find(|frame| above_target.contains(frame));
        let common = common.ok_or_else(|| TransformError::Disconnected {
            target_frame: bare(target).into(),
            source_frame: bare(source).into(),
        })?;
        let common_from = |lineage: &[&str]| {
            let mut below = lineage.iter().take_while(|frame| *frame != common);
            below.try_fold(Isometry3::identity(), |parent_from_start, frame| {
                let link = self.frames.get(*frame);
                let link = link.ok_or_else(|| TransformError::UnknownFrame((*frame).into()))?;
                Ok(link.at(frame, stamp_ns)? * parent_from_start)
            })
        };
        Ok(common_from(&above_target)?.inverse() * common_from(&above_source)?)
    }

    /// `frame`, its parent, and so on up to the root.
    fn lineage<'a>(&'a self, frame: &'a str) -> Result<Vec<&'a str>, TransformError> {
        let mut name = bare(frame);
        let is_known = |name: &str| {
            self.frames.contains_key(name) || self.frames.values().any(|f| f.parent == name)
        };
        if !is_known(name) {
            return Err(TransformError::UnknownFrame(name.into()));
        }
        let mut lineage = vec![name];
        while let Some(link) = self.frames.get(name) {
            name = &link.parent;
            lineage.push(name);
            if lineage.len() > DEPTH_MAX {
                let text = format!("{frame} (its parents form a loop)");
                return Err(TransformError::UnknownFrame(text));
            }
        }
        Ok(lineage)
    }
}

impl Frame {
    fn insert(&mut self, stamp_ns: i64, pose: Isometry3<f64>) {
        let newest_ns = self.samples.back().map_or(i64::MIN, |sample| sample.0);
        if stamp_ns < newest_ns.saturating_sub(JUMP_NS) {
            self.samples.clear();
        }
        let place = self.samples.partition_point(|sample| sample.0 < stamp_ns);
        match self.samples.get_mut(place) {
            Some(sample) if sample.0 == stamp_ns => sample.1 = pose,
            _ => self.samples.insert(place, (stamp_ns, pose)),
        }
        let newest_ns = self.samples.back().map_or(stamp_ns, |sample| sample.0);
        while self
            .samples
            .front()
            .is_some_and(|sample| sample.0 < newest_ns.saturating_sub(MEMORY_NS))
        {
            self.samples.pop_front();
        }
    }

    fn at(&self, name: &str, stamp_ns: i64) -> Result<Isometry3<f64>, TransformError> {
        let seconds = |ns: i64| ns as f64 * 1e-9;
        let place = self.samples.partition_point(|sample| sample.0 < stamp_ns);
        let after = self.samples.get(place);
        let before = place
            .checked_sub(1)
            .and_then(|place| self.samples.get(place));
        match (before, after) {
            (_, Some((stamp, pose))) if *stamp == stamp_ns || self.fixed => Ok(*pose),
            (Some((_, pose)), _) if self.fixed => Ok(*pose),
            (Some((t0, p0)), Some((t1, p1))) => {
                let share = stamp_ns.saturating_sub(*t0) as f64 / t1.saturating_sub(*t0) as f64;
                // Opposite rotations have no shortest way between them; the nearer sample serves.
                Ok(p0
                    .try_lerp_slerp(p1, share, 1e-9)
                    .unwrap_or(if share < 0.5 { *p0 } else { *p1 }))
            }
            (None, Some((first, _))) => Err(TransformError::TooOld {
                frame: name.into(),
                late_s: seconds(first.saturating_sub(stamp_ns)),
            }),
            (Some((last, _)), None) => Err(TransformError::NotYet {
                frame: name.into(),
                early_s: seconds(stamp_ns.saturating_sub(*last)),
            }),
            (None, None) => Err(TransformError::UnknownFrame(name.into())),
        }
    }
}

/// tf2 names have no leading slash; tf1's had.
fn bare(frame: &str) -> &str {
    frame.trim_start_matches('/')
}

#[cfg(test)]
mod tests;
