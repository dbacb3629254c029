//! Why an object, or a place on it, cannot be grasped.

/// A mesh or settings that no grasp can be found with.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GraspError {
    /// A setting is out of range.
    #[error("{name} is {value}: expected more than {min} and at most {max}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// What it was.
        value: f64,
        /// It must be above this.
        min: f64,
        /// And not above this.
        max: f64,
    },
    /// There is no surface.
    #[error("the mesh has {vertices} vertices and {triangles} triangles: expected a surface")]
    Empty {
        /// Vertices of the mesh.
        vertices: usize,
        /// Triangles of the mesh.
        triangles: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names a vertex beyond the mesh's {vertices}")]
    Index {
        /// Index of the triangle.
        triangle: usize,
        /// Vertices of the mesh.
        vertices: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not a number: clean the mesh first")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// The triangles' front sides face inward.
    #[error("the triangles face inward: turn them over, so that normals point out of the object")]
    InsideOut,
    /// No vertex is within the graspable region.
    #[error("no vertex lies within the middle {ratio} of the length: the mesh is too coarse")]
    NoRegion {
        /// The settings' graspable_ratio.
        ratio: f64,
    },
}

/// Why two fingers cannot press at this handle.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GraspRefused {
    /// The handle is not one of the region's vertices.
    #[error("vertex {handle} is outside the graspable region")]
    OutsideRegion {
        /// The asked handle.
        handle: u32,
    },
    /// The slice at the handle's height holds no other vertex.
    #[error("vertex {handle} is alone in its slice: there is nothing for the second finger")]
    NoOpposite {
        /// The asked handle.
        handle: u32,
    },
    /// The gripper does not open so far.
    #[error("{width_m:.4} m wide at vertex {handle}: the gripper opens to {opening_max_m} m")]
    TooWide {
        /// The asked handle.
        handle: u32,
        /// Distance between the two handles.
        width_m: f64,
        /// The settings' opening_max_m.
        opening_max_m: f64,
    },
    /// Both pads would touch the same part.
    #[error("{width_m:.4} m wide at vertex {handle}: too thin to be pressed from both sides")]
    TooThin {
        /// The asked handle.
        handle: u32,
        /// Distance between the two handles.
        width_m: f64,
    },
    /// The surface looks along the long side, as a lid does: a finger would slip off.
    #[error("the surface at vertex {vertex} looks along the object, as a lid does")]
    EndCap {
        /// The handle that is on it: the asked one or the one opposite.
        vertex: u32,
    },
    /// The surface does not face away from the other finger: an inside wall, or too slanted.
    #[error("the surface at vertex {vertex} does not face a finger, {angle_deg:.0} degrees off")]
    NotFacing {
        /// The handle that is on it: the asked one or the one opposite.
        vertex: u32,
        /// Angle between its normal and the line from the other handle.
        angle_deg: f64,
    },
}
