//! Private parameters: read once, completed with their defaults, checked, and written back for all to see.

use serde::de::DeserializeOwned;
use serde::{Serialize, Serializer};
use serde_yaml::{Mapping, Value};
use std::fmt::Display;
use thiserror::Error;

/// A parameter that cannot be used; the node must not start with it.
#[derive(Debug, Error)]
pub enum ParameterError {
    /// A key that nobody knows, or a value of the wrong type.
    #[error("parameters of {node}: {reason}")]
    Unreadable {
        /// The node.
        node: String,
        /// Names the key and what is allowed.
        reason: String,
    },
    /// A value outside its range.
    #[error("parameters of {node}: {reason}")]
    Invalid {
        /// The node.
        node: String,
        /// Names the parameter, its value and the range.
        reason: String,
    },
    /// The parameter server failed.
    #[error("cannot read the parameters of {node}: {reason}")]
    Server {
        /// The node.
        node: String,
        /// What the server said.
        reason: String,
    },
}

/// Reads the private parameters of this node.
pub(crate) fn read() -> Result<Value, ParameterError> {
    let node = rosrust::name();
    let server = |reason: String| ParameterError::Server {
        node: node.clone(),
        reason,
    };
    let parameter =
        rosrust::param(&node).ok_or_else(|| server("its name cannot be resolved".into()))?;
    match parameter.exists() {
        Ok(false) => Ok(Value::Mapping(Mapping::new())),
        Ok(true) => parameter.get().map_err(|error| server(error.to_string())),
        Err(error) => Err(server(error.to_string())),
    }
}

/// Makes `P` of `value`: what is absent has its default, what is unknown or out of range is an error.
pub(crate) fn resolve<P: DeserializeOwned, E: Display>(
    node: &str,
    value: Value,
    validate: impl Fn(&P) -> Result<(), E>,
) -> Result<P, ParameterError> {
    let parameters =
        serde_path_to_error::deserialize(value).map_err(|error| ParameterError::Unreadable {
            node: node.into(),
            reason: error.to_string(),
        })?;
    validate(&parameters).map_err(|error| ParameterError::Invalid {
        node: node.into(),
        reason: error.to_string(),
    })?;
    Ok(parameters)
}

/// Writes all parameters as they are in force, so that `rosparam get` shows the defaults too.
pub(crate) fn write_back(parameters: &impl Serialize) {
    let Ok(Value::Mapping(mapping)) = serde_yaml::to_value(parameters) else {
        return;
    };
    for (key, value) in mapping {
        // XML-RPC has no word for "none".
        let (Value::String(key), false) = (key, value.is_null()) else {
            continue;
        };
        let parameter = rosrust::param(&format!("~{key}"));
        if let Some(Err(error)) = parameter.map(|parameter| parameter.set(&Wire(&value))) {
            log::warn!("cannot write the parameter {key} back: {error}");
        }
    }
}

/// A value as rosrust can send it: of all whole numbers it knows 32-bit ones only, and makes strings of the others.
struct Wire<'a>(&'a Value);

impl Serialize for Wire<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Value::Number(number) => match number.as_i64().map(i32::try_from) {
                Some(Ok(whole)) => serializer.serialize_i32(whole),
                _ => serializer.serialize_f64(number.as_f64().unwrap_or(f64::NAN)),
            },
            Value::Sequence(values) => serializer.collect_seq(values.iter().map(Wire)),
            Value::Mapping(entries) => {
                let entries = entries.iter().filter(|(_, value)| !value.is_null());
                serializer.collect_map(entries.map(|(key, value)| (key, Wire(value))))
            }
            other => other.serialize(serializer),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    struct Sample {
        radius_m: f64,
    }

    impl Default for Sample {
        fn default() -> Self {
            Self { radius_m: 0.5 }
        }
    }

    fn resolve_text(text: &str) -> Result<Sample, ParameterError> {
        resolve(
            "/sample",
            serde_yaml::from_str(text).unwrap(),
            |sample: &Sample| {
                let fine = sample.radius_m > 0.0;
                fine.then_some(())
                    .ok_or(format!("radius_m is {}; it must be > 0", sample.radius_m))
            },
        )
    }

    #[test]
    fn defaults_fill_in_and_whole_numbers_serve_as_reals() {
        assert_eq!(resolve_text("{}").unwrap(), Sample::default());
        assert_eq!(
            resolve_text("radius_m: 2").unwrap(),
            Sample { radius_m: 2.0 }
        );
    }

    #[test]
    fn unknown_keys_and_bad_values_are_named() {
        let unknown = resolve_text("raduis_m: 1.0").unwrap_err().to_string();
        assert!(
            unknown.contains("/sample") && unknown.contains("raduis_m"),
            "{unknown}"
        );
        assert!(
            unknown.contains("radius_m"),
            "says what is allowed: {unknown}"
        );
        let range = resolve_text("radius_m: -1.0").unwrap_err().to_string();
        assert!(range.contains("radius_m is -1"), "{range}");
    }
}
