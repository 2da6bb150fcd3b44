//! Rays from one point, or nearly, in any directions: sorted by direction into packets, whose hits are written back in
//! the rays' order.
//!
//! The directions of a hemisphere are of up to 24 classes (octant and fastest axis). In the order of their strata a
//! packet would straddle two or three classes, and be split; sorted, packets are full, and as their rays start at one
//! point they need not spread much to share a shaft.

use super::{TracePacket, Width};
use crate::bvh::BvhView;
use crate::geometry::{Hit, HitPacket, Ray, RayPacket};
use crate::simd::{Lanes, Simd};

/// Rays that are sorted together.
const CHUNK: usize = 256;
/// Directions are told apart by octant and fastest axis, and by a grid of 4 × 4 cells on that face of the cube.
const KEYS: usize = 3 * 8 * CELLS as usize;
const CELLS: u16 = 16;

/// Traces the packets of a gather.
pub(crate) trait Gather {
    /// A ray, and what else is known of it.
    type Ray: Copy;

    /// The ray alone.
    fn ray(ray: &Self::Ray) -> &Ray;

    /// Traces up to `N` rays, one at least, which are alike, and whose indices in the batch are given.
    fn trace<const N: usize, S: Simd, L: Lanes<N>>(&mut self, rays: &[Self::Ray], indices: &[usize])
    where
        Width<N>: TracePacket<N>;
}

/// Has `gather` trace rays in packets of rays that are alike, in any order.
#[inline(always)]
pub(crate) fn in_packets<S: Simd, G: Gather>(gather: &mut G, rays: &[G::Ray]) {
    for (chunk, rays) in rays.chunks(CHUNK).enumerate() {
        let (keys, order) = sorted(rays.iter().map(G::ray));
        let class = |index: u8| keys[usize::from(index)] / CELLS;
        let order = &order[..rays.len().min(CHUNK)];
        for alike in order.chunk_by(|&a, &b| class(a) == class(b)) {
            let (sixteens, rest) = alike.as_chunks::<16>();
            for indices in sixteens {
                together::<16, S, S::F16, G>(gather, chunk, rays, indices);
            }
            if rest.len() > 8 {
                together::<16, S, S::F16, G>(gather, chunk, rays, rest);
            } else if !rest.is_empty() {
                together::<8, S, S::F8, G>(gather, chunk, rays, rest);
            }
        }
    }
}

/// Traces up to `N` of the rays of a chunk in a packet.
#[inline(always)]
fn together<const N: usize, S: Simd, L: Lanes<N>, G: Gather>(
    gather: &mut G,
    chunk: usize,
    rays: &[G::Ray],
    numbers: &[u8],
) where
    Width<N>: TracePacket<N>,
{
    let (mut sorted, mut indices) = ([rays[0]; N], [0; N]);
    for ((ray, index), &number) in sorted.iter_mut().zip(&mut indices).zip(numbers) {
        *ray = rays[usize::from(number) % rays.len()];
        *index = chunk * CHUNK + usize::from(number);
    }
    let count = numbers.len().min(N);
    gather.trace::<N, S, L>(&sorted[..count], &indices[..count]);
}

/// The rays of a gather through a tree. Gives `write` the index of each and its nearest hit, or with `ANY` one that
/// stands for any.
struct Through<'a, const ANY: bool, F> {
    tree: &'a BvhView<'a>,
    write: F,
}

impl<const ANY: bool, F: FnMut(usize, Hit)> Gather for Through<'_, ANY, F> {
    type Ray = Ray;

    #[inline(always)]
    fn ray(ray: &Ray) -> &Ray {
        ray
    }

    #[inline(always)]
    fn trace<const N: usize, S: Simd, L: Lanes<N>>(&mut self, rays: &[Ray], indices: &[usize]) {
        let mut hits = HitPacket::MISS;
        let found = super::trace::<ANY, N, S, L>(self.tree, &RayPacket::from_rays(rays), &mut hits);
        for (lane, &index) in indices.iter().enumerate().take(N) {
            (self.write)(index, if ANY { Hit::any_if(found >> lane & 1 != 0) } else { hits.hit(lane) });
        }
    }
}

/// Gives `write` the index of each ray and its nearest hit, or with `ANY` one that stands for any, in any order.
#[inline(always)]
pub(in crate::traverse) fn trace<const ANY: bool, S: Simd>(
    tree: &BvhView,
    rays: &[Ray],
    write: impl FnMut(usize, Hit),
) {
    in_packets::<S, _>(&mut Through::<ANY, _> { tree, write }, rays);
}

/// The keys of up to 256 rays, and their numbers in the order of their keys, of equal ones in their own. Not inlined, so
/// that the memory for counting is free while the rays are traced.
#[inline(never)]
fn sorted<'r>(rays: impl Iterator<Item = &'r Ray>) -> ([u16; CHUNK], [u8; CHUNK]) {
    let (mut keys, mut ends) = ([0u16; CHUNK], [0u16; KEYS + 1]);
    let mut count = 0;
    for (key, ray) in keys.iter_mut().zip(rays) {
        *key = key_of(ray);
        ends[usize::from(*key) + 1] += 1;
        count += 1;
    }
    for key in 0..KEYS {
        ends[key + 1] += ends[key];
    }
    let mut order = [0; CHUNK];
    for (index, &key) in (0..=u8::MAX).zip(&keys).take(count) {
        let place = &mut ends[usize::from(key)];
        order[usize::from(*place) % CHUNK] = index;
        *place += 1;
    }
    (keys, order)
}

/// Less than [`KEYS`], for NaN too: the octant, the fastest axis, and where the ray meets that face of the unit cube.
#[inline(always)]
fn key_of(ray: &Ray) -> u16 {
    let d = ray.direction.to_array();
    let size = d.map(f32::abs);
    let z = if size[0] >= size[1] && size[0] >= size[2] {
        0
    } else if size[1] >= size[2] {
        1
    } else {
        2
    };
    let octant = d.iter().enumerate().fold(0, |octant, (axis, d)| octant | (d.to_bits() >> 31) << axis);
    // Saturates, and makes zero of NaN.
    let cell = |axis: usize| ((size[axis] / size[z] * 4.0) as u32).min(3);
    let (x, y) = (cell((z + 1) % 3), cell((z + 2) % 3));
    ((octant * 3 + z as u32) * 16 + (x & 1 | (y & 1) << 1 | (x & 2) << 1 | (y & 2) << 2)) as u16
}
