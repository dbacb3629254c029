//! Parameters of another node that a user's file may set here by mistake.

use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// A parameter that `scan_server` has; set here, it is an error that says so.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct MovedToScanServer;

impl<'de> Deserialize<'de> for MovedToScanServer {
    fn deserialize<D: Deserializer<'de>>(_: D) -> Result<Self, D::Error> {
        Err(D::Error::custom(
            "this is a parameter of scan_server now; move it to config/scan_server.yaml",
        ))
    }
}
