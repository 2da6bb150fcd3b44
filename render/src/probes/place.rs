//! Valid positions of probes: outside of walls and other bodies.
//!
//! A probe more than a quarter of whose directions end on the back of a surface is covered. (Surfaces that are meant to
//! be seen from both sides have no back, and glass is no body.) On a grid it is moved to the nearest free point of its
//! own cell. If there is none it is *filled*: it gets the mean of its neighbours that are free or already filled,
//! weighted by the inverse square of their distance, nearest first. So light at covered points is never used.

use glam::Vec3;
use halfdome_kernel::Ray;
use rayon::prelude::*;

use super::gather::ProbeLight;
use super::quadrature::Quadrature;
use super::{Probe, ProbeGrid, State};
use crate::watch::Watch;
use crate::world::{Hit, World};

/// A point is covered if it sees more backs than this part of all directions.
const BACKS: f32 = 0.25;
/// Rings of directions for the test.
const RINGS: u32 = 8;
/// The side of the grid on which free points of a cell are sought.
const CANDIDATES: i32 = 5;
/// How far from the middle of its cell a probe is moved at most, in cells.
const REACH: f32 = 0.4;

/// Whether a point that sees this many backs is covered.
pub(super) fn is_covered(backs: f32) -> bool {
    backs > BACKS
}

/// The part of all directions in which each point sees the back of something; `None` if the watcher stops.
pub(super) fn backs(world: &World, points: &[Vec3], watch: &dyn Watch) -> Option<Vec<f32>> {
    let sphere: Vec<(Vec3, f32)> =
        Quadrature::new(RINGS).points().map(|(direction, weight)| (direction.as_vec3(), weight as f32)).collect();
    let bodies = world.bodies();
    let share = |point: &Vec3| {
        if watch.stop() {
            return None;
        }
        let rays: Vec<Ray> = sphere.iter().map(|(direction, _)| Ray::new(*point, *direction)).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        world.intersect_many(&rays, &mut hits);
        let is_back = |(ray, hit): (&Ray, &Hit)| hit.is_hit() && bodies.is_back(world, ray, hit);
        let seen = rays.iter().zip(&hits).zip(&sphere).filter(|(pair, _)| is_back(*pair));
        Some(seen.map(|(_, (_, weight))| weight).sum::<f32>() / (4.0 * std::f32::consts::PI))
    };
    points.par_iter().map(share).collect()
}

/// Probes of a grid, moved where they would be covered; `None` if the watcher stops. Their light is yet to be found.
pub(super) fn probes(world: &World, grid: &ProbeGrid, watch: &dyn Watch) -> Option<Vec<Probe>> {
    let middles: Vec<Vec3> = grid.positions().collect();
    let seen = backs(world, &middles, watch)?;
    let place = |(position, backs): (Vec3, f32)| {
        let mut probe = Probe { position, state: State::Free, backs, light: ProbeLight::default() };
        if is_covered(backs) {
            let points: Vec<Vec3> = offsets().iter().map(|offset| position + *offset * grid.cell()).collect();
            let seen = self::backs(world, &points, watch)?;
            match seen.iter().position(|backs| !is_covered(*backs)) {
                Some(free) => (probe.position, probe.backs, probe.state) = (points[free], seen[free], State::Moved),
                None => probe.state = State::Covered,
            }
        }
        Some(probe)
    };
    middles.into_par_iter().zip(seen).map(place).collect()
}

/// Points of a cell, from the middle to the corners, in cells.
fn offsets() -> Vec<Vec3> {
    let half = CANDIDATES / 2;
    let line = || -half..=half;
    let mut offsets: Vec<[i32; 3]> = line()
        .flat_map(|z| line().flat_map(move |y| line().map(move |x| [x, y, z])))
        .filter(|o| *o != [0; 3])
        .collect();
    offsets.sort_by_key(|o| o.iter().map(|x| x * x).sum::<i32>());
    offsets.into_iter().map(|o| Vec3::from_array(o.map(|x| x as f32)) * (REACH / half as f32)).collect()
}

/// Fills covered probes from their neighbours.
pub(super) fn fill(grid: &ProbeGrid, probes: &mut [Probe]) {
    loop {
        let filled: Vec<(usize, ProbeLight)> = (0..probes.len())
            .filter(|&i| probes[i].state == State::Covered)
            .filter_map(|i| Some((i, mean_of_neighbours(grid, probes, i)?)))
            .collect();
        if filled.is_empty() {
            return;
        }
        for (i, light) in filled {
            (probes[i].light, probes[i].state) = (light, State::Filled);
        }
    }
}

/// The mean of the up to 26 neighbours that have light.
fn mean_of_neighbours(grid: &ProbeGrid, probes: &[Probe], index: usize) -> Option<ProbeLight> {
    let place = grid.place(index);
    let (mut sum, mut weights) = (ProbeLight::default(), 0.0);
    let near = |axis: usize| {
        let at = place[axis];
        at.saturating_sub(1)..(at + 2).min(grid.count[axis])
    };
    for (z, y) in near(2).flat_map(|z| near(1).map(move |y| (z, y))) {
        for x in near(0) {
            let other = grid.index([x, y, z]);
            if other != index && probes[other].state != State::Covered {
                let steps = Vec3::from_array([x, y, z].map(|x| x as f32)) - Vec3::from_array(place.map(|x| x as f32));
                let weight = (steps * grid.cell()).length_squared().max(f32::MIN_POSITIVE).recip();
                sum.add(&probes[other].light, weight);
                weights += weight;
            }
        }
    }
    let mut mean = ProbeLight::default();
    mean.add(&sum, 1.0 / weights);
    (weights > 0.0).then_some(mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_covered_is_filled_from_outside_inwards() {
        let grid = ProbeGrid { min: Vec3::ZERO, max: Vec3::new(5.0, 1.0, 1.0), count: [5, 1, 1] };
        let probe = |light: f32, state| Probe {
            position: Vec3::ZERO,
            state,
            backs: 0.0,
            light: ProbeLight { harmonics: [Vec3::splat(light); 9], axes: [Vec3::splat(light); 6] },
        };
        let covered = probe(1000.0, State::Covered);
        let mut probes = [probe(1.0, State::Free), covered, covered, covered, probe(3.0, State::Moved)];
        fill(&grid, &mut probes);
        let found = probes.map(|probe| (probe.light.axes[0].x, probe.light.harmonics[8].z, probe.state));
        let expected = [
            (1.0, 1.0, State::Free),
            (1.0, 1.0, State::Filled),
            (2.0, 2.0, State::Filled),
            (3.0, 3.0, State::Filled),
            (3.0, 3.0, State::Moved),
        ];
        assert_eq!(found, expected);
        let mut lost = [covered; 5];
        fill(&grid, &mut lost);
        assert!(lost.iter().all(|probe| probe.state == State::Covered));
    }

    #[test]
    fn offsets_stay_in_the_cell_and_grow() {
        let offsets = offsets();
        assert_eq!(offsets.len(), 124);
        assert!(offsets.iter().all(|offset| offset.abs().max_element() <= REACH));
        assert!(offsets.is_sorted_by(|a, b| a.length() <= b.length() + 1e-6));
    }
}
