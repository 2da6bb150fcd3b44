//! Light refracted by glass.
//!
//! From a point of a surface, rays are sent through glass, refracted at every face, until one leaves it towards the
//! light: Newton's method for the two coordinates of the direction at the surface. Ray differentials give the change of
//! the ray for a small change of that direction (Igehy, "Tracing ray differentials", 1999), with the normals'
//! derivatives across each triangle. This is manifold exploration (Jakob and Marschner 2012; Hanika, Droske and
//! Fascione, "Manifold next event estimation", 2015), with the chain of refractions as a function of its first
//! direction `ω`, which may meet any number of faces.
//!
//! With `ω'` the direction in which the ray leaves, and `y` where it passes a point light, across the ray, the surface receives per
//! area that faces `ω`
//!
//! `E T |∂ω/∂ω'|` of a sun with the irradiance `E`, and `I T |∂ω/∂y|` of a point of the intensity `I`,
//!
//! where `T` is the transmittance of the faces and of the path between them.
//!
//! Light may arrive by several paths, and at points without glass in front: searches begin where
//! [photons](super::photons) have left the glass, and if none of them finds a path, towards the light.
//!
//! Deviations: paths whose starts photons miss are left out (those that meet in a point, as on the axis of a ball), and
//! light reflected within glass or on it. A light with a size emits from each point of a disc that faces the glass.

use glam::{Mat2, Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Frame;

use super::super::{Surface, World};
use super::{Face, MOST};

/// When a search gives up.
#[derive(Clone, Copy)]
struct SearchLimits {
    /// Rays that are sent out at most.
    shots: usize,
    /// The number of halvings of a step.
    halvings: u32,
    /// The greatest ratio of the angular error after a step to that before. Where no path leads to the light, the
    /// search ends in a minimum.
    less: f32,
}

/// Limits for a search that begins in the direction of the light.
const FROM_STRAIGHT: SearchLimits = SearchLimits { shots: 10, halvings: 3, less: 0.85 };
/// Limits for a search that begins where a photon has left the glass: a path is near, or there is none.
const FROM_PHOTON: SearchLimits = SearchLimits { shots: 5, halvings: 0, less: 0.5 };
/// The allowed angular error of a ray beside the light: a twentieth of the sun's width.
const CLOSE: f32 = 2.5e-4;
/// The most that a step turns the direction, as a tangent.
const STEP: f32 = 0.4;
/// The most ways to a point.
const MOST_WAYS: usize = 8;
/// Ways whose directions differ by less are the same.
const SAME: f32 = 1e-3;
/// Solids one in another of which absorption is known.
const NESTED: usize = 4;

/// The light's end of a connection.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightEnd {
    /// A light at infinity: the unit vector towards it.
    Direction(Vec3),
    /// From a point.
    Point(Vec3),
}

/// A way on which light arrives at a surface.
pub(crate) struct RefractedConnection {
    /// The unit vector from the surface by which it arrives.
    pub direction: Vec3,
    /// The ray from the last face of glass to the light.
    pub rest: Ray,
    /// The unit vector by which it leaves the light.
    pub leaving: Vec3,
    /// The transmittance of the glass.
    pub transmittance: Vec3,
    /// `|∂ω/∂ω'|`, or `|∂ω/∂y|` per area.
    pub spread: f32,
    /// The error of the direction, as a search ends close to the light.
    off: f32,
}

/// All ways that were found.
#[derive(Default)]
pub(crate) struct RefractedConnections([Option<RefractedConnection>; MOST_WAYS]);

impl RefractedConnections {
    /// Each of them.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &RefractedConnection> + Clone {
        self.0.iter().flatten()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0[0].is_none()
    }

    fn add(&mut self, way: RefractedConnection) {
        if let Some(place) = self.0.iter_mut().find(|place| place.is_none()) {
            *place = Some(way);
        }
    }
}

impl RefractedConnection {
    /// Whether a direction is that of the way, found from another start.
    fn is_along(&self, direction: Vec3) -> bool {
        let apart = (4.0 * self.off).max(SAME);
        (self.direction - direction).length_squared() < apart * apart
    }
}

/// A ray with its differentials by a change of its first direction along each of two axes.
pub(super) struct DifferentialRay {
    pub(super) ray: Ray,
    pub(super) d_origin: [Vec3; 2],
    pub(super) d_direction: [Vec3; 2],
    pub(super) transmittance: Vec3,
}

/// The result of a direction.
struct ChainEnd {
    beam: DifferentialRay,
    /// The offset of the ray from the light along two axes across it: as an angle, or as a length.
    beside: Vec2,
    /// Its derivative by the direction along each axis.
    jacobian: Mat2,
    /// The distance to a point, and 1 to a sun: `beside` divided by its angle.
    distance: f32,
    angle: f32,
}

impl World {
    /// The paths of light from `end`, the light of this index, to a surface through refracting glass. Where glass is on
    /// the straight line, and photons seed no path, the search begins there; `straight` is that line, if light comes
    /// along it.
    #[inline(never)]
    pub(crate) fn refracted_connections(
        &self,
        from: &Surface,
        (end, light): (LightEnd, u32),
        straight: Option<Vec3>,
    ) -> RefractedConnections {
        let mut ways = RefractedConnections::default();
        for start in self.glass.photons.starts(light, from.position) {
            if let Some(way) = self.refracted_connection_near(from, end, start, FROM_PHOTON)
                && straight.is_none_or(|straight| !way.is_along(straight))
                && !ways.iter().any(|other| way.is_along(other.direction))
            {
                ways.add(way);
            }
        }
        if ways.is_empty()
            && straight.is_none()
            && let Some(start) = self.first_direction(from, end)
            && let Some(way) = self.refracted_connection_near(from, end, start, FROM_STRAIGHT)
        {
            ways.add(way);
        }
        ways
    }

    /// Looks for the way on which light arrives whose direction is near this one.
    fn refracted_connection_near(
        &self,
        from: &Surface,
        end: LightEnd,
        mut direction: Vec3,
        patience: SearchLimits,
    ) -> Option<RefractedConnection> {
        let mut frame = Frame::from_normal(direction);
        let mut shot = self.trace_chain(from, direction, &frame, end)?;
        let mut shots = 1;
        while shot.angle > CLOSE {
            let determinant = shot.jacobian.determinant();
            if determinant == 0.0 || !determinant.is_finite() {
                return None;
            }
            let step = -(shot.jacobian.inverse() * shot.beside);
            let mut step = step * (STEP / step.length()).min(1.0);
            // Half of a step that leads away from the light, or off the glass, and of that half again.
            let mut halvings = 0;
            (direction, frame, shot) = loop {
                if shots == patience.shots || halvings > patience.halvings {
                    return None;
                }
                shots += 1;
                halvings += 1;
                let next = frame.to_world(step.extend(1.0)).normalize();
                let next_frame = Frame::from_normal(next);
                match self.trace_chain(from, next, &next_frame, end) {
                    Some(further) if further.angle < patience.less * shot.angle => break (next, next_frame, further),
                    _ => step *= 0.5,
                }
            };
        }
        let ChainEnd { beam, jacobian, distance, angle, .. } = shot;
        let spread = jacobian.determinant().abs().recip();
        let rest = match end {
            LightEnd::Direction(direction) => Ray::new(beam.ray.origin, direction),
            LightEnd::Point(point) => Ray::between(beam.ray.origin, point),
        };
        // False for NaN.
        (spread.is_finite() && angle <= CLOSE).then_some(RefractedConnection {
            direction,
            rest,
            leaving: -beam.ray.direction,
            transmittance: beam.transmittance,
            spread,
            off: CLOSE * distance * spread.sqrt(),
        })
    }

    /// The start direction: straight towards the light, or from within a solid the direction into which the next face
    /// refracts its light.
    fn first_direction(&self, from: &Surface, end: LightEnd) -> Option<Vec3> {
        let towards = |point: Vec3| match end {
            LightEnd::Direction(direction) => direction,
            LightEnd::Point(end) => (end - point).normalize_or_zero(),
        };
        let straight = towards(from.position);
        let ray = Ray::new(from.origin_towards(straight), straight);
        let face = self.face(&ray, from.time)?;
        if !face.surface.is_back || face.is_thin {
            return Some(straight);
        }
        let outside = towards(face.surface.position);
        refract(-outside, -face.surface.smooth_normal, face.ior.recip()).map(|(inwards, ..)| -inwards)
    }

    /// Sends a ray out, refracted at all the glass that it meets before it passes the light.
    fn trace_chain(&self, from: &Surface, direction: Vec3, frame: &Frame, end: LightEnd) -> Option<ChainEnd> {
        let axes = [Vec3::X, Vec3::Y].map(|axis| frame.to_world(axis));
        let ray = Ray::new(from.origin_towards(direction), direction);
        let mut beam = DifferentialRay { ray, d_origin: [Vec3::ZERO; 2], d_direction: axes, transmittance: Vec3::ONE };
        let (mut inside, mut depth, mut way, mut begun) = ([Vec3::ZERO; NESTED], 0usize, 0.0, 0.0);
        for _ in 0..MOST {
            if let LightEnd::Point(point) = end {
                beam.ray.t_max = (point - beam.ray.origin).dot(beam.ray.direction);
                if beam.ray.t_max <= 0.0 {
                    return None;
                }
            }
            let Some(face) = self.face(&beam.ray, from.time) else {
                // A point within a solid: of a sun no ray ends there.
                if let (LightEnd::Point(_), Some(solid)) = (end, depth.checked_sub(1)) {
                    beam.transmittance *= (-beam.ray.t_max * inside[solid]).exp();
                }
                return beam.past(end, way);
            };
            let distance = face.hit.t;
            way += distance;
            if depth > 0 {
                beam.transmittance *= (-distance * inside[depth - 1]).exp();
            } else {
                begun += distance;
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
                // Out of the solid that the surface is in, whose length on the way to a sun is known here alone; to a point, the path
                // takes all of the rest for it.
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

    /// Goes on behind a face as it came.
    pub(super) fn straight(&mut self, face: &Face) {
        self.arrive(face);
        self.ray.origin = face.surface.origin_towards(self.ray.direction);
    }

    /// The miss of the ray beside the light, given the distance so far.
    fn past(self, end: LightEnd, way: f32) -> Option<ChainEnd> {
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
                (direction, self.ray.at(rest) - point, by, way + rest)
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
fn refract(direction: Vec3, normal: Vec3, eta: f32) -> Option<(Vec3, f32, f32)> {
    let cos = -direction.dot(normal);
    let squared = 1.0 - eta * eta * (1.0 - cos * cos);
    if cos <= 0.0 || squared <= 0.0 {
        return None;
    }
    let cos_beyond = squared.sqrt();
    Some(((eta * direction + (eta * cos - cos_beyond) * normal).normalize(), cos, cos_beyond))
}

#[cfg(test)]
mod tests;
