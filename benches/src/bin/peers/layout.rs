//! Embree's input and output: the structures of `rtcore_ray.h` and `rtcore_scene.h` of Embree 4.4, with one level of
//! instances and with instance arrays, as its releases are built. A library built without those has smaller hits, and
//! leaves the last word alone.

use std::ffi::{c_int, c_void};
use std::ptr;

use halfdome_kernel::{Hit, Ray};

/// `RTC_INVALID_GEOMETRY_ID`.
const INVALID: u32 = u32::MAX;

/// `RTC_RAY_QUERY_FLAG_INCOHERENT`.
pub(crate) const INCOHERENT: u32 = 0;
/// `RTC_RAY_QUERY_FLAG_COHERENT`.
pub(crate) const COHERENT: u32 = 1 << 16;

/// `RTCRayHitNt<N>`, and for N = 1 `RTCRayHit`. Its alignment is the largest that any width asks for.
#[repr(C, align(64))]
pub(crate) struct RayHit<const N: usize> {
    origin: [[f32; N]; 3],
    t_near: [f32; N],
    direction: [[f32; N]; 3],
    time: [f32; N],
    t_far: [f32; N],
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
    normal: [[f32; N]; 3],
    u: [f32; N],
    v: [f32; N],
    prim_id: [u32; N],
    geom_id: [u32; N],
    instance_id: [u32; N],
    instance_prim_id: [u32; N],
}

/// `RTCIntersectArguments`, and `RTCOccludedArguments`, which is alike; with room for the fields of later versions.
#[repr(C)]
pub(crate) struct Arguments {
    flags: u32,
    feature_mask: u32,
    context: *mut c_void,
    filter: *mut c_void,
    intersect: *mut c_void,
    reserved: [u64; 4],
}

/// Which lanes are active: -1 or 0 each.
#[repr(C, align(64))]
pub(crate) struct Valid<const N: usize>(pub(crate) [c_int; N]);

impl<const N: usize> RayHit<N> {
    /// Up to N rays, without hits.
    pub(crate) fn new(rays: &[Ray]) -> Self {
        let ray = |i: usize| &rays[i.min(rays.len() - 1)];
        let lanes = |value: fn(&Ray) -> f32| std::array::from_fn(|i| value(ray(i)));
        Self {
            origin: [lanes(|ray| ray.origin.x), lanes(|ray| ray.origin.y), lanes(|ray| ray.origin.z)],
            t_near: lanes(|ray| ray.t_min),
            direction: [lanes(|ray| ray.direction.x), lanes(|ray| ray.direction.y), lanes(|ray| ray.direction.z)],
            time: [0.0; N],
            t_far: lanes(|ray| ray.t_max),
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
            normal: [[0.0; N]; 3],
            u: [0.0; N],
            v: [0.0; N],
            prim_id: [INVALID; N],
            geom_id: [INVALID; N],
            instance_id: [INVALID; N],
            instance_prim_id: [INVALID; N],
        }
    }

    pub(crate) fn hit(&self, lane: usize) -> Hit {
        if self.geom_id[lane] == INVALID {
            return Hit::MISS;
        }
        Hit { t: self.t_far[lane], u: self.u[lane], v: self.v[lane], prim_id: self.prim_id[lane] }
    }

    /// Embree answers an occlusion query with a `t_far` of minus infinity.
    pub(crate) fn is_occluded(&self, lane: usize) -> bool {
        self.t_far[lane] < 0.0
    }
}

impl Arguments {
    /// No context, no callbacks, every feature.
    pub(crate) fn new(flags: u32) -> Self {
        let none = ptr::null_mut();
        Self { flags, feature_mask: u32::MAX, context: none, filter: none, intersect: none, reserved: [0; 4] }
    }
}

impl<const N: usize> Valid<N> {
    /// The first `count` lanes.
    pub(crate) fn first(count: usize) -> Self {
        Self(std::array::from_fn(|lane| if lane < count { -1 } else { 0 }))
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use glam::Vec3;

    use super::*;

    /// The headers count a packet's fields in words of N lanes: `tfar` is the 8th, `Ng` the 12th, `instPrimID` the
    /// 20th.
    #[test]
    fn fields_lie_where_the_headers_have_them() {
        fn check<const N: usize>() {
            assert_eq!(offset_of!(RayHit<N>, t_far), 4 * 8 * N);
            assert_eq!(offset_of!(RayHit<N>, normal), 4 * 12 * N);
            assert_eq!(offset_of!(RayHit<N>, prim_id), 4 * 17 * N);
            assert_eq!(offset_of!(RayHit<N>, geom_id), 4 * 18 * N);
            assert_eq!(offset_of!(RayHit<N>, instance_prim_id), 4 * 20 * N);
            assert!(align_of::<RayHit<N>>() >= 4 * N);
            assert!(align_of::<Valid<N>>() >= 4 * N);
        }
        check::<1>();
        check::<8>();
        check::<16>();
    }

    #[test]
    fn a_query_holds_its_rays_and_misses() {
        let rays = [1.0, 2.0, 3.0].map(|x| Ray { t_max: 10.0 * x, ..Ray::new(Vec3::new(x, 0.5, 0.0), Vec3::Y) });
        let mut query = RayHit::<8>::new(&rays);
        assert_eq!(query.origin[0][..3], [1.0, 2.0, 3.0]);
        assert_eq!((query.origin[1][2], query.direction[1][2], query.t_far[2]), (0.5, 1.0, 30.0));
        assert_eq!(query.hit(1), Hit::MISS);
        assert_eq!(Valid::<4>::first(3).0, [-1, -1, -1, 0]);
        (query.geom_id[1], query.prim_id[1], query.t_far[1]) = (0, 7, 1.5);
        assert_eq!(query.hit(1), Hit { t: 1.5, u: 0.0, v: 0.0, prim_id: 7 });
        query.t_far[0] = f32::NEG_INFINITY;
        assert_eq!([0, 1].map(|lane| query.is_occluded(lane)), [true, false]);
    }
}
