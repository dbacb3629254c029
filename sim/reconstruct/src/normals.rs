//! Outward normals of a cloud.
//!
//! Each normal is that of the plane through a point's nearest neighbours. Their signs are made consistent along a minimum
//! spanning tree of the neighbours' graph (Hoppe et al., SIGGRAPH 1992). Two neighbours agree if one normal, mirrored in
//! the plane halfway between them, is nearly the other: this holds along a surface, round an edge, and also through a thin
//! wall, whose two sides face away from each other.

use std::num::NonZeroUsize;

use cloud::Tree;
use cloud::normals::Moments;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::report::NormalSource;

/// One unit vector a point, outward; zero where a point's neighbours lie on one line. Points must be finite.
fn estimate(points: &[Point3<f32>], neighbours: NonZeroUsize) -> Vec<Vector3<f64>> {
    let Some(tree) = Tree::new(points) else {
        return Vec::new();
    };
    let near = nearest(points, neighbours);
    let mut planes = Planes::new(points, &near);
    let mut sides = Sides::new(points.len());
    sides.join_along(&planes.edges(&near));
    sides.bridge(&planes, &tree, neighbours.saturating_add(1));
    for (at, normal) in planes.normals.iter_mut().enumerate() {
        if sides.root(at).1 {
            *normal = -*normal;
        }
    }
    let mut normals = planes.normals;
    if !faces_outward(points, &normals) {
        normals.iter_mut().for_each(|normal| *normal = -*normal);
    }
    normals
}

/// Outward unit normals, one a point, or zeros: the given ones where they fit the points, otherwise estimated ones.
pub(crate) fn outward(
    points: &[Point3<f32>],
    given: Option<Vec<Vector3<f64>>>,
    neighbours: NonZeroUsize,
) -> (Vec<Vector3<f64>>, NormalSource) {
    let Some(mut given) = given else {
        return (estimate(points, neighbours), NormalSource::Estimated);
    };
    let judgement = judge(points, &given, neighbours);
    if judgement.along_planes < ALONG_PLANES_MIN {
        (
            estimate(points, neighbours),
            NormalSource::EstimatedForAskew,
        )
    } else if judgement.opposite > OPPOSITE_MAX {
        (
            estimate(points, neighbours),
            NormalSource::EstimatedForSides,
        )
    } else if faces_outward(points, &given) {
        (given, NormalSource::Given)
    } else {
        given.iter_mut().for_each(|normal| *normal = -*normal);
        (given, NormalSource::GivenInward)
    }
}

/// Given normals fit if the median cosine between them and the estimated planes' normals is at least this.
const ALONG_PLANES_MIN: f64 = 0.8;
/// Largest share of neighbours with opposite sides. Scans of thin cups have up to 0.15 %, two halves of a can that look the same
/// way 1.6 %.
const OPPOSITE_MAX: f64 = 0.005;
/// Largest doubt (see [`Edge`]) at which two neighbours' relative sign counts as certain.
const DOUBT_MAX: f64 = 0.2;

/// How well given normals fit the points.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Judgement {
    /// Median of the cosines between a point's normal and that of the plane through its neighbours, without sign.
    along_planes: f64,
    /// Share of neighbours that certainly have different sides, of those that certainly have the same or different ones.
    opposite: f64,
}

/// Compares unit normals, or zeros, of either sign with the planes through the points' neighbours.
fn judge(points: &[Point3<f32>], normals: &[Vector3<f64>], neighbours: NonZeroUsize) -> Judgement {
    let near = nearest(points, neighbours);
    let mut planes = Planes::new(points, &near);
    let pairs = planes.normals.iter().zip(normals);
    let mut cosines: Vec<f64> = pairs
        .filter(|(of_plane, given)| of_plane.norm() > 0.5 && given.norm() > 0.5)
        .map(|(of_plane, given)| of_plane.dot(given).abs())
        .collect();
    cosines.sort_by(f64::total_cmp);
    planes.normals = normals.to_vec();
    let edges = planes.edges(&near);
    let certain: Vec<&Edge> = edges
        .iter()
        .take_while(|edge| edge.doubt < DOUBT_MAX)
        .collect();
    let opposite = certain.iter().filter(|edge| edge.opposite).count();
    Judgement {
        along_planes: cosines.get(cosines.len() / 2).copied().unwrap_or(0.0),
        opposite: opposite as f64 / certain.len().max(1) as f64,
    }
}

fn nearest(points: &[Point3<f32>], neighbours: NonZeroUsize) -> Vec<Vec<u32>> {
    let Some(tree) = Tree::new(points) else {
        return Vec::new();
    };
    // One more: the nearest to a point is the point itself.
    let count = neighbours.saturating_add(1);
    points
        .par_iter()
        .map(|point| {
            tree.nearest_n(point, count)
                .map(|near| near.index as u32)
                .collect()
        })
        .collect()
}

/// The planes through the points' neighbours.
struct Planes<'a> {
    points: &'a [Point3<f32>],
    /// Unit vectors; zero where the neighbours lie on one line.
    normals: Vec<Vector3<f64>>,
    /// Squares of half the radius of the neighbours, m².
    grains_sq: Vec<f64>,
}

impl<'a> Planes<'a> {
    fn new(points: &'a [Point3<f32>], near: &[Vec<u32>]) -> Self {
        let plane = |(point, near): (&Point3<f32>, &Vec<u32>)| {
            let mut moments = Moments::default();
            let mut farthest_sq = 0.0_f64;
            for &index in near {
                let offset: Vector3<f64> = (points[index as usize] - point).cast();
                farthest_sq = farthest_sq.max(offset.norm_squared());
                moments.add(&offset);
            }
            let plane = moments.plane();
            let normal = plane.map(|plane| plane.normal.into_inner());
            (normal.unwrap_or_default(), farthest_sq / 4.0)
        };
        let (normals, grains_sq) = points.par_iter().zip(near).map(plane).unzip();
        Self {
            points,
            normals,
            grains_sq,
        }
    }

    /// The relative sign of two neighbours' normals, and how doubtful it is.
    fn edge(&self, a: u32, b: u32) -> Edge {
        let [from, to] = [a, b].map(|at| &self.normals[at as usize]);
        let [start, end] = [a, b].map(|at| &self.points[at as usize]);
        let between: Vector3<f64> = (end - start).cast();
        // Points nearer to each other than the grain differ by noise alone; no wall is that thin.
        let grain_sq = self.grains_sq[a as usize].max(self.grains_sq[b as usize]);
        let length_sq = (between.norm_squared() + grain_sq).max(f64::MIN_POSITIVE);
        let mirrored = from - between * (2.0 * from.dot(&between) / length_sq);
        let agreement = mirrored.dot(to);
        Edge {
            doubt: 1.0 - agreement.abs(),
            ends: [a, b],
            opposite: agreement < 0.0,
        }
    }

    /// The edges of the neighbours' graph, most certain first: Kruskal's order.
    fn edges(&self, near: &[Vec<u32>]) -> Vec<Edge> {
        let edges_at = |(at, near): (usize, &Vec<u32>)| {
            let at = at as u32;
            let others = near.iter().copied().filter(|&other| other != at);
            others.map(|other| self.edge(at, other)).collect::<Vec<_>>()
        };
        let mut edges: Vec<Edge> = near
            .par_iter()
            .enumerate()
            .flat_map_iter(edges_at)
            .collect();
        edges.par_sort_by(|a, b| a.doubt.total_cmp(&b.doubt).then(a.ends.cmp(&b.ends)));
        edges
    }
}

/// Two points, how doubtful their normals' relative sign is (0 to 1), and whether the signs differ.
struct Edge {
    doubt: f64,
    ends: [u32; 2],
    opposite: bool,
}

/// Union-find with parity: sets of points whose normals' signs are known relative to each other.
struct Sides {
    parents: Vec<u32>,
    /// Parity: whether a point's sign differs from its parent's.
    opposite: Vec<bool>,
    sizes: Vec<u32>,
}

impl Sides {
    fn new(count: usize) -> Self {
        Self {
            parents: (0..count as u32).collect(),
            opposite: vec![false; count],
            sizes: vec![1; count],
        }
    }

    /// The root of a point's set, and whether the point's sign differs from the root's.
    fn root(&self, point: usize) -> (usize, bool) {
        let (mut at, mut opposite) = (point, false);
        while self.parents[at] as usize != at {
            opposite ^= self.opposite[at];
            at = self.parents[at] as usize;
        }
        (at, opposite)
    }

    /// Joins the sets of an edge's ends, the smaller to the larger (union by size). False if they are one already.
    fn join(&mut self, edge: &Edge) -> bool {
        let [(a, a_opposite), (b, b_opposite)] = edge.ends.map(|end| self.root(end as usize));
        if a == b {
            return false;
        }
        let (large, small) = if self.sizes[a] >= self.sizes[b] {
            (a, b)
        } else {
            (b, a)
        };
        self.parents[small] = large as u32;
        self.opposite[small] = a_opposite ^ b_opposite ^ edge.opposite;
        self.sizes[large] += self.sizes[small];
        true
    }

    fn join_along(&mut self, edges: &[Edge]) {
        for edge in edges {
            self.join(edge);
        }
    }

    /// Joins sets that the graph left apart, each to its nearest other one, until there is only one.
    fn bridge(&mut self, planes: &Planes, tree: &Tree, count: NonZeroUsize) {
        let points = planes.points;
        let mut count = count;
        loop {
            let roots: Vec<usize> = (0..points.len()).map(|at| self.root(at).0).collect();
            let Some(largest) = roots.iter().copied().max_by_key(|&root| self.sizes[root]) else {
                return;
            };
            if self.sizes[largest] as usize == points.len() || count.get() > points.len() {
                return;
            }
            count = count.saturating_mul(NonZeroUsize::MIN.saturating_add(1));
            let mut found: Vec<(f32, u32, u32)> = (0..points.len())
                .into_par_iter()
                .filter(|&at| roots[at] != largest)
                .filter_map(|at| {
                    let mut near = tree.nearest_n(&points[at], count);
                    let other = near.find(|near| roots[near.index] != roots[at])?;
                    Some((other.distance_sq, at as u32, other.index as u32))
                })
                .collect();
            found.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
            for (_, a, b) in found {
                self.join(&planes.edge(a, b));
            }
        }
    }
}

/// Whether the normals of the outermost points face outward, by majority over the 26 directions of a cube's faces, edges
/// and corners.
fn faces_outward(points: &[Point3<f32>], normals: &[Vector3<f64>]) -> bool {
    let steps = [-1.0, 0.0, 1.0];
    let mut vote = 0.0;
    for direction in steps.iter().flat_map(|&x| {
        steps
            .iter()
            .flat_map(move |&y| steps.map(|z| Vector3::new(x, y, z)))
    }) {
        let Some(direction) = direction.try_normalize(0.0) else {
            continue;
        };
        let height = |at: &usize| points[*at].coords.cast::<f64>().dot(&direction);
        let outermost = (0..points.len()).max_by(|a, b| height(a).total_cmp(&height(b)));
        if let Some(outermost) = outermost {
            let along = normals[outermost].dot(&direction);
            vote += along * along.abs();
        }
    }
    vote >= 0.0
}
