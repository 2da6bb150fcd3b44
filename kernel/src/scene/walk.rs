//! Walks through scenes: the scene's own tree, and in its leaves whatever lies there, in its own space.

use core::ops::{ControlFlow, Range};

use super::shape;
use super::{Item, MAX_LEVELS, Object, SceneHit, SceneRay, SceneView};
use crate::geometry::Hit;
use crate::geometry::moment::Moment;
use crate::geometry::setup::{NODE_ORIGIN_PAD, RaySetup, Slabs};
use crate::simd::{Isa, Simd, Work, dispatch};
use crate::traverse::flight::{self, Collector, Ground};
use crate::traverse::{Pending, Verdict, moving};

/// The nearest hit so far that is accepted.
pub(super) struct Search<F> {
    best: SceneHit,
    filter: F,
}

impl<F: FnMut(&SceneHit) -> Verdict> Search<F> {
    pub(super) fn new(ray: &SceneRay, filter: F) -> Self {
        let nothing = Hit { t: ray.ray.t_max, ..Hit::MISS };
        Self { best: SceneHit { hit: nothing, ..SceneHit::MISS }, filter }
    }

    /// Sees a hit within the ray's interval. `Break` if it ends the search.
    #[inline(always)]
    pub(super) fn see(&mut self, hit: SceneHit) -> ControlFlow<()> {
        if !hit.precedes(&self.best) {
            return ControlFlow::Continue(());
        }
        let verdict = (self.filter)(&hit);
        if verdict != Verdict::Reject {
            self.best = hit;
        }
        if verdict == Verdict::Stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    pub(super) fn found(self) -> Option<SceneHit> {
        self.best.is_hit().then_some(self.best)
    }
}

/// A ray in a scene, on the way to which it went through others.
pub(super) struct Visit<'a, F> {
    scene: &'a SceneView<'a>,
    isa: Isa,
    ray: SceneRay,
    instances: [u32; MAX_LEVELS],
    depth: usize,
    search: &'a mut Search<F>,
    /// For the trees of triangles: one at a time.
    pending: &'a mut Pending,
}

impl<F: FnMut(&SceneHit) -> Verdict> Work for Visit<'_, F> {
    type Output = ControlFlow<()>;

    /// Shows the search the hits of the ray that may precede its best one. `Break` if the search was ended.
    #[inline(always)]
    fn run<S: Simd>(self) -> ControlFlow<()> {
        let Visit { scene, ray, .. } = self;
        let tree = scene.tree();
        let (Some(mut setup), Some(moment)) =
            (RaySetup::new(&ray.ray, &scene.reach()), Moment::new(ray.time, tree.keys()))
        else {
            return ControlFlow::Continue(());
        };
        let reach = (scene.reach().min - ray.ray.origin).abs().max((scene.reach().max - ray.ray.origin).abs());
        // The second term is for the rounding of this sum.
        setup.slabs.widen(scene.error() * reach.max_element() + ray.ray.origin.abs() * NODE_ORIGIN_PAD);
        let mut items = Items { visit: self, moment };
        let mut pending = Pending::EMPTY;
        flight::descend::<S, _>(&mut items, &setup.slabs, ray.ray.t_min, &mut pending)
    }
}

impl<'a, F: FnMut(&SceneHit) -> Verdict> Visit<'a, F> {
    /// A ray in a scene that lies in no other. `pending` is memory, whatever is in it.
    #[inline(always)]
    pub(super) fn outermost(
        scene: &'a SceneView<'a>,
        ray: &SceneRay,
        search: &'a mut Search<F>,
        pending: &'a mut Pending,
    ) -> Self {
        let instances = [SceneHit::NO_INSTANCE; MAX_LEVELS];
        Self { scene, isa: scene.isa(), ray: *ray, instances, depth: 0, search, pending }
    }

    /// Runs the search; whether it was ended early does not matter.
    #[inline(always)]
    pub(super) fn trace<S: Simd>(self) {
        let _ = self.run::<S>();
    }
}

/// Enters a scene that lies in another. Not inlined: this is where the recursion turns.
#[inline(never)]
fn enter<F: FnMut(&SceneHit) -> Verdict>(isa: Isa, visit: Visit<F>) -> ControlFlow<()> {
    dispatch(isa, visit)
}

/// The items of a scene at a moment.
struct Items<'a, F> {
    visit: Visit<'a, F>,
    moment: Moment,
}

impl<F: FnMut(&SceneHit) -> Verdict> Ground for Items<'_, F> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.visit.search.best.hit.t
    }

    #[inline(always)]
    fn enter<S: Simd>(&self, node: u32, pending: &mut Pending, slabs: &Slabs, octant: u8, t_min: f32) {
        let (tree, Moment { key, fraction }) = (self.visit.scene.tree(), self.moment);
        if fraction != 0.0 {
            let keys = [tree.nodes(key), tree.nodes(key + 1)];
            moving::enter_between::<S>(keys, fraction, node, pending, slabs, octant, (t_min, self.t_max()));
        } else if let Some(node) = tree.nodes(key).get(node as usize) {
            pending.enter::<S>(node, slabs, octant, t_min, self.t_max());
        }
    }

    #[inline(always)]
    fn look<S: Simd>(&mut self, numbers: Range<usize>) -> ControlFlow<()> {
        let scene = self.visit.scene;
        for &number in scene.tree().items().get(numbers).unwrap_or(&[]) {
            let part = scene.parts().get(number as usize);
            let item = part.and_then(|part| scene.items().get(part.item as usize));
            if let (Some(part), Some(item)) = (part, item)
                && item.mask & self.visit.ray.mask != 0
            {
                self.visit.meet::<S>(item, part.item, part.prim_id)?;
            }
        }
        ControlFlow::Continue(())
    }
}

impl<F: FnMut(&SceneHit) -> Verdict> Visit<'_, F> {
    /// Traces the ray through one item.
    #[inline(always)]
    fn meet<S: Simd>(&mut self, item: &Item, index: u32, prim_id: u32) -> ControlFlow<()> {
        let SceneRay { ray, time, mask } = self.ray;
        let Some(ray) = item.placement.to_local(&ray, time) else {
            return ControlFlow::Continue(());
        };
        let mut found = Found { search: &mut *self.search, geometry_id: index, instances: self.instances };
        match item.object {
            Object::Mesh(tree) => flight::walk::<S, _>(&tree, &ray, self.pending, &mut found),
            Object::Moving(tree) => moving::walk::<S, _>(&tree, &ray, time, self.pending, &mut found),
            Object::Shape(shape) => match shape::intersect(shape, prim_id, &ray, time) {
                Some(hit) => found.see(hit, true),
                None => ControlFlow::Continue(()),
            },
            Object::Scene(scene) => {
                let mut instances = self.instances;
                if let Some(place) = instances.get_mut(self.depth) {
                    *place = index;
                }
                let ray = SceneRay { ray, time, mask };
                let (search, pending) = (&mut *self.search, &mut *self.pending);
                enter(self.isa, Visit { scene, isa: self.isa, ray, instances, depth: self.depth + 1, search, pending })
            }
        }
    }
}

/// Hits with one item, on their way to the search.
struct Found<'a, F> {
    search: &'a mut Search<F>,
    geometry_id: u32,
    instances: [u32; MAX_LEVELS],
}

impl<F: FnMut(&SceneHit) -> Verdict> Collector for Found<'_, F> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.search.best.hit.t
    }

    #[inline(always)]
    fn see(&mut self, hit: Hit, _front: bool) -> ControlFlow<()> {
        self.search.see(SceneHit { hit, geometry_id: self.geometry_id, instances: self.instances })
    }
}
