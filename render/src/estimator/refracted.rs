//! Light from one point of a light that comes straight and by smooth glass that refracts it: one of the ways is chosen by what it
//! brings.

use glam::Vec3;
use halfdome_kernel::Ray;

use crate::world::{Between, LightEnd, SpecularConnection, Surface, World};

/// How much finer the digits are that choose a way, or decide about searches, than those that place a point on a light.
pub(super) const FINER: f32 = 4096.0;

/// A way of light to a surface.
pub(super) struct LightWay {
    /// The unit vector by which light arrives.
    pub direction: Vec3,
    /// The shadow ray from the surface to the light, or its part behind panes or the last face.
    pub shadow: Ray,
    /// Radiance over the density of the choice; of a delta light, irradiance on what faces it.
    pub received: Vec3,
    /// Whether no bounce finds it straight, as glass bends it.
    pub is_bent: bool,
    pub wedges: Wedges,
}

/// Glass that a straight way crosses though it bends light a little.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Wedges {
    None,
    /// Only light samples cross it straight.
    OfSamples,
    /// Bounces cross it straight, too.
    OfBounces,
}

/// The greatest angle, as a sine, between light that panes with faces of which normals differ by 3° let through and its straight
/// way.
const MAX_BEND: f32 = 0.06;

impl Wedges {
    /// Of panes that light samples alone may cross.
    pub(super) fn of_samples(are_exact: bool) -> Self {
        if are_exact { Self::None } else { Self::OfSamples }
    }
}

impl LightWay {
    /// What is left of the straight way of light behind the glass on it; `None` if that bends it.
    pub(super) fn straight(self, world: &World, time: f32) -> Option<Self> {
        match world.glass_between(&self.shadow, time) {
            Between::NoGlass => Some(self),
            Between::Panes { rest, transmittance, are_exact } => {
                let (received, wedges) = (transmittance * self.received, Wedges::of_samples(are_exact));
                Some(Self { shadow: rest, received, is_bent: !are_exact, wedges, ..self })
            }
            Between::Bends => None,
        }
    }
}

/// The way of light from `end`, the point that was chosen of the light with this number, to `surface`: the straight one, if there is
/// one, or a connection by which `received` gives what comes. The number in [0, 1) chooses the way. `None` if glass keeps the
/// light off.
pub(super) fn choose_way(
    world: &World,
    surface: &Surface,
    (end, number): (LightEnd, u32),
    straight: Option<LightWay>,
    received: impl Fn(&SpecularConnection) -> Vec3,
    u: f32,
) -> Option<LightWay> {
    let along = straight.as_ref().map(|way| way.direction);
    let refracted = world.refracted_connections(surface, (end, number), along);
    // Light through the same glass counts once: as connections find it, which is exact, unless bounces find it straight.
    let is_same = |it: &SpecularConnection| along.is_some_and(|way| it.direction.cross(way).length() < MAX_BEND);
    let wedges = straight.as_ref().map_or(Wedges::None, |way| way.wedges);
    let straight = straight.filter(|_| wedges != Wedges::OfSamples || !refracted.iter().any(is_same));
    let refracted = refracted.iter().filter(|it| wedges != Wedges::OfBounces || !is_same(it));
    if refracted.clone().next().is_none() {
        return straight;
    }
    let straight = straight.filter(|way| !world.occluded_at(&way.shadow, surface.time));
    let bent = refracted.map(|connection| {
        let SpecularConnection { direction, rest: shadow, .. } = *connection;
        LightWay { direction, shadow, received: received(connection), is_bent: true, wedges: Wedges::None }
    });
    let brought = |way: &LightWay| way.received.element_sum() * surface.shading_normal.dot(way.direction).abs();
    let total: f32 = straight.iter().map(brought).sum::<f32>() + bent.clone().map(|way| brought(&way)).sum::<f32>();
    let mut rest = u * total;
    for way in straight.into_iter().chain(bent) {
        let share = brought(&way);
        rest -= share;
        if rest < 0.0 {
            return Some(LightWay { received: way.received * (total / share), ..way });
        }
    }
    None
}
