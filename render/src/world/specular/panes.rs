//! Light that crosses glass without a change of direction.
//!
//! With the reflectance `F` of a face and the transmittance `a` between the two parallel faces of a pane,
//!
//! `T = (1 - F)² a / (1 - F² a²)`,
//!
//! all inner reflections summed; a thin wall has `a = 1`.
//!
//! Deviations: a pane does not offset light sideways; films and coats reflect nothing.

pub(in crate::world) mod glass_tree;

use glam::Vec3;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Frame;

use self::glass_tree::{GlassTree, Next, Pane};
use super::super::{Hit, MIDDLE, World};
use super::{Between, Face, MAX_FACES, MIN_STRAIGHT_COS, beyond};

/// The cosine of 3°, the greatest angle between two faces that count as parallel.
const MIN_PARALLEL_COS: f32 = 0.998_63;
/// The greatest relative change of the light's density by which a pane may spread or focus light from a point.
const MAX_SPREAD: f32 = 0.03;
/// The same of faces between which photons find that light has kept its direction.
const EXACT: (f32, f32) = (MIN_STRAIGHT_COS, 1e-3);

impl World {
    /// The part of a shadow ray beyond all smooth glass that it meets first, ignoring refraction, at mid-shutter: an
    /// approximation for estimates of visibility.
    pub(in crate::world) fn beyond_glass(&self, shadow: Ray) -> Ray {
        let mut ray = shadow;
        if !self.has_clear_glass() || !self.specular.may_meet(&shadow) {
            return ray;
        }
        for _ in 0..MAX_FACES {
            let Some(face) = self.face(&ray, MIDDLE) else { break };
            ray = beyond(&ray, &face.surface);
        }
        ray
    }

    /// The glass that a shadow ray crosses.
    #[inline(never)]
    pub(crate) fn glass_between(&self, shadow: &Ray, time: f32) -> Between {
        let (mut ray, mut transmittance, mut are_exact) = (*shadow, Vec3::ONE, true);
        if !self.specular.may_meet(shadow) || self.specular.misses_glass(shadow) {
            return Between::NoGlass;
        }
        for index in 0..MAX_FACES {
            let Some(entry) = self.face(&ray, time) else {
                return match index {
                    0 => Between::NoGlass,
                    _ => Between::Panes { rest: ray, transmittance, are_exact },
                };
            };
            let cos = entry.surface.smooth_normal.dot(ray.direction.normalize()).abs();
            let inner = beyond(&ray, &entry.surface);
            if entry.is_thin {
                (ray, transmittance) = (inner, transmittance * entry.thin_wall_transmittance(cos));
                continue;
            }
            if entry.surface.is_back {
                return Between::Bends;
            }
            let Some(exit) = self.face(&inner, time) else { return Between::Bends };
            let is_same = exit.surface.is_back && std::ptr::eq(exit.surface.material, entry.surface.material);
            let distance = (inner.origin - shadow.origin).length();
            if !is_same || !self.are_parallel(&entry, &exit, distance, (MIN_PARALLEL_COS, MAX_SPREAD)) {
                return Between::Bends;
            }
            are_exact = are_exact && self.are_parallel(&entry, &exit, distance, EXACT);
            // The straight ray's length inside, times the cosine outside, is the pane's thickness.
            let ([(f, cos_inside), (g, _)], thickness) =
                ([entry.at(cos), exit.at(cos)], (exit.surface.position - entry.surface.position).length() * cos);
            let absorbed = (-thickness / cos_inside.max(1e-3) * entry.absorption).exp();
            transmittance *=
                entry.tint * exit.tint * (1.0 - f) * (1.0 - g) * absorbed / (1.0 - f * g * absorbed * absorbed);
            ray = beyond(&inner, &exit.surface);
        }
        Between::Bends
    }

    /// The pane that a ray has hit, if it crosses it straight.
    pub(crate) fn pane_at(&self, ray: &Ray, hit: &Hit, time: f32) -> Option<Pane> {
        let glass = self.panes().filter(|_| self.is_clear_glass(hit))?;
        let Next::Pane(pane) = glass.next(ray) else { return None };
        let is_solid = pane.enters < pane.leaves;
        (pane.enters == hit.t && !(is_solid && self.occluded_at(&pane.inside(ray), time))).then_some(pane)
    }

    /// What a ray hits straight behind the panes that it has met first, and their transmittance.
    pub(crate) fn behind_panes(&self, ray: &Ray, hit: &Hit, time: f32) -> (Hit, Vec3) {
        let (mut ray, mut hit, mut transmittance) = (*ray, *hit, Vec3::ONE);
        for _ in 0..MAX_FACES {
            let Some(pane) = self.pane_at(&ray, &hit, time) else { break };
            transmittance *= pane.transmittance;
            ray.t_min = pane.leaves.next_up();
            hit = self.intersect_at(&ray, time);
        }
        (hit, transmittance)
    }

    /// What a ray that has hit glass would hit straight behind all glass.
    pub(crate) fn straight_behind_glass(&self, ray: &Ray, hit: &Hit, time: f32) -> Hit {
        let (mut ray, mut hit) = (*ray, *hit);
        for _ in 0..MAX_FACES {
            if !self.is_clear_glass(&hit) {
                break;
            }
            ray.t_min = hit.t.next_up();
            hit = self.intersect_at(&ray, time);
        }
        hit
    }

    /// The part of a shadow ray behind all panes on its straight way, and their transmittance; `None` if glass bends it, or
    /// if something is in front of a pane or inside.
    #[inline]
    pub(crate) fn through_panes(&self, shadow: &Ray, time: f32) -> Option<(Ray, Vec3)> {
        match self.panes() {
            Some(glass) => self.through(glass, shadow, time),
            None => Some((*shadow, Vec3::ONE)),
        }
    }

    #[inline(never)]
    fn through(&self, glass: &GlassTree, shadow: &Ray, time: f32) -> Option<(Ray, Vec3)> {
        let Some(first) = glass.intersect(shadow) else { return Some((*shadow, Vec3::ONE)) };
        let mut is_free = true;
        let crossed = glass.cross(shadow, &first, |part| is_free = is_free && !self.occluded_at(&part, time));
        crossed.filter(|_| is_free)
    }

    /// Whether two faces of a solid preserve the direction of light, and its divergence over this distance, within these limits:
    /// the cosine between them, and the change of the light's density.
    fn are_parallel(&self, entry: &Face, exit: &Face, distance: f32, (min_cos, max_spread): (f32, f32)) -> bool {
        let normal = entry.surface.smooth_normal;
        if normal.dot(exit.surface.smooth_normal) < min_cos {
            return false;
        }
        let [first, second] = [self.normal_derivative(entry), self.normal_derivative(exit)];
        let frame = Frame::from_normal(normal);
        [Vec3::X, Vec3::Y].iter().all(|&axis| {
            let step = frame.to_world(axis);
            (entry.ior - 1.0) * (first.at(step) - second.at(step)).length() * distance < max_spread
        })
    }
}

#[cfg(test)]
mod tests;
