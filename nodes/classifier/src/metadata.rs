//! What a model file says about itself; written by `train`, read by the node.

use std::fmt;
use std::str::FromStr;

use crate::error::MetadataError;

/// How a cloud is moved to the origin before the network sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Centring {
    /// By the mean of its points.
    Centroid,
    /// By the middle of its bounding box.
    Box,
    /// By the centre of the sphere that it lies on, as a ball does; by that of its bounding box where it lies on none. A part
    /// of a ball is then as far from the origin as the whole.
    Sphere,
}

impl FromStr for Centring {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        match text {
            "centroid" => Ok(Self::Centroid),
            "box" => Ok(Self::Box),
            "sphere" => Ok(Self::Sphere),
            _ => Err(()),
        }
    }
}

impl fmt::Display for Centring {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Centroid => "centroid",
            Self::Box => "box",
            Self::Sphere => "sphere",
        })
    }
}

/// What tells whether an object is known at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KnownBy {
    /// The network's own score, see [`crate::KNOWN_SCORE_NAME`].
    #[default]
    Network,
    /// The distance from the features that are kept beside the model ([`adaptation::Familiar`]). The features of a taught
    /// model were not trained to tell what it was taught from strangers.
    Features,
}

/// Where every network expects the object's up direction; stored, so that other readers of the file know.
const UP_AXIS: &str = "+z";
/// Absent where the network takes no normals.
const NORMALS: &str = "normals";
/// Absent where the network's own score says so.
const KNOWN_BY: &str = "known_by";
const FEATURES: &str = "features";
/// Absent in files of before it was written.
const TRAINED_ON: &str = "trained_on";

/// Everything that a model file says about itself.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelMetadata {
    /// Names of the classes, in the order of the network's output.
    pub labels: Vec<String>,
    /// N, how many points the network takes.
    pub point_count: usize,
    /// The length by which coordinates are divided. Fixed: size tells two balls apart.
    pub metres_per_unit: f64,
    /// How clouds are moved to the origin.
    pub centring: Centring,
    /// Whether the network also takes each point's normal.
    pub normals: bool,
    /// Which network this is.
    pub network_version: String,
    /// The training run that made the model.
    pub run_id: String,
    /// What scores less than this is called unknown.
    pub known_threshold: f64,
    /// Which score that is.
    pub known_by: KnownBy,
    /// Which datasets it was trained on and how they were split, in the words of `train`; `None` where that was not written.
    pub trained_on: Option<String>,
}

impl ModelMetadata {
    /// Values of a point: 3 coordinates, and 3 of its normal if the network takes it.
    pub fn columns(&self) -> usize {
        if self.normals { 6 } else { 3 }
    }

    /// The entries to store in the model file.
    pub fn to_entries(&self) -> Vec<(&'static str, String)> {
        let mut entries = vec![
            ("labels", self.labels.join(",")),
            ("point_count", self.point_count.to_string()),
            ("metres_per_unit", self.metres_per_unit.to_string()),
            ("centring", self.centring.to_string()),
            ("up_axis", UP_AXIS.to_owned()),
            ("network_version", self.network_version.clone()),
            ("run_id", self.run_id.clone()),
            ("known_threshold", self.known_threshold.to_string()),
        ];
        if self.known_by == KnownBy::Features {
            entries.push((KNOWN_BY, FEATURES.to_owned()));
        }
        if self.normals {
            entries.push((NORMALS, "estimated".to_owned()));
        }
        if let Some(trained_on) = &self.trained_on {
            entries.push((TRAINED_ON, trained_on.clone()));
        }
        entries
    }

    /// Reads the entries back, each found by its key.
    ///
    /// # Errors
    /// The first key that is missing or has an impossible value.
    pub fn from_lookup(lookup: impl Fn(&str) -> Option<String>) -> Result<Self, MetadataError> {
        let entries = Entries(lookup);
        entries.up_axis()?;
        Ok(Self {
            labels: entries.labels()?,
            point_count: entries.parsed("point_count", "a whole number from 1 to 4096", |n| {
                (1..=4096).contains(n)
            })?,
            metres_per_unit: entries.parsed(
                "metres_per_unit",
                "a length above 0 and up to 100",
                |metres: &f64| *metres > 0.0 && *metres <= 100.0,
            )?,
            centring: entries.parsed("centring", "`centroid`, `box` or `sphere`", |_| true)?,
            normals: entries.normals()?,
            network_version: entries.text("network_version")?,
            run_id: entries.text("run_id")?,
            known_threshold: entries.parsed(
                "known_threshold",
                "a finite number",
                |threshold: &f64| threshold.is_finite(),
            )?,
            known_by: entries.known_by()?,
            trained_on: (entries.0)(TRAINED_ON),
        })
    }
}

/// Metadata entries behind a lookup function.
struct Entries<F>(F);

impl<F: Fn(&str) -> Option<String>> Entries<F> {
    fn get(&self, key: &'static str) -> Result<String, MetadataError> {
        self.0(key).ok_or(MetadataError::Missing { key })
    }

    fn text(&self, key: &'static str) -> Result<String, MetadataError> {
        let value = self.get(key)?;
        if value.trim().is_empty() {
            let allowed = "a text that is not empty";
            return Err(MetadataError::Wrong {
                key,
                value,
                allowed,
            });
        }
        Ok(value)
    }

    fn parsed<T: FromStr>(
        &self,
        key: &'static str,
        allowed: &'static str,
        is_allowed: impl Fn(&T) -> bool,
    ) -> Result<T, MetadataError> {
        let value = self.get(key)?;
        match value.trim().parse() {
            Ok(parsed) if is_allowed(&parsed) => Ok(parsed),
            _ => Err(MetadataError::Wrong {
                key,
                value,
                allowed,
            }),
        }
    }

    fn up_axis(&self) -> Result<(), MetadataError> {
        let (key, value) = ("up_axis", self.get("up_axis")?);
        if value == UP_AXIS {
            Ok(())
        } else {
            Err(MetadataError::Wrong {
                key,
                value,
                allowed: UP_AXIS,
            })
        }
    }

    fn normals(&self) -> Result<bool, MetadataError> {
        match self.0(NORMALS) {
            None => Ok(false),
            Some(value) if value == "estimated" => Ok(true),
            Some(value) => Err(MetadataError::Wrong {
                key: NORMALS,
                value,
                allowed: "`estimated`, or absent",
            }),
        }
    }

    fn known_by(&self) -> Result<KnownBy, MetadataError> {
        match self.0(KNOWN_BY) {
            None => Ok(KnownBy::Network),
            Some(value) if value == FEATURES => Ok(KnownBy::Features),
            Some(value) => Err(MetadataError::Wrong {
                key: KNOWN_BY,
                value,
                allowed: "`features`, or absent",
            }),
        }
    }

    fn labels(&self) -> Result<Vec<String>, MetadataError> {
        let value = self.get("labels")?;
        let labels: Vec<String> = value.split(',').map(|l| l.trim().to_owned()).collect();
        let distinct: std::collections::HashSet<&String> = labels.iter().collect();
        if labels.len() < 2 || distinct.len() < labels.len() || labels.iter().any(String::is_empty)
        {
            return Err(MetadataError::Wrong {
                key: "labels",
                value,
                allowed: "two or more different names separated by commas",
            });
        }
        Ok(labels)
    }
}

#[cfg(test)]
mod tests;
