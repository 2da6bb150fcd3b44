//! Traversal of scenes: the scene's own tree, and in its leaves the objects, in their own spaces.

use core::ops::{ControlFlow, Range};

use super::answers::Answers;
use super::object::Target;
use super::search::{Closest, ItemCollector, Judged, Search};
use super::{Item, SceneHit, SceneRay, SceneView};
use super::{round, shape};
use crate::geometry::moment::Moment;
use crate::geometry::setup::{NODE_ORIGIN_PAD, RaySetup, Slabs};
use crate::geometry::{Hit, Ray};
use crate::simd::{Isa, Simd, Work, dispatch};
use crate::traverse::single::{self, Intersector, moving};
use crate::traverse::{TraversalStack, Verdict};

/// The nearest hit that a filter accepts.
pub(super) fn filtered(
    scene: &SceneView,
    ray: &SceneRay,
    mut filter: impl FnMut(&SceneHit) -> Verdict,
) -> Option<SceneHit> {
    let mut best = Closest::new(ray.ray.t_max).best;
    let mut judge = |hit: &SceneHit| {
        if hit.precedes(&best) {
            let verdict = filter(hit);
            if verdict != Verdict::Reject {
                best = *hit;
            }
            if verdict == Verdict::Stop {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(best.hit.t)
    };
    let mut search = Judged { t_max: ray.ray.t_max, judge: &mut judge };
    dispatch(scene.isa(), Trace { scene, ray, search: &mut search });
    best.is_hit().then_some(best)
}

/// One ray and its search.
pub(super) struct Trace<'a, Q> {
    pub scene: &'a SceneView<'a>,
    pub ray: &'a SceneRay,
    pub search: &'a mut Q,
}

impl<Q: Search> Work for Trace<'_, Q> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        Memory::new().trace::<S, _>(self.scene, self.ray, self.search);
    }
}

/// One ray, and the entry with the box of an index in the scene's tree.
pub(super) struct MeetItem<'a, 's, Q> {
    pub visit: Visit<'a, 's, Q>,
    pub index: u32,
}

impl<Q: Search> Work for MeetItem<'_, '_, Q> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(mut self) {
        // The search itself records whether it was ended early.
        let _ = self.visit.meet_part::<S>(self.index);
    }
}

/// Rays whose nearest hits are written to `hits`, which has as many elements.
pub(super) struct TraceAll<'a, A> {
    pub scene: &'a SceneView<'a>,
    pub rays: &'a [SceneRay],
    pub answers: A,
}

impl<A: Answers> Work for TraceAll<'_, A> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(mut self) {
        let mut memory = Memory::new();
        for (index, ray) in self.rays.iter().enumerate() {
            self.answers.begin(index, ray.ray.t_max);
            let mut search = self.answers.search(index, ray.ray.t_max);
            memory.trace::<S, _>(self.scene, ray, &mut search);
            self.answers.advance(index, search);
            self.answers.end(index);
        }
    }
}

/// Stacks for the outermost scene's tree, and for trees of triangles, one at a time.
struct Memory {
    items: TraversalStack,
    triangles: TraversalStack,
}

impl Memory {
    #[inline(always)]
    fn new() -> Self {
        Self { items: TraversalStack::new(), triangles: TraversalStack::new() }
    }

    #[inline(always)]
    fn trace<S: Simd, Q: Search>(&mut self, scene: &SceneView, ray: &SceneRay, search: &mut Q) {
        let triangles = &mut self.triangles;
        let visit = Visit { scene, isa: scene.isa(), ray: *ray, first_path: 0, depth: 0, search, triangles };
        // The search itself records whether it was ended early.
        let _ = visit.walk::<S>(&mut self.items);
    }
}

/// A ray in a nested scene.
pub(super) struct Visit<'a, 's, Q> {
    pub scene: &'a SceneView<'a>,
    pub isa: Isa,
    pub ray: SceneRay,
    /// The first of the paths through this scene, in the outermost.
    pub first_path: u64,
    pub depth: u32,
    pub search: &'s mut Q,
    /// Memory for walks through trees of triangles, one at a time.
    pub triangles: &'s mut TraversalStack,
}

impl<Q: Search> Visit<'_, '_, Q> {
    /// Shows the search the hits of the ray that are not behind its `t_max`. `Break` if the search was ended. `stack`
    /// is memory with any contents.
    #[inline(always)]
    fn walk<S: Simd>(self, stack: &mut TraversalStack) -> ControlFlow<()> {
        let Visit { scene, ray, .. } = self;
        let Some((slabs, moment)) = set_up(scene, &ray) else {
            return ControlFlow::Continue(());
        };
        single::traverse::<S, _>(&mut ItemIntersector { visit: self, moment }, &slabs, ray.ray.t_min, stack)
    }
}

/// The setup for the boxes of a scene's tree, and the moment; `None` if the ray can hit nothing.
#[inline(always)]
fn set_up(scene: &SceneView, SceneRay { ray, time, .. }: &SceneRay) -> Option<(Slabs, Moment)> {
    let mut setup = RaySetup::new(ray, &scene.reach())?;
    let moment = Moment::new(*time, scene.tree().keys())?;
    let reach = (scene.reach().min - ray.origin).abs().max((scene.reach().max - ray.origin).abs());
    // The second term is for the rounding of this sum.
    setup.slabs.widen(scene.widening().of_ray(reach.max_element()) + ray.origin.abs() * NODE_ORIGIN_PAD);
    Some((setup.slabs, moment))
}

/// Enters a nested scene. Not inlined: this is the recursive call.
#[inline(never)]
pub(super) fn enter<Q: Search>(visit: Visit<Q>) -> ControlFlow<()> {
    dispatch(visit.isa, visit)
}

impl<Q: Search> Work for Visit<'_, '_, Q> {
    type Output = ControlFlow<()>;
    #[inline(always)]
    fn run<S: Simd>(self) -> ControlFlow<()> {
        let mut stack = TraversalStack::new();
        self.walk::<S>(&mut stack)
    }
}

/// The items of a scene at a moment.
struct ItemIntersector<'a, 's, Q> {
    visit: Visit<'a, 's, Q>,
    moment: Moment,
}

impl<Q: Search> Intersector for ItemIntersector<'_, '_, Q> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.visit.search.t_max()
    }

    #[inline(always)]
    fn visit_node<S: Simd>(&self, node: u32, stack: &mut TraversalStack, slabs: &Slabs, octant: u8, t_min: f32) {
        let (tree, Moment { key, fraction }) = (self.visit.scene.tree(), self.moment);
        if fraction != 0.0 {
            let keys = [tree.nodes(key), tree.nodes(key + 1)];
            moving::push_children_between::<S>(keys, fraction, node, stack, slabs, octant, (t_min, self.t_max()));
        } else {
            stack.push_children_of::<S>(tree.nodes(key), node, slabs, octant, (t_min, self.t_max()));
        }
    }

    #[inline(always)]
    fn visit_leaf<S: Simd>(&mut self, contents: Range<usize>) -> ControlFlow<()> {
        let scene = self.visit.scene;
        for &index in scene.tree().items().get(contents).unwrap_or(&[]) {
            self.visit.meet_part::<S>(index)?;
        }
        ControlFlow::Continue(())
    }
}

impl<Q: Search> Visit<'_, '_, Q> {
    /// Traces the ray through the entry with the box of this index, if its mask allows.
    #[inline(always)]
    fn meet_part<S: Simd>(&mut self, index: u32) -> ControlFlow<()> {
        match self.scene.item_of(index) {
            Some((part, item)) if item.mask & self.ray.mask != 0 => self.meet::<S>(item, part.item, part.prim_id),
            _ => ControlFlow::Continue(()),
        }
    }

    /// Traces the ray through one item.
    #[inline(always)]
    fn meet<S: Simd>(&mut self, item: &Item, index: u32, prim_id: u32) -> ControlFlow<()> {
        let SceneRay { ray, time, .. } = self.ray;
        let Some(ray) = item.placement.to_local(&ray, time) else {
            return ControlFlow::Continue(());
        };
        let path = self.first_path + (self.scene.paths() - 1);
        let common = SceneHit { hit: Hit::MISS, item: index, depth: self.depth, path };
        match item.object.target() {
            Target::Nothing => ControlFlow::Continue(()),
            Target::Mesh(tree) => self.search.visit_mesh::<S>(&tree, &ray, common, self.triangles),
            Target::Moving(tree) => {
                let mut collector = ItemCollector { search: &mut *self.search, common };
                moving::walk::<S, _>(&tree, &ray, time, self.triangles, &mut collector)
            }
            Target::Round(tree) => round::enter(&tree, &ray, self.isa, self.triangles, &mut *self.search, common),
            Target::Shape(shape) => match shape::intersect(shape, prim_id, &ray, time) {
                Some(hit) if hit.t <= self.search.t_max() => self.search.report(SceneHit { hit, ..common }),
                _ => ControlFlow::Continue(()),
            },
            Target::Scene(scene) => enter(self.nested(&scene, item, ray)),
        }
    }

    /// The visit of an item that is a scene, from the ray in the space of that.
    #[inline(always)]
    pub(super) fn nested<'i>(&'i mut self, scene: &'i SceneView<'i>, item: &Item, ray: Ray) -> Visit<'i, 'i, Q> {
        let Self { isa, ray: SceneRay { time, mask, .. }, first_path, depth, .. } = *self;
        let (ray, first_path, depth) = (SceneRay { ray, time, mask }, first_path + item.first_path, depth + 1);
        Visit { scene, isa, ray, first_path, depth, search: &mut *self.search, triangles: &mut *self.triangles }
    }
}
