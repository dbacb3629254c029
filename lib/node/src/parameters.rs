//! Private parameters: read once, completed with their defaults, checked, and written back for all to see.

use crate::xmlrpc as wire;
use crate::{master, names};
use serde::Serialize;
use serde::de::DeserializeOwned;
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

/// Reads the private parameters of this node, after it has set those that the arguments give: `_NAME:=YAML`.
pub(crate) fn read() -> Result<Value, ParameterError> {
    let node = names::own();
    let server = |reason: String| ParameterError::Server {
        node: node.into(),
        reason,
    };
    for (name, text) in given(std::env::args().skip(1)) {
        let value = serde_yaml::from_str(&text)
            .ok()
            .and_then(|value: Value| to_wire(&value))
            .ok_or_else(|| server(format!("_{name}:={text} is no value")))?;
        set(&name, value).map_err(|error| server(error.to_string()))?;
    }
    let exists = master::blocking(master::call("hasParam", &[node.into()]));
    match exists.map_err(|error| server(error.to_string()))? {
        wire::Value::Bool(true) => {
            let value = master::blocking(master::call("getParam", &[node.into()]));
            value
                .map(from_wire)
                .map_err(|error| server(error.to_string()))
        }
        _ => Ok(Value::Mapping(Mapping::new())),
    }
}

/// Private parameters among a program's arguments; names with two underscores are ROS's own.
fn given(arguments: impl Iterator<Item = String>) -> Vec<(String, String)> {
    let pair = |word: String| {
        let (name, value) = word.strip_prefix('_')?.split_once(":=")?;
        (!name.starts_with('_')).then(|| (name.to_owned(), value.to_owned()))
    };
    arguments.filter_map(pair).collect()
}

fn set(name: &str, value: wire::Value) -> std::io::Result<()> {
    let name = format!("{}/{name}", names::own());
    master::blocking(master::call("setParam", &[name[..].into(), value])).map(drop)
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
        let (Value::String(key), Some(value)) = (key, to_wire(&value)) else {
            continue;
        };
        if let Err(error) = set(&key, value) {
            log::warn!("cannot write the parameter {key} back: {error}");
        }
    }
}

/// The value as XML-RPC has it, whose whole numbers have 32 bits; `None` for nothing.
fn to_wire(value: &Value) -> Option<wire::Value> {
    Some(match value {
        Value::Null => return None,
        Value::Bool(value) => wire::Value::Bool(*value),
        Value::Number(number) => match number.as_i64().map(i32::try_from) {
            Some(Ok(whole)) => wire::Value::Int(whole),
            _ => wire::Value::Double(number.as_f64().unwrap_or(f64::NAN)),
        },
        Value::String(text) => wire::Value::Text(text.clone()),
        Value::Sequence(values) => values.iter().filter_map(to_wire).collect(),
        Value::Mapping(entries) => {
            let member =
                |(key, value): (&Value, &Value)| Some((key.as_str()?.to_owned(), to_wire(value)?));
            wire::Value::Struct(entries.iter().filter_map(member).collect())
        }
        Value::Tagged(tagged) => return to_wire(&tagged.value),
    })
}

fn from_wire(value: wire::Value) -> Value {
    match value {
        wire::Value::Bool(value) => value.into(),
        wire::Value::Int(value) => value.into(),
        wire::Value::Double(value) => value.into(),
        wire::Value::Text(text) => text.into(),
        wire::Value::Array(values) => values.into_iter().map(from_wire).collect(),
        wire::Value::Struct(members) => {
            let member = |(name, value): (String, _)| (Value::from(name), from_wire(value));
            Value::Mapping(members.into_iter().map(member).collect())
        }
    }
}

#[cfg(test)]
mod tests;
