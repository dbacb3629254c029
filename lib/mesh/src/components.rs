//! Connected components.

use petgraph::unionfind::UnionFind;

/// The connected component of each vertex, numbered from 0 in the order of the triangles, and how many there are. A vertex
/// without a triangle has the number `u32::MAX`.
///
/// # Panics
/// If a triangle names a vertex that does not exist.
pub fn components(vertex_count: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let mut sets: UnionFind<u32> = UnionFind::new(vertex_count);
    for &[a, b, c] in triangles {
        sets.union(a, b);
        sets.union(a, c);
    }
    let set_of = sets.into_labeling();
    let mut number_of_set = vec![u32::MAX; vertex_count];
    let mut numbers = vec![u32::MAX; vertex_count];
    let mut count = 0;
    for &corner in triangles.iter().flatten() {
        let number = &mut number_of_set[set_of[corner as usize] as usize];
        if *number == u32::MAX {
            *number = count;
            count += 1;
        }
        numbers[corner as usize] = *number;
    }
    (numbers, count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_numbered_as_their_triangles_come() {
        let triangles = [[5, 6, 7], [0, 1, 2], [7, 3, 5], [1, 2, 4]];
        let (numbers, count) = components(9, &triangles);
        assert_eq!(numbers, [1, 1, 1, 0, 1, 0, 0, 0, u32::MAX]);
        assert_eq!(count, 2);
        assert_eq!(components(0, &[]), (Vec::new(), 0));
    }
}
