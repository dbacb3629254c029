//! What both ends of a connection must agree on.

use crate::names;
use crate::tcpros::header;
use rosrust::Message;
use std::collections::HashMap;

/// Type and checksum of a topic's messages, which both ends of a connection must agree on.
pub(crate) struct MessageKind {
    /// PACKAGE/NAME.
    pub name: String,
    pub md5: String,
    pub definition: String,
}

impl MessageKind {
    pub fn of<T: Message>() -> Self {
        Self {
            name: T::msg_type(),
            md5: T::md5sum(),
            definition: T::msg_definition(),
        }
    }

    /// The connection header of a topic of this kind, with one more field.
    pub fn header(&self, topic: &str, more: (&str, &str)) -> Vec<u8> {
        header(&[
            ("callerid", names::own()),
            ("topic", topic),
            ("type", &self.name),
            ("md5sum", &self.md5),
            ("message_definition", &self.definition),
            more,
        ])
    }

    /// Checks type and checksum in the other end's header.
    ///
    /// # Errors
    /// Names the field that differs.
    pub fn check(&self, fields: &HashMap<String, String>) -> Result<(), String> {
        for (field, ours) in [("type", &self.name), ("md5sum", &self.md5)] {
            match fields.get(field) {
                Some(theirs) if theirs == ours || theirs == "*" => {}
                Some(theirs) => {
                    return Err(format!("{field} is {theirs} where {ours} is published"));
                }
                None if field == "type" => {}
                None => return Err(format!("the header lacks its {field}")),
            }
        }
        Ok(())
    }
}
