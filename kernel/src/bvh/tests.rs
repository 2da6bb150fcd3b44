//! Trees of all qualities: their cost, independence of executors, and triangles that are hard to separate.

use alloc::vec;
use alloc::vec::Vec;
use std::sync::Mutex;
use std::thread;

use glam::{Vec3, vec3};

use super::binary::BinaryTree;
use super::executor::{Executor, Serial};
use super::primitive::Primitive;
use super::{Bvh, BvhView, Child, Quality, WIDTH, reinsertion, top_down};
use crate::geometry::{Aabb, Hit, MAX_COORDINATE, Triangle};

/// Runs the second part first.
struct Backwards;

impl Executor for Backwards {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        let b = b();
        (a(), b)
    }
}

/// A thread for each part where there are threads, and a list of what is heard.
#[derive(Default)]
struct Threads(Mutex<Vec<f32>>);

impl Executor for Threads {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        // WebAssembly has none.
        if cfg!(target_family = "wasm") {
            return (a(), b());
        }
        thread::scope(|scope| {
            let b = scope.spawn(b);
            (a(), b.join().unwrap())
        })
    }

    fn advance(&self, fraction: f32) {
        self.0.lock().unwrap().push(fraction);
    }
}

/// A triangle of about `size` at `center`.
fn triangle_at(center: Vec3, size: f32) -> Triangle {
    [center - Vec3::splat(size), center + vec3(size, 0.0, 0.0), center + vec3(0.0, size, size)]
}

/// Points of the unit cube: the fractional parts of multiples of irrational numbers.
fn scattered(count: usize) -> impl Iterator<Item = Vec3> {
    (0..count).map(|i| (i as f32 * vec3(0.754_877_7, 0.569_840_3, 0.438_579_3)).fract())
}

fn soup(count: usize, size: f32) -> Vec<Triangle> {
    scattered(count).map(|center| triangle_at(center, size)).collect()
}

fn build(triangles: &[Triangle], quality: Quality) -> Bvh {
    let (bvh, report) = Bvh::build(triangles, &quality.into()).unwrap();
    assert_eq!(report.rejected_builds, 0, "{quality}");
    assert_valid(&bvh, report.kept);
    bvh
}

/// The tree is what traversal relies on, and has each of `count` triangles once.
fn assert_valid(bvh: &Bvh, count: usize) {
    let tree = bvh.view();
    assert_eq!(BvhView::new(tree.nodes(), tree.blocks()).err(), None);
    let mut ids: Vec<u32> =
        tree.blocks().iter().flat_map(|block| block.prim_id).filter(|&id| id != Hit::NO_PRIM).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count);
    assert_eq!(bvh.statistics().triangles, count);
}

/// The definition of the expected cost, from the tree as it lies in memory.
fn cost(bvh: &Bvh) -> f64 {
    let area = |aabb: Aabb| f64::from(aabb.half_area());
    let tree = bvh.view();
    let mut sum = area(tree.bounds());
    for node in tree.nodes() {
        for slot in 0..WIDTH {
            sum += match Child::unpack(node.children[slot]) {
                Child::Empty => 0.0,
                Child::Node(_) => area(node.aabb(slot)),
                Child::Leaf { count, .. } => 0.6 * f64::from(count) * area(node.aabb(slot)),
            };
        }
    }
    sum / area(tree.bounds())
}

#[test]
fn the_cost_is_that_of_the_tree() {
    for (count, size) in [(9, 0.1), (100, 0.02), (5000, 0.01), (20_000, 0.1)] {
        for quality in Quality::ALL {
            let bvh = build(&soup(count, size), quality);
            let (said, is) = (f64::from(bvh.statistics().cost), cost(&bvh));
            assert!((said - is).abs() < 1e-4 * is, "{quality}: {said} {is}");
        }
    }
}

#[test]
fn more_trouble_makes_better_trees() {
    // Houses along streets, of two triangles a wall.
    let corner = |house: usize, height: f32, i: usize| {
        let at = |bit: usize| if i >> bit & 1 == 1 { 0.7 } else { 0.0 };
        vec3((house % 50) as f32 + at(0), height * at(1), (house / 50) as f32 + at(2))
    };
    let walls = [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 3, 6, 7], [0, 2, 4, 6], [1, 3, 5, 7]];
    let mut triangles = Vec::new();
    for (house, point) in scattered(2500).enumerate() {
        for wall in walls {
            let [a, b, c, d] = wall.map(|i| corner(house, 0.5 + 8.0 * point.x, i));
            triangles.extend([[a, b, c], [b, c, d]]);
        }
    }
    let [fast, medium, high] = Quality::ALL.map(|quality| cost(&build(&triangles, quality)));
    assert!(high < medium && medium < fast, "{fast} {medium} {high}");
}

#[test]
fn clusters_are_told_apart() {
    // Three groups of eight along one axis, shuffled: none shares a block.
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        let triangles: Vec<_> = (0..24)
            .map(|i| triangle_at(axis * ((i % 3) as f32 * 10.0) + vec3(0.1, 0.2, 0.3) * (i / 3) as f32, 0.1))
            .collect();
        for quality in Quality::ALL {
            let bvh = build(&triangles, quality);
            assert_eq!(bvh.statistics().nodes, 1);
            for block in bvh.view().blocks() {
                let mut ids = block.prim_id.iter().filter(|&&id| id != Hit::NO_PRIM);
                assert!(ids.all(|id| id % 3 == block.prim_id[0] % 3), "{:?}", block.prim_id);
            }
        }
    }
}

#[test]
fn executors_do_not_matter() {
    let triangles = soup(60_000, 0.004);
    for quality in Quality::ALL {
        let expected = build(&triangles, quality);
        let threads = Threads::default();
        let (backwards, _) = Bvh::build_on(&Backwards, &triangles, &quality.into()).unwrap();
        let (threaded, _) = Bvh::build_on(&threads, &triangles, &quality.into()).unwrap();
        for other in [backwards, threaded] {
            assert!(other.view().nodes() == expected.view().nodes());
            // Not the blocks themselves: the NaN of unused lanes are not equal.
            let bits = |bvh: &Bvh| bytemuck::cast_slice::<_, u32>(bvh.view().blocks()).to_vec();
            assert!(bits(&other) == bits(&expected));
            assert_eq!(other.statistics().cost, expected.statistics().cost);
        }
        let heard = threads.0.into_inner().unwrap();
        assert!(heard.len() > 10 && heard.iter().all(|&fraction| fraction > 0.0));
        assert!((heard.iter().sum::<f32>() - 1.0).abs() < 1e-3, "{quality}: {}", heard.iter().sum::<f32>());
    }
}

/// What `reinsertion` makes less.
fn area(tree: &BinaryTree) -> f32 {
    tree.nodes.iter().filter(|node| !node.is_leaf()).map(|node| node.aabb.half_area()).sum()
}

#[test]
fn reinsertion_keeps_leaves_and_saves_area() {
    let triangles = soup(20_000, 0.05);
    let prims = (0..).zip(&triangles).map(|(id, triangle)| Primitive::new(&Aabb::around(triangle), id)).collect();
    let mut tree = top_down::build(&Serial, prims, Quality::Fast.effort().splitting, WIDTH, 1.0);
    let leaves = |tree: &BinaryTree| {
        let mut leaves: Vec<_> =
            tree.nodes.iter().filter(|node| node.is_leaf()).map(|node| (node.first, node.count)).collect();
        leaves.sort_unstable();
        leaves
    };
    let expected = leaves(&tree);
    for _ in 0..3 {
        let last = area(&tree);
        reinsertion::optimize(&Serial, &mut tree, reinsertion::Patience { rounds: 1, least_gain: 0.0 }, 1.0);
        assert!(area(&tree) < last);
        assert_eq!(leaves(&tree), expected);
        for node in tree.nodes.iter().filter(|node| !node.is_leaf()) {
            let [a, b] = node.children().map(|child| tree.nodes[child].aabb);
            assert_eq!(node.aabb, a.union(&b));
        }
    }
    // All nodes are still reached.
    let count = tree.nodes.len();
    assert_eq!(tree.in_order().unwrap().nodes.len(), count);
}

#[test]
fn a_chain_of_shells_is_not_too_deep() {
    // Each triangle's box holds those before it: a chain costs least.
    let mut rejected_builds = 0;
    for growth in [1.001f32, 1.01, 1.02] {
        let triangles: Vec<_> = (0..3000).map(|i| triangle_at(Vec3::ZERO, 1e-9 * growth.powi(i % 2000))).collect();
        for quality in Quality::ALL {
            let (bvh, report) = Bvh::build(&triangles, &quality.into()).unwrap();
            assert_valid(&bvh, 3000);
            rejected_builds += report.rejected_builds;
        }
    }
    assert!(rejected_builds > 0, "the shells are no test");
}

#[test]
fn what_cannot_be_told_apart_is_halved() {
    let same = vec![triangle_at(Vec3::ONE, 1.0); 20_000];
    let centered: Vec<_> = (0..20_000).map(|i| triangle_at(Vec3::ZERO, 1.0 + (i % 100) as f32)).collect();
    let on_a_line: Vec<_> = (0..20_000).map(|i| [0, 1, 2].map(|k| vec3((i * 3 + k) as f32, 0.0, 0.0))).collect();
    let far: Vec<_> = soup(20_000, 0.1).iter().map(|triangle| triangle.map(|p| (p - 0.5) * MAX_COORDINATE)).collect();
    let tiny: Vec<_> = soup(20_000, 0.1).iter().map(|triangle| triangle.map(|p| p * 1e-42)).collect();
    for triangles in [same, centered, on_a_line, far, tiny] {
        for quality in Quality::ALL {
            let (bvh, report) = Bvh::build(&triangles, &quality.into()).unwrap();
            assert_valid(&bvh, report.kept);
            let statistics = bvh.statistics();
            assert!(statistics.depth <= 24, "{quality}: {statistics:?}");
            assert!(statistics.blocks < 20_000 / 4, "{quality}: {statistics:?}");
        }
    }
}
