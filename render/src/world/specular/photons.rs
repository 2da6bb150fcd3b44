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

mod send;

use glam::{IVec3, Mat2, Vec2, Vec3};
use halfdome_kernel::geometry::Aabb;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::chain::Reflection;
use crate::light::Light;
use crate::world::World;

/// The least width of a cell, as a part of the body's radius.
const MIN_CELL_IN_RADII: f32 = 0.01;
/// The greatest extents of footprints of refracted and of reflected light, as parts of the body's radius: wider
/// footprints are faint, but flat mirrors keep their light together.
const MAX_EXTENTS: [f32; 2] = [0.5, 4.0];
/// The least width of a cell, as a part of its distance from the origin.
const MIN_CELL_IN_DISTANCES: f32 = 1e-6;
/// The allowed distance of a point from a footprint's plane, relative to its length: where it folds, the second
/// derivative matters.
const FOLD: f32 = 0.25;
/// The most lights that are searched for in mirrors from a point.
const MAX_LIGHTS: usize = 4;
/// The most photons of a cell, ...
const MAX_OF_CELL: usize = 48;
/// ... and the most starts for a point.
const MAX_STARTS: usize = 32;

/// A map of light of points, spots and suns.
#[derive(Debug, Default)]
pub(super) struct Photons {
    /// The lights that have any, in order of their indices.
    lights: Vec<(u32, LightPhotons)>,
}

/// Photons of one light, and the cells around where they arrive.
#[derive(Debug, Default)]
struct LightPhotons {
    photons: Vec<Photon>,
    /// In a cell, of photons whose starts are close to each other there, one; by level and place.
    cells: HashMap<(i32, IVec3), Vec<u32>, BuildHasherDefault<CellHasher>>,
    levels: Vec<Level>,
    /// Around all footprints.
    bounds: Option<Aabb>,
}

/// Cells of one size.
#[derive(Clone, Copy, Debug)]
struct Level {
    /// The binary logarithm of their width.
    exponent: i32,
    width: f32,
    /// The greatest irradiance of a photon in them.
    irradiance: f32,
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
    /// The kind of its chain.
    pub reflection: Reflection,
    /// About how much light comes, as a part of what would come straight from the light.
    pub strength: f32,
    /// The emission of a photon that arrives there (of a sun, its origin; of other lights, its direction), ...
    pub sent: Vec3,
    /// ... and how far apart photons were.
    pub spacing: f32,
    /// The distance of the point from the middle of the footprint: the less, the likelier is a path near the start.
    off: f32,
}

/// The starts for a point.
#[derive(Clone, Copy)]
pub(crate) struct Starts {
    starts: [Start; MAX_STARTS],
    count: usize,
}

/// The starts for a point of searches for a light that is reflected there.
pub(crate) struct ReflectedStarts {
    /// The index of the light.
    pub light: u32,
    /// The reciprocal of the probability of choosing it.
    pub inv_probability: f32,
    pub starts: Starts,
}

/// A photon that has arrived.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    photon: Photon,
    point: Vec3,
    /// Half of the extent of its footprint.
    extent: Vec3,
}

impl Photon {
    /// The start for a point that is within the footprint, or so far beside it.
    fn start(&self, point: Vec3, beside: f32) -> Option<Start> {
        let t = (point - self.origin).dot(self.direction);
        if t <= 0.0 {
            return None;
        }
        let offset = point - (self.origin + t * self.direction);
        let [a, b] = [0, 1].map(|axis| self.across(axis, t));
        let lengths = Vec2::new(a.length(), b.length());
        let (longest, beside) = (lengths.max_element(), beside + self.blur * t);
        // The least squares, as footprints that fold have no area.
        let least = (1e-2 * longest) * (1e-2 * longest);
        let (dot, squares) = (a.dot(b), lengths * lengths + least);
        let gram = Mat2::from_cols_array(&[squares.x, dot, dot, squares.y]);
        let place = gram.inverse() * Vec2::new(a.dot(offset), b.dot(offset));
        let rest = (offset - a * place.x - b * place.y).length();
        // Not of NaN either.
        if !(place.abs().cmple(1.0 + beside / lengths).all() && rest <= FOLD * longest + beside) {
            return None;
        }
        let off = place.abs().max_element().max(rest / (FOLD * longest));
        let exit = self.origin + place.x * self.d_origin[0] + place.y * self.d_origin[1];
        Some(Start {
            direction: (exit - point).normalize_or_zero(),
            sent: self.sent.at + place.x * self.sent.by[0] + place.y * self.sent.by[1],
            spacing: self.sent.by[0].length(),
            reflection: self.reflection,
            strength: self.irradiance,
            off,
        })
    }

    /// The change of the place where the photon is after a way, across it.
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

    /// The starts for a point of searches for the light of this index.
    pub(super) fn starts(&self, light: u32, point: Vec3) -> Starts {
        let found = self.lights.binary_search_by_key(&light, |(index, _)| *index);
        found.map_or(Starts::NONE, |place| self.lights[place].1.merged_starts(point, 0.0))
    }
}

impl World {
    /// Lights whose reflections may arrive at a point, with the starts of the searches for them, the strongest first; of many
    /// lights a few, evenly spread by `roulette` in [0, 1). Starts weaker than a part of `always`, which is `roulette` or
    /// its remainder, are left out.
    pub(crate) fn reflected_starts(
        &self,
        point: Vec3,
        roulette: f32,
        always: f32,
    ) -> impl Iterator<Item = ReflectedStarts> {
        let lights = &self.specular.reflected.lights;
        let stride = (lights.len() as f32 / MAX_LIGHTS as f32).max(1.0);
        (0..lights.len().min(MAX_LIGHTS)).filter_map(move |slot| {
            let (place, rest) = if stride == 1.0 {
                (slot, roulette)
            } else {
                let place = (slot as f32 + roulette) * stride;
                ((place as usize).min(lights.len() - 1), place.fract())
            };
            let (light, photons) = &lights[place];
            let Light::Punctual(punctual) = &self.lights.lights()[*light as usize] else { return None };
            if !photons.may_reach(point) {
                return None;
            }
            let distance_squared = punctual.place().map_or(1.0, |(position, ..)| position.distance_squared(point));
            let starts = photons.merged_starts(point, rest * always / distance_squared);
            let starts = starts.strongest_first(distance_squared);
            Some(ReflectedStarts { light: *light, inv_probability: stride, starts })
        })
    }
}

impl Starts {
    const NONE: Self = Self {
        starts: [Start {
            direction: Vec3::ZERO,
            reflection: None,
            strength: 0.0,
            sent: Vec3::ZERO,
            spacing: 0.0,
            off: 0.0,
        }; MAX_STARTS],
        count: 0,
    };

    /// Each of them.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Start> {
        self.starts[..self.count].iter()
    }

    /// The same starts, the strongest first, where the light has the reciprocal of this irradiance.
    fn strongest_first(mut self, distance_squared: f32) -> Self {
        let starts = &mut self.starts[..self.count];
        starts.iter_mut().for_each(|start| start.strength *= distance_squared);
        starts.sort_by(|a, b| b.strength.total_cmp(&a.strength));
        self
    }

    /// Adds a start, or puts it in the place of one that is farther from its light: of one beside it, or of the worst if
    /// there is no place left. It then counts as strong as the stronger of both.
    fn add(&mut self, start: Start) {
        let kept = &mut self.starts[..self.count];
        let same = kept.iter().position(|other| start.is_beside(other));
        let worst = || kept.iter().enumerate().max_by(|a, b| a.1.off.total_cmp(&b.1.off)).map(|(i, _)| i);
        match same.or_else(|| if self.count == MAX_STARTS { worst() } else { None }) {
            Some(place) => {
                let other = &mut kept[place];
                let strength = start.strength.max(other.strength);
                *other = Start { strength, ..if start.off < other.off { start } else { *other } };
            }
            None => {
                self.starts[self.count] = start;
                self.count += 1;
            }
        }
    }
}

impl LightPhotons {
    /// Whether a point is in the box of all footprints.
    fn may_reach(&self, point: Vec3) -> bool {
        self.bounds.is_some_and(|bounds| point.cmpge(bounds.min).all() && point.cmple(bounds.max).all())
    }

    /// The starts for a point by photons of at least this irradiance, without those that lead to the same connection.
    fn merged_starts(&self, point: Vec3, irradiance: f32) -> Starts {
        let mut starts = Starts::NONE;
        if self.may_reach(point) {
            for level in self.levels.iter().filter(|level| level.irradiance >= irradiance) {
                let photons = self.cells.get(&(level.exponent, cell(point, level.width))).into_iter().flatten();
                let photons = photons.map(|&index| &self.photons[index as usize]);
                let strong = photons.filter(|photon| photon.irradiance >= irradiance);
                strong
                    .filter_map(|photon| {
                        photon.start(point, if photon.reflection.is_some() { 0.5 * level.width } else { level.width })
                    })
                    .for_each(|start| starts.add(start));
            }
        }
        starts
    }

    /// Adds a photon that has arrived from a body of this radius.
    fn add(&mut self, arrival: &Arrival, radius: f32) {
        let Arrival { photon, point, extent } = arrival;
        let greatest = extent.max_element();
        let limit = MAX_EXTENTS[usize::from(photon.reflection.is_some())] * radius;
        if greatest.is_nan() || greatest > limit {
            return;
        }
        // Cells far from the origin are no narrower than a few roundings of their coordinates.
        let least = (MIN_CELL_IN_RADII * radius).max(MIN_CELL_IN_DISTANCES * point.abs().max_element());
        let level = greatest.max(least).log2().floor() as i32;
        let width = (level as f32).exp2();
        match self.levels.iter_mut().find(|other| other.exponent == level) {
            Some(other) => other.irradiance = other.irradiance.max(photon.irradiance),
            None => self.levels.push(Level { exponent: level, width, irradiance: photon.irradiance }),
        }
        let index = self.photons.len() as u32;
        self.photons.push(*photon);
        let around = Aabb { min: *point - *extent, max: *point + *extent };
        self.bounds = Some(self.bounds.map_or(around, |bounds| bounds.union(&around)));
        let [min, max] = [around.min, around.max].map(|corner| cell(corner, width));
        for z in min.z..=max.z {
            for y in min.y..=max.y {
                for x in min.x..=max.x {
                    let at = IVec3::new(x, y, z);
                    self.add_to(at, level, index);
                }
            }
        }
    }

    /// Stores a photon in a cell that it may light, unless the cell has a better one with a start close to its own.
    fn add_to(&mut self, at: IVec3, level: i32, index: u32) {
        let width = (level as f32).exp2();
        let center = width * (at.as_vec3() + 0.5);
        let start = |index: u32| self.photons[index as usize].start(center, width);
        let Some(own) = start(index) else {
            return;
        };
        let kept = self.cells.entry((level, at)).or_default();
        let mut others = (0..kept.len()).filter_map(|i| Some((i, start(kept[i])?)));
        match others.find(|(_, start)| own.is_beside(start)) {
            Some((i, start)) if own.off < start.off => kept[i] = index,
            None if kept.len() < MAX_OF_CELL => kept.push(index),
            _ => {}
        }
    }
}

impl Start {
    /// Whether a search from it finds what one from the other does.
    fn is_beside(&self, other: &Self) -> bool {
        self.reflection == other.reflection && self.sent.distance(other.sent) < self.spacing.min(other.spacing)
    }
}

/// The cell of this width that a point is in.
fn cell(point: Vec3, width: f32) -> IVec3 {
    let scaled = point / width;
    let towards_zero = scaled.as_ivec3();
    towards_zero.saturating_sub(IVec3::from(scaled.cmplt(towards_zero.as_vec3())))
}

/// A hash of few words, faster than the standard library's, which withstands attackers.
#[derive(Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_i32(byte.into()));
    }

    fn write_i32(&mut self, word: i32) {
        // Knuth's multiplier of a linear congruential generator.
        self.0 = (self.0.rotate_left(13) ^ u64::from(word as u32)).wrapping_mul(6_364_136_223_846_793_005);
    }
}
