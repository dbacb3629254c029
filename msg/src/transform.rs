//! `geometry_msgs/Transform` to and from isometries.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3 as Vector};
use rosrust_msg::geometry_msgs::{Point, Quaternion as QuaternionMessage, Transform, Vector3};

/// The isometry of a message, unless its numbers are not finite or its quaternion is far from unit length.
pub fn to_isometry(message: &Transform) -> Option<Isometry3<f64>> {
    let Vector3 { x, y, z } = message.translation;
    let q = &message.rotation;
    let quaternion = Quaternion::new(q.w, q.x, q.y, q.z);
    let finite = [x, y, z].iter().all(|v| v.is_finite());
    // Written so that a quaternion that is not a number fails too.
    let unit = (quaternion.norm() - 1.0).abs() < 1e-2;
    (finite && unit).then(|| {
        Isometry3::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::from_quaternion(quaternion),
        )
    })
}

/// The message of an isometry.
pub fn from_isometry(isometry: &Isometry3<f64>) -> Transform {
    let q = isometry.rotation.quaternion();
    Transform {
        translation: from_vector(&isometry.translation.vector),
        rotation: QuaternionMessage {
            x: q.i,
            y: q.j,
            z: q.k,
            w: q.w,
        },
    }
}

/// The message of a vector.
pub fn from_vector(vector: &Vector<f64>) -> Vector3 {
    Vector3 {
        x: vector.x,
        y: vector.y,
        z: vector.z,
    }
}

/// The message of a point.
pub fn from_point(point: &Point3<f64>) -> Point {
    Point {
        x: point.x,
        y: point.y,
        z: point.z,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_transform_survives_the_message() {
        let isometry = Isometry3::new(Vector::new(0.1, -0.2, 0.3), Vector::new(0.4, 0.5, -0.6));
        let back = to_isometry(&from_isometry(&isometry)).unwrap();
        assert!((back.inverse() * isometry).translation.vector.norm() < 1e-12);
        assert!(back.rotation.angle_to(&isometry.rotation) < 1e-9);
    }

    #[test]
    fn an_unset_or_broken_rotation_is_refused() {
        assert!(to_isometry(&Transform::default()).is_none());
        let mut message = from_isometry(&Isometry3::identity());
        message.rotation.w = f64::NAN;
        assert!(to_isometry(&message).is_none());
    }
}
