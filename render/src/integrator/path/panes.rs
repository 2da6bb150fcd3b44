//! Panes on the straight ways of paths and of shadow rays: both go through, and are dimmed.
//!
//! Elsewhere glass hides lights from light samples, and paths that leave it see them with their whole weight. Through a
//! pane a bounce keeps its direction, and so its density: light samples look through the pane too, and both are weighted
//! as if it were not there. A bounce that meets a pane with the transmittance `T` and reflectance `R` goes through with the
//! probability `p = max T / (max T + max R)`, and otherwise is reflected. Panes are no vertices of paths then.
//!
//! What the camera sees through panes, and through panes in mirrors, is refracted by both faces as by other glass.

use glam::Vec3;
use halfdome_kernel::{self as kernel, Ray, offset_point};
use smallvec::SmallVec;

use super::Advance;
use crate::estimator::ShadowRay;
use crate::integrator::path_block::{LANES, PathBlock, ShadowRays};
use crate::integrator::state::Path;
use crate::light::Receiver;
use crate::world::{Next, Pane, chance, time_of};

/// The most panes that a bounce goes through or is reflected by, one after the other.
const MAX_PANES: usize = 16;

impl Advance<'_, '_> {
    /// Takes bounces and aimed paths that have hit panes through them, or reflects them.
    #[inline(never)]
    pub(super) fn pass_panes(&mut self) {
        let Some(glass) = self.world.panes() else { return };
        let mut waiting: Vec<usize> = (0..self.wave.paths.len()).collect();
        for _ in 0..MAX_PANES {
            waiting.retain(|&source| {
                let (path, ray, hit) = (&self.wave.paths[source], &self.wave.rays[source], &self.wave.hits[source]);
                if !meets_panes(path) || !self.world.is_clear_glass(hit) {
                    return false;
                }
                let Next::Pane(pane) = glass.next(ray) else { return false };
                let (is_first_hit, time) = (pane.enters == hit.t, time_of(self.batch.times, path.index as usize));
                let inside = pane.inside(ray);
                is_first_hit && (pane.enters == pane.leaves || self.is_free(&inside, time)) && self.pass(source, &pane)
            });
            if waiting.is_empty() {
                return;
            }
            self.wave.trace_again(self.world, self.batch.times, &waiting);
        }
    }

    /// Whether a part of a ray at a pane hits nothing.
    fn is_free(&mut self, part: &Ray, time: f32) -> bool {
        self.wave.traced_at_panes += 1;
        !self.world.occluded_at(part, time)
    }

    /// Takes a path through a pane, or reflects it; whether it goes on.
    fn pass(&mut self, source: usize, pane: &Pane) -> bool {
        let world = self.world;
        let (path, ray, hit) = (&mut self.wave.paths[source], &mut self.wave.rays[source], &self.wave.hits[source]);
        let Pane { leaves, normal, transmittance, reflectance, .. } = *pane;
        let [through, back] = [transmittance, reflectance].map(|part| part.max_element());
        if through + back <= 0.0 {
            path.throughput = Vec3::ZERO;
            return false;
        }
        let probability = through / (through + back);
        if path.is_aimed() || chance(ray, hit) < probability {
            // From the same origin, so that distances stay those of light samples.
            path.throughput *= if path.is_aimed() { transmittance } else { transmittance / probability };
            path.normal = path.normal_behind_pane();
            ray.t_min = leaves.next_up();
            return path.throughput.max_element() > 0.0;
        }
        let direction = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
        let origin = offset_point(ray.at(hit.t), normal, world.placed_record(hit).offset, direction);
        path.normal = path.normal_mirrored_by(Receiver::pack(normal, false));
        path.throughput *= reflectance / (1.0 - probability);
        (path.density, path.target) = (f32::INFINITY, 0);
        *ray = Ray::new(origin, direction);
        let on_the_way = self.wave.transmittance(world, source, hit.t);
        self.wave.paths[source].throughput *= on_the_way;
        self.record_mirrored(source);
        true
    }

    /// Takes the shadow rays of a block through panes.
    #[inline(never)]
    pub(super) fn pass_shadows(&mut self, block: &PathBlock, shadows: &mut ShadowRays) {
        let Some(glass) = self.world.panes() else { return };
        shadows.start_at_surfaces();
        let mut lit = SmallVec::<[usize; LANES]>::new();
        lit.extend((0..block.len).filter(|&i| shadows.is_lit(i)));
        let rays: SmallVec<[Ray; LANES]> = lit.iter().map(|&i| shadows.ray(i)).collect();
        let mut hits = [kernel::Hit::MISS; LANES];
        glass.intersect_many(&rays, &mut hits[..rays.len()]);
        let mut before = Vec::new();
        let (mut parts, mut times) = (Vec::new(), Vec::new());
        for ((&i, ray), hit) in lit.iter().zip(&rays).zip(&hits).filter(|(_, hit)| hit.is_hit()) {
            let add = |part: Ray| {
                parts.push(part);
                times.push(time_of(self.batch.times, block.index(i)));
                before.push(i);
            };
            match glass.cross(ray, hit, add) {
                Some((rest, transmittance)) => shadows.pass(i, rest.t_min, transmittance),
                None => shadows.lose(i),
            }
        }
        let mut occluded = vec![false; parts.len()];
        self.world.occluded_many_at(&parts, &times, &mut occluded);
        self.wave.traced_at_panes += parts.len() as u64;
        before.iter().zip(occluded).filter(|(_, occluded)| *occluded).for_each(|(&i, _)| shadows.lose(i));
    }

    /// Takes a shadow ray of path `i` through panes; whether it goes on.
    pub(super) fn pass_shadow(&mut self, block: &PathBlock, i: usize, shadow: &mut ShadowRay) -> bool {
        let Some(glass) = self.world.panes() else { return true };
        let mut hits = [kernel::Hit::MISS];
        glass.intersect_many(&[shadow.ray], &mut hits);
        if !hits[0].is_hit() {
            return true;
        }
        let time = time_of(self.batch.times, block.index(i));
        let mut is_free = true;
        let crossed = glass.cross(&shadow.ray, &hits[0], |part| is_free &= self.is_free(&part, time));
        let Some((rest, transmittance)) = crossed.filter(|_| is_free) else { return false };
        (shadow.ray, shadow.radiance) = (rest, shadow.radiance * transmittance);
        true
    }
}

/// Whether a path goes straight through panes: a bounce that light samples might have taken, or one that was aimed.
fn meets_panes(path: &Path) -> bool {
    !path.is_first() && (path.density < f32::INFINITY || path.is_aimed())
}
