//! A tree of axis-parallel boxes over a mesh's triangles.

use nalgebra::Point3;

/// Triangles in a leaf, at most.
const LEAF_MAX: usize = 4;

/// Which triangles are together; the boxes themselves follow from the vertices.
pub(super) struct BoxTree {
    /// Parents before children; the root first.
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
}

enum Node {
    Inner { children: [u32; 2] },
    Leaf { first: u32, end: u32 },
}

#[derive(Clone, Copy)]
struct Aabb {
    min: Point3<f64>,
    max: Point3<f64>,
}

impl BoxTree {
    /// Splits the triangles at the median along the longest side of their centres' box, again and again.
    pub fn new(vertices_m: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let centre = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|index| vertices_m[index as usize].coords);
            Point3::from((a + b + c) / 3.0)
        };
        let centres: Vec<Point3<f64>> = triangles.iter().map(centre).collect();
        let mut tree = Self {
            nodes: Vec::new(),
            order: (0..triangles.len() as u32).collect(),
        };
        if !triangles.is_empty() {
            tree.split(&centres, 0, triangles.len());
        }
        tree
    }

    fn split(&mut self, centres: &[Point3<f64>], first: usize, end: usize) -> u32 {
        let index = self.nodes.len();
        let [first_u32, end_u32] = [first, end].map(|k| k as u32);
        self.nodes.push(Node::Leaf {
            first: first_u32,
            end: end_u32,
        });
        if end - first > LEAF_MAX {
            let part = &mut self.order[first..end];
            let bounds = Aabb::around(part.iter().map(|&t| centres[t as usize]));
            let axis = (bounds.max - bounds.min).imax();
            let half = part.len() / 2;
            part.select_nth_unstable_by(half, |&a, &b| {
                let [a_at, b_at] = [a, b].map(|t| centres[t as usize][axis]);
                a_at.total_cmp(&b_at).then(a.cmp(&b))
            });
            let children = [(first, first + half), (first + half, end)]
                .map(|(first, end)| self.split(centres, first, end));
            self.nodes[index] = Node::Inner { children };
        }
        index as u32
    }

    /// Calls `visit` once for each pair of triangles whose boxes touch.
    pub fn for_near_pairs(
        &self,
        vertices_m: &[Point3<f64>],
        triangles: &[[u32; 3]],
        mut visit: impl FnMut(u32, u32),
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let boxes = Boxes::new(self, vertices_m, triangles);
        let mut pairs = vec![[0, 0]];
        while let Some([a, b]) = pairs.pop() {
            if a != b && !boxes.nodes[a as usize].touches(&boxes.nodes[b as usize]) {
                continue;
            }
            match (&self.nodes[a as usize], &self.nodes[b as usize]) {
                (&Node::Inner { children: [l, r] }, _) if a == b => {
                    pairs.extend([[l, l], [r, r], [l, r]]);
                }
                (
                    &Node::Leaf { first, end },
                    &Node::Leaf {
                        first: from,
                        end: to,
                    },
                ) => {
                    for i in first..end {
                        for j in from.max(if a == b { i + 1 } else { from })..to {
                            if boxes.leaves[i as usize].touches(&boxes.leaves[j as usize]) {
                                visit(self.order[i as usize], self.order[j as usize]);
                            }
                        }
                    }
                }
                (&Node::Inner { children: [l, r] }, _) => pairs.extend([[l, b], [r, b]]),
                (_, &Node::Inner { children: [l, r] }) => pairs.extend([[a, l], [a, r]]),
            }
        }
    }
}

/// Boxes of a tree's nodes, and of the triangles in the order of its leaves.
struct Boxes {
    nodes: Vec<Aabb>,
    leaves: Vec<Aabb>,
}

impl Boxes {
    fn new(tree: &BoxTree, vertices_m: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let of_triangle = |&index: &u32| {
            let corners = triangles[index as usize];
            Aabb::around(corners.into_iter().map(|v| vertices_m[v as usize]))
        };
        let leaves: Vec<Aabb> = tree.order.iter().map(of_triangle).collect();
        let mut nodes = vec![Aabb::EMPTY; tree.nodes.len()];
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            nodes[index] = match *node {
                Node::Leaf { first, end } => {
                    let inside = &leaves[first as usize..end as usize];
                    inside.iter().fold(Aabb::EMPTY, |all, one| all.with(one))
                }
                Node::Inner { children: [l, r] } => nodes[l as usize].with(&nodes[r as usize]),
            };
        }
        Self { nodes, leaves }
    }
}

impl Aabb {
    const EMPTY: Self = Self {
        min: Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        max: Point3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    fn around(points: impl Iterator<Item = Point3<f64>>) -> Self {
        points.fold(Self::EMPTY, |all, point| Self {
            min: all.min.inf(&point),
            max: all.max.sup(&point),
        })
    }

    fn with(&self, other: &Self) -> Self {
        Self {
            min: self.min.inf(&other.min),
            max: self.max.sup(&other.max),
        }
    }

    fn touches(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }
}
