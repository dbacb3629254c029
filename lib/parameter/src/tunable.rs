//! Parameters that may change while a program runs.

use crate::{ParameterError, in_range};

/// A numeric field of the parameters `P` that may change at run time. [`tunables!`](crate::tunables) makes tables of them.
#[derive(Debug, Clone, Copy)]
pub struct Tunable<P: 'static> {
    /// Name of the parameter.
    pub name: &'static str,
    /// Description for the person who changes it.
    pub about: &'static str,
    /// Unit of the value; may be empty.
    pub unit: &'static str,
    /// Smallest allowed value.
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
    /// Whether the field is an integer.
    pub is_whole: bool,
    /// Reads the field.
    pub get: fn(&P) -> f64,
    /// Writes the field.
    pub set: fn(&mut P, f64),
}

impl<P> Tunable<P> {
    /// Checks that the field is in its range.
    ///
    /// # Errors
    /// The value is outside of the range or NaN.
    pub fn check(&self, parameters: &P) -> Result<(), ParameterError> {
        in_range(
            self.name,
            (self.get)(parameters),
            self.min..=self.max,
            self.unit,
        )
    }

    /// Sets the field to the value, clamped to the range. NaN changes nothing.
    pub fn set_clamped(&self, parameters: &mut P, value: f64) {
        if !value.is_nan() {
            (self.set)(parameters, value.clamp(self.min, self.max));
        }
    }
}

/// A table of [`Tunable`]s: for each a field, its type, its range, its unit and what it is.
#[macro_export]
macro_rules! tunables {
    ($parameters:ty; $($name:ident: $kind:ty, $min:literal ..= $max:literal, $unit:literal, $about:literal;)*) => {
        &[$($crate::Tunable {
            name: stringify!($name),
            about: $about,
            unit: $unit,
            min: $min as f64,
            max: $max as f64,
            // Converting 0.5 to an integer type loses the half.
            is_whole: 0.5 as $kind as f64 != 0.5,
            get: |parameters: &$parameters| parameters.$name as f64,
            set: |parameters: &mut $parameters, value| parameters.$name = value as $kind,
        }),*]
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq)]
    struct Sample {
        radius_m: f64,
        count: u32,
    }

    const TUNABLES: &[Tunable<Sample>] = tunables! { Sample;
        radius_m: f64, 0.1..=0.9, "m", "Radius";
        count: u32, 1..=64, "", "How many";
    };

    #[test]
    fn values_are_checked_and_clamped_by_the_same_range() {
        let mut sample = Sample {
            radius_m: 0.5,
            count: 65,
        };
        let [radius, count] = TUNABLES else {
            panic!("two fields")
        };
        assert_eq!((radius.is_whole, count.is_whole), (false, true));
        assert_eq!(radius.check(&sample), Ok(()));
        let error = count.check(&sample).map_err(|error| error.to_string());
        assert_eq!(
            error,
            Err("parameter count is 65; it must be from 1 to 64".into())
        );
        radius.set_clamped(&mut sample, 7.0);
        count.set_clamped(&mut sample, -3.0);
        assert_eq!(
            sample,
            Sample {
                radius_m: 0.9,
                count: 1
            }
        );
        radius.set_clamped(&mut sample, f64::NAN);
        assert_eq!(sample.radius_m, 0.9);
    }
}
