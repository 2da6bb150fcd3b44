//! Walks through scenes: the scene's own tree, and in its leaves whatever lies there, in its own space.

use core::ops::{ControlFlow, Range};

use super::shape;
use super::{Item, Object, SceneHit, SceneRay, SceneView};
use crate::geometry::Hit;
use crate::geometry::moment::Moment;
use crate::geometry::setup::{NODE_ORIGIN_PAD, RaySetup, Slabs};
use crate::simd::{Isa, Simd, Work, dispatch};
use crate::traverse::single::{self, Collector, Intersector, moving};
use crate::traverse::{TraversalStack, Verdict};

/// Rays to be traced one after the other, and who hears of what. Not generic, so that a program has this once for each
/// instruction set: a filter is called a few times a ray.
pub(super) struct Trace<'a> {
    pub scene: &'a SceneView<'a>,
    pub rays: &'a [SceneRay],
    pub filter: &'a mut dyn FnMut(&SceneHit) -> Verdict,
    /// Hears of the result of each ray, by its number.
    pub write: &'a mut dyn FnMut(usize, Option<SceneHit>),
}

impl Work for Trace<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let (mut items, mut triangles) = (TraversalStack::new(), TraversalStack::new());
        for (number, ray) in self.rays.iter().enumerate() {
            let nothing = SceneHit { hit: Hit { t: ray.ray.t_max, ..Hit::MISS }, ..SceneHit::MISS };
            let mut search = Search { best: nothing, filter: &mut *self.filter };
            let visit = Visit {
                scene: self.scene,
                isa: self.scene.isa(),
                ray: *ray,
                first_path: 0,
                depth: 0,
                search: &mut search,
                triangles: &mut triangles,
            };
            // Whether the search was ended early does not matter.
            let _ = visit.walk::<S>(&mut items);
            (self.write)(number, search.best.is_hit().then_some(search.best));
        }
    }
}

/// The nearest hit so far that is accepted.
struct Search<'a> {
    best: SceneHit,
    filter: &'a mut dyn FnMut(&SceneHit) -> Verdict,
}

/// A ray in a scene, on the way to which it went through others.
struct Visit<'a, 'f> {
    scene: &'a SceneView<'a>,
    isa: Isa,
    ray: SceneRay,
    /// The first of the paths through this scene, in the outermost.
    first_path: u64,
    depth: u32,
    search: &'a mut Search<'f>,
    /// Memory for walks through trees of triangles, one at a time.
    triangles: &'a mut TraversalStack,
}

impl Visit<'_, '_> {
    /// Shows the search the hits of the ray that may precede its best one. `Break` if the search was ended. `stack` is
    /// memory, whatever is in it.
    #[inline(always)]
    fn walk<S: Simd>(self, stack: &mut TraversalStack) -> ControlFlow<()> {
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
        single::traverse::<S, _>(&mut ItemIntersector { visit: self, moment }, &setup.slabs, ray.ray.t_min, stack)
    }
}

/// Enters a scene that lies in another. Not inlined: this is where the recursion turns.
#[inline(never)]
fn enter(visit: Visit) -> ControlFlow<()> {
    dispatch(visit.isa, visit)
}

impl Work for Visit<'_, '_> {
    type Output = ControlFlow<()>;
    #[inline(always)]
    fn run<S: Simd>(self) -> ControlFlow<()> {
        let mut stack = TraversalStack::new();
        self.walk::<S>(&mut stack)
    }
}

/// The items of a scene at a moment.
struct ItemIntersector<'a, 'f> {
    visit: Visit<'a, 'f>,
    moment: Moment,
}

impl Intersector for ItemIntersector<'_, '_> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.visit.search.best.hit.t
    }

    #[inline(always)]
    fn visit_node<S: Simd>(&self, node: u32, stack: &mut TraversalStack, slabs: &Slabs, octant: u8, t_min: f32) {
        let (tree, Moment { key, fraction }) = (self.visit.scene.tree(), self.moment);
        if fraction != 0.0 {
            let keys = [tree.nodes(key), tree.nodes(key + 1)];
            moving::push_children_between::<S>(keys, fraction, node, stack, slabs, octant, (t_min, self.t_max()));
        } else if let Some(node) = tree.nodes(key).get(node as usize) {
            stack.push_children::<S>(node, slabs, octant, t_min, self.t_max());
        }
    }

    #[inline(always)]
    fn visit_leaf<S: Simd>(&mut self, numbers: Range<usize>) -> ControlFlow<()> {
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

impl Visit<'_, '_> {
    /// Traces the ray through one item.
    #[inline(always)]
    fn meet<S: Simd>(&mut self, item: &Item, index: u32, prim_id: u32) -> ControlFlow<()> {
        let SceneRay { ray, time, mask } = self.ray;
        let Some(ray) = item.placement.to_local(&ray, time) else {
            return ControlFlow::Continue(());
        };
        let path = self.first_path + (self.scene.paths() - 1);
        let mut found = ItemCollector { search: &mut *self.search, geometry_id: index, depth: self.depth, path };
        match item.object {
            Object::Mesh(tree) => single::walk::<S, _>(&tree, &ray, self.triangles, &mut found),
            Object::Moving(tree) => moving::walk::<S, _>(&tree, &ray, time, self.triangles, &mut found),
            Object::Shape(shape) => match shape::intersect(shape, prim_id, &ray, time) {
                Some(hit) => found.report(hit, true),
                None => ControlFlow::Continue(()),
            },
            Object::Scene(scene) => {
                let (ray, first_path) = (SceneRay { ray, time, mask }, self.first_path + item.first_path);
                let (search, triangles) = (&mut *self.search, &mut *self.triangles);
                enter(Visit { scene, isa: self.isa, ray, first_path, depth: self.depth + 1, search, triangles })
            }
        }
    }
}

/// Hits with one item, on their way to the search.
struct ItemCollector<'a, 'f> {
    search: &'a mut Search<'f>,
    geometry_id: u32,
    depth: u32,
    path: u64,
}

impl Collector for ItemCollector<'_, '_> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.search.best.hit.t
    }

    #[inline(always)]
    fn report(&mut self, hit: Hit, _front: bool) -> ControlFlow<()> {
        let hit = SceneHit { hit, geometry_id: self.geometry_id, depth: self.depth, path: self.path };
        if !hit.precedes(&self.search.best) {
            return ControlFlow::Continue(());
        }
        let verdict = (self.search.filter)(&hit);
        if verdict != Verdict::Reject {
            self.search.best = hit;
        }
        if verdict == Verdict::Stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
