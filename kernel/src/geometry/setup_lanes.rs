//! Setup of rays in lanes, each with its own direction class: equal to [`RaySetup`] bit for bit; and the rays' test
//! against a box that they share.

use super::Aabb;
use super::box_lanes::BoxLanes;
#[cfg(doc)]
use super::setup::{Line, RaySetup, Slabs};
use super::setup::{
    MAX_COORDINATE, MAX_DIRECTION, MIN_COMPONENT, MIN_DIRECTION, NODE_ORIGIN_PAD, NODE_PAD, UNDERFLOW_PAD,
};
use super::setup_rows::{DirectionClasses, SetupRows, rows};
use crate::simd::{Lanes, Mask, Simd};

/// Rays prepared for traversal. Lanes that are not `live` are unspecified.
pub(crate) struct SetupLanes<const N: usize, L: Lanes<N>> {
    /// The rays that can hit something.
    pub live: u32,
    pub t_min: L,
    pub t_max: L,
    /// The rays that run fastest along x, and along y.
    fastest: [L::Mask; 2],
    /// Those whose directions are negative along x, y and z.
    negative: [L::Mask; 3],
    /// As in [`Slabs`].
    inverse: [L; 3],
    near_shift: [L; 3],
    far_shift: [L; 3],
    /// [`Line::numbers`].
    pub lines: [L; 8],
}

impl<const N: usize, L: Lanes<N>> SetupLanes<N, L> {
    /// From the rays' fields in the order of [`Ray`](super::Ray).
    #[inline(always)]
    pub(crate) fn new(rays: [L; 8], scene: &Aabb) -> Self {
        Self::within(rays, &BoxLanes::splat(scene))
    }

    /// The same, with a box for each ray.
    #[inline(always)]
    pub(crate) fn within([ox, oy, oz, t_min, dx, dy, dz, t_max]: [L; 8], scenes: &BoxLanes<L>) -> Self {
        let (o, d) = ([ox, oy, oz], [dx, dy, dz]);
        let size = [dx.abs(), dy.abs(), dz.abs()];
        let largest = size[0].max(size[1]).max(size[2]);
        let live = in_limits(&o, &size, largest) & t_min.le(t_max).bits() & scenes.not_empty::<N>();
        let fastest = [size[0].eq(largest), size[1].eq(largest)];

        let least = largest * L::splat(MIN_COMPONENT);
        let inverse = [inverse(dx, size[0], least), inverse(dy, size[1], least), inverse(dz, size[2], least)];
        let zero = L::splat(0.0);
        let negative = [inverse[0].lt(zero), inverse[1].lt(zero), inverse[2].lt(zero)];

        let reach = scenes.reach::<N>(&o);
        let reach_z = along::<2, N, L>(fastest, reach);
        let (mut near_shift, mut far_shift) = (o, o);
        for axis in 0..3 {
            let pad = (reach[axis] + reach_z) * L::splat(NODE_PAD) + o[axis].abs() * L::splat(NODE_ORIGIN_PAD);
            let pad = pad.copysign(d[axis]);
            near_shift[axis] = (o[axis] + pad) * inverse[axis] + L::splat(UNDERFLOW_PAD);
            far_shift[axis] = (o[axis] - pad) * inverse[axis] - L::splat(UNDERFLOW_PAD);
        }

        let [lox, loy, loz] = in_order(fastest, o);
        let [lix, liy, liz] = in_order(fastest, inverse);
        let [ldx, ldy, _] = in_order(fastest, d);
        let lines = [lox, loy, loz, lix, liy, liz, ldx * liz, ldy * liz];
        Self { live, t_min, t_max, fastest, negative, inverse, near_shift, far_shift, lines }
    }

    /// Where the rays enter and leave a box, of which the lower and upper bounds along each axis are given, within
    /// their intervals.
    #[inline(always)]
    pub(crate) fn intersect_box(&self, bounds: [[f32; 2]; 3]) -> (L, L) {
        let (near_x, far_x) = self.slab(0, bounds[0]);
        let (near_y, far_y) = self.slab(1, bounds[1]);
        let (near_z, far_z) = self.slab(2, bounds[2]);
        (near_x.max(near_y).max(near_z.max(self.t_min)), far_x.min(far_y).min(far_z.min(self.t_max)))
    }

    /// Widens boxes by `pad` besides, along each axis, as [`Slabs::widen`] does.
    #[inline(always)]
    pub(crate) fn widen(&mut self, pad: [L; 3]) {
        for (axis, pad) in pad.into_iter().enumerate() {
            let distance = pad * self.inverse[axis].abs();
            self.near_shift[axis] = self.near_shift[axis] + distance;
            self.far_shift[axis] = self.far_shift[axis] - distance;
        }
    }

    #[inline(always)]
    fn slab(&self, axis: usize, [lower, upper]: [f32; 2]) -> (L, L) {
        let (lower, upper, negative) = (L::splat(lower), L::splat(upper), self.negative[axis]);
        let near = L::select(negative, upper, lower).mul_sub(self.inverse[axis], self.near_shift[axis]);
        let far = L::select(negative, lower, upper).mul_sub(self.inverse[axis], self.far_shift[axis]);
        (near, far)
    }
}

impl<L: Lanes<8>> SetupLanes<8, L> {
    /// The classes of the lanes' directions.
    #[inline(always)]
    pub(crate) fn classes(&self) -> DirectionClasses {
        let [nx, ny, nz] = self.negative;
        DirectionClasses {
            fastest: [self.fastest[0].bits(), self.fastest[1].bits()],
            negative: [nx.bits(), ny.bits(), nz.bits()],
        }
    }

    /// The setup of each lane.
    #[inline(always)]
    pub(crate) fn rows<S: Simd<F8 = L>>(&self) -> SetupRows {
        let ([ix, iy, iz], [nx, ny, nz], [fx, fy, fz]) = (self.inverse, self.near_shift, self.far_shift);
        let zero = L::splat(0.0);
        SetupRows {
            lines: rows::<S>(self.lines),
            slabs: rows::<S>([ix, iy, iz, nx, ny, nz, self.t_min, self.t_max]),
            far_shifts: rows::<S>([fx, fy, fz, zero, zero, zero, zero, zero]),
            classes: self.classes(),
        }
    }
}

/// The lanes that are within the [numeric limits](crate#numeric-limits). Each component on its own: a maximum may lose
/// a NaN.
#[inline(always)]
fn in_limits<const N: usize, L: Lanes<N>>(o: &[L; 3], size: &[L; 3], largest: L) -> u32 {
    let (coordinate, length) = (L::splat(MAX_COORDINATE), L::splat(MAX_DIRECTION));
    let origin = o[0].abs().le(coordinate) & o[1].abs().le(coordinate) & o[2].abs().le(coordinate);
    let direction = size[0].le(length) & size[1].le(length) & size[2].le(length);
    (origin & direction & L::splat(MIN_DIRECTION).le(largest)).bits()
}

/// The reciprocal of a component, which is raised if it is small.
#[inline(always)]
fn inverse<const N: usize, L: Lanes<N>>(d: L, size: L, least: L) -> L {
    L::splat(1.0) / L::select(size.lt(least), least.copysign(d), d)
}

/// Of a vector, the component `k` of x, y and z in the order in which the axis along which the ray is fastest is the
/// last.
#[inline(always)]
fn along<const K: usize, const N: usize, L: Lanes<N>>([x, y]: [L::Mask; 2], v: [L; 3]) -> L {
    L::select(x, v[(K + 1) % 3], L::select(y, v[(K + 2) % 3], v[K]))
}

/// A vector in the order of [`Line::axes`] of a ray that runs forward.
#[inline(always)]
fn in_order<const N: usize, L: Lanes<N>>(fastest: [L::Mask; 2], v: [L; 3]) -> [L; 3] {
    [along::<0, N, L>(fastest, v), along::<1, N, L>(fastest, v), along::<2, N, L>(fastest, v)]
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, vec3};

    use super::super::setup::{Line, RaySetup, Slabs};
    use super::*;
    use crate::geometry::Ray;
    use crate::geometry::setup_rows::FORWARD;
    use crate::simd::{Work, dispatch, isas};
    use crate::traverse::tests::Random;

    /// Eight rays, each alone and all in lanes.
    struct Compare<'a>(&'a [Ray; 8], &'a Aabb);

    impl Work for Compare<'_> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self) {
            let [a, b, c, d, e, f, g, h] = self.0;
            let load = |ray: &Ray| S::F8::load(bytemuck::cast_ref(ray));
            let rays = [load(a), load(b), load(c), load(d), load(e), load(f), load(g), load(h)];
            let lanes = SetupLanes::new(S::transpose(rays), self.1);
            let rows = lanes.rows::<S>();
            for (lane, ray) in self.0.iter().enumerate() {
                let alone = RaySetup::new(ray, self.1);
                assert_eq!(lanes.live >> lane & 1 == 1, alone.is_some(), "{ray:?}");
                let Some(alone) = alone else { continue };
                let setup = setup(&rows, lane);
                assert_eq!(setup.slabs.negative, alone.slabs.negative, "{ray:?}");
                assert_eq!(bits(&setup.slabs), bits(&alone.slabs), "{ray:?}");
                assert_eq!(rows.slabs[lane][6..], [ray.t_min, ray.t_max]);
                // Backward rays have the first two axes the other way round.
                let ([x, y, z], numbers) = (alone.line.axes, alone.line.numbers);
                let backward = ray.direction[z as usize] < 0.0;
                let order = if backward { [1, 0, 2, 4, 3, 5, 7, 6] } else { [0, 1, 2, 3, 4, 5, 6, 7] };
                assert_eq!(setup.line.axes, if backward { [y, x, z] } else { [x, y, z] }, "{ray:?}");
                assert_eq!(setup.line.numbers.map(f32::to_bits), order.map(|k: usize| numbers[k].to_bits()), "{ray:?}");
            }
        }
    }

    /// What the rows hold of a lane, put together as for a ray alone.
    fn setup(rows: &SetupRows, lane: usize) -> RaySetup {
        let octant = rows.classes.octant(lane);
        let [ix, iy, iz, nx, ny, nz, ..] = rows.slabs[lane];
        let negative = [octant & 1 != 0, octant & 2 != 0, octant & 4 != 0];
        let axes = FORWARD[rows.classes.fastest(lane) % 3];
        assert_eq!(rows.classes.near_rows(lane), [0, 1, 2].map(|axis| 2 * axis as u8 + u8::from(negative[axis])));
        assert_eq!(rows.classes.corner_offsets(lane), axes.map(|axis| 8 * axis as u8));
        RaySetup {
            slabs: Slabs { inverse: [ix, iy, iz], near_shift: [nx, ny, nz], far_shift: rows.far_shift(lane), negative },
            line: Line { axes, numbers: rows.lines[lane] },
        }
    }

    fn bits(slabs: &Slabs) -> [[u32; 3]; 3] {
        [slabs.inverse, slabs.near_shift, slabs.far_shift].map(|v| v.map(f32::to_bits))
    }

    #[test]
    fn eight_rays_are_made_ready_as_each_alone() {
        let mut random = Random(31);
        let scene = Aabb { min: vec3(-1.0, -2.0, -0.5), max: vec3(3.0, 1.0, 0.5) };
        let steps = [-1.0f32, 1.0, 0.0, -0.0, 1e-12, -1e-12, 1e16, f32::NAN];
        for round in 0..if cfg!(miri) { 4 } else { 400 } {
            let rays = core::array::from_fn(|_| {
                let mut any = || steps[random.bits() as usize % (steps.len() - round % 3)];
                let direction = if round % 2 == 0 { Vec3::new(any(), any(), any()) } else { random.vector() };
                let t_min = random.unit() - 0.5;
                Ray { origin: random.vector() * 3.0, t_min, direction, t_max: 3.0 * random.unit() - 0.5 }
            });
            for scene in [&scene, &Aabb::EMPTY] {
                isas().for_each(|isa| dispatch(isa, Compare(&rays, scene)));
            }
        }
    }
}
