//! Finds the views of a scan in a motion that somebody else commands.
//!
//! A scan is a run of rests in one direction with as many distinct angles as it has views. A rest that reverses the
//! direction begins a new run at the turning point. Nothing is handed out before the run is complete, so that a wrist
//! that returns to its start does not begin a scan that never ends. All decisions rest on stamps: a recording played
//! twice as fast gives the same views.

/// When a view counts.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRules {
    /// Views of a scan.
    pub view_count: usize,
    /// Motion that still counts as rest, rad.
    pub tolerance_rad: f64,
    /// Rest before a view, ns.
    pub dwell_ns: i64,
    /// Least angle between views, rad.
    pub separation_rad: f64,
}

/// A view: what was seen at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Taken<C> {
    /// Wrist angle, rad.
    pub angle_rad: f64,
    /// The cloud.
    pub cloud: C,
}

/// Follows the wrist and the clouds.
#[derive(Debug)]
pub struct Sweep<C> {
    rules: SweepRules,
    rest: Option<Rest>,
    pending: Option<(i64, C)>,
    run: Vec<Taken<C>>,
}

#[derive(Debug, Clone, Copy)]
struct Rest {
    angle_rad: f64,
    since_ns: i64,
    viewed: bool,
}

impl<C: Clone> Sweep<C> {
    /// Starts with nothing seen.
    pub fn new(rules: SweepRules) -> Self {
        Self {
            rules,
            rest: None,
            pending: None,
            run: Vec::new(),
        }
    }

    /// Forgets everything, as after a jump in time.
    pub fn reset(&mut self) {
        *self = Self::new(self.rules.clone());
    }

    /// Follows other rules from now on, and forgets what was seen by the old ones.
    pub fn obey(&mut self, rules: SweepRules) {
        if rules != self.rules {
            *self = Self::new(rules);
        }
    }

    /// Notes a cloud with the stamp of its image.
    pub fn on_cloud(&mut self, stamp_ns: i64, cloud: C) {
        let wanted = self
            .rest
            .is_some_and(|rest| !rest.viewed && stamp_ns >= rest.since_ns + self.rules.dwell_ns);
        // The first that qualifies waits for the joint state that proves the wrist was still at rest.
        if wanted && self.pending.is_none() {
            self.pending = Some((stamp_ns, cloud));
        }
    }

    /// Notes the wrist's angle; gives the views of a scan when this completes one.
    pub fn on_angle(&mut self, stamp_ns: i64, angle_rad: f64) -> Option<Vec<Taken<C>>> {
        let still = self
            .rest
            .filter(|rest| (angle_rad - rest.angle_rad).abs() <= self.rules.tolerance_rad);
        let Some(rest) = still else {
            self.rest = Some(Rest {
                angle_rad,
                since_ns: stamp_ns,
                viewed: false,
            });
            self.pending = None;
            return None;
        };
        let (_, cloud) = self.pending.take_if(|(seen_ns, _)| *seen_ns <= stamp_ns)?;
        self.rest = Some(Rest {
            viewed: true,
            ..rest
        });
        self.add(Taken {
            angle_rad: rest.angle_rad,
            cloud,
        })
    }

    fn add(&mut self, view: Taken<C>) -> Option<Vec<Taken<C>>> {
        if let Some(last) = self.run.last_mut() {
            let turn_rad = view.angle_rad - last.angle_rad;
            if turn_rad.abs() < self.rules.separation_rad {
                // The same rest again after a twitch: the newer look counts.
                *last = view;
                return None;
            }
            let first_rad = self.run[0].angle_rad;
            let last_rad = self.run[self.run.len() - 1].angle_rad;
            if self.run.len() > 1 && (last_rad - first_rad) * turn_rad < 0.0 {
                self.run.drain(..self.run.len() - 1);
            }
        }
        self.run.push(view);
        if self.run.len() < self.rules.view_count {
            return None;
        }
        // The last angle may be where the next run turns, but its cloud is of this scan.
        Some(std::mem::take(&mut self.run))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    struct Player {
        sweep: Sweep<i64>,
        now_ns: i64,
        angle_rad: f64,
        scans: Vec<Vec<f64>>,
    }

    impl Player {
        fn new() -> Self {
            let rules = SweepRules {
                view_count: 3,
                tolerance_rad: 0.01,
                dwell_ns: 250 * MS,
                separation_rad: 0.1,
            };
            Self {
                sweep: Sweep::new(rules),
                now_ns: 0,
                angle_rad: 0.0,
                scans: Vec::new(),
            }
        }

        fn tick(&mut self) {
            self.now_ns += 10 * MS;
            if self.now_ns % (30 * MS) == 0 {
                self.sweep.on_cloud(self.now_ns - 5 * MS, self.now_ns);
            }
            let wobble = if self.now_ns % (20 * MS) == 0 {
                1e-4
            } else {
                0.0
            };
            if let Some(views) = self.sweep.on_angle(self.now_ns, self.angle_rad + wobble) {
                self.scans
                    .push(views.iter().map(|view| view.angle_rad).collect());
            }
        }

        fn go(&mut self, target_rad: f64) {
            while (self.angle_rad - target_rad).abs() > 1e-9 {
                let step = (target_rad - self.angle_rad).clamp(-0.012, 0.012);
                self.angle_rad += step;
                self.tick();
            }
            (0..60).for_each(|_| self.tick());
        }
    }

    fn rounded(scans: &[Vec<f64>]) -> Vec<Vec<i32>> {
        let tenths = |angle: &f64| (angle * 10.0).round() as i32;
        scans
            .iter()
            .map(|scan| scan.iter().map(tenths).collect())
            .collect()
    }

    #[test]
    fn active_scans_are_found_again() {
        let mut player = Player::new();
        player.go(0.0);
        for _ in 0..3 {
            [-0.6, 0.0, 0.6]
                .into_iter()
                .for_each(|angle| player.go(angle));
        }
        assert_eq!(rounded(&player.scans), vec![vec![-6, 0, 6]; 3]);
    }

    #[test]
    fn nothing_is_taken_in_motion_or_too_early() {
        let mut player = Player::new();
        for i in 0..300 {
            player.angle_rad = 0.02 * f64::from(i);
            player.tick();
        }
        (0..20).for_each(|_| player.tick());
        assert!(player.scans.is_empty() && player.sweep.run.is_empty());
    }

    #[test]
    fn a_cloud_counts_only_if_the_wrist_was_still_at_rest() {
        let mut sweep = Player::new().sweep;
        sweep.on_angle(0, 0.0);
        sweep.on_angle(300 * MS, 0.0);
        sweep.on_cloud(310 * MS, 1);
        sweep.on_angle(320 * MS, 0.5);
        assert!(sweep.run.is_empty());
    }

    #[test]
    fn a_reset_does_not_mix_two_scans() {
        let mut player = Player::new();
        player.go(-0.6);
        player.go(0.0);
        player.sweep.reset();
        player.go(0.6);
        assert!(player.scans.is_empty());
        [-0.6, 0.0, 0.6]
            .into_iter()
            .for_each(|angle| player.go(angle));
        assert_eq!(rounded(&player.scans), [[-6, 0, 6]]);
    }

    #[test]
    fn other_rules_begin_anew_and_the_same_change_nothing() {
        let mut player = Player::new();
        let rules = player.sweep.rules.clone();
        player.go(-0.6);
        player.go(0.0);
        player.sweep.obey(rules.clone());
        player.go(0.6);
        player.go(0.0);
        let view_count = 2;
        player.sweep.obey(SweepRules {
            view_count,
            ..rules
        });
        player.go(0.3);
        player.go(0.6);
        assert_eq!(rounded(&player.scans), [vec![-6, 0, 6], vec![3, 6]]);
    }

    #[test]
    fn one_view_makes_a_scan_where_one_is_asked_for() {
        let mut player = Player::new();
        player.sweep.rules.view_count = 1;
        player.go(0.0);
        player.go(0.5);
        assert_eq!(rounded(&player.scans), [[0], [5]]);
    }
}
