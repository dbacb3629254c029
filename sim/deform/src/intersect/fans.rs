//! The triangles around each vertex.

use nalgebra::{Point3, Unit, Vector3};

/// Which triangles are around each vertex of a mesh.
pub(super) struct Fans {
    /// Around vertex i are `around[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    around: Vec<Sector>,
    /// Whether the triangles around each vertex close up, each edge between exactly two of them.
    is_closed: Vec<bool>,
}

/// A triangle as its first corner sees it.
#[derive(Clone, Copy)]
struct Sector {
    triangle: u32,
    others: [u32; 2],
}

impl Fans {
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut sectors = Vec::with_capacity(3 * triangles.len());
        for (triangle, &[a, b, c]) in (0..).zip(triangles) {
            for (apex, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                sectors.push((apex, Sector { triangle, others }));
            }
        }
        sectors.sort_by_key(|(apex, _)| *apex);
        let start = |vertex| sectors.partition_point(|(apex, _)| *apex < vertex) as u32;
        let starts = (0..=vertex_count as u32).map(start).collect();
        let mut fans = Self {
            starts,
            around: sectors.into_iter().map(|(_, sector)| sector).collect(),
            is_closed: Vec::new(),
        };
        let is_closed = |vertex| {
            let sorted = |k: usize| {
                let mut ends: Vec<u32> = fans.of(vertex).iter().map(|s| s.others[k]).collect();
                ends.sort_unstable();
                ends
            };
            let [from, to] = [sorted(0), sorted(1)];
            from == to && from.windows(2).all(|pair| pair[0] != pair[1])
        };
        fans.is_closed = (0..vertex_count).map(is_closed).collect();
        fans
    }

    /// For each vertex, whether its triangles surely do not pass through each other: seen along the vertex's normal they
    /// all show their front and go round once, so that each has a sector of its own.
    ///
    /// `normals`: of the triangles, as long as twice their areas.
    pub fn are_plain(&self, vertices_m: &[Point3<f64>], normals: &[Vector3<f64>]) -> Vec<bool> {
        (0..vertices_m.len())
            .map(|vertex| self.is_plain(vertex, vertices_m, normals))
            .collect()
    }

    fn is_plain(
        &self,
        vertex: usize,
        vertices_m: &[Point3<f64>],
        normals: &[Vector3<f64>],
    ) -> bool {
        let fan = self.of(vertex);
        let of_triangle = |sector: &Sector| normals[sector.triangle as usize];
        let sum: Vector3<f64> = fan.iter().map(of_triangle).sum();
        let Some(normal) = Unit::try_new(sum, 0.0) else {
            return false;
        };
        let aside = sum.cross(&Vector3::ith(sum.iamin(), 1.0));
        let height = |other: u32| (vertices_m[other as usize] - vertices_m[vertex]).dot(&aside);
        let mut rounds = 0;
        for sector in fan {
            let front = of_triangle(sector);
            // Far from the rounding of the product.
            if front.dot(&normal) <= 1e-6 * front.norm() {
                return false;
            }
            let [from, to] = sector.others.map(height);
            rounds += i32::from(from < 0.0 && to >= 0.0);
        }
        self.is_closed[vertex] && rounds == 1
    }

    fn of(&self, vertex: usize) -> &[Sector] {
        &self.around[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}
