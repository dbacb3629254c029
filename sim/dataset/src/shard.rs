//! One of several parts of a dataset.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Part `number` of `of` parts, counted from 1. Written `2/4`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    number: usize,
    of: usize,
}

/// A text that is no shard.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{text}' is no shard: expected K/N with 1 <= K <= N, like 2/4")]
pub struct NoShard {
    /// What was given.
    pub text: String,
}

impl Shard {
    /// Number of this shard, from 1.
    pub fn number(self) -> usize {
        self.number
    }

    /// Number of shards of the whole dataset.
    pub fn of(self) -> usize {
        self.of
    }

    /// Whether a unit, counted from 0 within its object, belongs to this shard. Each unit belongs to exactly one, and
    /// the shards of an object differ by one unit at most.
    pub fn holds(self, unit: usize) -> bool {
        unit % self.of == self.number - 1
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = NoShard;

    fn from_str(text: &str) -> Result<Self, NoShard> {
        let numbers = text.split_once('/');
        let numbers = numbers.and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err(NoShard {
                text: text.to_owned(),
            }),
        }
    }
}

impl TryFrom<String> for Shard {
    type Error = NoShard;

    fn try_from(text: String) -> Result<Self, NoShard> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn each_unit_belongs_to_exactly_one_shard() {
        for of in 1..=7 {
            let shards: Vec<Shard> = (1..=of)
                .map(|number| format!("{number}/{of}").parse().unwrap())
                .collect();
            for unit in 0..50 {
                let holders = shards.iter().filter(|shard| shard.holds(unit)).count();
                assert_eq!(holders, 1, "unit {unit} of {of} shards");
            }
        }
    }

    #[test]
    fn impossible_shards_are_refused() {
        for text in ["5/4", "0/4", "0/0", "1", "/", "a/b", "-1/4", "1/4/2", ""] {
            let message = text.parse::<Shard>().unwrap_err().to_string();
            assert!(message.contains(&format!("'{text}'")), "{message}");
        }
    }
}
