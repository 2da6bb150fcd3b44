//! A ray stream through a scene: rays traverse the scene's own tree and the trees of its items at the same time, each
//! with its own place, and step in phases as in a [stream](crate::traverse::stream) through one tree. `t` is the same
//! in all spaces, so one stack holds the subtrees of both: those of the item on top, then a [`NONE`], then those of the
//! scene. A hit culls all of them.
//!
//! A ray that reaches an item of triangles is transformed into the item's space, together with up to seven others. It
//! is tested against points, curves and shapes like a single ray. Nested scenes are not traced as streams: a stack of
//! 32 KiB has no room for a stream below their recursion.

mod entering;
mod items;
mod trees;

use trees::PlaceTrees;

use super::answers::Answers;
use super::search::Search;
use super::walk::Trace;
use super::widening::Widening;
use super::{SceneHit, SceneRay, SceneView};
use crate::bvh::{Child, Node, WIDTH};
use crate::geometry::box_lanes::BoxLanes;
use crate::geometry::setup::NODE_ORIGIN_PAD;
use crate::geometry::setup_lanes::SetupLanes;
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Simd, Work, dispatch};
use crate::traverse::single::moving::{block_between, node_between};
#[cfg(doc)]
use crate::traverse::stream::NONE;
use crate::traverse::stream::{ActiveRay, AllHits, Next, Stream, places_of};

/// Rays that are traced at the same time: as many as fit on a stack of 32 KiB.
const ACTIVE: usize = 32;

/// Rays to trace as a stream, and their answers, of which there are as many.
pub(super) struct StreamAll<'a, A> {
    pub scene: &'a SceneView<'a>,
    pub rays: &'a [SceneRay],
    pub answers: A,
}

impl<A: Answers> Work for StreamAll<'_, A> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { scene, rays, answers } = self;
        let common = SceneHit { path: scene.paths() - 1, ..SceneHit::MISS };
        let trees = PlaceTrees::new(scene);
        SceneStream { scene, rays, answers, trees, stream: Stream::EMPTY, turned: 0, common }.run::<S>();
    }
}

/// The rays in flight through a scene.
struct SceneStream<'a, A> {
    scene: &'a SceneView<'a>,
    rays: &'a [SceneRay],
    answers: A,
    stream: Stream<ACTIVE>,
    trees: PlaceTrees<'a>,
    /// A bit for each place whose ray has left an item, but whose setup is still that of the item's space.
    turned: u64,
    /// What hits with triangles of the scene's own items have in common, but for the item.
    common: SceneHit,
}

impl<'a, A: Answers> SceneStream<'a, A> {
    #[inline(always)]
    fn run<S: Simd>(&mut self) {
        let tree = self.scene.tree();
        // What moves is somewhere in the box around all places.
        let mut around = Node::EMPTY;
        around.set(0, &tree.bounds(), Child::Node(0));
        let root = if tree.keys() > 1 { &around } else { tree.nodes(0).first().unwrap_or(&Node::EMPTY) };
        loop {
            self.start::<S>(root);
            let Next { nodes, leaves, ended } = self.stream.classify::<S>();
            if self.stream.busy == 0 {
                return;
            }
            let (inside, moving) = (self.trees.inside, self.trees.moving);
            self.turn_back::<S>(nodes & self.turned);
            let mut crowded = self.stream.visit_nodes::<S>(nodes & !moving, &self.trees);
            crowded |= self.visit_moving_nodes::<S>(nodes & moving);
            self.finish(crowded);
            if A::ANY {
                self.stream.visit_leaves::<true, S>(leaves & inside & !moving, &self.trees, &mut AllHits);
            } else {
                self.stream.visit_leaves::<false, S>(leaves & inside & !moving, &self.trees, &mut AllHits);
            }
            self.visit_moving_leaves::<S>(leaves & inside & moving);
            self.leave::<S>(ended & inside);
            self.meet_items::<S>(leaves & !inside);
            self.end(ended & !inside);
        }
    }

    /// Starts rays, eight at a time, while there are places for so many.
    #[inline(always)]
    fn start<S: Simd>(&mut self, root: &Node) {
        while self.stream.has_room_for_eight(self.rays.len()) {
            let first = self.stream.started;
            let mut timeless = 0;
            for (lane, ray) in self.rays[first..].iter().enumerate().take(WIDTH) {
                timeless |= u32::from(ray.time.is_nan()) << lane;
            }
            let rays = self.rays[first..].iter().map(|ray| &ray.ray);
            let mut setups = set_up::<S>(self.scene, ray_rows::<S>(rays));
            setups.live &= !timeless;
            let places = if A::ANY {
                self.stream.start_eight::<true, S>(&setups, self.rays.len(), root, &self.trees)
            } else {
                self.stream.start_eight::<false, S>(&setups, self.rays.len(), root, &self.trees)
            };
            for (index, place) in (first..).zip(places_of(places)) {
                let SceneRay { ray, time, .. } = &self.rays[index];
                self.answers.begin(index, ray.t_max);
                self.trees.enter_scene(place, *time);
            }
        }
    }

    /// Sets up rays that go on in the scene's own space.
    #[inline(always)]
    fn turn_back<S: Simd>(&mut self, mut places: u64) {
        self.turned &= !places;
        while places != 0 {
            let rays = places_of(places).map(|place| &self.ray(place).ray);
            let setups = set_up::<S>(self.scene, ray_rows::<S>(rays)).rows::<S>();
            for (lane, place) in places_of(places).enumerate().take(WIDTH) {
                self.stream.active[place % ACTIVE].set_up(&setups, lane, A::ANY);
                places &= !(1 << place);
            }
        }
    }

    /// Visits nodes between two keys. Gives the places of rays whose stacks have no room.
    #[inline(always)]
    fn visit_moving_nodes<S: Simd>(&mut self, visitors: u64) -> u64 {
        let mut crowded = 0;
        for place in places_of(visitors) {
            let Some((from, to, fraction)) = self.trees.moving_node(place, self.stream.next(place)) else { continue };
            if !self.stream.active[place % ACTIVE].visit_node::<S>(&node_between::<S>(from, to, fraction)) {
                crowded |= 1 << place;
            }
            self.go_on::<S>(place);
        }
        crowded
    }

    /// Visits the first blocks of leaves between two keys.
    #[inline(always)]
    fn visit_moving_leaves<S: Simd>(&mut self, visitors: u64) {
        for place in places_of(visitors) {
            let leaf = self.stream.next(place);
            let Some((from, to, fraction)) = self.trees.moving_block(place, leaf) else { continue };
            let block = block_between::<S>(from, to, fraction);
            let active = &mut self.stream.active[place % ACTIVE];
            let next = if A::ANY {
                active.visit_block::<true, S>(&block);
                active.after_block::<true>(leaf)
            } else {
                active.visit_block::<false, S>(&block);
                active.after_block::<false>(leaf)
            };
            self.visit_next::<S>(place, next);
        }
    }

    /// Rays that have finished an item continue in the scene.
    #[inline(always)]
    fn leave<S: Simd>(&mut self, places: u64) {
        for place in places_of(places) {
            let ActiveRay { best, index, .. } = self.stream.active[place % ACTIVE];
            if self.answers.leave(index, best, &self.common_of(place)) {
                self.end(1 << place);
                continue;
            }
            let SceneRay { ray, time, .. } = self.ray(place);
            let t_max = self.answers.search(index, ray.t_max).t_max();
            self.stream.active[place % ACTIVE].best = Hit::none_before(t_max);
            self.trees.enter_scene(place, *time);
            self.turned |= 1 << place;
            self.go_on::<S>(place);
        }
    }

    /// Finishes rays whose stacks are full, each alone, from the scene's root.
    #[inline(always)]
    fn finish(&mut self, crowded: u64) {
        for place in places_of(crowded) {
            let ActiveRay { best, index, .. } = self.stream.active[place % ACTIVE];
            let is_inside = self.trees.inside >> place & 1 != 0;
            if !(is_inside && self.answers.leave(index, best, &self.common_of(place))) {
                let ray = *self.ray(place);
                let mut search = self.answers.search(index, ray.ray.t_max);
                dispatch(self.scene.isa(), Trace { scene: self.scene, ray: &ray, search: &mut search });
                self.answers.advance(index, search);
            }
            self.end(1 << place);
        }
    }

    /// The searches of rays are over.
    #[inline(always)]
    fn end(&mut self, places: u64) {
        for place in places_of(places) {
            self.answers.end(self.stream.active[place % ACTIVE].index);
        }
        self.stream.busy &= !places;
        self.turned &= !places;
    }

    /// The ray at a place visits the top of its stack next.
    #[inline(always)]
    fn go_on<S: Simd>(&mut self, place: usize) {
        let next = self.stream.active[place % ACTIVE].pop();
        self.visit_next::<S>(place, next);
    }

    #[inline(always)]
    fn visit_next<S: Simd>(&mut self, place: usize, next: u32) {
        if self.trees.moving >> place & 1 != 0 {
            self.trees.prefetch_later::<S>(place, next);
        }
        self.stream.visit_next::<S>(place, next, &self.trees);
    }

    /// The ray at a place.
    #[inline(always)]
    fn ray(&self, place: usize) -> &'a SceneRay {
        const NOWHERE: &SceneRay = &SceneRay { ray: NO_RAY, time: f32::NAN, mask: 0 };
        self.rays.get(self.stream.active[place % ACTIVE].index).unwrap_or(NOWHERE)
    }

    /// What hits in the item that the ray at a place is in have in common.
    #[inline(always)]
    fn common_of(&self, place: usize) -> SceneHit {
        SceneHit { item: self.trees.item(place), ..self.common }
    }
}

/// Hits nothing.
const NO_RAY: Ray =
    Ray { origin: glam::Vec3::NAN, t_min: f32::INFINITY, direction: glam::Vec3::ZERO, t_max: f32::NEG_INFINITY };

/// The numbers of the first eight rays, a row each; NaN where there are fewer.
#[inline(always)]
fn ray_rows<'r, S: Simd>(rays: impl Iterator<Item = &'r Ray>) -> [S::F8; WIDTH] {
    let mut rows = [S::F8::splat(f32::NAN); WIDTH];
    for (row, ray) in rows.iter_mut().zip(rays) {
        *row = S::F8::load(bytemuck::cast_ref(ray));
    }
    rows
}

/// The setup of eight rays in the scene's own space; for the pads see `walk.rs`.
#[inline(always)]
fn set_up<S: Simd>(scene: &SceneView, rows: [S::F8; WIDTH]) -> SetupLanes<WIDTH, S::F8> {
    let rays = S::transpose(rows);
    let bounds = BoxLanes::splat(&scene.reach());
    let mut setups = SetupLanes::within(rays, &bounds);
    let [x, y, z, ..] = rays;
    let [rx, ry, rz] = bounds.reach(&[x, y, z]);
    let (reach, origin_pad) = (rx.max(ry).max(rz), S::F8::splat(NODE_ORIGIN_PAD));
    let Widening { ordinary, distorted, near, .. } = *scene.widening();
    let far = reach - S::F8::splat(near);
    let pad = |axis: usize, origin: S::F8| {
        let widening = (S::F8::splat(ordinary[axis]) * reach).max(S::F8::splat(distorted[axis]) * far);
        widening + origin.abs() * origin_pad
    };
    setups.widen([pad(0, x), pad(1, y), pad(2, z)]);
    setups
}
