//! How right analysis by synthesis is of what no camera saw.

use std::fmt::{Display, Formatter};
use std::time::Instant;

use deformation::{Parameters, Reference, Synthesis, measure};
use nalgebra::Point3;

use super::score::{DENTED_M, at, interval};
use super::{Case, Place};

/// A claim and a dent nearer to each other than this are the same.
const SAME_M: f64 = 0.02;
/// The goal: a claimed depth is at most so wrong.
const RIGHT_M: f64 = 0.0025;

/// What was said of one object.
#[derive(Debug, Clone, Default)]
pub struct Unseen {
    /// Dents whose bottoms no camera saw.
    pub dents: usize,
    /// How many of them are claimed.
    pub found: usize,
    pub claims: Vec<Claim>,
    /// Root mean square distance of the wall from the synthesised shape, where it was seen and where not, m.
    pub shape_m: Option<[f64; 2]>,
    /// The same from an undeformed reference that lies exactly right.
    pub rest_m: [f64; 2],
    /// Of the whole answer.
    pub milliseconds: f64,
}

/// A depth that is claimed of a place that no camera saw.
#[derive(Debug, Clone, Default)]
pub struct Claim {
    pub depth_m: f64,
    pub sigma_m: f64,
    /// Of the deepest place around it.
    pub truth_m: f64,
}

impl Claim {
    /// Square of the error in standard deviations.
    fn ratio_sq(&self) -> f64 {
        ((self.depth_m - self.truth_m) / self.sigma_m).powi(2)
    }
}

impl Unseen {
    pub fn of(case: &Case, reference: &Reference) -> Self {
        let start = Instant::now();
        let result = measure(reference, &case.observation(), &Parameters::default());
        let milliseconds = 1e3 * start.elapsed().as_secs_f64();
        let dents = unseen_dents(&case.wall);
        let mut unseen = Self {
            dents: dents.len(),
            milliseconds,
            ..Self::default()
        };
        let Ok(found) = result else { return unseen };
        for dent in found.unseen_dents() {
            let around = case
                .wall
                .iter()
                .filter(|place| away_m(place, &dent.centre) < SAME_M);
            unseen.claims.push(Claim {
                depth_m: dent.depth_m,
                sigma_m: dent.depth_sigma_m,
                truth_m: around
                    .map(|place| f64::from(place.depth_m))
                    .fold(0.0, f64::max),
            });
        }
        let is_found = |dent: &&Place| {
            let mut claims = found.unseen_dents().iter();
            claims.any(|claim| away_m(dent, &claim.centre) < SAME_M)
        };
        unseen.found = dents.iter().filter(is_found).count();
        if let Ok(synthesis) = &found.synthesis {
            let off_m = distances_m(synthesis, &case.wall);
            unseen.shape_m = Some(by_sight(&case.wall, |k| off_m[k]));
            unseen.rest_m = by_sight(&case.wall, |k| f64::from(case.wall[k].depth_m));
        }
        unseen
    }
}

fn away_m(place: &Place, other: &Point3<f64>) -> f64 {
    (place.from.cast::<f64>() - other).norm()
}

/// The deepest place of each dent most of whose bottom no camera saw.
fn unseen_dents(wall: &[Place]) -> Vec<Place> {
    const SAME_DENT_M: f32 = 0.03;
    let mut left: Vec<&Place> = wall.iter().collect();
    let mut unseen = Vec::new();
    while let Some(&deepest) = left.iter().max_by(|a, b| a.depth_m.total_cmp(&b.depth_m)) {
        if f64::from(deepest.depth_m) < DENTED_M {
            break;
        }
        let is_near = |place: &Place| (place.from - deepest.from).norm() < SAME_DENT_M;
        let bottom = wall
            .iter()
            .filter(|place| is_near(place) && place.depth_m >= 0.7 * deepest.depth_m);
        let (seen, all) = bottom.fold((0, 0), |(seen, all), place| {
            (seen + usize::from(place.seen), all + 1)
        });
        if 2 * seen < all {
            unseen.push(deepest.clone());
        }
        left.retain(|place| !is_near(place));
    }
    unseen
}

/// Of the true wall from the synthesised shape, along its normals.
fn distances_m(synthesis: &Synthesis, wall: &[Place]) -> Vec<f64> {
    let vertices = &synthesis.vertices;
    let normals = mesh::vertex_normals(vertices, &synthesis.triangles);
    let places: Vec<_> = vertices.iter().map(|vertex| vertex.cast()).collect();
    let Some(tree) = cloud::Tree::new(&places) else {
        return vec![f64::NAN; wall.len()];
    };
    let distance_m = |place: &Place| {
        let nearest = tree.nearest(&place.to).index;
        normals[nearest].dot(&(place.to.cast::<f64>() - vertices[nearest]))
    };
    wall.iter().map(distance_m).collect()
}

/// Root mean square over the seen places, and over the others.
fn by_sight(wall: &[Place], off_m: impl Fn(usize) -> f64) -> [f64; 2] {
    [true, false].map(|seen| {
        let places = (0..wall.len()).filter(|&k| wall[k].seen == seen);
        let (sum, count) = places.fold((0.0, 0.0), |(sum, count), k| {
            (sum + off_m(k).powi(2), count + 1.0)
        });
        (sum / f64::max(count, 1.0)).sqrt()
    })
}

/// The table of many.
#[derive(Debug, Clone, Default)]
pub struct Table {
    pub dents: usize,
    pub found: usize,
    pub claims: Vec<Claim>,
    /// Means over the objects that were synthesised, seen and unseen, m.
    pub shape_m: [f64; 2],
    pub rest_m: [f64; 2],
    /// Median and 99 %.
    pub milliseconds: [f64; 2],
}

impl Table {
    pub fn of<'a>(all: impl Iterator<Item = &'a Unseen> + Clone) -> Self {
        let pairs = all
            .clone()
            .filter_map(|unseen| Some([unseen.shape_m?, unseen.rest_m]));
        let pairs: Vec<[[f64; 2]; 2]> = pairs.collect();
        let mean = |which: usize, sight: usize| {
            let sum_m: f64 = pairs.iter().map(|pair| pair[which][sight]).sum();
            sum_m / pairs.len() as f64
        };
        let milliseconds: Vec<f64> = all.clone().map(|unseen| unseen.milliseconds).collect();
        Self {
            dents: all.clone().map(|unseen| unseen.dents).sum(),
            found: all.clone().map(|unseen| unseen.found).sum(),
            claims: all.flat_map(|unseen| unseen.claims.clone()).collect(),
            shape_m: [mean(0, 0), mean(0, 1)],
            rest_m: [mean(1, 0), mean(1, 1)],
            milliseconds: [at(&milliseconds, 0.5), at(&milliseconds, 0.99)],
        }
    }

    /// Of the claimed depths, m.
    pub fn errors_m(&self) -> Vec<f64> {
        let error = |claim: &Claim| (claim.depth_m - claim.truth_m).abs();
        self.claims.iter().map(error).collect()
    }
}

impl Display for Table {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let errors_m = self.errors_m();
        let count = errors_m.len();
        let mean = |sum: f64| 1e3 * sum / count as f64;
        writeln!(
            f,
            "dents that no camera saw: claimed {}",
            interval(self.found, self.dents)
        )?;
        writeln!(
            f,
            "claims: bias {:+.2} mm, mean error {:.2} mm, 90 % {:.2} mm; wrong by more than {:.1} mm: {}; \
             where nothing is deeper than 2 mm: {}; errors are {:.2} of their standard deviations (RMS)",
            mean(self.claims.iter().map(|c| c.depth_m - c.truth_m).sum()),
            mean(errors_m.iter().sum()),
            1e3 * at(&errors_m, 0.9),
            1e3 * RIGHT_M,
            interval(errors_m.iter().filter(|&&m| m > RIGHT_M).count(), count),
            self.claims
                .iter()
                .filter(|claim| claim.truth_m < 0.002)
                .count(),
            (self.claims.iter().map(Claim::ratio_sq).sum::<f64>() / count as f64).sqrt()
        )?;
        let [seen, unseen] = [0, 1].map(|k| [self.shape_m[k], self.rest_m[k]].map(|m| 1e3 * m));
        writeln!(
            f,
            "wall from the synthesised shape: {:.2} mm where seen, {:.2} mm where not (RMS); from the undeformed one: \
             {:.2} and {:.2} mm",
            seen[0], unseen[0], seen[1], unseen[1]
        )?;
        let [median, high] = self.milliseconds;
        writeln!(
            f,
            "time with synthesis: median {median:.1} ms, 99 % {high:.1} ms"
        )
    }
}
