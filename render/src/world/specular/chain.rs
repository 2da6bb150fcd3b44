//! A chain of specular events between a surface and a light: faces that a ray crosses, and at most one that reflects it.
//!
//! A ray leaves the surface and is refracted at each face of smooth glass that it meets. If the chain has a reflection,
//! the face with that index reflects the ray instead. Ray differentials give the change of the ray for a small change
//! of its first direction (Igehy, "Tracing ray differentials", 1999), with the normals' derivatives across each
//! triangle: with the normal `n` on the ray's side and `∂` along either axis,
//!
//! `d' = d - 2 (d·n) n`, `∂d' = ∂d - 2 ((∂d·n + d·∂n) n + (d·n) ∂n)`
//!
//! for a reflection.

use glam::{Mat2, Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Frame;

use super::super::{Surface, World};
use super::{Face, MAX_FACES};

/// The most solids inside each other of which absorption is known.
const MAX_NESTED: usize = 4;

/// The index of the face that reflects the ray of a chain, counted from the surface; `None` if all faces transmit it.
pub(super) type Reflection = Option<u8>;

/// The light's end of a connection.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightEnd {
    /// A light at infinity: the unit vector towards it.
    Direction(Vec3),
    /// From a point.
    Point(Vec3),
}

/// A ray with its differentials by a change of its first direction along each of two axes.
#[derive(Clone, Copy)]
pub(super) struct DifferentialRay {
    pub(super) ray: Ray,
    pub(super) d_origin: [Vec3; 2],
    pub(super) d_direction: [Vec3; 2],
    pub(super) transmittance: Vec3,
}

/// Where a chain that begins with some direction passes the light.
pub(super) struct ChainEnd {
    pub(super) beam: DifferentialRay,
    /// The offset of the ray from the light along two axes across it: as an angle, or as a length.
    pub(super) beside: Vec2,
    /// Its derivative by the direction along each axis.
    pub(super) jacobian: Mat2,
    /// The distance to a point, and 1 to a sun: `beside` divided by its angle.
    pub(super) distance: f32,
    pub(super) angle: f32,
}

impl World {
    /// Sends a ray out through all faces that it meets before it passes the light; `None` if it does not get there.
    pub(super) fn trace_chain(
        &self,
        from: &Surface,
        (direction, frame): (Vec3, &Frame),
        (end, reflection): (LightEnd, Reflection),
    ) -> Option<ChainEnd> {
        let axes = [Vec3::X, Vec3::Y].map(|axis| frame.to_world(axis));
        let ray = Ray::new(from.origin_towards(direction), direction);
        let mut beam = DifferentialRay { ray, d_origin: [Vec3::ZERO; 2], d_direction: axes, transmittance: Vec3::ONE };
        let (mut inside, mut depth, mut distance, mut begun) = ([Vec3::ZERO; MAX_NESTED], 0usize, 0.0, 0.0);
        for index in 0..MAX_FACES as u8 {
            let is_turned = reflection.is_none_or(|mirror| mirror < index);
            let is_mirror = reflection == Some(index);
            beam.ray.t_max = f32::INFINITY;
            if let LightEnd::Point(point) = end
                && is_turned
            {
                beam.ray.t_max = (point - beam.ray.origin).dot(beam.ray.direction);
                if beam.ray.t_max <= 0.0 {
                    return None;
                }
            }
            let face = if is_mirror { self.mirror_face(&beam.ray, from.time) } else { self.face(&beam.ray, from.time) };
            let Some(face) = face else {
                if !is_turned {
                    return None;
                }
                // A point within a solid: of a sun no ray ends there.
                if let (LightEnd::Point(_), Some(solid)) = (end, depth.checked_sub(1)) {
                    beam.transmittance *= (-beam.ray.t_max * inside[solid]).exp();
                }
                return beam.past(end, distance);
            };
            let step = face.hit.t;
            distance += step;
            if depth > 0 {
                beam.transmittance *= (-step * inside[depth - 1]).exp();
            } else {
                begun += step;
            }
            if is_mirror {
                // The absorption of the solid that the surface is in is known only where light enters it.
                if depth == 0 && face.surface.is_back && face.absorption != Vec3::ZERO {
                    return None;
                }
                self.reflect(&mut beam, &face)?;
                continue;
            }
            if face.is_thin {
                let cos = face.surface.smooth_normal.dot(beam.ray.direction).abs();
                beam.transmittance *= face.thin_wall_transmittance(cos);
                beam.straight(&face);
                continue;
            }
            if !face.surface.is_back {
                *inside.get_mut(depth)? = face.absorption;
                depth += 1;
            } else if depth > 0 {
                depth -= 1;
            } else if face.absorption != Vec3::ZERO {
                // Out of the solid that the surface is in, whose length on the way to a sun is known here alone; to a
                // point, the path takes all of the rest for it.
                if let LightEnd::Point(_) = end {
                    return None;
                }
                beam.transmittance *= (-begun * face.absorption).exp();
                begun = 0.0;
            }
            self.refract(&mut beam, &face)?;
        }
        None
    }

    /// Reflects a beam at a face; `None` if it would lead behind the face, or nothing is reflected.
    pub(super) fn reflect(&self, beam: &mut DifferentialRay, face: &Face) -> Option<()> {
        let (surface, direction) = (&face.surface, beam.ray.direction);
        let normal = surface.smooth_normal;
        let along = direction.dot(normal);
        let reflected = (direction - 2.0 * along * normal).normalize();
        let reflectance = self.mirror_reflectance(face);
        if along >= 0.0 || reflected.dot(surface.normal) <= 0.0 || reflectance == Vec3::ZERO {
            return None;
        }
        beam.transmittance *= reflectance;
        let normals = self.normal_derivative(face);
        beam.arrive(face);
        for axis in 0..2 {
            let (by, normal_by) = (beam.d_direction[axis], normals.at(beam.d_origin[axis]));
            let along_by = by.dot(normal) + direction.dot(normal_by);
            beam.d_direction[axis] = by - 2.0 * (along_by * normal + along * normal_by);
        }
        beam.ray.direction = reflected;
        beam.ray.origin = surface.origin_towards(reflected);
        Some(())
    }

    /// Lets a beam through a face.
    pub(super) fn refract(&self, beam: &mut DifferentialRay, face: &Face) -> Option<()> {
        let (surface, eta) = (&face.surface, if face.surface.is_back { face.ior } else { face.ior.recip() });
        let normal = surface.smooth_normal;
        let (refracted, cos, cos_beyond) = refract(beam.ray.direction, normal, eta)?;
        let (reflected, _) = face.at(if surface.is_back { cos_beyond } else { cos });
        beam.transmittance *= face.tint * (1.0 - reflected);
        let normals = self.normal_derivative(face);
        beam.arrive(face);
        for axis in 0..2 {
            let [d_origin, d_direction] = [beam.d_origin[axis], beam.d_direction[axis]];
            let normal_by = normals.at(d_origin);
            let cos_by = -(d_direction.dot(normal) + beam.ray.direction.dot(normal_by));
            let along = eta * cos - cos_beyond;
            let along_by = (eta - eta * eta * cos / cos_beyond) * cos_by;
            beam.d_direction[axis] = eta * d_direction + along * normal_by + along_by * normal;
        }
        beam.ray.direction = refracted;
        beam.ray.origin = surface.origin_towards(refracted);
        Some(())
    }
}

impl DifferentialRay {
    /// Moves the changes of the origin to the plane of a face.
    fn arrive(&mut self, face: &Face) {
        let (direction, normal) = (self.ray.direction, face.surface.normal);
        for axis in 0..2 {
            let moved = self.d_origin[axis] + face.hit.t * self.d_direction[axis];
            self.d_origin[axis] = moved - direction * (moved.dot(normal) / direction.dot(normal));
        }
    }

    /// Continues behind a face in its direction.
    pub(super) fn straight(&mut self, face: &Face) {
        self.arrive(face);
        self.ray.origin = face.surface.origin_towards(self.ray.direction);
    }

    /// The miss of the ray beside the light, given its length so far.
    fn past(self, end: LightEnd, length: f32) -> Option<ChainEnd> {
        let direction = self.ray.direction;
        let (axis, beside, by, distance) = match end {
            LightEnd::Direction(sun) => {
                if direction.dot(sun) <= 0.0 {
                    return None;
                }
                (sun, direction, self.d_direction, 1.0)
            }
            LightEnd::Point(point) => {
                let rest = self.ray.t_max;
                let by = [0, 1].map(|axis| self.d_origin[axis] + rest * self.d_direction[axis]);
                (direction, self.ray.at(rest) - point, by, length + rest)
            }
        };
        let across = Frame::from_normal(axis);
        let [x, y] = [Vec3::X, Vec3::Y].map(|axis| across.to_world(axis));
        let project = |vector: Vec3| Vec2::new(vector.dot(x), vector.dot(y));
        let (beside, jacobian) = (project(beside), Mat2::from_cols(project(by[0]), project(by[1])));
        Some(ChainEnd { beam: self, beside, jacobian, distance, angle: beside.length() / distance })
    }
}

/// The unit direction of a ray refracted at a face whose normal is on its side, with the refractive index here divided
/// by that beyond; and the cosines here and beyond.
pub(super) fn refract(direction: Vec3, normal: Vec3, eta: f32) -> Option<(Vec3, f32, f32)> {
    let cos = -direction.dot(normal);
    let squared = 1.0 - eta * eta * (1.0 - cos * cos);
    if cos <= 0.0 || squared <= 0.0 {
        return None;
    }
    let cos_beyond = squared.sqrt();
    Some(((eta * direction + (eta * cos - cos_beyond) * normal).normalize(), cos, cos_beyond))
}
