//! Reading and writing PLY (Turk, "The PLY Polygon File Format", 1994), with the liberties that programs take: ASCII values
//! may be broken into lines anywhere, and unknown elements and properties are skipped.

mod header;
mod values;

use nalgebra::Point3;

use super::{Fault, Raw};
use header::{Element, Encoding, Header, Kind};
use values::Values;

const VERTEX: &str = "vertex";
const AXES: [&str; 3] = ["x", "y", "z"];
/// MeshLab's and PCL's names.
const NORMALS: [[&str; 3]; 2] = [["nx", "ny", "nz"], ["normal_x", "normal_y", "normal_z"]];

/// The vertices and faces of a whole PLY file, in its order.
pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    let (header, payload) = Header::parse(bytes)?;
    check(&header, payload.len())?;
    let read = Reader::read(&header, payload);
    // Some programs write an empty line between the header and binary data. Whether these bytes are data follows from the
    // length of the file.
    let break_len = payload
        .iter()
        .take_while(|byte| matches!(byte, b'\r' | b'\n'))
        .count()
        .min(2);
    let is_even =
        |read: &Result<Reader, Fault>| read.as_ref().is_ok_and(|read| read.values.is_at_end());
    let later = (1..=break_len).map(|len| Reader::read(&header, &payload[len..]));
    let read = match header.encoding {
        Encoding::Ascii => read,
        _ if is_even(&read) => read,
        _ => later.into_iter().find(is_even).unwrap_or(read),
    }?;
    if header.encoding == Encoding::Ascii && !read.values.is_at_end() {
        return Err(Fault::malformed(
            "it has more numbers than its header announces",
            "name all columns in the header, or export it again",
        ));
    }
    Ok(read.raw)
}

/// A binary little-endian PLY file of these points.
pub(super) fn encode(points: &[Point3<f32>]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement {VERTEX} {}\n\
         property float x\nproperty float y\nproperty float z\nend_header\n",
        points.len()
    )
    .into_bytes();
    bytes.extend(
        points
            .iter()
            .flat_map(|point| point.coords.iter())
            .flat_map(|coordinate| coordinate.to_le_bytes()),
    );
    bytes
}

/// Refuses a header without usable coordinates, or one that announces more data than the file has.
fn check(header: &Header, payload_len: usize) -> Result<(), Fault> {
    let Some(vertex) = header.element(VERTEX) else {
        let names: Vec<_> = header
            .elements
            .iter()
            .map(|element| element.name.as_str())
            .collect();
        return Err(Fault::NoCoordinates(format!(
            "elements [{}]",
            names.join(", ")
        )));
    };
    if places(vertex, AXES).is_none() {
        let names: Vec<_> = vertex
            .properties
            .iter()
            .map(|property| property.name.as_str())
            .collect();
        return Err(Fault::NoCoordinates(format!("[{}]", names.join(", "))));
    }
    let sizes = header.elements.iter().map(|element| {
        element
            .count
            .saturating_mul(element.smallest_size(header.encoding))
    });
    let needed = sizes.fold(0, usize::saturating_add);
    // Nothing needs to follow the last digit.
    let slack = usize::from(header.encoding == Encoding::Ascii);
    if needed > payload_len + slack {
        return Err(Fault::Truncated(format!(
            "its header announces at least {needed} bytes, there are {payload_len}"
        )));
    }
    Ok(())
}

fn places(element: &Element, names: [&str; 3]) -> Option<[usize; 3]> {
    match names.map(|name| element.scalar(name)) {
        [Some(x), Some(y), Some(z)] => Some([x, y, z]),
        _ => None,
    }
}

struct Reader<'a> {
    values: Values<'a>,
    vertex_count: usize,
    /// Limit on the number of triangles, in proportion to the file's size. It protects from a file whose faces have so many
    /// corners that their triangles would fill the memory.
    triangles_max: usize,
    raw: Raw,
}

impl<'a> Reader<'a> {
    fn read(header: &Header, payload: &'a [u8]) -> Result<Self, Fault> {
        let mut reader = Self {
            values: Values::new(payload, header.encoding),
            vertex_count: header.element(VERTEX).map_or(0, |element| element.count),
            triangles_max: payload.len() / 4 + (1 << 20),
            raw: Raw::default(),
        };
        for element in &header.elements {
            if element.is_called(VERTEX) {
                reader.vertices(element)?;
            } else if let (true, Some(corners)) = (element.is_called("face"), element.corners()) {
                reader
                    .raw
                    .triangles
                    .reserve_exact(element.count.min(payload.len() / 4));
                reader.lists(element, corners, Self::face)?;
            } else if let (true, Some(corners)) =
                (element.is_called("tristrips"), element.corners())
            {
                reader.lists(element, corners, Self::strip)?;
            } else if !element.properties.is_empty() {
                (0..element.count).try_for_each(|_| reader.skip(element))?;
            }
        }
        Ok(reader)
    }

    fn vertices(&mut self, element: &Element) -> Result<(), Fault> {
        let Some(axes) = places(element, AXES) else {
            return Ok(());
        };
        let normal = NORMALS.into_iter().find_map(|names| places(element, names));
        // The header's count has been held against the file's length.
        let mut raw = Raw::with_capacity(element.count, normal.is_some());
        let mut row = vec![0.0; element.properties.len()];
        let is_wanted =
            |at: &usize| axes.contains(at) || normal.is_some_and(|normal| normal.contains(at));
        let wanted: Vec<bool> = (0..row.len()).map(|at| is_wanted(&at)).collect();
        for _ in 0..element.count {
            for (at, property) in element.properties.iter().enumerate() {
                match wanted[at] {
                    true => row[at] = self.values.number(property.kind)?,
                    false => self.skip_property(element, at)?,
                }
            }
            raw.push(
                axes.map(|at| row[at]),
                normal.map(|places| places.map(|at| row[at])),
            );
        }
        (self.raw.points, self.raw.normals) = (raw.points, raw.normals);
        Ok(())
    }

    /// Reads an element of which one list counts.
    fn lists(
        &mut self,
        element: &Element,
        corners: usize,
        read: fn(&mut Self, &Element, usize, usize) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        for number in 0..element.count {
            for at in 0..element.properties.len() {
                match at == corners {
                    true => read(self, element, at, number)?,
                    false => self.skip_property(element, at)?,
                }
            }
        }
        Ok(())
    }

    /// Cuts a polygon into a fan about its first corner.
    fn face(&mut self, element: &Element, at: usize, number: usize) -> Result<(), Fault> {
        let length = self.length(element, at)?;
        let mut fan = [0; 2];
        for corner in 0..length {
            let index = self.index(element, at, number)?;
            if corner >= 2 {
                self.triangle([fan[0], fan[1], index])?;
            }
            fan[usize::from(corner > 0)] = index;
        }
        Ok(())
    }

    /// Triangle strip: each corner after the first two makes a triangle with the two before it, with alternating
    /// orientation; −1 starts a new strip (as in Stanford's scans).
    fn strip(&mut self, element: &Element, at: usize, number: usize) -> Result<(), Fault> {
        let kind = element.properties[at].kind;
        let mut before = [None; 2];
        let mut is_turned = false;
        for _ in 0..self.length(element, at)? {
            let index = self.values.whole(kind)?;
            if index == -1 || (kind == Kind::U32 && index == i64::from(u32::MAX)) {
                (before, is_turned) = ([None; 2], false);
                continue;
            }
            let index = self.checked(index, element, number)?;
            if let [Some(first), Some(second)] = before {
                self.triangle(match is_turned {
                    true => [second, first, index],
                    false => [first, second, index],
                })?;
                is_turned = !is_turned;
            }
            before = [before[1], Some(index)];
        }
        Ok(())
    }

    fn triangle(&mut self, corners: [u32; 3]) -> Result<(), Fault> {
        if self.raw.triangles.len() >= self.triangles_max {
            return Err(Fault::malformed(
                "its faces have too many corners for its size",
                header::EXPORT,
            ));
        }
        self.raw.triangles.push(corners);
        Ok(())
    }

    fn index(&mut self, element: &Element, at: usize, number: usize) -> Result<u32, Fault> {
        let index = self.values.whole(element.properties[at].kind)?;
        self.checked(index, element, number)
    }

    fn checked(&self, index: i64, element: &Element, number: usize) -> Result<u32, Fault> {
        let found = u32::try_from(index).ok();
        found
            .filter(|&index| (index as usize) < self.vertex_count)
            .ok_or_else(|| {
                let reason = format!(
                    "{} {number} names vertex {index}, of vertices 0 to {}",
                    element.name,
                    self.vertex_count as i64 - 1
                );
                Fault::malformed(reason, header::EXPORT)
            })
    }

    fn length(&mut self, element: &Element, at: usize) -> Result<usize, Fault> {
        let Some(kind) = element.properties[at].length else {
            return Ok(1);
        };
        let length = self.values.whole(kind)?;
        usize::try_from(length).map_err(|_| {
            let name = &element.properties[at].name;
            Fault::malformed(format!("a list {name:?} of {length}"), header::EXPORT)
        })
    }

    fn skip(&mut self, element: &Element) -> Result<(), Fault> {
        (0..element.properties.len()).try_for_each(|at| self.skip_property(element, at))
    }

    fn skip_property(&mut self, element: &Element, at: usize) -> Result<(), Fault> {
        let length = self.length(element, at)?;
        self.values.skip(element.properties[at].kind, length)
    }
}
