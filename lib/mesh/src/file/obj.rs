//! Wavefront OBJ: vertices, normals and faces. Textures, materials, groups, lines and curves are read over.

use cloud::text::{self, Lines, Tokens};
use nalgebra::{Point3, Vector3};

/// What is wrong, and where.
#[derive(Debug)]
pub(super) struct Fault {
    /// Counted from 1.
    pub line: usize,
    pub reason: String,
}

/// What a file holds; the triangles name points that are there.
#[derive(Debug)]
pub(super) struct Raw {
    pub points: Vec<Point3<f32>>,
    pub normals: Option<Vec<Vector3<f32>>>,
    pub triangles: Vec<[u32; 3]>,
}

/// The vertices and faces of a whole file, in its order.
///
/// A vertex's normal is the sum of those that its faces give it; if they name one that the file does not have, there are
/// none. In a file without faces the normals belong to the vertices in order, if they are as many.
pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    let at = |line| move |reason| Fault { line, reason };
    let text = text::without_mark(bytes);
    let text = text.map_err(|error| at(1)(format!("{error}; save it as UTF-8")))?;
    let mut obj = Obj {
        triangles_max: text.len() / 4 + (1 << 20),
        ..Obj::default()
    };
    let mut lines = Lines::new(text);
    while let Some(line) = lines.next() {
        let first = lines.taken();
        match line.strip_suffix(b"\\") {
            // A backslash continues the statement in the next line. Comments and paths may also end with one.
            Some(part) if is_read(line) => {
                let mut whole = part.to_vec();
                for next in lines.by_ref() {
                    let part = next.strip_suffix(b"\\");
                    whole.push(b' ');
                    whole.extend(part.unwrap_or(next));
                    if part.is_none() {
                        break;
                    }
                }
                obj.add(&whole, first)
            }
            _ => obj.add(line, first),
        }
        .map_err(at(first))?;
    }
    obj.finish()
}

fn is_read(line: &[u8]) -> bool {
    let word = Tokens::new(line).next();
    word.is_some_and(|word| [b"v".as_slice(), b"vn", b"f"].contains(&word))
}

#[derive(Default)]
struct Obj {
    points: Vec<Point3<f32>>,
    normals: Vec<Vector3<f32>>,
    triangles: Vec<[u32; 3]>,
    /// Limit on the number of triangles, in proportion to the file's size. It protects from a file whose faces have so many
    /// corners that their triangles would fill the memory.
    triangles_max: usize,
    /// (vertex, normal) of each corner that names both.
    pairs: Vec<[u32; 2]>,
    /// The largest index of a vertex that a face names, and the line of the face: it may name what follows.
    farthest: (u32, usize),
}

impl Obj {
    fn add(&mut self, line: &[u8], number: usize) -> Result<(), String> {
        let statement = line.split(|&byte| byte == b'#').next();
        let mut words = Tokens::new(statement.unwrap_or_default());
        match words.next() {
            Some(b"v") => self.points.push(Point3::from(numbers(words)?)),
            Some(b"vn") => self.normals.push(Vector3::from(numbers(words)?)),
            Some(b"f") => self.add_face(words, number)?,
            _ => {}
        }
        Ok(())
    }

    /// Cuts a polygon into a fan about its first corner.
    fn add_face(&mut self, words: Tokens, line: usize) -> Result<(), String> {
        let mut fan = [0; 2];
        let mut corners = 0;
        for word in words {
            let vertex = self.corner(word)?;
            if vertex > self.farthest.0 || self.farthest.1 == 0 {
                self.farthest = (vertex, line);
            }
            if corners >= 2 {
                if self.triangles.len() >= self.triangles_max {
                    return Err("the faces have too many corners for the file's size".to_owned());
                }
                self.triangles.push([fan[0], fan[1], vertex]);
            }
            fan[usize::from(corners > 0)] = vertex;
            corners += 1;
        }
        match corners {
            0..3 => Err(format!("a face of {corners} corners")),
            _ => Ok(()),
        }
    }

    /// The vertex of a corner, which is written `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&mut self, word: &[u8]) -> Result<u32, String> {
        let mut parts = word.split(|&byte| byte == b'/');
        let vertex = index(
            parts.next().unwrap_or_default(),
            self.points.len(),
            "vertex",
        )?;
        if let Some(normal) = parts.nth(1).filter(|part| !part.is_empty()) {
            let normal = index(normal, self.normals.len(), "normal")?;
            self.pairs.push([vertex, normal]);
        }
        Ok(vertex)
    }

    fn finish(mut self) -> Result<Raw, Fault> {
        let (farthest, line) = self.farthest;
        if line > 0 && farthest as usize >= self.points.len() {
            return Err(Fault {
                line,
                reason: format!(
                    "vertex {}, of {}",
                    u64::from(farthest) + 1,
                    self.points.len()
                ),
            });
        }
        let normals = match self.triangles.is_empty() {
            true => {
                (self.normals.len() == self.points.len()).then(|| std::mem::take(&mut self.normals))
            }
            false => self.summed_normals(),
        };
        Ok(Raw {
            normals,
            points: self.points,
            triangles: self.triangles,
        })
    }

    fn summed_normals(&self) -> Option<Vec<Vector3<f32>>> {
        if self.pairs.is_empty() {
            return None;
        }
        let mut sums = vec![Vector3::zeros(); self.points.len()];
        for &[vertex, normal] in &self.pairs {
            sums[vertex as usize] += self.normals.get(normal as usize)?;
        }
        Some(sums)
    }
}

/// The first three numbers; weights and colours may follow.
fn numbers(mut words: Tokens) -> Result<[f32; 3], String> {
    let mut next = || text::number(words.next().ok_or("fewer than three numbers")?);
    Ok([next()?, next()?, next()?])
}

/// Converts an OBJ index to one from 0: OBJ counts from 1, or backward from −1, the last vertex so far.
fn index(word: &[u8], count: usize, what: &str) -> Result<u32, String> {
    let no_index = || {
        format!(
            "{:?} is no index of a {what}",
            String::from_utf8_lossy(word)
        )
    };
    let written: i64 = str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse().ok())
        .ok_or_else(no_index)?;
    let index = match written {
        1.. => Some(written - 1),
        0 => None,
        // As many as fit into memory.
        _ => (count as i64).checked_add(written),
    };
    let index = index.and_then(|index| u32::try_from(index).ok());
    index.ok_or_else(|| format!("{what} {written}, where {count} were given so far"))
}
