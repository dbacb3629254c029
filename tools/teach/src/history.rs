//! What was taught to a model, as its file says.

use chrono::{SecondsFormat, Utc};
use serde::{Deserialize, Serialize};

/// Key of the metadata entry: a JSON list of [`Step`].
pub const HISTORY: &str = "history";

/// How often a taught object was named rightly, on dents and views that it was not taught with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Simulated scans of three views.
    pub scans: usize,
    /// Share that was named rightly.
    pub right: f64,
    /// Share that was named rightly and called known.
    pub known_and_right: f64,
}

/// What changed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", tag = "did")]
pub enum Did {
    /// An object was added.
    Teach {
        /// Its name.
        label: String,
        /// Name of the file that it was made of.
        from: String,
        /// SHA-256 of that file.
        sha256: String,
        /// How well it is told.
        held_out: HeldOut,
    },
    /// An object was removed.
    Forget {
        /// Its name.
        label: String,
    },
    /// An object got another name.
    Rename {
        /// Its name of before.
        label: String,
        /// The new one.
        to: String,
    },
}

/// One change of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// What changed.
    #[serde(flatten)]
    pub did: Did,
    /// When: UTC, RFC 3339.
    pub at: String,
    /// SHA-256 of the model file of before.
    pub parent: String,
}

impl Step {
    /// A change of now.
    pub fn now(did: Did, parent: &str) -> Self {
        Self {
            did,
            at: Utc::now().to_rfc3339_opts(SecondsFormat::Secs, true),
            parent: parent.to_owned(),
        }
    }
}

impl Did {
    /// The name that the change is about.
    pub fn label(&self) -> &str {
        match self {
            Self::Teach { label, .. } | Self::Forget { label } | Self::Rename { label, .. } => {
                label
            }
        }
    }
}

/// Which step taught the object that now has this name; `None` where it was there from the first.
pub fn origin_of<'a>(steps: &'a [Step], label: &str) -> Option<&'a Step> {
    let mut name = label;
    for step in steps.iter().rev() {
        match &step.did {
            Did::Teach { label, .. } if label == name => return Some(step),
            Did::Rename { label, to } if to == name => name = label,
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn taught(label: &str) -> Step {
        let held_out = HeldOut {
            scans: 10,
            right: 0.9,
            known_and_right: 0.8,
        };
        let did = Did::Teach {
            label: label.to_owned(),
            from: format!("{label}.ply"),
            sha256: "0".to_owned(),
            held_out,
        };
        Step::now(did, "parent")
    }

    fn renamed(label: &str, to: &str) -> Step {
        let [label, to] = [label, to].map(str::to_owned);
        Step::now(Did::Rename { label, to }, "parent")
    }

    #[test]
    fn an_object_is_followed_through_its_names() {
        let steps = [
            taught("a"),
            renamed("a", "b"),
            taught("a"),
            renamed("b", "c"),
        ];
        assert_eq!(origin_of(&steps, "c"), Some(&steps[0]));
        assert_eq!(origin_of(&steps, "a"), Some(&steps[2]));
        assert_eq!(origin_of(&steps, "medium-can"), None);
    }

    #[test]
    fn steps_read_back_the_same() {
        let steps = vec![taught("a"), renamed("a", "b")];
        let text = serde_json::to_string(&steps).unwrap();
        assert_eq!(serde_json::from_str::<Vec<Step>>(&text).unwrap(), steps);
        assert!(steps[0].at.ends_with('Z'), "{}", steps[0].at);
    }
}
