//! The documented limits hold, and a step beyond them nothing is hit: not a ray, not a triangle, not a tree.

use glam::{Vec3, vec3};
use halfdome_kernel::bvh::{Child, MAX_STACK, Node, TriangleBlock, WIDTH};
use halfdome_kernel::{
    Aabb, BuildOptions, Bvh, BvhView, Error, Hit, InvalidTree, MAX_COORDINATE, MAX_DIRECTION, MIN_DIRECTION, Ray,
    Triangle,
};
use halfdome_tests::check::{check, check_tree, isas};

const TRIANGLE: Triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];

/// A ray that hits the triangle's middle at `t = 1`.
const RAY: Ray = Ray { origin: vec3(0.25, 0.25, 1.0), t_min: 0.0, direction: Vec3::NEG_Z, t_max: f32::INFINITY };

fn hit(ray: Ray) -> Option<Hit> {
    check(&[TRIANGLE], &[ray])[0]
}

#[test]
fn the_limits_are_those_that_the_documentation_tells() {
    assert_eq!(MAX_COORDINATE, 4_398_046_511_104.0);
    assert_eq!(MAX_DIRECTION, 1_125_899_906_842_624.0);
    assert_eq!(MIN_DIRECTION, 1.0 / MAX_DIRECTION);
    assert_eq!(hit(RAY), Some(Hit { t: 1.0, u: 0.25, v: 0.25, prim_id: 0 }));
}

#[test]
fn directions_of_the_least_and_the_greatest_length_and_a_step_beyond() {
    for (length, beyond) in [(MIN_DIRECTION, MIN_DIRECTION.next_down()), (MAX_DIRECTION, MAX_DIRECTION.next_up())] {
        for axis in 0..3 {
            let turned = |p: Vec3| Vec3::from([0, 1, 2].map(|i| p[(i + axis) % 3]));
            let triangle = TRIANGLE.map(turned);
            let ray = |length: f32| Ray { origin: turned(RAY.origin), direction: turned(Vec3::NEG_Z) * length, ..RAY };
            let hits = check(&[triangle], &[ray(length), ray(beyond), ray(-beyond)]);
            let found = hits[0].expect("the limit itself is allowed");
            assert_eq!((found.t, found.prim_id), (1.0 / length, 0));
            assert_eq!(hits[1..], [None, None]);
        }
        // The largest component counts, and no other.
        assert!(hit(Ray { direction: vec3(0.0, 1e-30, -length), ..RAY }).is_some());
    }
    for direction in
        [Vec3::ZERO, -Vec3::ZERO, Vec3::splat(1e-45), Vec3::Z * -1e-30, Vec3::Z * -1e30, Vec3::splat(f32::MAX)]
    {
        assert_eq!(hit(Ray { direction, ..RAY }), None, "{direction}");
    }
}

#[test]
fn coordinates_of_the_greatest_size_and_a_step_beyond() {
    let far = Ray { origin: vec3(0.25, 0.25, MAX_COORDINATE), ..RAY };
    assert_eq!(hit(far).map(|hit| (hit.t, hit.prim_id)), Some((MAX_COORDINATE, 0)));
    assert_eq!(hit(Ray { origin: vec3(0.25, 0.25, MAX_COORDINATE.next_up()), ..RAY }), None);
    for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let (mut origin, mut direction) = (RAY.origin, RAY.direction);
            (origin[axis], direction[axis]) = (wrong, wrong);
            assert_eq!([hit(Ray { origin, ..RAY }), hit(Ray { direction, ..RAY })], [None; 2], "{wrong} {axis}");
        }
    }
    // The largest triangle there is: hit, and dropped one step beyond.
    let m = MAX_COORDINATE;
    let largest = [vec3(-m, -m, 0.0), vec3(m, -m, 0.0), vec3(0.0, m, 0.0)];
    let found = check(&[largest], &[RAY, far])[0].expect("it covers the origin");
    assert_eq!((found.t, found.prim_id), (1.0, 0));
    let beyond = [vec3(-m, -m, 0.0), vec3(m.next_up(), -m, 0.0), vec3(0.0, m, 0.0)];
    let (_, report) = Bvh::build(&[beyond, largest], &BuildOptions::default()).unwrap();
    assert_eq!((report.kept, report.out_of_range), (1, 1));
    assert_eq!(check(&[beyond, largest], &[RAY])[0].map(|hit| hit.prim_id), Some(1));
}

#[test]
fn intervals_of_all_kinds() {
    let (inf, nan) = (f32::INFINITY, f32::NAN);
    for (t_min, t_max, found) in [
        (1.0, 1.0, true),
        (1f32.next_up(), inf, false),
        (0.0, 1f32.next_down(), false),
        (-inf, inf, true),
        (-2.0, -1.0, false),
        (2.0, 0.0, false),
        (0.0, 0.0, false),
        (-0.0, inf, true),
        (inf, inf, false),
        (-inf, -inf, false),
        (nan, inf, false),
        (0.0, nan, false),
        (nan, nan, false),
        (inf, -inf, false),
        (f32::MIN, f32::MAX, true),
    ] {
        assert_eq!(hit(Ray { t_min, t_max, ..RAY }).is_some(), found, "{t_min} {t_max}");
    }
    // Behind the origin, if that is asked for; at the origin.
    let behind = Ray { direction: Vec3::Z, t_min: -inf, ..RAY };
    assert_eq!(hit(behind).map(|hit| hit.t), Some(-1.0));
    let at = Ray { origin: vec3(0.25, 0.25, 0.0), t_max: 0.0, ..RAY };
    assert_eq!(hit(at).map(|hit| hit.t), Some(0.0));
}

/// A chain of `length` nodes with four leaves and the next node each, and a last one with `last` leaves. All boxes are
/// the same, so that rays keep all of them for later.
fn chain(length: u32, last: usize) -> (Vec<Node>, Vec<TriangleBlock>) {
    let aabb = Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE };
    let mut blocks = Vec::new();
    let mut nodes: Vec<Node> = Vec::new();
    for next in 1..=length + 1 {
        let mut node = Node::EMPTY;
        // The nodes come before the leaves, in all octants, so that leaves pile up.
        let (first, leaves) = if next <= length { (4, 4) } else { (0, last) };
        if next <= length {
            node.set(0, &aabb, Child::Node(next));
        }
        for slot in first..first + leaves {
            let mut block = TriangleBlock::EMPTY;
            block.set(0, &TRIANGLE.map(|p| p - Vec3::Z * (0.9 / (1.0 + blocks.len() as f32))), blocks.len() as u32);
            node.set(slot, &aabb, Child::Leaf { first: blocks.len() as u32, count: 1 });
            blocks.push(block);
        }
        node.order = [0o07654321; WIDTH];
        nodes.push(node);
    }
    (nodes, blocks)
}

#[test]
fn chains_as_deep_as_the_stack_allows_and_one_entry_deeper() {
    // Each link leaves four leaves on the stack.
    let links = (MAX_STACK - WIDTH) / 4;
    assert_eq!(4 * links + WIDTH, MAX_STACK, "the last node fills the stack");
    for (length, last, needed) in
        [(links - 1, 8, MAX_STACK - 4), (links, 7, MAX_STACK - 1), (links, 8, MAX_STACK), (links + 1, 5, MAX_STACK + 1)]
    {
        let (nodes, blocks) = chain(length as u32, last);
        let tree = match BvhView::new(&nodes, &blocks) {
            Ok(tree) => tree,
            Err(error) => {
                let allowed = MAX_STACK as u32;
                let rejected_builds = InvalidTree::TooDeep { needed: needed as u32, allowed };
                assert_eq!((error, needed > MAX_STACK), (Error::InvalidTree(rejected_builds), true));
                continue;
            }
        };
        assert!(needed <= MAX_STACK, "{needed} entries");
        // Down the chain and through all triangles; the last triangle is nearest from above, the first from below.
        let above = RAY;
        let below = Ray { origin: vec3(0.25, 0.25, -1.5), direction: Vec3::Z, ..RAY };
        let beside = Ray { origin: vec3(0.75, 0.75, 1.0), ..RAY };
        let prim = |hit: Option<Hit>| hit.map(|hit| hit.prim_id);
        for isa in isas() {
            let tree = tree.with_isa(isa);
            let found = [above, below, beside].map(|ray| prim(tree.intersect(&ray)));
            assert_eq!(found, [Some(blocks.len() as u32 - 1), Some(0), None], "{}", isa.level());
        }
        let rays = [above, below, beside];
        let expected = rays.map(|ray| tree.with_isa(halfdome_kernel::Isa::SCALAR).intersect(&ray));
        check_tree(&tree, &rays, &expected);
    }
}
