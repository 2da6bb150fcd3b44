//! A ray stream through a scene: rays are on their way through the scene's own tree and through those of its items at
//! the same time, each at a place of its own, and step in phases as in a [stream](crate::traverse::stream) through one
//! tree. `t` is the same in all spaces, so one stack holds the subtrees of both: those of the item on top, then a
//! [`NONE`], then those of the scene. A hit culls all of them.
//!
//! A ray that comes to an item with triangles that stand still is taken into the item's space, together with up to seven
//! others that come to one. What else items are it meets alone, as a single ray does; there scenes in scenes turn to
//! recursion.

use super::object::Target;
use super::search::{Any, Closest, Search};
use super::walk::{MeetItem, Trace};
use super::{SceneHit, SceneRay, SceneView};
use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::moment::Moment;
use crate::geometry::setup::NODE_ORIGIN_PAD;
use crate::geometry::setup_lanes::{BoxLanes, SetupLanes};
use crate::geometry::{Aabb, Hit, Ray};
use crate::simd::{Lanes, Simd, Work, dispatch};
use crate::traverse::single::moving;
use crate::traverse::stream::{ActiveRay, NONE, Next, Stream, Trees, places_of};

/// Rays that are traced at the same time: as many as leave room on a stack of 32 KiB for scenes in scenes.
const ACTIVE: usize = 32;

/// Fewer rays are traced one by one, as most would be on their way alone.
pub(super) const LEAST: usize = 24;

/// What is known of rays by their numbers in the batch.
pub(super) trait Answers {
    /// What a ray looks for.
    type Search: Search;
    /// Whether any hit is as good as another.
    const ANY: bool;

    /// Nothing has been found up to `t_max`.
    fn begin(&mut self, number: usize, t_max: f32);

    /// The rest of a search.
    fn search(&self, number: usize, t_max: f32) -> Self::Search;

    /// What a search has come to. Whether it has ended.
    fn advance(&mut self, number: usize, search: Self::Search) -> bool;

    /// What a hit in an item has to precede, by `t` and `prim_id` alone.
    fn to_precede(&self, number: usize, t_max: f32, common: &SceneHit) -> Hit;

    /// The ray has left an item, with this hit or what it [had to precede](Self::to_precede). Whether its search has
    /// ended.
    fn leave(&mut self, number: usize, hit: Hit, common: &SceneHit) -> bool;

    /// The search is over.
    fn end(&mut self, number: usize);
}

/// The nearest hits.
pub(super) struct Nearest<'a>(pub &'a mut [SceneHit]);

impl Nearest<'_> {
    #[inline(always)]
    fn best(&self, number: usize) -> SceneHit {
        self.0.get(number).copied().unwrap_or(SceneHit::MISS)
    }

    #[inline(always)]
    fn set(&mut self, number: usize, hit: SceneHit) {
        if let Some(place) = self.0.get_mut(number) {
            *place = hit;
        }
    }
}

impl Answers for Nearest<'_> {
    type Search = Closest;
    const ANY: bool = false;

    #[inline(always)]
    fn begin(&mut self, number: usize, t_max: f32) {
        self.set(number, Closest::new(t_max).best);
    }

    #[inline(always)]
    fn search(&self, number: usize, _t_max: f32) -> Closest {
        Closest { best: self.best(number) }
    }

    #[inline(always)]
    fn advance(&mut self, number: usize, search: Closest) -> bool {
        self.set(number, search.best);
        false
    }

    #[inline(always)]
    fn to_precede(&self, number: usize, _t_max: f32, common: &SceneHit) -> Hit {
        Closest { best: self.best(number) }.to_precede(common)
    }

    #[inline(always)]
    fn leave(&mut self, number: usize, hit: Hit, common: &SceneHit) -> bool {
        let mut closest = Closest { best: self.best(number) };
        closest.take(hit, common);
        self.set(number, closest.best);
        false
    }

    #[inline(always)]
    fn end(&mut self, number: usize) {
        if !self.best(number).is_hit() {
            self.set(number, SceneHit::MISS);
        }
    }
}

/// Whether there are hits.
pub(super) struct Occluded<'a>(pub &'a mut [bool]);

impl Occluded<'_> {
    #[inline(always)]
    fn set(&mut self, number: usize, occluded: bool) -> bool {
        if let Some(place) = self.0.get_mut(number) {
            *place = occluded;
        }
        occluded
    }
}

impl Answers for Occluded<'_> {
    type Search = Any;
    const ANY: bool = true;

    #[inline(always)]
    fn begin(&mut self, number: usize, _t_max: f32) {
        self.set(number, false);
    }

    #[inline(always)]
    fn search(&self, _number: usize, t_max: f32) -> Any {
        Any { t_max, found: false }
    }

    #[inline(always)]
    fn advance(&mut self, number: usize, search: Any) -> bool {
        self.set(number, search.found)
    }

    #[inline(always)]
    fn to_precede(&self, _number: usize, t_max: f32, _common: &SceneHit) -> Hit {
        Hit::none_before(t_max)
    }

    #[inline(always)]
    fn leave(&mut self, number: usize, hit: Hit, _common: &SceneHit) -> bool {
        self.set(number, hit.is_hit())
    }

    #[inline(always)]
    fn end(&mut self, _number: usize) {}
}

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
        let nodes = scene.tree().nodes(0);
        let trees = ItemTrees { nodes: [nodes; ACTIVE], blocks: [&[]; ACTIVE], items: [0; ACTIVE] };
        let path = scene.paths() - 1;
        let mut streams = SceneStream {
            scene,
            rays,
            answers,
            trees,
            stream: Stream::EMPTY,
            inside: 0,
            turned: 0,
            common: SceneHit { path, ..SceneHit::MISS },
        };
        streams.run::<S>();
    }
}

/// For each place the tree that its ray is in, and the item that has it.
struct ItemTrees<'a> {
    nodes: [&'a [Node]; ACTIVE],
    blocks: [&'a [TriangleBlock]; ACTIVE],
    items: [u32; ACTIVE],
}

impl Trees for ItemTrees<'_> {
    #[inline(always)]
    fn nodes(&self, place: usize) -> &[Node] {
        self.nodes[place % ACTIVE]
    }

    #[inline(always)]
    fn blocks(&self, place: usize) -> &[TriangleBlock] {
        self.blocks[place % ACTIVE]
    }
}

/// Rays on their way through a scene.
struct SceneStream<'a, A> {
    scene: &'a SceneView<'a>,
    rays: &'a [SceneRay],
    answers: A,
    stream: Stream<ACTIVE>,
    trees: ItemTrees<'a>,
    /// A bit for each place whose ray is in an item.
    inside: u64,
    /// A bit for each place whose ray has left an item, but whose setup is still that of the item's space.
    turned: u64,
    /// What hits with triangles of the scene's own items have in common, but for the item.
    common: SceneHit,
}

impl<'a, A: Answers> SceneStream<'a, A> {
    #[inline(always)]
    fn run<S: Simd>(&mut self) {
        let tree = self.scene.tree();
        let moves = tree.keys() > 1;
        // What moves is somewhere in the box around all places.
        let mut around = Node::EMPTY;
        around.set(0, &tree.bounds(), Child::Node(0));
        let root = if moves { &around } else { tree.nodes(0).first().unwrap_or(&Node::EMPTY) };
        loop {
            self.start::<S>(root);
            let Next { nodes, leaves, ended } = self.stream.classify::<S>();
            if self.stream.busy == 0 {
                return;
            }
            self.turn_back::<S>(nodes & self.turned);
            let still = if moves { nodes & self.inside } else { nodes };
            let mut crowded = self.stream.visit_nodes::<S>(still, &self.trees);
            if nodes != still {
                crowded |= self.visit_moving_nodes::<S>(nodes & !still);
            }
            self.finish(crowded);
            let inside = self.inside;
            if A::ANY {
                self.stream.visit_leaves::<true, S>(leaves & inside, &self.trees);
            } else {
                self.stream.visit_leaves::<false, S>(leaves & inside, &self.trees);
            }
            self.leave::<S>(ended & inside);
            self.meet_items::<S>(leaves & !inside);
            self.end(ended & !inside);
        }
    }

    /// Starts rays, eight at a time, while there are places for so many.
    #[inline(always)]
    fn start<S: Simd>(&mut self, root: &Node) {
        while self.stream.has_room_for_eight(self.rays.len()) {
            let rays = &self.rays[self.stream.started..];
            let mut rows = [S::F8::splat(f32::NAN); WIDTH];
            let mut timeless = 0;
            for (lane, (row, ray)) in rows.iter_mut().zip(rays).enumerate() {
                *row = S::F8::load(bytemuck::cast_ref(&ray.ray));
                timeless |= u32::from(ray.time.is_nan()) << lane;
            }
            let mut setups = set_up::<S>(self.scene, rows);
            setups.live &= !timeless;
            let first = self.stream.started;
            if A::ANY {
                self.stream.start_eight::<true, S>(&setups, self.rays.len(), root, &self.trees);
            } else {
                self.stream.start_eight::<false, S>(&setups, self.rays.len(), root, &self.trees);
            }
            for number in first..self.stream.started {
                self.answers.begin(number, self.rays[number].ray.t_max);
            }
        }
    }

    /// The setup of rays that go on in the scene's own space.
    #[inline(always)]
    fn turn_back<S: Simd>(&mut self, mut places: u64) {
        self.turned &= !places;
        while places != 0 {
            let mut rows = [S::F8::splat(f32::NAN); WIDTH];
            for (row, place) in rows.iter_mut().zip(places_of(places)) {
                *row = S::F8::load(bytemuck::cast_ref(&self.ray(place).ray));
            }
            let setups = set_up::<S>(self.scene, rows).rows::<S>();
            for (lane, place) in places_of(places).enumerate().take(WIDTH) {
                self.stream.active[place % ACTIVE].set_up(&setups, lane, A::ANY);
                places &= !(1 << place);
            }
        }
    }

    /// Visits nodes of the scene's tree where they are at each ray's time. Gives the places of rays whose stacks have no room.
    #[inline(always)]
    fn visit_moving_nodes<S: Simd>(&mut self, visitors: u64) -> u64 {
        let tree = self.scene.tree();
        let mut crowded = 0;
        for place in places_of(visitors) {
            let Some(moment) = Moment::new(self.ray(place).time, tree.keys()) else { continue };
            let next = self.stream.next(place) as usize;
            let (Some(from), to) = (tree.nodes(moment.key).get(next), tree.nodes(moment.key + 1).get(next)) else {
                continue;
            };
            let active = &mut self.stream.active[place % ACTIVE];
            let had_room = match to {
                Some(to) if moment.fraction != 0.0 => {
                    active.visit_node::<S>(&moving::node_between::<S>(from, to, moment.fraction))
                }
                _ => active.visit_node::<S>(from),
            };
            if !had_room {
                crowded |= 1 << place;
            }
            self.stream.go_on::<S>(place, &self.trees);
        }
        crowded
    }

    /// Rays that have met all of an item go on in the scene.
    #[inline(always)]
    fn leave<S: Simd>(&mut self, places: u64) {
        for place in places_of(places) {
            let ActiveRay { best, number, .. } = self.stream.active[place % ACTIVE];
            let common = self.common_of(place);
            self.inside &= !(1 << place);
            self.turned |= 1 << place;
            self.trees.nodes[place % ACTIVE] = self.scene.tree().nodes(0);
            if self.answers.leave(number, best, &common) {
                self.end(1 << place);
                continue;
            }
            let t_max = self.answers.search(number, self.ray(place).ray.t_max).t_max();
            self.stream.active[place % ACTIVE].best = Hit::none_before(t_max);
            self.stream.go_on::<S>(place, &self.trees);
        }
    }

    /// Rays meet the first item of the leaf that they visit next.
    #[inline(always)]
    fn meet_items<S: Simd>(&mut self, places: u64) {
        let mut entering = Entering::<S>::none();
        let mut crowded = 0;
        for place in places_of(places) {
            let leaf = self.stream.next(place);
            if Child::has_more_blocks(leaf)
                && !self.stream.active[place % ACTIVE].push(Child::without_first_block(leaf))
            {
                crowded |= 1 << place;
                continue;
            }
            let number = self.scene.tree().items().get(Child::first_block(leaf) as usize).copied().unwrap_or(u32::MAX);
            match self.still_item(place, number) {
                Some((item, tree, ray)) => {
                    entering.push(place, item, tree, &ray);
                    if entering.len == WIDTH {
                        crowded |= self.enter::<S>(&entering);
                        entering.len = 0;
                    }
                }
                None => self.meet_alone::<S>(place, number),
            }
        }
        crowded |= self.enter::<S>(&entering);
        self.finish(crowded);
    }

    /// The item with the box of this number, if the ray sees it and it is made of triangles that stand still: its index, its
    /// tree, and the ray in its space.
    #[inline(always)]
    fn still_item(&self, place: usize, number: u32) -> Option<(u32, BvhView<'a>, Ray)> {
        let (part, item) = self.scene.item_of(number)?;
        let SceneRay { ray, time, mask } = self.ray(place);
        if item.mask & mask == 0 {
            return None;
        }
        let tree = match item.object.target() {
            Target::Mesh(tree) => tree,
            Target::Moving(tree) => {
                let moment = Moment::new(*time, tree.keys()).filter(|moment| moment.fraction == 0.0)?;
                tree.at_key(moment.key)
            }
            _ => return None,
        };
        Some((part.item, tree, item.placement.to_local(ray, *time)?))
    }

    /// Takes up to eight rays into items. Gives the places of those whose stacks have no room.
    #[inline(always)]
    fn enter<S: Simd>(&mut self, entering: &Entering<'a, S>) -> u64 {
        if entering.len == 0 {
            return 0;
        }
        let boxes = BoxLanes::from_rows::<S>(entering.boxes);
        let setups = SetupLanes::within(S::transpose(entering.rays), &boxes);
        let live = setups.live;
        let setups = setups.rows::<S>();
        let mut crowded = 0;
        for lane in 0..entering.len.min(WIDTH) {
            let (place, item) = (entering.places[lane], entering.items[lane]);
            if live >> lane & 1 == 0 {
                self.stream.go_on::<S>(place, &self.trees);
                continue;
            }
            let active = &mut self.stream.active[place % ACTIVE];
            if !active.push(NONE) {
                crowded |= 1 << place;
                continue;
            }
            active.set_up(&setups, lane, A::ANY);
            let common = SceneHit { geometry_id: item, ..self.common };
            let t_max = self.rays.get(active.number).map_or(f32::INFINITY, |ray| ray.ray.t_max);
            active.best = self.answers.to_precede(active.number, t_max, &common);
            self.trees.items[place % ACTIVE] = item;
            self.trees.nodes[place % ACTIVE] = entering.trees[lane].0;
            self.trees.blocks[place % ACTIVE] = entering.trees[lane].1;
            self.inside |= 1 << place;
            self.turned &= !(1 << place);
            self.stream.visit_next::<S>(place, Child::Node(0).pack(), &self.trees);
        }
        crowded
    }

    /// A ray meets what has the box of this number as a single ray does, if it sees that.
    #[inline(always)]
    fn meet_alone<S: Simd>(&mut self, place: usize, number: u32) {
        let ray = *self.ray(place);
        let index = self.stream.active[place % ACTIVE].number;
        let is_seen = self.scene.item_of(number).is_some_and(|(_, item)| item.mask & ray.mask != 0);
        if is_seen {
            let mut search = self.answers.search(index, ray.ray.t_max);
            meet(self.scene, &ray, number, &mut search);
            let active = &mut self.stream.active[place % ACTIVE];
            if search.t_max() < active.best.t {
                active.best.t = search.t_max();
                active.cull::<S>(search.t_max());
            }
            if self.answers.advance(index, search) {
                return self.end(1 << place);
            }
        }
        self.stream.go_on::<S>(place, &self.trees);
    }

    /// Finishes rays whose stacks are full, each alone, from the scene's root.
    #[inline(always)]
    fn finish(&mut self, crowded: u64) {
        for place in places_of(crowded) {
            let ActiveRay { best, number, .. } = self.stream.active[place % ACTIVE];
            let ended = self.inside >> place & 1 != 0 && self.answers.leave(number, best, &self.common_of(place));
            if !ended {
                let ray = *self.ray(place);
                let mut search = self.answers.search(number, ray.ray.t_max);
                dispatch(self.scene.isa(), Trace { scene: self.scene, ray: &ray, search: &mut search });
                self.answers.advance(number, search);
            }
            self.end(1 << place);
        }
    }

    /// The searches of rays are over.
    #[inline(always)]
    fn end(&mut self, places: u64) {
        for place in places_of(places) {
            self.answers.end(self.stream.active[place % ACTIVE].number);
            self.trees.nodes[place % ACTIVE] = self.scene.tree().nodes(0);
        }
        self.stream.busy &= !places;
        self.inside &= !places;
        self.turned &= !places;
    }

    /// The ray at a place.
    #[inline(always)]
    fn ray(&self, place: usize) -> &'a SceneRay {
        const NOWHERE: &SceneRay = &SceneRay { ray: NO_RAY, time: f32::NAN, mask: 0 };
        self.rays.get(self.stream.active[place % ACTIVE].number).unwrap_or(NOWHERE)
    }

    /// What hits in the item that the ray at a place is in have in common.
    #[inline(always)]
    fn common_of(&self, place: usize) -> SceneHit {
        SceneHit { geometry_id: self.trees.items[place % ACTIVE], ..self.common }
    }
}

/// Hits nothing.
const NO_RAY: Ray =
    Ray { origin: glam::Vec3::NAN, t_min: f32::INFINITY, direction: glam::Vec3::ZERO, t_max: f32::NEG_INFINITY };

/// The setup of eight rays in the scene's own space; see [`walk`](super::walk) for the pads.
#[inline(always)]
fn set_up<S: Simd>(scene: &SceneView, rows: [S::F8; WIDTH]) -> SetupLanes<WIDTH, S::F8> {
    let rays = S::transpose(rows);
    let bounds = BoxLanes::splat(&scene.reach());
    let mut setups = SetupLanes::within(rays, &bounds);
    let [x, y, z, ..] = rays;
    let [rx, ry, rz] = bounds.reach(&[x, y, z]);
    let (reach, origin_pad) = (rx.max(ry).max(rz), S::F8::splat(NODE_ORIGIN_PAD));
    let error = scene.error();
    let [ex, ey, ez] = [S::F8::splat(error.x), S::F8::splat(error.y), S::F8::splat(error.z)];
    setups.widen([
        ex * reach + x.abs() * origin_pad,
        ey * reach + y.abs() * origin_pad,
        ez * reach + z.abs() * origin_pad,
    ]);
    setups
}

/// Up to eight rays that are about to enter items.
struct Entering<'a, S: Simd> {
    rays: [S::F8; WIDTH],
    boxes: [S::F8; WIDTH],
    trees: [(&'a [Node], &'a [TriangleBlock]); WIDTH],
    places: [usize; WIDTH],
    items: [u32; WIDTH],
    len: usize,
}

impl<'a, S: Simd> Entering<'a, S> {
    #[inline(always)]
    fn none() -> Self {
        let nan = S::F8::splat(f32::NAN);
        Self {
            rays: [nan; WIDTH],
            boxes: [nan; WIDTH],
            trees: [(&[], &[]); WIDTH],
            places: [0; WIDTH],
            items: [0; WIDTH],
            len: 0,
        }
    }

    /// There must be room.
    #[inline(always)]
    fn push(&mut self, place: usize, item: u32, tree: BvhView<'a>, ray: &Ray) {
        let lane = self.len % WIDTH;
        let Aabb { min, max } = tree.bounds();
        self.rays[lane] = S::F8::load(bytemuck::cast_ref(ray));
        self.boxes[lane] = S::F8::load(&[min.x, min.y, min.z, 0.0, max.x, max.y, max.z, 0.0]);
        self.trees[lane] = (tree.nodes(), tree.blocks());
        (self.places[lane], self.items[lane]) = (place, item);
        self.len += 1;
    }
}

/// Not inlined, so that its stack frame is there only while it runs.
#[inline(never)]
fn meet<Q: Search>(scene: &SceneView, ray: &SceneRay, number: u32, search: &mut Q) {
    dispatch(scene.isa(), MeetItem { scene, ray, number, search });
}
