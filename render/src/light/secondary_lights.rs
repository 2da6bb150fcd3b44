//! Secondary lights: parts of surfaces that lights light so strongly that they light the room themselves, such as the
//! inside of a lampshade, the sunlit part of a floor, or a curtain before a window. Bounces rarely hit them, and each
//! hit is a firefly in the picture.
//!
//! So they are sampled as lights (see [`estimator`](crate::estimator)): a light tree of their own chooses one by its
//! estimated contribution to a receiver. The probability of such a ray follows from their total irradiance, relative to
//! the mean irradiance of the scene's surfaces. Each is a triangle of the scene, or a cell of one.

use std::f32::consts::PI;

use glam::{Vec2, Vec2Swizzles, Vec3};
use halfdome_kernel::Triangle;

use super::Receiver;
use super::cells::{Division, PartTable, TrianglePart};
use super::tree::leaf::{TriangleLight, Triangles};
use super::tree::{RootWeights, Tree, total};

/// Bins of directions along each axis of an octahedral map.
const SIDE: usize = 8;
/// The margin beyond the farthest ray.
const SLACK: f32 = 1.1;

/// How far the light of a part reaches, by bins of directions: the inside of a shade is visible from above and from
/// below.
#[derive(Clone, Debug)]
pub(crate) struct Reach([f32; SIDE * SIDE]);

impl Default for Reach {
    fn default() -> Self {
        Self([0.0; SIDE * SIDE])
    }
}

/// Part of a surface that is a secondary light.
#[derive(Clone, Debug)]
pub(crate) struct LitPart {
    pub cell: TrianglePart,
    /// How it shines, and where its corners are.
    pub light: TriangleLight,
    /// Nothing, until it is measured.
    pub reach: Reach,
}

/// The secondary lights of a world.
#[derive(Debug, Default)]
pub(crate) struct SecondaryLights {
    tree: Option<Tree<Triangles>>,
    parts: Vec<LitPart>,
    table: PartTable,
    /// Their mean radiance by power, as luminance.
    radiance: f32,
    /// The irradiance from which on each path aims at them, likewise.
    worth: f32,
    /// The mean irradiance of other surfaces, likewise.
    elsewhere: f32,
    /// Whether they are so large that the many rays of a gather find them.
    are_large: bool,
}

/// A secondary light that was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChosenPart<'a> {
    pub part: &'a LitPart,
    /// The probability with which it was chosen.
    pub probability: f32,
    /// The rescaled remainder of the number that chose it, in [0, 1).
    pub rest: f64,
}

/// The secondary light at a point of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartAt<'a> {
    pub part: &'a LitPart,
    index: u32,
}

impl SecondaryLights {
    /// These secondary lights, which are triangles or cells of them, in a scene of `triangles` triangles.
    pub(crate) fn new(parts: Vec<LitPart>, division_of: impl Fn(u32) -> Division, triangles: usize) -> Self {
        let lights: Vec<TriangleLight> = parts.iter().map(|part| part.light).collect();
        let power: f64 = lights.iter().map(|it| f64::from(it.area * it.radiance)).sum();
        let by_power: f64 = lights.iter().map(|it| f64::from(it.area * it.radiance * it.radiance)).sum();
        let radiance = (by_power / power) as f32;
        let table = PartTable::new(parts.iter().map(|part| &part.cell), division_of, triangles);
        Self { tree: Tree::build(&lights), parts, table, radiance, ..Self::default() }
    }

    /// Paths sample secondary lights where their total irradiance is `worth`, as luminance, and rarely where it is
    /// less; `elsewhere` is the mean irradiance by all other surfaces. Gathers sample none that `are_large`.
    pub(crate) fn aim_from(&mut self, worth: f32, elsewhere: f32, are_large: bool) {
        (self.worth, self.elsewhere, self.are_large) = (worth, elsewhere, are_large);
    }

    /// The number of aimed rays for a receiver that sends so many other rays, evenly spread: by about what part of its
    /// irradiance secondary lights cause if nothing is in between. Where several of the others find them, fewer are
    /// worth it.
    pub(crate) fn aimed_rays(&self, receiver: &Receiver, others: usize) -> u32 {
        if self.are_large {
            return 0;
        }
        let irradiance = self.tree.as_ref().map_or(0.0, |tree| total(&tree.root_weights(receiver)));
        if irradiance <= 0.0 {
            return 0;
        }
        let share = irradiance / (irradiance + self.elsewhere);
        let hits = others as f32 * irradiance / (PI * self.radiance);
        (share * others as f32 / hits.max(1.0)).ceil() as u32
    }

    /// The secondary light at a point of triangle `prim_id` with these barycentric coordinates.
    #[inline(always)]
    pub(crate) fn at(&self, prim_id: u32, place: Vec2) -> Option<PartAt<'_>> {
        let index = self.table.at(prim_id, place)?;
        Some(PartAt { part: &self.parts[index as usize], index })
    }

    /// All of them.
    pub(crate) fn parts(&self) -> &[LitPart] {
        &self.parts
    }

    /// Whether there are any.
    #[inline(always)]
    pub(crate) fn has_any(&self) -> bool {
        self.tree.is_some()
    }

    /// Whether they are so large that the many rays of a gather find them.
    #[inline(always)]
    pub(crate) fn are_large(&self) -> bool {
        self.are_large
    }

    /// The probability that a surface of a path samples a secondary light, by their total estimated irradiance.
    #[inline(always)]
    pub(crate) fn chance(&self, receiver: &Receiver) -> f32 {
        let Some(tree) = &self.tree else { return 0.0 };
        (total(&tree.root_weights(receiver)) / self.worth).min(1.0)
    }

    /// Chooses one for a receiver by a number in [0, 1). `None` if none may send light there.
    #[inline(always)]
    pub(crate) fn choose(&self, receiver: &Receiver, u: f64) -> Option<ChosenPart<'_>> {
        let tree = self.tree.as_ref()?;
        let weights = tree.root_weights(receiver);
        if total(&weights) == 0.0 {
            return None;
        }
        let pick = tree.choose(receiver, &weights, u);
        Some(ChosenPart { part: &self.parts[pick.index as usize], probability: pick.probability, rest: pick.rest })
    }

    /// The probability with which this one is chosen.
    #[inline(always)]
    pub(crate) fn probability(&self, at: &PartAt, receiver: &Receiver) -> f32 {
        let Some(tree) = &self.tree else { return 0.0 };
        let weight = tree.weight(at.index, receiver);
        if weight == 0.0 { 0.0 } else { weight / total(&tree.root_weights(receiver)) }
    }

    /// So many of them, with their indices, that represent all, and the unoccluded irradiance that each represents.
    pub(crate) fn representatives(
        &self,
        receiver: &Receiver,
        count: u32,
    ) -> (f32, impl Iterator<Item = (usize, &LitPart)>) {
        let weights = self.tree.as_ref().map_or_else(RootWeights::default, |tree| tree.root_weights(receiver));
        let sum = total(&weights);
        let tree = self.tree.as_ref().filter(|_| sum > 0.0);
        let chosen = tree.into_iter().flat_map(move |tree| {
            let number = move |k: u32| (f64::from(k) + 0.5) / f64::from(count);
            (0..count).map(move |k| tree.choose(receiver, &weights, number(k)).index as usize)
        });
        (sum / count as f32, chosen.map(|index| (index, &self.parts[index])))
    }
}

impl LitPart {
    /// Whether its light may come so far in this unit vector.
    #[inline(always)]
    pub(crate) fn may_reach(&self, direction: Vec3, distance: f32) -> bool {
        distance <= SLACK * self.reach.0[bin(direction)]
    }

    /// Its corners in space.
    #[inline(always)]
    pub(crate) fn corners(&self) -> &Triangle {
        &self.light.corners
    }
}

impl Reach {
    /// The reach of a part whose rays in these unit directions went as far as given.
    pub(crate) fn of(rays: impl Iterator<Item = (Vec3, f32)>) -> Self {
        let mut reach = Self::default();
        for (direction, distance) in rays {
            let farthest = &mut reach.0[bin(direction)];
            *farthest = farthest.max(distance);
        }
        reach
    }
}

/// The bin of a unit vector.
#[inline(always)]
fn bin(direction: Vec3) -> usize {
    let flat = direction / direction.abs().element_sum();
    let folded = (1.0 - flat.truncate().yx().abs()) * flat.truncate().signum();
    let place = if flat.z < 0.0 { folded } else { flat.truncate() };
    let step = |x: f32| (((0.5 * x + 0.5) * SIDE as f32) as usize).min(SIDE - 1);
    step(place.x) + SIDE * step(place.y)
}
