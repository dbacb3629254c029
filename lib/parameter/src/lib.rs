//! Checks of parameters with the same messages in every program, and defaults that several nodes share.

mod tunable;

pub use tunable::Tunable;

use std::fmt::Display;
use std::ops::RangeInclusive;

/// Default range of depths in which the object is looked for, m: that of the reference implementation's camera client.
pub const DEPTH_RANGE_M: RangeInclusive<f64> = 0.25..=0.70;

/// A parameter whose value cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("parameter {name} is {value}; it must be {allowed}")]
pub struct ParameterError {
    /// Name of the parameter, as the user writes it.
    pub name: &'static str,
    /// The refused value.
    pub value: String,
    /// The allowed values, with the unit.
    pub allowed: String,
}

impl ParameterError {
    /// Says that `name` is `value` but must be `allowed`.
    pub fn new(name: &'static str, value: impl Display, allowed: impl Into<String>) -> Self {
        Self {
            name,
            value: value.to_string(),
            allowed: allowed.into(),
        }
    }
}

/// Checks that a value is in `range`. `unit`, for the message, may be empty.
///
/// # Errors
/// The value is outside of the range or NaN.
pub fn in_range<T: PartialOrd + Display>(
    name: &'static str,
    value: T,
    range: RangeInclusive<T>,
    unit: &str,
) -> Result<(), ParameterError> {
    if range.contains(&value) {
        return Ok(());
    }
    let space = if unit.is_empty() { "" } else { " " };
    let allowed = format!("from {} to {}{space}{unit}", range.start(), range.end());
    Err(ParameterError::new(name, value, allowed))
}

/// Name of the parameter that is refused once the defaults are changed so; for tests.
pub fn refused_name<P: Default>(
    validate: impl FnOnce(&P) -> Result<(), ParameterError>,
    change: impl FnOnce(&mut P),
) -> Option<&'static str> {
    let mut parameters = P::default();
    change(&mut parameters);
    validate(&parameters).err().map(|error| error.name)
}

/// Checks fields of parameters, each with its range and its unit where its name does not tell; a prefix completes the names of
/// a group of parameters. The function around it returns the error of the first field that is out of its range.
#[macro_export]
macro_rules! check_ranges {
    ($parameters:expr; $($fields:tt)*) => { $crate::check_ranges!($parameters, ""; $($fields)*) };
    ($parameters:expr, $prefix:literal; $($name:ident: $range:expr $(, $unit:literal)?;)*) => {
        $($crate::in_range(
            concat!($prefix, stringify!($name)),
            $parameters.$name,
            $range,
            concat!($($unit)?),
        )?;)*
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_of_a_group_are_named_with_it() {
        struct Hand {
            force: f64,
            speed_rad_s: f64,
        }
        let check = |hand: &Hand| -> Result<(), ParameterError> {
            check_ranges! { hand, "hand/";
                force: 0.0..=1.0;
                speed_rad_s: 0.1..=3.5, "rad/s";
            }
            Ok(())
        };
        let hand = |force, speed_rad_s| Hand { force, speed_rad_s };
        let refused = |hand: &Hand| check(hand).err().map(|error| error.to_string());
        assert_eq!(refused(&hand(1.0, 0.1)), None);
        let force = "parameter hand/force is 2; it must be from 0 to 1";
        assert_eq!(refused(&hand(2.0, 9.0)), Some(force.to_owned()));
        let speed = "parameter hand/speed_rad_s is 9; it must be from 0.1 to 3.5 rad/s";
        assert_eq!(refused(&hand(0.5, 9.0)), Some(speed.to_owned()));
    }

    #[test]
    fn the_message_names_parameter_value_and_range() {
        let error =
            in_range("depth_max_m", 40.0, 0.0..=10.0, "m").map_err(|error| error.to_string());
        assert_eq!(
            error,
            Err("parameter depth_max_m is 40; it must be from 0 to 10 m".to_owned())
        );
    }

    #[test]
    fn nan_is_refused_and_the_ends_are_allowed() {
        assert!(in_range("x", f64::NAN, 0.0..=1.0, "").is_err());
        assert!(in_range("x", 0.0, 0.0..=1.0, "").is_ok());
        assert!(in_range("x", 1.0, 0.0..=1.0, "").is_ok());
    }
}
