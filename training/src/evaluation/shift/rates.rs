//! Shares, and how certain they are.

use serde::{Deserialize, Serialize};

/// Counts of answers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rates {
    /// All scans.
    pub scans: u32,
    /// Those whose label is right, known or not.
    pub right: u32,
    /// Those whose label is right and known.
    pub known_right: u32,
    /// Those whose label is wrong and called known.
    pub known_wrong: u32,
    /// Those without an answer: too little was left of the object.
    pub none: u32,
}

impl Rates {
    /// Counts an answer.
    pub fn add(&mut self, is_right: bool, is_known: bool) {
        self.scans += 1;
        self.right += u32::from(is_right);
        self.known_right += u32::from(is_right && is_known);
        self.known_wrong += u32::from(!is_right && is_known);
    }

    /// Counts a scan without one.
    pub fn add_none(&mut self) {
        self.scans += 1;
        self.none += 1;
    }
}

/// A share in percent with its 95 % interval, which holds near 0 and 1 too (Wilson 1927).
pub fn interval(part: u32, whole: u32) -> String {
    let (low, high) = wilson(part, whole);
    let share = f64::from(part) / f64::from(whole.max(1));
    let [share, low, high] = [share, low, high].map(|value| 100.0 * value);
    format!("{share:.1} ({low:.0}–{high:.0})")
}

fn wilson(part: u32, whole: u32) -> (f64, f64) {
    const Z: f64 = 1.959_964;
    if whole == 0 {
        return (0.0, 1.0);
    }
    let whole = f64::from(whole);
    let share = f64::from(part) / whole;
    let scale = 1.0 / (1.0 + Z * Z / whole);
    let middle = scale * (share + Z * Z / (2.0 * whole));
    let reach = scale * Z * (share * (1.0 - share) / whole + Z * Z / (4.0 * whole * whole)).sqrt();
    ((middle - reach).max(0.0), (middle + reach).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newcombe 1998, Table I: 81 of 263 gives 0.2553 to 0.3662, 0 of 20 gives 0 to 0.1611, 1 of 29 0.0061 to 0.1718.
    #[test]
    fn intervals_are_those_of_the_literature() {
        for (part, whole, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let found = wilson(part, whole);
            assert!(
                (found.0 - low).abs() < 1e-4 && (found.1 - high).abs() < 1e-4,
                "{found:?}"
            );
        }
        assert_eq!(wilson(0, 0), (0.0, 1.0));
        assert_eq!(interval(19, 20), "95.0 (76–99)");
    }

    #[test]
    fn each_scan_counts_once() {
        let mut rates = Rates::default();
        rates.add(true, true);
        rates.add(true, false);
        rates.add(false, true);
        rates.add(false, false);
        rates.add_none();
        let expected = Rates {
            scans: 5,
            right: 2,
            known_right: 1,
            known_wrong: 1,
            none: 1,
        };
        assert_eq!(rates, expected);
    }
}
