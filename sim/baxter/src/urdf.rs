//! The part of a URDF that kinematics needs: joints, their frames and their limits.
//!
//! The alternative is urdf-rs 0.10 with k 0.32. k uses nalgebra 0.30, so every pose would have to be converted; urdf-rs
//! depends on two more XML parsers; and its errors do not name the joint.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::Node;

/// Joints of a robot in file order.
#[derive(Debug, Clone)]
pub struct Urdf {
    /// Every joint, parents before or after their children as in the file.
    pub joints: Vec<Joint>,
}

/// One joint: how the child frame stands in the parent frame.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Name, as in joint_states.
    pub name: String,
    /// Link the joint is mounted on.
    pub parent: String,
    /// Link the joint carries.
    pub child: String,
    /// Child frame in the parent frame at joint position 0, metres.
    pub parent_from_child_at_zero: Isometry3<f64>,
    /// How it moves.
    pub kind: JointKind,
    /// Range of motion; none for fixed joints.
    pub limits: Option<Limits>,
    /// Joint that this one copies, and the factor.
    pub mimics: Option<(String, f64)>,
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointKind {
    /// Not at all.
    Fixed,
    /// Turns about an axis given in the child frame.
    Revolute(Unit<Vector3<f64>>),
    /// Slides along an axis given in the child frame.
    Prismatic(Unit<Vector3<f64>>),
}

/// Range and speed of a joint: rad and rad/s, or metres and m/s for a prismatic one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Smallest position.
    pub lower: f64,
    /// Largest position.
    pub upper: f64,
    /// Largest speed.
    pub velocity: f64,
}

impl Limits {
    /// The nearest position within the range.
    pub fn clip(&self, position: f64) -> f64 {
        position.clamp(self.lower, self.upper)
    }
}

/// What is wrong with a URDF, or with a question about it.
#[derive(Debug, thiserror::Error)]
pub enum UrdfError {
    /// Not XML.
    #[error("the robot description is not XML")]
    Xml(#[from] roxmltree::Error),
    /// An element lacks a child or an attribute.
    #[error("joint `{joint}` of the robot description lacks `{what}`")]
    Lacks {
        /// Joint with the fault.
        joint: String,
        /// Missing element or attribute.
        what: &'static str,
    },
    /// An attribute is not what it should be.
    #[error("joint `{joint}`: `{what}` is `{text}`, which is not valid")]
    Invalid {
        /// Joint with the fault.
        joint: String,
        /// Attribute.
        what: &'static str,
        /// What it holds.
        text: String,
    },
    /// No such joint or link.
    #[error("the robot description has no {kind} `{name}`")]
    Unknown {
        /// "joint" or "link".
        kind: &'static str,
        /// Name asked for.
        name: String,
    },
}

impl Urdf {
    /// The simulated robot's own description, as text for the parameter /robot_description.
    pub const BAXTER: &'static str = include_str!("../urdf/baxter.urdf");

    /// Reads the joints out of URDF text.
    ///
    /// # Errors
    /// Text that is not XML; a joint without name, type, parent, child or (if it moves) limit; malformed numbers.
    pub fn parse(text: &str) -> Result<Self, UrdfError> {
        let document = roxmltree::Document::parse(text)?;
        let joints = document
            .root_element()
            .children()
            .filter(|node| node.has_tag_name("joint"))
            .map(read_joint)
            .collect::<Result<_, _>>()?;
        Ok(Self { joints })
    }

    /// The joint of that name.
    ///
    /// # Errors
    /// No such joint.
    pub fn joint(&self, name: &str) -> Result<&Joint, UrdfError> {
        let found = self.joints.iter().find(|joint| joint.name == name);
        found.ok_or_else(|| UrdfError::Unknown {
            kind: "joint",
            name: name.to_owned(),
        })
    }
}

impl Joint {
    /// Child frame in the parent frame with the joint at `position` (rad, or metres for a prismatic joint).
    pub fn parent_from_child(&self, position: f64) -> Isometry3<f64> {
        let at_zero = self.parent_from_child_at_zero;
        match self.kind {
            JointKind::Fixed => at_zero,
            JointKind::Revolute(axis) => at_zero * UnitQuaternion::from_axis_angle(&axis, position),
            JointKind::Prismatic(axis) => {
                at_zero * Translation3::from(axis.into_inner() * position)
            }
        }
    }
}

fn read_joint(node: Node) -> Result<Joint, UrdfError> {
    let name = node
        .attribute("name")
        .unwrap_or("without a name")
        .to_owned();
    let link = |tag: &'static str| -> Result<String, UrdfError> {
        let link = child(node, tag).and_then(|element| element.attribute("link"));
        Ok(link.ok_or_else(|| lacks(&name, tag))?.to_owned())
    };
    let kind = read_kind(node, &name)?;
    let limits = match kind {
        JointKind::Fixed => None,
        _ => Some(read_limits(node, &name)?),
    };
    Ok(Joint {
        parent: link("parent")?,
        child: link("child")?,
        parent_from_child_at_zero: read_origin(node, &name)?,
        kind,
        limits,
        mimics: read_mimic(node, &name)?,
        name,
    })
}

fn read_kind(node: Node, name: &str) -> Result<JointKind, UrdfError> {
    let axis = || -> Result<Unit<Vector3<f64>>, UrdfError> {
        let axis = match child(node, "axis") {
            Some(element) => vector(element, name, "xyz")?.unwrap_or_else(Vector3::x),
            None => Vector3::x(),
        };
        let too_short = || invalid(name, "axis", format!("{axis:?}"));
        Unit::try_new(axis, 1e-9).ok_or_else(too_short)
    };
    match node.attribute("type") {
        Some("fixed") => Ok(JointKind::Fixed),
        Some("revolute") => Ok(JointKind::Revolute(axis()?)),
        Some("prismatic") => Ok(JointKind::Prismatic(axis()?)),
        Some(other) => Err(invalid(name, "type", other.to_owned())),
        None => Err(lacks(name, "type")),
    }
}

fn read_limits(node: Node, name: &str) -> Result<Limits, UrdfError> {
    let element = child(node, "limit").ok_or_else(|| lacks(name, "limit"))?;
    let limits = Limits {
        lower: number(element, name, "lower")?,
        upper: number(element, name, "upper")?,
        velocity: number(element, name, "velocity")?,
    };
    if limits.lower > limits.upper || limits.velocity < 0.0 {
        return Err(invalid(name, "limit", format!("{limits:?}")));
    }
    Ok(limits)
}

fn read_origin(node: Node, name: &str) -> Result<Isometry3<f64>, UrdfError> {
    let Some(element) = child(node, "origin") else {
        return Ok(Isometry3::identity());
    };
    let xyz = vector(element, name, "xyz")?.unwrap_or_default();
    let rpy = vector(element, name, "rpy")?.unwrap_or_default();
    let rotation = UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z);
    Ok(Isometry3::from_parts(Translation3::from(xyz), rotation))
}

fn read_mimic(node: Node, name: &str) -> Result<Option<(String, f64)>, UrdfError> {
    let Some(element) = child(node, "mimic") else {
        return Ok(None);
    };
    let copied = element
        .attribute("joint")
        .ok_or_else(|| lacks(name, "mimic joint"))?;
    Ok(Some((
        copied.to_owned(),
        number(element, name, "multiplier")?,
    )))
}

fn child<'a, 'input>(node: Node<'a, 'input>, tag: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|element| element.has_tag_name(tag))
}

fn number(element: Node, joint: &str, attribute: &'static str) -> Result<f64, UrdfError> {
    let text = element
        .attribute(attribute)
        .ok_or_else(|| lacks(joint, attribute))?;
    let value = text
        .trim()
        .parse::<f64>()
        .ok()
        .filter(|value| value.is_finite());
    value.ok_or_else(|| invalid(joint, attribute, text.to_owned()))
}

fn vector(
    element: Node,
    joint: &str,
    attribute: &'static str,
) -> Result<Option<Vector3<f64>>, UrdfError> {
    let Some(text) = element.attribute(attribute) else {
        return Ok(None);
    };
    let values: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    match values.as_deref() {
        Ok([x, y, z]) if [x, y, z].iter().all(|value| value.is_finite()) => {
            Ok(Some(Vector3::new(*x, *y, *z)))
        }
        _ => Err(invalid(joint, attribute, text.to_owned())),
    }
}

fn lacks(joint: &str, what: &'static str) -> UrdfError {
    UrdfError::Lacks {
        joint: joint.to_owned(),
        what,
    }
}

fn invalid(joint: &str, what: &'static str, text: String) -> UrdfError {
    UrdfError::Invalid {
        joint: joint.to_owned(),
        what,
        text,
    }
}
