//! Rays from one point, or nearly, in any directions: sorted by direction into packets, whose hits are written back in
//! the rays' order.
//!
//! The directions of a hemisphere are of up to 24 classes (octant and fastest axis). In the order of their strata a
//! packet would straddle two or three classes, and be split; sorted, packets are full, and as their rays start at one
//! point they need not spread much to share a shaft.

use crate::bvh::BvhView;
use crate::geometry::{Hit, HitPacket, Ray, RayPacket};
use crate::simd::{Lanes, Simd};

/// Rays that are sorted together.
const CHUNK: usize = 256;
/// Directions are told apart by octant and fastest axis, and by a grid of 4 × 4 cells on that face of the cube.
const KEYS: usize = 3 * 8 * CELLS as usize;
const CELLS: u16 = 16;

/// Gives `write` the index of each ray and its nearest hit, or with `ANY` one that stands for any, in any order.
#[inline(always)]
pub(in crate::traverse) fn trace<const ANY: bool, S: Simd>(
    tree: &BvhView,
    rays: &[Ray],
    mut write: impl FnMut(usize, Hit),
) {
    for (chunk, rays) in rays.chunks(CHUNK).enumerate() {
        let mut write = |index: u8, hit: Hit| write(chunk * CHUNK + usize::from(index), hit);
        let (keys, order) = sorted(rays);
        let class = |index: u8| keys[usize::from(index)] / CELLS;
        let order = &order[..rays.len().min(CHUNK)];
        for alike in order.chunk_by(|&a, &b| class(a) == class(b)) {
            let (sixteens, rest) = alike.as_chunks::<16>();
            for indices in sixteens {
                together::<ANY, 16, S, S::F16>(tree, rays, indices, &mut write);
            }
            if rest.len() > 8 {
                together::<ANY, 16, S, S::F16>(tree, rays, rest, &mut write);
            } else if !rest.is_empty() {
                together::<ANY, 8, S, S::F8>(tree, rays, rest, &mut write);
            }
        }
    }
}

/// Traces up to `N` of `rays` in a packet.
#[inline(always)]
fn together<const ANY: bool, const N: usize, S: Simd, L: Lanes<N>>(
    tree: &BvhView,
    rays: &[Ray],
    indices: &[u8],
    write: &mut impl FnMut(u8, Hit),
) {
    let mut sorted = [rays[0]; N];
    for (ray, &index) in sorted.iter_mut().zip(indices) {
        *ray = rays[usize::from(index) % rays.len()];
    }
    let mut hits = HitPacket::MISS;
    let packet = RayPacket::from_rays(&sorted[..indices.len().min(N)]);
    let found = super::trace::<ANY, N, S, L>(tree, &packet, &mut hits);
    for (lane, &index) in indices.iter().enumerate().take(N) {
        write(index, if ANY { Hit::any_if(found >> lane & 1 != 0) } else { hits.hit(lane) });
    }
}

/// The numbers of up to 256 rays in the order of their keys, and of equal ones in their own.
#[inline(always)]
fn sorted(rays: &[Ray]) -> ([u16; CHUNK], [u8; CHUNK]) {
    let (mut keys, mut ends) = ([0u16; CHUNK], [0u16; KEYS + 1]);
    for (key, ray) in keys.iter_mut().zip(rays) {
        *key = key_of(ray);
        ends[usize::from(*key) + 1] += 1;
    }
    for key in 0..KEYS {
        ends[key + 1] += ends[key];
    }
    let mut order = [0; CHUNK];
    for (index, &key) in (0..=u8::MAX).zip(&keys).take(rays.len()) {
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
