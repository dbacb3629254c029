//! The names of the eight objects.

use std::fmt;
use std::str::FromStr;

use mesh::{Mesh, revolve};

use crate::outline::{
    LARGE_CUP_MM, MEDIUM_BALL_MM, MEDIUM_CAN_MM, MEDIUM_CUP_MM, SMALL_BALL_MM, SMALL_CUP_MM,
    TINY_BALL_MM, food_can_mm,
};
use crate::profile::{SEGMENTS, ball, subdivided};
use crate::variation::Variation;

/// One of the paper's eight objects. The order of [`ObjectClass::ALL`] is the order of a model's labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ObjectClass {
    /// Soft-drink can, 65.5 mm wide and 127.4 mm high.
    MediumCan,
    /// Tin of sweet corn, 75.9 x 118.5 mm.
    FoodCan,
    /// Paper cup, 88.5 x 102.9 mm.
    SmallCup,
    /// Plastic cup, 83.4 x 126.7 mm.
    MediumCup,
    /// Drinks cup, 88.7 x 171.1 mm.
    LargeCup,
    /// Foam basketball, 61.2 x 63.8 mm.
    TinyBall,
    /// Tennis ball, 64.0 x 64.7 mm.
    SmallBall,
    /// Foam ball, 97.4 x 90.0 mm.
    MediumBall,
}

impl ObjectClass {
    /// All objects, in the order of a model's labels.
    pub const ALL: [ObjectClass; 8] = [
        ObjectClass::MediumCan,
        ObjectClass::FoodCan,
        ObjectClass::SmallCup,
        ObjectClass::MediumCup,
        ObjectClass::LargeCup,
        ObjectClass::TinyBall,
        ObjectClass::SmallBall,
        ObjectClass::MediumBall,
    ];

    /// The name used in messages, labels and file names.
    pub fn name(self) -> &'static str {
        match self {
            ObjectClass::MediumCan => "medium-can",
            ObjectClass::FoodCan => "food-can",
            ObjectClass::SmallCup => "small-cup",
            ObjectClass::MediumCup => "medium-cup",
            ObjectClass::LargeCup => "large-cup",
            ObjectClass::TinyBall => "tiny-ball",
            ObjectClass::SmallBall => "small-ball",
            ObjectClass::MediumBall => "medium-ball",
        }
    }

    /// Whether the object is a hollow, thin-walled one, whose dents stay; a ball springs back.
    pub fn is_hollow(self) -> bool {
        !matches!(
            self,
            ObjectClass::TinyBall | ObjectClass::SmallBall | ObjectClass::MediumBall
        )
    }

    /// Closed outline (radius, height) in metres, from the axis at the bottom, outward and up, to the axis again.
    fn outline_m(self) -> Vec<[f32; 2]> {
        match self {
            ObjectClass::MediumCan => subdivided(MEDIUM_CAN_MM),
            ObjectClass::FoodCan => subdivided(&food_can_mm()),
            ObjectClass::SmallCup => subdivided(SMALL_CUP_MM),
            ObjectClass::MediumCup => subdivided(MEDIUM_CUP_MM),
            ObjectClass::LargeCup => subdivided(LARGE_CUP_MM),
            ObjectClass::TinyBall => ball(TINY_BALL_MM),
            ObjectClass::SmallBall => ball(SMALL_BALL_MM),
            ObjectClass::MediumBall => ball(MEDIUM_BALL_MM),
        }
    }

    /// Width and height of the undented object, m.
    pub fn size_m(self) -> [f32; 2] {
        let outline = self.outline_m();
        let most = |axis: usize| outline.iter().map(|place| place[axis]).fold(0.0, f32::max);
        [2.0 * most(0), most(1)]
    }

    /// The undented object in the object frame.
    pub fn mesh(self, variation: &Variation) -> Mesh {
        let mut mesh = revolve(&self.outline_m(), SEGMENTS);
        variation.apply(&mut mesh);
        mesh
    }
}

impl fmt::Display for ObjectClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that is none of the eight.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown object '{name}': expected one of {}", names())]
pub struct UnknownObject {
    /// What was asked for.
    pub name: String,
}

impl FromStr for ObjectClass {
    type Err = UnknownObject;

    fn from_str(name: &str) -> Result<Self, UnknownObject> {
        Self::ALL
            .into_iter()
            .find(|class| class.name() == name)
            .ok_or_else(|| UnknownObject {
                name: name.to_owned(),
            })
    }
}

fn names() -> String {
    ObjectClass::ALL.map(ObjectClass::name).join(", ")
}

#[cfg(test)]
mod tests;
