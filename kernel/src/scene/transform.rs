//! The transform of an item: an affine map from its own space to the scene's, `p = M q + T`, static or moving.
//!
//! A ray is transformed the other way: `o' = M⁻¹ (o - T)` and `d' = M⁻¹ d`, computed in `f64` and rounded once. Its
//! direction keeps the length that this gives it, so `t` is the same in both spaces. Between two keys the elements of
//! `M` and `T` are interpolated, and the result inverted, in `f64` too; every point of the item then moves in a
//! straight line, and a box that is interpolated between boxes that enclose the item at the keys encloses it in
//! between.
//!
//! # Error bounds
//! With `u = 2⁻²⁴`, the local ray's point at `t` is off by `u (|o'| + t |d'|)`, and a hit there lies in the item's
//! local boxes widened by `e' ρ'`, where `ρ'` is the greatest distance along an axis from `o'` to anything in local
//! space, the local origin included, and `e'` is `23 u` for triangles and shapes (twice `OWN_PAD`, and rounding) or the
//! [error](Placement::error) of a scene. Back in the outer space that is `|M| (e' + 3u) ρ'`, and `ρ'` is at most
//! `|M⁻¹| ρ`. So a hit is off the item's box, along axis `k`, by at most `ρ` times
//!
//! ```text
//! error_k = (Σ_j |M_kj|) ‖M⁻¹‖ (e' + 32 u)          ‖.‖: greatest row sum of absolute values
//! ```
//!
//! so boxes are widened by this amount, in the tree or by the ray (see [`widening`](super::widening)), and no hit is
//! lost at an instance's box. A scene where this bound exceeds a [quarter](MAX_ERROR) is refused; a rotation's is 6e-6
//! at most.

#[cfg(any(feature = "alloc", test))]
use alloc::sync::Arc;
use core::ops::Deref;

use glam::{Affine3A, DMat3, DVec3, Vec3};

use super::image::image_of_mesh;
use super::image_box::{image_at, moving_pad, round_up};
use super::inverse::{Inverse, MAX_CONDITION, inverse_norm_between, linear, norm, row_sums, translation};
use crate::bvh::BvhView;
use crate::error::{Error, InvalidScene};
use crate::geometry::moment::Moment;
use crate::geometry::{Aabb, Ray, RayPacket};

/// The greatest error of a scene's boxes, in units of the reach of a ray.
pub(super) const MAX_ERROR: f32 = 0.25;

/// Rounding in one change of spaces, and of hits within their own boxes.
const ROUNDING: f64 = 32.0 / (1u32 << 24) as f64;

/// Above this condition the elements, which are rounded to `f32`, do not tell a transform from one that flattens.
const FLAT: f64 = (1u32 << 22) as f64;

/// Transforms at evenly spaced times.
#[derive(Clone, Debug)]
pub(super) enum Keys<'a> {
    Borrowed(&'a [Affine3A]),
    #[cfg(any(feature = "alloc", test))]
    Shared(Arc<[Affine3A]>),
}

impl Deref for Keys<'_> {
    type Target = [Affine3A];
    #[inline(always)]
    fn deref(&self) -> &[Affine3A] {
        match self {
            Self::Borrowed(keys) => keys,
            #[cfg(any(feature = "alloc", test))]
            Self::Shared(keys) => keys,
        }
    }
}

/// A transform without padding, as there may be millions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packed([f32; 12]);

impl Packed {
    fn new(transform: &Affine3A) -> Self {
        Self(transform.to_cols_array())
    }

    #[inline(always)]
    fn get(&self) -> Affine3A {
        Affine3A::from_cols_array(&self.0)
    }

    /// Where it takes the origin.
    #[inline(always)]
    fn translation(&self) -> DVec3 {
        let [.., x, y, z] = self.0;
        DVec3::new(x.into(), y.into(), z.into())
    }
}

/// The transform of an item.
#[derive(Clone, Debug)]
pub(super) enum Placement<'a> {
    /// No transform.
    AsItIs,
    /// A transform that flattens the item: it cannot be hit.
    Flat { to_scene: Packed },
    /// A static transform.
    Still { to_scene: Packed, to_local: Inverse, inverse_norm: f32 },
    /// Transforms at evenly spaced times; the inverse's norm is a bound for all times.
    Moving { keys: Keys<'a>, inverse_norm: f32 },
}

impl<'a> Placement<'a> {
    /// A placement by a static transform.
    ///
    /// # Errors
    /// [`InvalidScene::NotFinite`] and [`InvalidScene::Singular`].
    pub(super) fn still(to_scene: &Affine3A) -> Result<Self, Error> {
        if !to_scene.is_finite() {
            return Err(InvalidScene::NotFinite { key: 0 }.into());
        }
        let flat = Self::Flat { to_scene: Packed::new(to_scene) };
        let Some(to_local) = Inverse::new(linear(to_scene)) else {
            return Ok(flat);
        };
        let inverse_norm = to_local.norm();
        match inverse_norm * norm(&linear(to_scene)) {
            condition if condition > FLAT => return Ok(flat),
            condition if condition > MAX_CONDITION => return Err(InvalidScene::Singular { key: 0 }.into()),
            _ => {}
        }
        Ok(Self::Still { to_scene: Packed::new(to_scene), to_local, inverse_norm: round_up(inverse_norm) })
    }

    /// A placement by transforms at evenly spaced times.
    ///
    /// # Errors
    /// [`InvalidScene::NoKeys`], [`InvalidScene::NotFinite`] and [`InvalidScene::Singular`]; the latter also if it is
    /// singular between keys, as halfway through half a turn.
    pub(super) fn moving(keys: Keys<'a>) -> Result<Self, Error> {
        if let [only] = &*keys {
            return Self::still(only);
        }
        if keys.is_empty() {
            return Err(InvalidScene::NoKeys.into());
        }
        if let Some(key) = keys.iter().position(|transform| !transform.is_finite()) {
            return Err(InvalidScene::NotFinite { key }.into());
        }
        let mut largest = 0.0f64;
        for (key, pair) in keys.windows(2).enumerate() {
            let [from, to] = [linear(&pair[0]), linear(&pair[1])];
            largest = largest.max(inverse_norm_between(&from, &to).ok_or(InvalidScene::Singular { key })?);
        }
        Ok(Self::Moving { keys, inverse_norm: round_up(largest) })
    }

    /// The number of keys at which the transform is given.
    pub(super) fn keys(&self) -> usize {
        match self {
            Self::AsItIs | Self::Flat { .. } | Self::Still { .. } => 1,
            Self::Moving { keys, .. } => keys.len(),
        }
    }

    /// The ray in the item's space, at a time in 0..=1 or moved there; `None` if the time is NaN.
    #[inline(always)]
    pub(super) fn to_local(&self, ray: &Ray, time: f32) -> Option<Ray> {
        if let Self::AsItIs = self {
            return Some(*ray);
        }
        let (translation, inverse) = self.inverse(time)?;
        Some(inverse.ray(translation, ray))
    }

    /// Sets origins and directions to those of the rays of a packet in the item's space, as of
    /// [`to_local`](Self::to_local). Whether there are any.
    #[inline(always)]
    pub(super) fn packet_to_local<const N: usize>(
        &self,
        rays: &RayPacket<N>,
        time: f32,
        local: &mut RayPacket<N>,
    ) -> bool {
        if let Self::AsItIs = self {
            (local.origin, local.direction) = (rays.origin, rays.direction);
            return true;
        }
        let Some((translation, inverse)) = self.inverse(time) else { return false };
        inverse.packet(translation, rays, local);
        true
    }

    /// The translation and the inverse at a time.
    #[inline(always)]
    fn inverse(&self, time: f32) -> Option<(DVec3, Inverse)> {
        match self {
            Self::AsItIs | Self::Flat { .. } => None,
            Self::Still { to_scene, to_local, .. } => Some((to_scene.translation(), *to_local)),
            Self::Moving { keys, .. } => {
                let (linear, translation) = between(keys, time)?;
                Some((translation, Inverse::new(linear)?))
            }
        }
    }

    /// The transform to the scene's space at a time, rounded.
    pub(super) fn to_scene(&self, time: f32) -> Option<Affine3A> {
        match self {
            Self::AsItIs => Some(Affine3A::IDENTITY),
            Self::Flat { to_scene } | Self::Still { to_scene, .. } => Some(to_scene.get()),
            Self::Moving { keys, .. } => {
                let (linear, translation) = between(keys, time)?;
                Some(Affine3A::from_mat3_translation(linear.as_mat3(), translation.as_vec3()))
            }
        }
    }

    /// The elements of the transform to the scene's space at a time; `None` if it flattens, or the time is NaN.
    pub(super) fn elements(&self, time: f32) -> Option<(DMat3, DVec3)> {
        match self {
            Self::AsItIs if time.is_nan() => None,
            Self::AsItIs => Some((DMat3::IDENTITY, DVec3::ZERO)),
            Self::Flat { .. } => None,
            Self::Still { .. } if time.is_nan() => None,
            Self::Still { to_scene, .. } => Some((linear(&to_scene.get()), to_scene.translation())),
            Self::Moving { keys, .. } => between(keys, time),
        }
    }

    /// A box around the image of `local` at a key.
    pub(super) fn aabb(&self, key: usize, local: &Aabb) -> Aabb {
        match self {
            Self::AsItIs => *local,
            Self::Flat { .. } => Aabb::EMPTY,
            Self::Still { to_scene, .. } => image_at(&to_scene.get(), local, 0.0),
            Self::Moving { keys, .. } => image_at(&keys[key], local, moving_pad(keys, local)),
        }
    }

    /// A box around the image of a mesh at a key: no larger than that of its box.
    pub(super) fn mesh_aabb(&self, key: usize, tree: &BvhView) -> Aabb {
        let whole = self.aabb(key, &tree.bounds());
        let (to_scene, pad) = match self {
            Self::AsItIs | Self::Flat { .. } => return whole,
            Self::Still { to_scene, .. } => (to_scene.get(), 0.0),
            Self::Moving { keys, .. } => (keys[key], round_up(moving_pad(keys, &tree.bounds()))),
        };
        let Aabb { min, max } = image_of_mesh(&to_scene, tree);
        match min.is_finite() && max.is_finite() {
            true => Aabb { min: whole.min.max(min - pad), max: whole.max.min(max + pad) },
            false => whole,
        }
    }

    /// The box that a ray's reach has to span for this item: the images of `local` and of the local origin at all keys.
    pub(super) fn reach(&self, local: &Aabb) -> Aabb {
        match self {
            Self::AsItIs => return *local,
            Self::Flat { .. } => return Aabb::EMPTY,
            Self::Still { .. } | Self::Moving { .. } => {}
        }
        let with_origin = local.union(&Aabb { min: Vec3::ZERO, max: Vec3::ZERO });
        (0..self.keys()).fold(Aabb::EMPTY, |reach, key| reach.union(&self.aabb(key, &with_origin)))
    }

    /// A bound of how far, in units of a ray's reach, a hit may be off the item's box if it may be off local boxes by
    /// `local`: see the module's error bounds.
    pub(super) fn error(&self, local: f32) -> Vec3 {
        let sums = |transform: &Affine3A| row_sums(&linear(transform));
        let (sums, inverse_norm) = match self {
            Self::AsItIs => return Vec3::splat(local),
            Self::Flat { .. } => return Vec3::ZERO,
            Self::Still { to_scene, inverse_norm, .. } => (sums(&to_scene.get()), inverse_norm),
            Self::Moving { keys, inverse_norm } => (keys.iter().map(sums).fold(DVec3::ZERO, DVec3::max), inverse_norm),
        };
        let error = sums * f64::from(*inverse_norm) * (f64::from(local) + ROUNDING);
        Vec3::from_array(error.to_array().map(round_up))
    }
}

/// The elements at a time.
fn between(keys: &[Affine3A], time: f32) -> Option<(DMat3, DVec3)> {
    let Moment { key, fraction } = Moment::new(time, keys.len())?;
    let (from, to) = (keys.get(key)?, keys.get(key + 1).unwrap_or(keys.get(key)?));
    let fraction = f64::from(fraction);
    let mix = |a: DVec3, b: DVec3| a * (1.0 - fraction) + b * fraction;
    let (a, b) = (linear(from), linear(to));
    let linear = DMat3::from_cols(mix(a.x_axis, b.x_axis), mix(a.y_axis, b.y_axis), mix(a.z_axis, b.z_axis));
    Some((linear, mix(translation(from), translation(to))))
}

#[cfg(test)]
mod tests;
