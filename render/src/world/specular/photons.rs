//! Photon maps of refracted and of reflected light: where it arrives, and from where on the last face. They seed the search
//! for connections.
//!
//! A search finds the connection next to its start, and light may reach a point by several connections, or reach points
//! outside the glass's shadow. So rays are sent from points, spots and suns at each body with smooth faces and followed
//! through them, as photons are (Jensen, "Global illumination using photon maps", 1996), with the footprint that ray
//! differentials give them (Schjøth et al., "Photon differentials", 2007). Beside a photon that has left the last face,
//! rays pass
//!
//! `x(u, v) = o + t d + u (∂o/∂u + t ∂d/∂u) + v (∂o/∂v + t ∂d/∂v)`.
//!
//! A point within the footprint has `u` and `v` in [-1, 1], and a search begins where its ray has left the last face.
//! Starts whose rays would have been sent from the same place through the same kind of chain are merged.
//!
//! Deviations: photons carry no flux; they only seed the manifold search, so their density has no meaning. They are
//! sent at mid-shutter. Their cells are around the surface where they arrive: objects smaller than a footprint in front
//! of that surface may be missed, and so may details of faces smaller than the photon spacing. With very many lights
//! and bodies, each light uses the bodies that look largest from it.

mod cells;
mod send;

use glam::{Vec2, Vec3};
use smallvec::SmallVec;

use self::cells::Cells;
use super::chain::Reflection;
use crate::light::Light;
use crate::scene::PunctualLight;
use crate::world::World;

/// The allowed distance of a point from a footprint's plane, relative to its length: where it folds, the second
/// derivative matters.
const FOLD: f32 = 0.25;
/// The most lights that are searched for in mirrors from a point.
const MAX_LIGHTS: usize = 4;
/// The most starts for a point.
const MAX_STARTS: usize = 32;

/// A map of light of points, spots and suns.
#[derive(Debug, Default)]
pub(super) struct Photons {
    /// The lights that have any, in order of their indices.
    lights: Vec<(u32, Cells)>,
}

/// A ray that has left the last face, and its change for one sent beside it, along each of two axes.
#[derive(Clone, Copy, Debug)]
struct Photon {
    origin: Vec3,
    direction: Vec3,
    d_origin: [Vec3; 2],
    d_direction: [Vec3; 2],
    sent: Sent,
    /// The angular size of its source: times the distance behind the last face it is the offset of light from elsewhere
    /// on the source.
    blur: f32,
    reflection: Reflection,
    /// Its irradiance where it arrives, for an intensity of 1, or of a sun for an irradiance of 1.
    irradiance: f32,
}

/// The emission of a photon: for a sun its origin, for other lights its direction.
#[derive(Clone, Copy, Debug)]
struct Sent {
    at: Vec3,
    /// The change for a photon sent beside it.
    by: [Vec3; 2],
}

/// The start of a search.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Start {
    /// The unit vector from the point in which light may come.
    pub direction: Vec3,
    /// How that light was sent.
    pub emission: Emission,
    /// About how much light comes, as a part of what would come straight from the light.
    pub strength: f32,
    /// The distance of the point from the middle of the footprint: the less, the likelier is a path near the start.
    off: f32,
}

/// How light that arrives at a point was sent.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Emission {
    /// The kind of its chain.
    pub reflection: Reflection,
    /// Of a sun, the photon's origin; of other lights, its direction.
    pub sent: Vec3,
    /// How far apart photons were.
    pub spacing: f32,
}

/// The starts for a point: memory that is not written before it is used, as most points have none.
#[derive(Default)]
pub(crate) struct Starts(SmallVec<[Start; MAX_STARTS]>);

/// A light that may be reflected to a point; of the sky, its sun.
pub(crate) struct LightInMirrors<'w> {
    /// Its index.
    pub index: u32,
    pub light: &'w PunctualLight,
    /// The square of its distance; 1 of a sun.
    pub distance_squared: f32,
    /// The reciprocal of the probability of choosing it.
    pub inv_probability: f32,
    photons: &'w Cells,
    /// What is left of the number that chose it.
    roulette: f32,
}

/// A photon that has arrived.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    photon: Photon,
    point: Vec3,
    /// Half of the extent of its footprint.
    extent: Vec3,
}

/// A point's place in a footprint.
#[derive(Clone, Copy)]
struct Place {
    /// `u` and `v`.
    coordinates: Vec2,
    /// The distance from the middle, 1 at the edge.
    off: f32,
}

impl Photon {
    /// The start for a point that is within the footprint, or so far beside it.
    fn start(&self, point: Vec3, beside: f32) -> Option<Start> {
        let place = self.place(point, beside)?;
        let [u, v] = place.coordinates.to_array();
        let exit = self.origin + u * self.d_origin[0] + v * self.d_origin[1];
        Some(Start {
            direction: (exit - point).normalize_or_zero(),
            emission: self.emission(&place),
            strength: self.irradiance,
            off: place.off,
        })
    }

    /// How light is sent that arrives at this place.
    fn emission(&self, place: &Place) -> Emission {
        let Sent { at, by } = self.sent;
        let sent = at + place.coordinates.x * by[0] + place.coordinates.y * by[1];
        Emission { reflection: self.reflection, sent, spacing: by[0].length() }
    }

    /// The place of a point that is within the footprint, or so far beside it.
    fn place(&self, point: Vec3, beside: f32) -> Option<Place> {
        let (place, is_within) = self.place_anywhere(point, beside);
        is_within.then_some(place)
    }

    /// The place of any point, and whether that is within the footprint, or so far beside it. Without branches, for lanes.
    #[inline(always)]
    fn place_anywhere(&self, point: Vec3, beside: f32) -> (Place, bool) {
        let t = (point - self.origin).dot(self.direction);
        let offset = point - (self.origin + t * self.direction);
        let (a, b) = (self.across(0, t), self.across(1, t));
        let lengths = Vec2::new(a.length(), b.length());
        let (longest, beside) = (lengths.x.max(lengths.y), beside + self.blur * t);
        // The least squares, as footprints that fold have no area.
        let least = (1e-2 * longest) * (1e-2 * longest);
        let (dot, squares) = (a.dot(b), lengths * lengths + least);
        let inv_determinant = (squares.x * squares.y - dot * dot).recip();
        let (along_a, along_b) = (a.dot(offset), b.dot(offset));
        let u = (squares.y * along_a - dot * along_b) * inv_determinant;
        let v = (squares.x * along_b - dot * along_a) * inv_determinant;
        let rest = (offset - a * u - b * v).length();
        // Not of NaN either.
        let is_within = (t > 0.0)
            & (u.abs() <= 1.0 + beside / lengths.x)
            & (v.abs() <= 1.0 + beside / lengths.y)
            & (rest <= FOLD * longest + beside);
        let off = u.abs().max(v.abs()).max(rest / (FOLD * longest));
        (Place { coordinates: Vec2::new(u, v), off }, is_within)
    }

    /// The change of the place where the photon is after a way, across it.
    #[inline(always)]
    fn across(&self, axis: usize, t: f32) -> Vec3 {
        let moved = self.d_origin[axis] + t * self.d_direction[axis];
        moved - self.direction * moved.dot(self.direction)
    }
}

impl Photons {
    /// Whether no photon has arrived.
    pub(super) fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// Writes the starts for a point of searches for the light of this index.
    pub(super) fn find_starts(&self, light: u32, point: Vec3, starts: &mut Starts) {
        starts.0.clear();
        if let Ok(place) = self.lights.binary_search_by_key(&light, |(index, _)| *index) {
            self.lights[place].1.find(point, 0.0, starts);
        }
    }
}

impl World {
    /// Lights whose reflections may arrive at a point and be worth a search, where starts of the strength `always` always are and
    /// of weaker ones a part; of many lights a few, evenly spread by `roulette` in [0, 1).
    pub(crate) fn lights_in_mirrors(
        &self,
        point: Vec3,
        (always, roulette): (f32, f32),
    ) -> impl Iterator<Item = LightInMirrors<'_>> {
        let lights = &self.specular.reflected.lights;
        let stride = (lights.len() as f32 / MAX_LIGHTS as f32).max(1.0);
        (0..lights.len().min(MAX_LIGHTS)).filter_map(move |slot| {
            let (place, roulette) = if stride == 1.0 {
                (slot, roulette)
            } else {
                let place = (slot as f32 + roulette) * stride;
                ((place as usize).min(lights.len() - 1), place.fract())
            };
            let (index, photons) = &lights[place];
            let light = self.narrow_light(*index).filter(|_| photons.may_reach(point))?;
            let distance_squared = light.place().map_or(1.0, |(position, ..)| position.distance_squared(point));
            let may_light = photons.may_light(point, roulette * always / distance_squared);
            may_light.then_some(LightInMirrors {
                index: *index,
                light,
                distance_squared,
                inv_probability: stride,
                photons,
                roulette,
            })
        })
    }

    /// The light of this index if it is a point, a spot or a sun; of the sky, its sun.
    fn narrow_light(&self, index: u32) -> Option<&PunctualLight> {
        match &self.lights.lights()[index as usize] {
            Light::Punctual(light) => Some(light),
            Light::Sky => self.lights.sky.sun(),
            Light::Triangle(_) => None,
        }
    }
}

impl LightInMirrors<'_> {
    /// Writes the starts for a point, the strongest first, of the searches that are worth it: of those weaker than
    /// `always`, a part in proportion to their strength.
    pub(crate) fn find_starts(&self, point: Vec3, always: f32, starts: &mut Starts) {
        starts.0.clear();
        self.photons.find(point, self.roulette * always / self.distance_squared, starts);
        let starts = &mut starts.0;
        starts.iter_mut().for_each(|start| start.strength *= self.distance_squared);
        starts.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    }
}

impl Starts {
    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Each of them.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Start> {
        self.0.iter()
    }

    /// Adds a start, or puts it in the place of one that is farther from its light: of one beside it, or of the worst if
    /// there is no place left. It then counts as strong as the stronger of both.
    fn add(&mut self, start: Start) {
        let kept = &mut self.0;
        let same = kept.iter().position(|other| start.emission.is_beside(&other.emission));
        let worst = || kept.iter().enumerate().max_by(|a, b| a.1.off.total_cmp(&b.1.off)).map(|(i, _)| i);
        match same.or_else(|| if kept.len() == MAX_STARTS { worst() } else { None }) {
            Some(place) => {
                let other = &mut kept[place];
                let strength = start.strength.max(other.strength);
                *other = Start { strength, ..if start.off < other.off { start } else { *other } };
            }
            None => kept.push(start),
        }
    }
}

impl Emission {
    /// Whether a search from it finds what one from the other does.
    fn is_beside(&self, other: &Self) -> bool {
        self.reflection == other.reflection && self.sent.distance(other.sent) < self.spacing.min(other.spacing)
    }
}
