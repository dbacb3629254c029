//! The lower end of an object, which the hand hides.

use crate::agreement::hidden;
use nalgebra::{Point3, Vector2};
use std::f32::consts::TAU;

/// Directions about the object's axis that are told apart.
const SECTORS: usize = 72;
/// The wall above a hidden part is taken from so many metres above it.
const BAND_M: f32 = 0.008;
/// Distance of the points that are added, m.
const STEP_M: f32 = 0.002;
/// Some strays may lie below the wall.
const STRAYS: usize = 4;
/// What is hidden farther than the fingers reach is not guessed, m.
const MARGIN_M: f32 = 0.005;

/// The wall in one direction.
#[derive(Debug, Clone, Copy)]
struct Wall {
    radius_m: f32,
    /// Where it begins to be seen.
    lowest_m: f32,
}

/// The points of one grasp (hand's frame, m) and points where the hand hides the lower end: the wall goes straight down from
/// where it is seen to where the object stands between the fingers, and is closed there.
///
/// Without them the object would be learned as that much shorter: in the hand again, its lower end is hidden again. Points that
/// do not come down between the fingers on all sides are given back as they are.
pub fn with_lower_end(points: &[Point3<f32>]) -> Vec<Point3<f32>> {
    let hidden = hidden();
    let bottom_m = hidden.below_m as f32;
    let highest_m = hidden.fingertips_m as f32 + MARGIN_M;
    let mut all = points.to_vec();
    let low = points.iter().filter(|point| point.z < highest_m + BAND_M);
    let low: Vec<Point3<f32>> = low.copied().collect();
    let Some(bounds) = cloud::bounds(&low) else {
        return all;
    };
    let centre = bounds.centre().xy();
    let Some(walls) = walls(&low, &centre.coords, highest_m) else {
        return all;
    };
    // Twice as many lines as sectors, so that they are no farther from each other than the points on them.
    let lines = 2 * SECTORS;
    for line in 0..lines {
        let turn = TAU * line as f32 / lines as f32;
        let wall = between(&walls, turn);
        let aside = wall.radius_m * Vector2::new(turn.cos(), turn.sin());
        let mut z = bottom_m;
        while z < wall.lowest_m {
            all.push(Point3::new(centre.x + aside.x, centre.y + aside.y, z));
            z += STEP_M;
        }
    }
    let widest_m = walls.iter().map(|wall| wall.radius_m).fold(0.0, f32::max);
    let reach = (widest_m / STEP_M).ceil() as i32;
    for (x, y) in (-reach..=reach).flat_map(|x| (-reach..=reach).map(move |y| (x, y))) {
        let aside = STEP_M * Vector2::new(x as f32, y as f32);
        let wall = between(&walls, aside.y.atan2(aside.x));
        if aside.norm() < wall.radius_m - 0.5 * STEP_M {
            all.push(Point3::new(
                centre.x + aside.x,
                centre.y + aside.y,
                bottom_m,
            ));
        }
    }
    all
}

/// The wall in each direction; `None` where most directions show none.
fn walls(low: &[Point3<f32>], centre: &Vector2<f32>, highest_m: f32) -> Option<[Wall; SECTORS]> {
    let mut of_sector: Vec<Vec<(f32, f32)>> = vec![Vec::new(); SECTORS];
    for point in low {
        let aside = point.xy().coords - centre;
        let sector = sector_of(aside.y.atan2(aside.x)) as usize % SECTORS;
        of_sector[sector].push((point.z, aside.norm()));
    }
    let seen: Vec<Option<Wall>> = of_sector
        .into_iter()
        .map(|mut seen| {
            seen.sort_by(|a, b| a.0.total_cmp(&b.0));
            let lowest_m = seen.get(STRAYS)?.0;
            let band = seen.iter().filter(|at| at.0 < lowest_m + BAND_M);
            let mut radii: Vec<f32> = band.map(|at| at.1).collect();
            radii.sort_by(f32::total_cmp);
            let radius_m = *radii.get(radii.len() / 2)?;
            (lowest_m <= highest_m).then_some(Wall { radius_m, lowest_m })
        })
        .collect();
    if 2 * seen.iter().flatten().count() < SECTORS {
        return None;
    }
    let nearest = |from: usize, step: usize| {
        let mut around = (1..SECTORS).map(|far| (far, (from + far * step) % SECTORS));
        around.find_map(|(far, at)| seen[at].map(|wall| (far as f32, wall)))
    };
    let mut walls = [Wall {
        radius_m: 0.0,
        lowest_m: 0.0,
    }; SECTORS];
    for (at, wall) in walls.iter_mut().enumerate() {
        *wall = match seen[at] {
            Some(wall) => wall,
            None => {
                let (after, next) = nearest(at, 1)?;
                let (before, last) = nearest(at, SECTORS - 1)?;
                mix(last, next, before / (before + after))
            }
        };
    }
    Some(walls)
}

/// Position of an angle (rad) among the sectors, from 0.
fn sector_of(turn: f32) -> f32 {
    turn.rem_euclid(TAU) / TAU * SECTORS as f32
}

/// The wall at an angle (rad), between the middles of two sectors.
fn between(walls: &[Wall; SECTORS], turn: f32) -> Wall {
    let at = (sector_of(turn) - 0.5).rem_euclid(SECTORS as f32);
    let first = at as usize % SECTORS;
    mix(walls[first], walls[(first + 1) % SECTORS], at.fract())
}

fn mix(a: Wall, b: Wall, share_of_b: f32) -> Wall {
    let mix = |a: f32, b: f32| a + share_of_b * (b - a);
    Wall {
        radius_m: mix(a.radius_m, b.radius_m),
        lowest_m: mix(a.lowest_m, b.lowest_m),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Recorded;
    use mesh::Mesh;
    use nalgebra::Isometry3;
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    /// What one grasp shows of a can of 30 mm and 100 mm.
    fn seen() -> Vec<Point3<f32>> {
        let bottom_m = hidden().below_m as f32;
        let can = Mesh::cylinder(0.03, 0.0, 0.1, 96);
        let can = can.transformed(&Isometry3::translation(0.004, -0.003, bottom_m));
        let all = can.surface_points(40_000, &mut Pcg64Mcg::seed_from_u64(1));
        let is_hidden = |point: &Point3<f32>| {
            let height_m = point.z - bottom_m;
            height_m < 0.016 || (height_m < 0.03 && (point.x - 0.004).abs() < 0.008)
        };
        all.into_iter().filter(|point| !is_hidden(point)).collect()
    }

    #[test]
    fn an_object_of_which_the_hand_hides_the_lower_end_is_as_high_as_it_is() {
        let seen = seen();
        let recorded = Recorded::of_one_grasp(&seen);
        let Ok(recorded) = recorded else {
            panic!("{recorded:?}");
        };
        let (min, max) = recorded.mesh.bounds();
        let extent = max - min;
        assert!((extent.z - 0.1).abs() < 0.002, "{extent}");
        assert!((extent.x - 0.06).abs() < 0.002 && (extent.y - 0.06).abs() < 0.002);
        assert!(recorded.mesh.is_closed_manifold());
        let share = recorded.unseen().seen_share();
        assert!((0.75..0.9).contains(&share), "{share}");
    }

    #[test]
    fn what_does_not_come_down_between_the_fingers_is_left_as_it_is() {
        let raised: Vec<Point3<f32>> = seen()
            .iter()
            .map(|at| Point3::new(at.x, at.y, at.z + 0.05))
            .collect();
        assert_eq!(with_lower_end(&raised), raised);
        assert!(with_lower_end(&[]).is_empty());
    }
}
