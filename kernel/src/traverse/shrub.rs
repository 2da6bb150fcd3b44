//! Many rays through a tree of one node, in waves: in each, the rays that go on are sorted by the block that they visit
//! next and by their fastest axis, and those of one kind meet its triangles eight at a time, a lane each.
//!
//! Nothing hides latency here, as nothing has to: so small a tree stays in the first-level cache, and what a flock does for
//! each ray, its lists and the gathering of triangles one by one, is most of what a ray costs. Triangles are looked up in
//! their block's own lanes.

use super::pending::meet_children;
use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::setup::Axis;
use crate::geometry::setup_lanes::{FORWARD, SetupLanes, rows};
use crate::geometry::triangle::{self, LineLanes};
use crate::geometry::{Hit, Ray};
use crate::simd::{Children, Lanes, Mask, Simd, lanes_of};

/// Rays that are sorted together.
const RAYS: usize = 256;
/// The most blocks of a tree that is traced so.
const BLOCKS: usize = 16;
/// Visits are told apart by block and axis: four times the block, plus the axis.
const KEYS: usize = 4 * BLOCKS;

/// Whether a tree is small enough.
#[inline(always)]
pub(super) fn is_shrub(tree: &BvhView) -> bool {
    tree.nodes().len() == 1 && tree.blocks().len() <= BLOCKS
}

/// Gives `land` the number of each ray and its nearest hit, or with `ANY` one that stands for any, in any order. The tree
/// is a shrub.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, rays: &[Ray], mut land: impl FnMut(usize, Option<Hit>)) {
    let Some(root) = tree.nodes().first() else { return };
    let mut wave = Wave::EMPTY;
    let (mut idle, mut departed) = (List::ALL, 0);
    let mut live = List::NONE;
    loop {
        while idle.len >= WIDTH && departed < rays.len() {
            wave.start::<S>(tree, root, rays, departed, &mut idle, &mut live);
            departed += WIDTH;
        }
        if live.len == 0 {
            return;
        }
        let done = idle.len;
        let mut kinds = wave.sort::<S>(&mut live, &mut idle);
        for place in done..idle.len {
            let i = idle.ray(place);
            land(wave.numbers[i], wave.best(i).found());
        }
        while kinds != 0 {
            let key = kinds.trailing_zeros() as usize;
            kinds &= kinds - 1;
            if let Some(block) = tree.blocks().get(key / 4) {
                wave.visit::<ANY, S>(block, FORWARD[key % 4 % 3], &live, key);
            }
        }
    }
}

/// Numbers of rays under way.
struct List {
    rays: [u8; RAYS],
    len: usize,
}

impl List {
    const NONE: Self = Self { rays: [0; RAYS], len: 0 };
    const ALL: Self = {
        let (mut rays, mut i) = ([0; RAYS], 0);
        while i < RAYS {
            rays[i] = i as u8;
            i += 1;
        }
        Self { rays, len: RAYS }
    };

    /// Writes `ray`, to stay only if `it_belongs` here.
    #[inline(always)]
    fn push(&mut self, ray: u8, it_belongs: bool) {
        self.rays[self.len % RAYS] = ray;
        self.len += usize::from(it_belongs);
    }

    #[inline(always)]
    fn ray(&self, place: usize) -> usize {
        usize::from(self.rays[place % RAYS])
    }
}

/// Rays under way.
struct Wave {
    /// Of each ray in its batch.
    numbers: [usize; RAYS],
    /// [`Line::numbers`](crate::geometry::setup::Line::numbers), in the order [`FORWARD`].
    lines: [[f32; WIDTH]; RAYS],
    fastest: [u8; RAYS],
    /// The best hits' `t`, `u`, `v` and `prim_id`, and the rays' `t_min`.
    found: [[f32; WIDTH]; RAYS],
    /// The leaves to visit, the next one last, and where their boxes begin.
    leaves: [[u32; WIDTH]; RAYS],
    near: [[f32; WIDTH]; RAYS],
    heights: [u8; RAYS],
    /// What the rays visit next, and where the rays of each key begin and end in the list.
    keys: [u8; RAYS],
    ends: [u16; KEYS + 1],
}

impl Wave {
    const EMPTY: Self = Self {
        numbers: [0; RAYS],
        lines: [[0.0; WIDTH]; RAYS],
        fastest: [0; RAYS],
        found: [[0.0; WIDTH]; RAYS],
        leaves: [[0; WIDTH]; RAYS],
        near: [[0.0; WIDTH]; RAYS],
        heights: [0; RAYS],
        keys: [0; RAYS],
        ends: [0; KEYS + 1],
    };

    /// Takes up to eight of `rays`, from the one numbered `first` on, through the root.
    #[inline(always)]
    fn start<S: Simd>(
        &mut self,
        tree: &BvhView,
        root: &Node,
        rays: &[Ray],
        first: usize,
        idle: &mut List,
        live: &mut List,
    ) {
        let mut lanes = [S::F8::splat(f32::NAN); WIDTH];
        for (lanes, ray) in lanes.iter_mut().zip(&rays[first..]) {
            *lanes = S::F8::load(bytemuck::cast_ref(ray));
        }
        let setups = SetupLanes::new(S::transpose(lanes), &tree.bounds());
        let (near, far) = meet_children::<S>(&setups, root);
        let (zero, nothing) = (S::F8::splat(0.0), S::F8::splat(f32::from_bits(Hit::NO_PRIM)));
        let found = rows::<S>([setups.t_max, zero, zero, nothing, setups.t_min, zero, zero, zero]);
        let (lines, courses) = (rows::<S>(setups.lines), setups.courses());
        for lane in 0..WIDTH.min(rays.len() - first) {
            idle.len -= 1;
            let i = idle.ray(idle.len);
            self.numbers[i] = first + lane;
            self.lines[i] = lines[lane];
            self.found[i] = found[lane];
            self.fastest[i] = courses.fastest(lane) as u8;
            let order = root.order[usize::from(courses.octant(lane))];
            let (leaves, nears) = (&mut self.leaves[i], &mut self.near[i]);
            let height = S::F8::keep(near[lane], far[lane], order, &root.children, leaves, nears);
            // One that can hit nothing stays where it is.
            self.heights[i] = if setups.live >> lane & 1 != 0 { height as u8 } else { 0 };
            live.push(i as u8, true);
        }
    }

    #[inline(always)]
    fn best(&self, i: usize) -> Hit {
        let [t, u, v, prim_id, ..] = self.found[i];
        Hit { t, u, v, prim_id: prim_id.to_bits() }
    }

    /// Sorts the live rays by what they visit next, and lists those that have nothing left to visit as idle. A bit mask of
    /// the keys there are.
    #[inline(always)]
    fn sort<S: Simd>(&mut self, live: &mut List, idle: &mut List) -> u64 {
        let mut going = List::NONE;
        let mut counts = [0u16; KEYS];
        for place in 0..live.len {
            let i = live.ray(place);
            let (leaf, has_any) = self.next::<S>(i);
            let key = (4 * Child::first_block(leaf) as usize + usize::from(self.fastest[i])) % KEYS;
            self.keys[going.len % RAYS] = key as u8;
            going.push(i as u8, has_any);
            idle.push(i as u8, !has_any);
            counts[key] += u16::from(has_any);
        }
        let (mut kinds, mut end) = (0, 0);
        for (key, (place, count)) in self.ends.iter_mut().zip(&mut counts).enumerate() {
            *place = end;
            end += *count;
            kinds |= u64::from(*count != 0) << key;
            *count = *place;
        }
        self.ends[KEYS] = end;
        for (&ray, &key) in going.rays.iter().zip(&self.keys).take(going.len) {
            let place = &mut counts[usize::from(key) % KEYS];
            live.rays[usize::from(*place) % RAYS] = ray;
            *place += 1;
        }
        live.len = going.len;
        kinds
    }

    /// Takes the leaf that a ray visits next, but for its first block, if there is any that does not begin behind the best
    /// hit. As near is not nearer: there may be a tie to decide.
    #[inline(always)]
    fn next<S: Simd>(&mut self, i: usize) -> (u32, bool) {
        let within = S::F8::load(&self.near[i]).le(S::F8::splat(self.found[i][0])).bits();
        let left = within & ((1 << (self.heights[i] & 15)) - 1);
        let top = (31 - (left | 1).leading_zeros()) as usize % WIDTH;
        let leaf = self.leaves[i][top];
        self.leaves[i][top] = Child::without_first_block(leaf);
        self.heights[i] = top as u8 + u8::from(Child::has_more_blocks(leaf));
        (leaf, left != 0)
    }

    /// Tests the rays that visit a block against its triangles. They share their fastest axis.
    #[inline(always)]
    fn visit<const ANY: bool, S: Simd>(&mut self, block: &TriangleBlock, axes: [Axis; 3], live: &List, key: usize) {
        let (mut place, end) = (usize::from(self.ends[key]), usize::from(self.ends[key + 1]));
        while place < end {
            // The last eight may repeat its last ray: it finds the same.
            let mut visitors = [0; WIDTH];
            for (lane, visitor) in visitors.iter_mut().enumerate() {
                *visitor = live.ray((place + lane).min(end - 1));
            }
            place += WIDTH;
            let (mut lines, mut found) = ([S::F8::splat(0.0); WIDTH], [S::F8::splat(0.0); WIDTH]);
            for (lane, &i) in visitors.iter().enumerate() {
                (lines[lane], found[lane]) = (S::F8::load(&self.lines[i]), S::F8::load(&self.found[i]));
            }
            let lines = LineLanes::new(S::transpose(lines));
            let mut found = S::transpose(found);
            if hit::<ANY, S>(block, axes, &lines, &mut found) {
                let rows = S::transpose(found);
                for (row, &i) in rows.iter().zip(&visitors) {
                    self.found[i] = row.store();
                }
            }
        }
    }
}

/// Takes hits of eight lines with a block's triangles that precede those found before. Whether there may be any.
#[inline(always)]
fn hit<const ANY: bool, S: Simd>(
    block: &TriangleBlock,
    axes: [Axis; 3],
    lines: &LineLanes<S::F8>,
    [t, u, v, prim_id, t_min, ..]: &mut [S::F8; WIDTH],
) -> bool {
    // For each triangle, the lines that pass inside of its edges.
    let mut inside = [0; WIDTH];
    let mut any = 0;
    for (triangle, inside) in inside.iter_mut().enumerate() {
        if block.prim_id[triangle] != Hit::NO_PRIM {
            *inside = triangle::inside(lines, spread::<S>(block, axes, triangle));
            any |= *inside;
        }
    }
    let is_any = any != 0;
    while any != 0 {
        // Each lane takes the first of its triangles.
        let (mut places, mut free) = (S::F8::splat(0.0), any);
        for (triangle, inside) in (0..).zip(&mut inside) {
            let taken = *inside & free;
            places = S::F8::select(Mask::from_bits(taken), S::F8::splat(f32::from_bits(triangle)), places);
            free &= !taken;
            *inside &= !taken;
        }
        let places: [u32; WIDTH] = bytemuck::cast(places.store());
        if let Some(crossing) = triangle::cross(lines, picked::<S>(block, axes, &places)) {
            let prims = S::look_up(bytemuck::cast_ref(&block.prim_id), &places);
            let within = crossing.bits & any & t_min.le(crossing.t).bits();
            let mut closer = crossing.t.lt(*t).bits();
            let ties = crossing.t.eq(*t).bits() & within;
            if ties != 0 {
                closer |= earlier(&prims.store(), &prim_id.store(), ties);
            }
            let closer = Mask::from_bits(closer & within);
            *t = S::F8::select(closer, if ANY { S::F8::splat(f32::NEG_INFINITY) } else { crossing.t }, *t);
            *u = S::F8::select(closer, crossing.u, *u);
            *v = S::F8::select(closer, crossing.v, *v);
            *prim_id = S::F8::select(closer, prims, *prim_id);
        }
        any = inside.iter().fold(0, |any, inside| any | inside);
    }
    is_any
}

/// Those of `lanes` in which the bits of the first number are less.
#[cold]
#[inline(never)]
fn earlier(first: &[f32; WIDTH], second: &[f32; WIDTH], lanes: u32) -> u32 {
    lanes_of(lanes)
        .filter(|&lane| first[lane % WIDTH].to_bits() < second[lane % WIDTH].to_bits())
        .fold(0, |bits, lane| bits | 1 << lane)
}

/// One triangle's corners in every lane.
#[inline(always)]
fn spread<S: Simd>(block: &TriangleBlock, [x, y, z]: [Axis; 3], triangle: usize) -> [[S::F8; 3]; 3] {
    let [a, b, c] = &block.corners;
    let axes = [x as usize, y as usize, z as usize];
    [splat::<S>(a, axes, triangle), splat::<S>(b, axes, triangle), splat::<S>(c, axes, triangle)]
}

#[inline(always)]
fn splat<S: Simd>(corner: &[[f32; WIDTH]; 3], [x, y, z]: [usize; 3], triangle: usize) -> [S::F8; 3] {
    [S::F8::splat(corner[x][triangle]), S::F8::splat(corner[y][triangle]), S::F8::splat(corner[z][triangle])]
}

/// In each lane the corners of one of a block's triangles.
#[inline(always)]
fn picked<S: Simd>(block: &TriangleBlock, [x, y, z]: [Axis; 3], places: &[u32; WIDTH]) -> [[S::F8; 3]; 3] {
    let [a, b, c] = &block.corners;
    let axes = [x as usize, y as usize, z as usize];
    [pick::<S>(a, axes, places), pick::<S>(b, axes, places), pick::<S>(c, axes, places)]
}

#[inline(always)]
fn pick<S: Simd>(corner: &[[f32; WIDTH]; 3], [x, y, z]: [usize; 3], places: &[u32; WIDTH]) -> [S::F8; 3] {
    [S::look_up(&corner[x], places), S::look_up(&corner[y], places), S::look_up(&corner[z], places)]
}
