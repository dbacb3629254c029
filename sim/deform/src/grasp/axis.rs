//! The long side of an object.

use mesh::triangle;
use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// Variance along the long side over that along the second longest, below which an object has no long side. The eight
/// scans: balls up to 1.04, the stoutest cup 1.38.
const LONG_RATIO_MIN: f64 = 1.15;

/// The direction in which a surface spreads most (principal component over its area, so that the density of vertices
/// does not matter), turned to the side of +z. Of a body that spreads nearly alike in its two longest directions, as a
/// ball does, it is +z.
pub(super) fn long_axis(vertices_m: &[Point3<f64>], triangles: &[[u32; 3]]) -> Unit<Vector3<f64>> {
    let eigen = spread(vertices_m, triangles).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let [longest, second] = [order[0], order[1]].map(|k| eigen.eigenvalues[k]);
    if longest < LONG_RATIO_MIN * second {
        return Vector3::z_axis();
    }
    let axis = Unit::new_normalize(eigen.eigenvectors.column(order[0]).into_owned());
    let leading = [axis.z, axis.y, axis.x]
        .into_iter()
        .find(|x| x.abs() > 1e-6);
    if leading.unwrap_or(1.0) < 0.0 {
        -axis
    } else {
        axis
    }
}

/// Centre of a surface's area, and outward flux from it: negative where the triangles face inward.
pub(super) fn centre_and_flux(
    vertices_m: &[Point3<f64>],
    triangles: &[[u32; 3]],
) -> (Point3<f64>, f64) {
    let corners = |t: &[u32; 3]| t.map(|index| vertices_m[index as usize]);
    let mut area_m2 = 0.0;
    let mut sum = Vector3::zeros();
    for indices in triangles {
        let corners = corners(indices);
        let area = triangle::area(corners);
        area_m2 += area;
        sum += area * (corners[0].coords + corners[1].coords + corners[2].coords) / 3.0;
    }
    let centre = sum / f64::max(area_m2, f64::MIN_POSITIVE);
    let flux = triangles.iter().map(|indices| {
        let [a, b, c] = corners(indices).map(|corner| corner.coords - centre);
        a.dot(&b.cross(&c))
    });
    (centre.into(), flux.sum())
}

/// Second moments of a surface about the centre of its area, over the area.
fn spread(vertices_m: &[Point3<f64>], triangles: &[[u32; 3]]) -> Matrix3<f64> {
    let (centre, _) = centre_and_flux(vertices_m, triangles);
    let mut area_m2 = 0.0;
    let mut moments = Matrix3::zeros();
    for indices in triangles {
        let corners = indices.map(|index| vertices_m[index as usize]);
        let area = triangle::area(corners);
        let [a, b, c] = corners.map(|corner| corner - centre);
        // Exact for linear coordinates: (Σ x xᵀ + (Σ x)(Σ x)ᵀ) · area / 12.
        let squares = [a, b, c, a + b + c].map(|x| x * x.transpose());
        moments += squares.iter().sum::<Matrix3<f64>>() * (area / 12.0);
        area_m2 += area;
    }
    moments / f64::max(area_m2, f64::MIN_POSITIVE)
}
