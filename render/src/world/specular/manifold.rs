//! Manifold exploration: light that reaches a surface by a chain of refractions, or of a reflection and refractions.
//!
//! From a point of a surface, rays are sent through a [chain](super::chain) of faces, until one leaves it towards the
//! light: Newton's method for the two coordinates of the direction at the surface, by ray differentials. This is manifold
//! exploration (Jakob and Marschner 2012; Hanika, Droske and Fascione, "Manifold next event estimation", 2015), with
//! the chain as a function of its first direction `ω`, which may meet any number of faces.
//!
//! With `ω'` the direction in which the ray leaves, and `y` where it passes a point light, across the ray, the surface
//! receives per area that faces `ω`
//!
//! `E T |∂ω/∂ω'|` of a sun with the irradiance `E`, and `I T |∂ω/∂y|` of a point of the intensity `I`,
//!
//! where `T` is the transmittance and reflectance of the faces and of the path between them.
//!
//! Light may arrive by several chains, and at points without a face in front: searches begin where
//! [photons](super::photons) have left the last face. If none of them finds a refraction, one begins towards the light.
//!
//! Deviations: connections whose starts photons miss are left out (those that meet in a point, as on the axis of a
//! ball), and so are chains of more than one reflection. A light with a size emits from each point of a disc that faces
//! the glass.

use glam::Vec3;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Frame;
use smallvec::SmallVec;

use super::super::{Surface, World};
use super::chain::{ChainEnd, LightEnd, Reflection, refract};
use super::photons::Starts;

/// When a search gives up.
#[derive(Clone, Copy)]
struct SearchLimits {
    /// The most chains that are traced.
    chains: usize,
    /// The number of halvings of a step.
    halvings: u32,
    /// The greatest ratio of the angular error after a step to that before. Where no chain leads to the light, the
    /// search ends in a minimum.
    progress: f32,
}

/// Limits for a search that begins in the direction of the light.
const FROM_STRAIGHT: SearchLimits = SearchLimits { chains: 10, halvings: 3, progress: 0.85 };
/// Limits for a search that begins where a photon has left the last face: a connection is near, or there is none.
const FROM_PHOTON: SearchLimits = SearchLimits { chains: 5, halvings: 0, progress: 0.5 };
/// The allowed angular error of a ray beside the light: a twentieth of the sun's width.
const MAX_ERROR: f32 = 2.5e-4;
/// The most that a step turns the direction, as a tangent.
const MAX_STEP: f32 = 0.4;
/// The most refracted connections from a point to a light.
const MAX_CONNECTIONS: usize = 8;
/// Connections whose directions differ by less are the same.
const MIN_SEPARATION: f32 = 1e-3;

/// A chain by which light arrives at a surface.
pub(crate) struct SpecularConnection {
    /// The unit vector from the surface by which it arrives.
    pub direction: Vec3,
    /// The ray from the last face to the light.
    pub rest: Ray,
    /// The unit vector by which it leaves the light.
    pub leaving: Vec3,
    /// The transmittance and reflectance of the chain.
    pub transmittance: Vec3,
    /// `|∂ω/∂ω'|`, or `|∂ω/∂y|` per area.
    pub spread: f32,
    reflection: Reflection,
    /// The error of the direction, as a search ends close to the light.
    error: f32,
}

/// The refracted connections from a point to a light.
#[derive(Default)]
pub(crate) struct RefractedConnections(SmallVec<[SpecularConnection; MAX_CONNECTIONS]>);

impl RefractedConnections {
    /// Each of them.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &SpecularConnection> + Clone {
        self.0.iter()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn add(&mut self, connection: SpecularConnection) {
        if self.0.len() < MAX_CONNECTIONS {
            self.0.push(connection);
        }
    }
}

impl SpecularConnection {
    /// Whether another connection to the same light is this one, where photons were this far apart.
    pub(crate) fn is_same(&self, other: &Self, spacing: f32) -> bool {
        self.reflection == other.reflection
            && (self.is_along(other.direction) || self.leaving.distance(other.leaving) < spacing)
    }

    /// Whether a direction is that of the connection, found from another start.
    pub(super) fn is_along(&self, direction: Vec3) -> bool {
        let apart = (4.0 * self.error).max(MIN_SEPARATION);
        (self.direction - direction).length_squared() < apart * apart
    }
}

impl World {
    /// The refracted connections from a surface to `end`, the light of this index. Where glass is on the straight line,
    /// and photons seed no search, one begins there; `straight` is that line, if light comes along it.
    #[inline(never)]
    pub(crate) fn refracted_connections(
        &self,
        from: &Surface,
        (end, light): (LightEnd, u32),
        straight: Option<Vec3>,
    ) -> RefractedConnections {
        let mut found = RefractedConnections::default();
        let mut starts = Starts::default();
        self.specular.refracted.find_starts(light, from.position, &mut starts);
        for start in starts.iter() {
            if let Some(connection) = self.connection_near(from, (end, None), start.direction, FROM_PHOTON)
                && straight.is_none_or(|straight| !connection.is_along(straight))
                && !found.iter().any(|other| connection.is_along(other.direction))
            {
                found.add(connection);
            }
        }
        if found.is_empty()
            && straight.is_none()
            && let Some(start) = self.first_direction(from, end)
            && let Some(connection) = self.connection_near(from, (end, None), start, FROM_STRAIGHT)
        {
            found.add(connection);
        }
        found
    }

    /// The connection from a surface to `end`, with a chain of this kind, that a photon's start leads to.
    #[inline(never)]
    pub(crate) fn connection_from(
        &self,
        from: &Surface,
        (end, reflection): (LightEnd, Reflection),
        start: Vec3,
    ) -> Option<SpecularConnection> {
        self.connection_near(from, (end, reflection), start, FROM_PHOTON)
    }

    /// Looks for the connection by a chain of this kind whose direction is near this one.
    fn connection_near(
        &self,
        from: &Surface,
        chain: (LightEnd, Reflection),
        mut direction: Vec3,
        limits: SearchLimits,
    ) -> Option<SpecularConnection> {
        let mut frame = Frame::from_normal(direction);
        let mut arrival = self.trace_chain(from, (direction, &frame), chain)?;
        let mut chains = 1;
        while arrival.angle > MAX_ERROR {
            let determinant = arrival.jacobian.determinant();
            if determinant == 0.0 || !determinant.is_finite() {
                return None;
            }
            let step = -(arrival.jacobian.inverse() * arrival.beside);
            let mut step = step * (MAX_STEP / step.length()).min(1.0);
            // Half of a step that leads away from the light, or off the faces, and of that half again.
            let mut halvings = 0;
            (direction, frame, arrival) = loop {
                if chains == limits.chains || halvings > limits.halvings {
                    return None;
                }
                chains += 1;
                halvings += 1;
                let next = frame.to_world(step.extend(1.0)).normalize();
                let next_frame = Frame::from_normal(next);
                match self.trace_chain(from, (next, &next_frame), chain) {
                    Some(further) if further.angle < limits.progress * arrival.angle => {
                        break (next, next_frame, further);
                    }
                    _ => step *= 0.5,
                }
            };
        }
        let ChainEnd { beam, jacobian, distance, angle, .. } = arrival;
        let spread = jacobian.determinant().abs().recip();
        let rest = match chain.0 {
            LightEnd::Direction(direction) => Ray::new(beam.ray.origin, direction),
            LightEnd::Point(point) => Ray::between(beam.ray.origin, point),
        };
        // False for NaN.
        (spread.is_finite() && angle <= MAX_ERROR).then_some(SpecularConnection {
            direction,
            rest,
            leaving: -beam.ray.direction,
            transmittance: beam.transmittance,
            spread,
            reflection: chain.1,
            error: MAX_ERROR * distance * spread.sqrt(),
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
}

#[cfg(test)]
mod tests;
