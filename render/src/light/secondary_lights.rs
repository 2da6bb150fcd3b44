//! Secondary lights: small triangles that a nearby lamp lights so strongly that they light the room
//! themselves, such as the inside of a lampshade. Bounces rarely hit them, and each hit is a firefly in the picture.
//!
//! So they are sampled as lights (see [`estimator`](crate::estimator)): a light tree of their own chooses a triangle by
//! its estimated contribution to a receiver. The probability of such a ray follows from their total irradiance,
//! relative to the mean irradiance of the scene's surfaces.

use glam::{Vec2Swizzles, Vec3};

use super::tree::leaf::{TriangleLight, Triangles};
use super::tree::{RootWeights, Tree, total};
use super::{NO_LIGHT, Receiver};

/// Bins of directions along each axis of an octahedral map.
const SIDE: usize = 8;
/// The margin beyond the farthest ray.
const SLACK: f32 = 1.1;
/// Triangles that represent all, for approximations.
const REPRESENTATIVES: u32 = 8;

/// How far the light of a triangle reaches, by bins of directions: the inside of a shade is visible from above and from
/// below.
#[derive(Clone, Debug)]
pub(crate) struct Reach([f32; SIDE * SIDE]);

/// The secondary lights of a world.
#[derive(Debug, Default)]
pub(crate) struct SecondaryLights {
    tree: Option<Tree<Triangles>>,
    prims: Vec<u32>,
    reach: Vec<Reach>,
    /// For each `prim_id` its number among them, or [`NO_LIGHT`]; empty if there are none.
    index_of: Vec<u32>,
    /// The irradiance from which on each path aims at them, as luminance.
    worth: f32,
    /// The mean irradiance of other surfaces, likewise.
    elsewhere: f32,
}

/// A secondary light that was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChosenTriangle {
    pub prim_id: u32,
    /// The probability with which it was chosen.
    pub probability: f32,
    /// The rescaled remainder of the number that chose it, in [0, 1).
    pub rest: f64,
}

impl SecondaryLights {
    /// The secondary lights with these `prim_id`s, in a scene of `triangles` triangles.
    pub(crate) fn new(lit: Vec<(u32, TriangleLight)>, reach: Vec<Reach>, triangles: usize) -> Self {
        let (prims, lights): (Vec<u32>, Vec<TriangleLight>) = lit.into_iter().unzip();
        let mut index_of = vec![NO_LIGHT; triangles];
        for (index, &prim_id) in (0..).zip(&prims) {
            index_of[prim_id as usize] = index;
        }
        Self { tree: Tree::build(&lights), prims, reach, index_of, worth: 0.0, elsewhere: 0.0 }
    }

    /// Paths sample secondary lights where their total irradiance is `worth`, as luminance, and rarely where it is
    /// less; `elsewhere` is the mean irradiance by all other surfaces.
    pub(crate) fn aim_from(&mut self, worth: f32, elsewhere: f32) {
        (self.worth, self.elsewhere) = (worth, elsewhere);
    }

    /// About what part of the irradiance at a receiver they cause if nothing is in between.
    pub(crate) fn share(&self, receiver: &Receiver) -> f32 {
        let irradiance = self.tree.as_ref().map_or(0.0, |tree| total(&tree.root_weights(receiver)));
        if irradiance > 0.0 { irradiance / (irradiance + self.elsewhere) } else { 0.0 }
    }

    /// Whether triangle `prim_id` is one.
    #[inline]
    pub(crate) fn contains(&self, prim_id: u32) -> bool {
        self.index_of.get(prim_id as usize).is_some_and(|&index| index != NO_LIGHT)
    }

    /// The `prim_id` of each.
    pub(crate) fn prims(&self) -> &[u32] {
        &self.prims
    }

    /// Whether there are any.
    #[inline(always)]
    pub(crate) fn has_any(&self) -> bool {
        self.tree.is_some()
    }

    /// The probability that a surface of a path samples a secondary light, by their total estimated irradiance.
    #[inline(always)]
    pub(crate) fn chance(&self, receiver: &Receiver) -> f32 {
        let Some(tree) = &self.tree else { return 0.0 };
        (total(&tree.root_weights(receiver)) / self.worth).min(1.0)
    }

    /// Chooses one for a receiver by a number in [0, 1). `None` if none may send light there.
    #[inline]
    pub(crate) fn choose(&self, receiver: &Receiver, u: f64) -> Option<ChosenTriangle> {
        let tree = self.tree.as_ref()?;
        let weights = tree.root_weights(receiver);
        if total(&weights) == 0.0 {
            return None;
        }
        let pick = tree.choose(receiver, &weights, u);
        let prim_id = self.prims[pick.index as usize];
        Some(ChosenTriangle { prim_id, probability: pick.probability, rest: pick.rest })
    }

    /// The probability with which triangle `prim_id` is chosen.
    #[inline]
    pub(crate) fn probability(&self, prim_id: u32, receiver: &Receiver) -> f32 {
        match (&self.tree, self.index_of.get(prim_id as usize)) {
            (Some(tree), Some(&index)) if index != NO_LIGHT => {
                let weight = tree.weight(index, receiver);
                if weight == 0.0 {
                    return 0.0;
                }
                weight / total(&tree.root_weights(receiver))
            }
            _ => 0.0,
        }
    }

    /// A few of them that represent all, with the unoccluded irradiance that each represents.
    pub(crate) fn representatives(&self, receiver: &Receiver) -> (f32, impl Iterator<Item = u32>) {
        let weights = self.tree.as_ref().map_or_else(RootWeights::default, |tree| tree.root_weights(receiver));
        let sum = total(&weights);
        let tree = self.tree.as_ref().filter(|_| sum > 0.0);
        let chosen = tree.into_iter().flat_map(move |tree| {
            let number = |k: u32| (f64::from(k) + 0.5) / f64::from(REPRESENTATIVES);
            (0..REPRESENTATIVES).map(move |k| self.prims[tree.choose(receiver, &weights, number(k)).index as usize])
        });
        (sum / REPRESENTATIVES as f32, chosen)
    }

    /// Whether light of triangle `prim_id`, which must be lit, may come so far in this unit vector.
    #[inline]
    pub(crate) fn may_reach(&self, prim_id: u32, direction: Vec3, distance: f32) -> bool {
        let Reach(farthest) = &self.reach[self.index_of[prim_id as usize] as usize];
        distance <= SLACK * farthest[bin(direction)]
    }
}

impl Reach {
    /// The reach of a triangle whose rays in these unit directions went as far as given.
    pub(crate) fn of(rays: impl Iterator<Item = (Vec3, f32)>) -> Self {
        let mut reach = Self([0.0; SIDE * SIDE]);
        for (direction, distance) in rays {
            let farthest = &mut reach.0[bin(direction)];
            *farthest = farthest.max(distance);
        }
        reach
    }
}

/// The bin of a unit vector.
#[inline]
fn bin(direction: Vec3) -> usize {
    let flat = direction / direction.abs().element_sum();
    let folded = (1.0 - flat.truncate().yx().abs()) * flat.truncate().signum();
    let place = if flat.z < 0.0 { folded } else { flat.truncate() };
    let step = |x: f32| (((0.5 * x + 0.5) * SIDE as f32) as usize).min(SIDE - 1);
    step(place.x) + SIDE * step(place.y)
}
