//! Values of XML-RPC and the messages that carry them: <http://xmlrpc.com/spec.md>.

use roxmltree::{Document, Node};
use std::fmt::Write;
use std::io;

/// Largest depth of nested values; ROS's own are three deep, parameters as deep as their YAML.
const DEPTH_MAX: usize = 32;

/// A value in a call or an answer. ROS uses neither dates nor base64.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Bool(bool),
    Int(i32),
    Double(f64),
    Text(String),
    Array(Vec<Value>),
    Struct(Vec<(String, Value)>),
}

impl From<i32> for Value {
    fn from(value: i32) -> Self {
        Self::Int(value)
    }
}

impl From<&str> for Value {
    fn from(value: &str) -> Self {
        Self::Text(value.into())
    }
}

impl FromIterator<Value> for Value {
    fn from_iter<I: IntoIterator<Item = Value>>(values: I) -> Self {
        Self::Array(values.into_iter().collect())
    }
}

impl Value {
    pub fn as_text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    pub fn into_text(self) -> Option<String> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    pub fn into_array(self) -> Option<Vec<Value>> {
        match self {
            Self::Array(values) => Some(values),
            _ => None,
        }
    }

    /// The texts of an array; other values in it are left out.
    pub fn into_texts(self) -> Vec<String> {
        let values = self.into_array().unwrap_or_default();
        values.into_iter().filter_map(Value::into_text).collect()
    }

    fn write(&self, xml: &mut String) {
        xml.push_str("<value>");
        // Writing to a string does not fail.
        let _ = match self {
            Self::Bool(value) => write!(xml, "<boolean>{}</boolean>", u8::from(*value)),
            Self::Int(value) => write!(xml, "<int>{value}</int>"),
            Self::Double(value) => write!(xml, "<double>{value:?}</double>"),
            Self::Text(text) => write!(xml, "<string>{}</string>", escaped(text)),
            Self::Array(values) => {
                xml.push_str("<array><data>");
                values.iter().for_each(|value| value.write(xml));
                write!(xml, "</data></array>")
            }
            Self::Struct(members) => {
                xml.push_str("<struct>");
                for (name, value) in members {
                    let _ = write!(xml, "<member><name>{}</name>", escaped(name));
                    value.write(xml);
                    xml.push_str("</member>");
                }
                write!(xml, "</struct>")
            }
        };
        xml.push_str("</value>");
    }
}

/// The text as XML has it; characters that XML 1.0 cannot say are replaced.
fn escaped(text: &str) -> String {
    let mut xml = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => xml.push_str("&amp;"),
            '<' => xml.push_str("&lt;"),
            '>' => xml.push_str("&gt;"),
            '\r' => xml.push_str("&#13;"),
            '\n' | '\t' | ' '.. => xml.push(letter),
            _ => xml.push('\u{fffd}'),
        }
    }
    xml
}

pub(super) fn encode_call(method: &str, arguments: &[Value]) -> String {
    let head = format!("<?xml version=\"1.0\"?><methodCall><methodName>{method}</methodName>");
    format!("{head}{}</methodCall>", parameters(arguments))
}

pub(super) fn encode_response(value: &Value) -> String {
    let value = parameters(std::slice::from_ref(value));
    format!("<?xml version=\"1.0\"?><methodResponse>{value}</methodResponse>")
}

pub(super) fn encode_fault(reason: &str) -> String {
    let mut fault = String::new();
    let (code, text) = ("faultCode".to_owned(), "faultString".to_owned());
    Value::Struct(vec![(code, 1.into()), (text, reason.into())]).write(&mut fault);
    format!("<?xml version=\"1.0\"?><methodResponse><fault>{fault}</fault></methodResponse>")
}

fn parameters(values: &[Value]) -> String {
    let mut xml = String::from("<params>");
    for value in values {
        xml.push_str("<param>");
        value.write(&mut xml);
        xml.push_str("</param>");
    }
    xml + "</params>"
}

/// The method's name and its arguments.
pub(super) fn decode_call(xml: &str) -> io::Result<(String, Vec<Value>)> {
    let document = Document::parse(xml).map_err(invalid)?;
    let call = named(document.root_element(), "methodCall")?;
    let method = child(call, "methodName")?.text().unwrap_or_default();
    let arguments = match child(call, "params") {
        Ok(parameters) => decode_parameters(parameters)?,
        Err(_) => Vec::new(),
    };
    Ok((method.trim().to_owned(), arguments))
}

/// What was returned; a fault is an error.
pub(super) fn decode_response(xml: &str) -> io::Result<Value> {
    let document = Document::parse(xml).map_err(invalid)?;
    let response = named(document.root_element(), "methodResponse")?;
    if let Ok(fault) = child(response, "fault") {
        let reason = match decode(child(fault, "value")?, 0)? {
            Value::Struct(members) => {
                let text = members.into_iter().find(|(name, _)| name == "faultString");
                text.and_then(|(_, text)| text.into_text())
            }
            _ => None,
        };
        return Err(io::Error::other(reason.unwrap_or_else(|| "a fault".into())));
    }
    let values = decode_parameters(child(response, "params")?)?;
    let first = values.into_iter().next();
    first.ok_or_else(|| invalid("nothing was returned"))
}

fn decode_parameters(parameters: Node) -> io::Result<Vec<Value>> {
    let parameters = elements(parameters, "param");
    parameters
        .map(|parameter| decode(child(parameter, "value")?, 0))
        .collect()
}

fn decode(value: Node, depth: usize) -> io::Result<Value> {
    if depth == DEPTH_MAX {
        return Err(invalid("values within values without end"));
    }
    let Some(typed) = value.children().find(Node::is_element) else {
        return Ok(Value::Text(text(value)));
    };
    let plain = text(typed);
    let number = plain.trim();
    match typed.tag_name().name() {
        "string" => Ok(Value::Text(plain)),
        "int" | "i4" => number.parse().map(Value::Int).map_err(invalid),
        "double" => number.parse().map(Value::Double).map_err(invalid),
        "boolean" => Ok(Value::Bool(number == "1")),
        "array" => elements(child(typed, "data")?, "value")
            .map(|value| decode(value, depth + 1))
            .collect(),
        "struct" => elements(typed, "member")
            .map(|member| {
                let name = text(child(member, "name")?);
                Ok((name, decode(child(member, "value")?, depth + 1)?))
            })
            .collect::<io::Result<_>>()
            .map(Value::Struct),
        other => Err(invalid(format!("a value of type '{other}'"))),
    }
}

fn text(node: Node) -> String {
    node.children().filter_map(|part| part.text()).collect()
}

fn elements<'a>(node: Node<'a, 'a>, name: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children()
        .filter(move |child| child.has_tag_name(name))
}

fn child<'a>(node: Node<'a, 'a>, name: &'a str) -> io::Result<Node<'a, 'a>> {
    let found = elements(node, name).next();
    found.ok_or_else(|| invalid(format!("no <{name}> in <{}>", node.tag_name().name())))
}

fn named<'a>(node: Node<'a, 'a>, name: &str) -> io::Result<Node<'a, 'a>> {
    let is_named = node.has_tag_name(name);
    is_named
        .then_some(node)
        .ok_or_else(|| invalid(format!("no <{name}>")))
}

fn invalid(reason: impl std::fmt::Display) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("no XML-RPC: {reason}"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn calls_come_back_as_they_were() {
        let member = ("radius_m".to_owned(), Value::Double(0.07));
        let arguments = vec![
            Value::from("/view <&> capture\n"),
            Value::Bool(true),
            Value::Array(vec![(-3).into(), Value::Struct(vec![member])]),
            Value::Array(Vec::new()),
            Value::from(""),
        ];
        let (method, back) = decode_call(&encode_call("setParam", &arguments)).unwrap();
        assert_eq!((&method[..], back), ("setParam", arguments));
        let untyped =
            "<methodResponse><params><param><value> a </value></param></params></methodResponse>";
        assert_eq!(decode_response(untyped).unwrap(), Value::from(" a "));
        let fault = decode_response(&encode_fault("no")).unwrap_err();
        assert_eq!(fault.to_string(), "no");
    }

    #[test]
    fn nonsense_is_an_error() {
        let deep = format!(
            "{}{}",
            "<value><array><data>".repeat(999),
            "</data></array></value>".repeat(999)
        );
        let deep =
            format!("<methodResponse><params><param>{deep}</param></params></methodResponse>");
        let number = "<methodResponse><params><param><value><int>x</int></value></param></params></methodResponse>";
        for bad in [
            "",
            "<a/>",
            "<methodResponse/>",
            number,
            &deep,
            "<methodResponse>",
        ] {
            assert!(decode_response(bad).is_err(), "{bad}");
        }
    }
}
