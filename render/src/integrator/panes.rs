//! Bounces that meet panes: they go straight through, and are dimmed, or they are reflected.
//!
//! Elsewhere glass hides lights from light samples, and paths that leave it see them with their whole weight. Through a
//! pane a bounce keeps its direction, and so its density: light samples look through the pane too, and both are weighted
//! as if it were not there. A bounce that meets a pane with the transmittance `T` and reflectance `R` goes through with the
//! probability `p = max T / (max T + max R)`, and otherwise is reflected. Panes are no vertices of paths then.
//!
//! What the camera sees through panes, and through panes in mirrors, is refracted by both faces as by other glass.

use glam::Vec3;
use halfdome_kernel::{Ray, offset_point};

use super::state::Path;
use crate::light::Receiver;
use crate::world::{Hit, Pane, World, chance, time_of};

/// The most panes that a bounce goes through or is reflected by, one after the other.
const MAX_PANES: usize = 16;

/// Paths side by side, with their rays and what these have hit.
pub(super) struct PathsAtPanes<'a, P> {
    pub world: &'a World,
    /// By camera ray, if anything moves.
    pub times: &'a [f32],
    pub paths: &'a mut [P],
    pub rays: &'a mut [Ray],
    pub hits: &'a mut [Hit],
    /// The number of rays that were traced again behind panes.
    pub traced: &'a mut u64,
}

/// A path that has gone through a pane, or was reflected by it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// The number of the path.
    pub source: usize,
    /// What its throughput was multiplied by.
    pub factor: Vec3,
    /// The pane's hit, if that has reflected it.
    pub mirrored: Option<Hit>,
}

impl<P: AsMut<Path>> PathsAtPanes<'_, P> {
    /// Takes bounces and aimed paths that have hit panes through them, or reflects them, until they hit something else.
    #[inline(never)]
    pub(super) fn pass(mut self) -> Vec<Crossing> {
        let mut crossings = Vec::new();
        if self.world.panes().is_none() {
            return crossings;
        }
        let mut waiting: Vec<usize> = (0..self.paths.len()).collect();
        for _ in 0..MAX_PANES {
            waiting.retain(|&source| {
                let Some(crossing) = self.cross(source) else { return false };
                crossings.push(crossing);
                self.paths[source].as_mut().throughput.max_element() > 0.0
            });
            if waiting.is_empty() {
                break;
            }
            self.trace_again(&waiting);
        }
        crossings
    }

    /// Takes a path through the pane that it has hit, or reflects it; `None` if it has hit something else.
    fn cross(&mut self, source: usize) -> Option<Crossing> {
        let (path, ray, hit) = (self.paths[source].as_mut(), &self.rays[source], &self.hits[source]);
        // Not what the camera sees.
        if path.density == f32::INFINITY && !path.is_aimed() {
            return None;
        }
        let pane = self.world.pane_at(ray, hit, time_of(self.times, path.index as usize))?;
        Some(self.pass_or_reflect(source, &pane))
    }

    fn pass_or_reflect(&mut self, source: usize, pane: &Pane) -> Crossing {
        let (path, ray, hit) = (self.paths[source].as_mut(), &mut self.rays[source], self.hits[source]);
        let Pane { leaves, normal, transmittance, reflectance, .. } = *pane;
        let [through, back] = [transmittance, reflectance].map(|part| part.max_element());
        let probability = if through + back > 0.0 { through / (through + back) } else { 1.0 };
        if path.is_aimed() || chance(ray, &hit) < probability {
            let factor = if path.is_aimed() { transmittance } else { transmittance / probability };
            path.throughput *= factor;
            path.normal = path.normal_behind_pane();
            // From the same origin, so that distances stay those of light samples.
            ray.t_min = leaves.next_up();
            return Crossing { source, factor, mirrored: None };
        }
        let factor = reflectance / (1.0 - probability);
        path.throughput *= factor;
        path.normal = path.normal_mirrored_by(Receiver::pack(normal, false));
        (path.density, path.target) = (f32::INFINITY, 0);
        let direction = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
        let origin = offset_point(ray.at(hit.t), normal, self.world.placed_record(&hit).offset, direction);
        *ray = Ray::new(origin, direction);
        Crossing { source, factor, mirrored: Some(hit) }
    }

    /// Traces the rays of these paths again.
    fn trace_again(&mut self, sources: &[usize]) {
        let rays: Vec<Ray> = sources.iter().map(|&source| self.rays[source]).collect();
        let times: Vec<f32> = match self.times {
            [] => Vec::new(),
            times => sources.iter().map(|&source| times[self.paths[source].as_mut().index as usize]).collect(),
        };
        let mut hits = vec![Hit::MISS; rays.len()];
        self.world.intersect_many_at(&rays, &times, &mut hits);
        sources.iter().zip(hits).for_each(|(&source, hit)| self.hits[source] = hit);
        *self.traced += rays.len() as u64;
    }
}
