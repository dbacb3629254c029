//! Wavefront OBJ: vertices, normals and faces. Textures, materials, groups, lines and curves are read over.

use std::str::SplitWhitespace;

use cloud::Surface;
use nalgebra::{Point3, Vector3};

/// What is wrong, and where.
#[derive(Debug)]
pub(super) struct Fault {
    /// Counted from 1.
    pub line: usize,
    pub reason: String,
}

/// The vertices and faces of a whole file, in its order.
///
/// A vertex's normal is the sum of those that its faces give it. In a file without faces the normals belong to the
/// vertices in order, if they are as many.
pub(super) fn parse(text: &str) -> Result<Surface, Fault> {
    let mut obj = Obj::default();
    for (number, line) in text.lines().enumerate() {
        obj.add(line).map_err(|reason| Fault {
            line: number + 1,
            reason,
        })?;
    }
    Ok(obj.finish())
}

#[derive(Default)]
struct Obj {
    surface: Surface,
    normals: Vec<Vector3<f32>>,
    /// (vertex, normal) of each corner that names both.
    pairs: Vec<(usize, usize)>,
}

impl Obj {
    fn add(&mut self, line: &str) -> Result<(), String> {
        let statement = line.split('#').next().unwrap_or_default();
        let mut words = statement.split_whitespace();
        match words.next() {
            Some("v") => self.surface.points.push(Point3::from(numbers(words)?)),
            Some("vn") => self.normals.push(Vector3::from(numbers(words)?)),
            Some("f") => self.add_face(words)?,
            _ => {}
        }
        Ok(())
    }

    /// Cuts a polygon into a fan about its first corner.
    fn add_face(&mut self, words: SplitWhitespace) -> Result<(), String> {
        let corners = words
            .map(|word| self.corner(word))
            .collect::<Result<Vec<u32>, _>>()?;
        if corners.len() < 3 {
            return Err(format!("a face of {} corners", corners.len()));
        }
        let fan = (2..corners.len()).map(|last| [corners[0], corners[last - 1], corners[last]]);
        self.surface.triangles.extend(fan);
        Ok(())
    }

    /// The vertex of a corner, which is written `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&mut self, word: &str) -> Result<u32, String> {
        let mut parts = word.split('/');
        let vertex = parts.next().unwrap_or_default();
        let vertex = index(vertex, self.surface.points.len(), "vertex")?;
        if let Some(normal) = parts.nth(1).filter(|part| !part.is_empty()) {
            let normal = index(normal, self.normals.len(), "normal")?;
            self.pairs.push((vertex, normal));
        }
        Ok(vertex as u32)
    }

    fn finish(self) -> Surface {
        let mut surface = self.surface;
        if surface.triangles.is_empty() {
            let is_one_each = self.normals.len() == surface.points.len();
            surface.normals = is_one_each.then_some(self.normals);
        } else if !self.pairs.is_empty() {
            let mut sums = vec![Vector3::zeros(); surface.points.len()];
            for (vertex, normal) in self.pairs {
                sums[vertex] += self.normals[normal];
            }
            surface.normals = Some(sums);
        }
        surface
    }
}

/// The first three numbers; weights and colours may follow.
fn numbers(mut words: SplitWhitespace) -> Result<[f32; 3], String> {
    let mut next = || {
        let word = words.next().ok_or("fewer than three numbers")?;
        word.parse().map_err(|_| format!("\"{word}\" is no number"))
    };
    Ok([next()?, next()?, next()?])
}

/// An index from 0 from one that counts from 1, or backward from −1.
fn index(word: &str, count: usize, what: &str) -> Result<usize, String> {
    let written: i64 = word
        .parse()
        .map_err(|_| format!("\"{word}\" is no index of a {what}"))?;
    let index = if written < 0 {
        count as i64 + written
    } else {
        written - 1
    };
    usize::try_from(index)
        .ok()
        .filter(|&index| index < count)
        .ok_or_else(|| format!("{what} {written}, where {count} were given so far"))
}
