//! Damaged trees: refused, or traced to the hits of the triangles that they hold.

use glam::Vec3;
use halfdome_kernel::bvh::{Child, Node, TriangleBlock, WIDTH};
use halfdome_kernel::geometry::intersect_triangle;
use halfdome_kernel::traverse::reference;
use halfdome_kernel::{BuildOptions, Bvh, BvhView, Error, Hit, HitPacket, InvalidTree, Ray, RayPacket, Triangle};
use halfdome_tests::random::Pcg;

/// A tree of several levels, and rays through it.
fn tree(random: &mut Pcg) -> (Vec<Node>, Vec<TriangleBlock>, Vec<Ray>) {
    let triangles: Vec<Triangle> = (0..400)
        .map(|_| {
            let center = random.in_cube();
            [(); 3].map(|()| (center + random.in_cube() * 0.2).as_vec3())
        })
        .collect();
    let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
    let rays = (0..24).map(|_| {
        let origin = random.in_cube() * 2.0;
        Ray::new(origin.as_vec3(), (random.in_cube() - origin).as_vec3())
    });
    let rays = rays.collect();
    (bvh.view().nodes().to_vec(), bvh.view().blocks().to_vec(), rays)
}

/// The blocks that the root leads to; the tree is valid, so the walk ends.
fn reachable(tree: &BvhView) -> Vec<TriangleBlock> {
    let mut blocks = Vec::new();
    let mut todo = vec![0u32];
    while let Some(index) = todo.pop() {
        for &child in &tree.nodes()[index as usize].children {
            match Child::unpack(child) {
                Child::Empty => {}
                Child::Node(index) => todo.push(index),
                Child::Leaf { first, count } => {
                    blocks.extend_from_slice(&tree.blocks()[first as usize..][..count as usize]);
                }
            }
        }
    }
    blocks
}

/// Traces an accepted tree in all ways. Two triangles may now have one index, so a hit's weights may be of either.
fn check_accepted(tree: &BvhView, rays: &[Ray]) {
    let blocks = reachable(tree);
    let hits_of = |ray: &Ray| -> Vec<Hit> {
        let lanes = blocks.iter().flat_map(|block| (0..WIDTH).map(move |lane| (block, lane)));
        lanes
            .filter(|(block, lane)| block.prim_id[*lane] != Hit::NO_PRIM)
            .filter_map(|(block, lane)| {
                let hit = intersect_triangle(ray, &block.triangle(lane))?;
                Some(Hit { prim_id: block.prim_id[lane], ..hit })
            })
            .collect()
    };
    let mut packed = HitPacket::MISS;
    for chunk in rays.chunks(8) {
        let packet = RayPacket::<8>::from_rays(chunk);
        tree.intersect_packet(&packet, &mut packed);
        let occluded = tree.occluded_packet(&packet);
        for (lane, ray) in chunk.iter().enumerate() {
            let all = hits_of(ray);
            let first = all.iter().copied().min_by(|a, b| a.t.total_cmp(&b.t).then(a.prim_id.cmp(&b.prim_id)));
            let found = [tree.intersect(ray), reference::intersect(tree, ray), Some(packed.hit(lane))];
            for hit in found.map(|hit| hit.filter(Hit::is_hit)) {
                assert_eq!(hit.map(|hit| (hit.t, hit.prim_id)), first.map(|hit| (hit.t, hit.prim_id)), "{ray:?}");
                assert!(hit.is_none_or(|hit| all.contains(&hit)), "{hit:?}");
            }
            assert_eq!([tree.occluded(ray), occluded >> lane & 1 == 1], [first.is_some(); 2]);
        }
    }
}

/// Damages a copy of a tree in many ways, and traces what passes for valid; gives how many were refused and traced.
fn fuzz(times: usize, damage: impl Fn(&mut Vec<Node>, &mut Vec<TriangleBlock>, &mut Pcg)) -> (usize, usize) {
    let mut random = Pcg::new(77);
    let (nodes, blocks, rays) = tree(&mut random);
    assert!(nodes.len() > 8, "{} nodes", nodes.len());
    let (mut refused, mut traced) = (0, 0);
    for _ in 0..times {
        let (mut nodes, mut blocks) = (nodes.clone(), blocks.clone());
        damage(&mut nodes, &mut blocks, &mut random);
        match BvhView::new(&nodes, &blocks) {
            Ok(tree) => {
                check_accepted(&tree, &rays);
                traced += 1;
            }
            Err(error) => {
                assert!(!error.to_string().is_empty());
                refused += 1;
            }
        }
    }
    (refused, traced)
}

fn flip(bytes: &mut [u8], random: &mut Pcg) {
    bytes[random.below(bytes.len())] ^= 1 << random.below(8);
}

#[test]
fn flipped_bits_of_nodes() {
    let (refused, traced) = fuzz(3000, |nodes, _, random| flip(bytemuck::cast_slice_mut(nodes), random));
    assert!(refused > 1000 && traced > 100, "{refused} {traced}");
}

#[test]
fn flipped_bits_of_triangles_and_their_indices() {
    let (refused, traced) = fuzz(3000, |_, blocks, random| flip(bytemuck::cast_slice_mut(blocks), random));
    assert!(refused > 500 && traced > 100, "{refused} {traced}");
}

#[test]
fn many_flipped_bits_at_once() {
    let (refused, _) = fuzz(500, |nodes, blocks, random| {
        for _ in 0..=random.below(40) {
            flip(bytemuck::cast_slice_mut(nodes), random);
            flip(bytemuck::cast_slice_mut(blocks), random);
        }
    });
    assert!(refused > 400, "{refused}");
}

#[test]
fn planes_of_any_bits() {
    let (refused, traced) = fuzz(3000, |nodes, _, random| {
        let node = random.below(nodes.len());
        nodes[node].planes[random.below(3)][random.below(2)][random.below(WIDTH)] = f32::from_bits(random.bits());
    });
    assert!(refused > 1000 && traced > 100, "{refused} {traced}");
}

/// What an empty slot's box says must not reach the bounds of the scene, on which the rays' tolerances depend.
#[test]
fn boxes_of_empty_slots() {
    let triangles = [[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::Z, Vec3::X, Vec3::Y]];
    let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
    let rays = [Ray::new(Vec3::new(0.2, 0.2, 2.0), Vec3::NEG_Z), Ray::new(Vec3::ONE, Vec3::NEG_ONE)];
    check_accepted(&bvh.view(), &rays);
    assert_eq!(bvh.view().nodes()[0].children[7], Child::Empty.pack());
    for plane in 0..6 {
        for value in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 0.0, 1e30, -1e30] {
            let mut nodes = bvh.view().nodes().to_vec();
            nodes[0].planes[plane / 2][plane % 2][7] = value;
            if let Ok(tree) = BvhView::new(&nodes, bvh.view().blocks()) {
                check_accepted(&tree, &rays);
            }
        }
    }
}

#[test]
fn children_that_are_elsewhere() {
    let (refused, traced) = fuzz(3000, |nodes, blocks, random| {
        let child = match random.below(4) {
            0 => Child::Node(random.below(nodes.len()) as u32).pack(),
            1 => {
                Child::Leaf { first: random.below(blocks.len() + 2) as u32, count: 1 + random.below(32) as u32 }.pack()
            }
            2 => Child::Empty.pack(),
            _ => random.bits(),
        };
        let node = random.below(nodes.len());
        nodes[node].children[random.below(WIDTH)] = child;
    });
    assert!(refused > 2000 && refused + traced == 3000, "{refused} {traced}");
}

#[test]
fn indices_of_any_bits() {
    let (refused, traced) = fuzz(1000, |_, blocks, random| {
        let block = random.below(blocks.len());
        blocks[block].prim_id[random.below(WIDTH)] = [random.bits(), random.bits() % 3, u32::MAX][random.below(3)];
    });
    assert!(refused > 100 && traced > 100, "{refused} {traced}");
}

#[test]
fn every_truncation_is_refused() {
    let (nodes, blocks, _) = tree(&mut Pcg::new(77));
    assert_eq!(BvhView::new(&[], &blocks).err(), Some(InvalidTree::NoRoot.into()));
    for length in 1..nodes.len() {
        assert!(BvhView::new(&nodes[..length], &blocks).is_err(), "{length} nodes");
    }
    for length in 0..blocks.len() {
        assert!(BvhView::new(&nodes, &blocks[..length]).is_err(), "{length} blocks");
    }
    let longer = [nodes.as_slice(), &[Node::EMPTY]].concat();
    let forgotten = InvalidTree::UnreachableNode { node: nodes.len() as u32 };
    assert_eq!(BvhView::new(&longer, &blocks).err(), Some(forgotten.into()));
}

#[test]
fn cycles_are_refused() {
    let mut node = Node::EMPTY;
    let aabb = halfdome_kernel::Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE };
    node.set(0, &aabb, Child::Node(0));
    assert_eq!(BvhView::new(&[node], &[]).err(), Some(InvalidTree::BadChild { node: 0, slot: 0 }.into()));
    node.set(0, &aabb, Child::Node(1));
    assert!(BvhView::new(&[node; 2], &[]).is_err());
    // A chain: deeper than the stack is allowed to be, it is refused too, and a shallower one traced.
    for (length, sound) in [(2, true), (20, true), (400, false)] {
        let mut chain: Vec<Node> = (1..length)
            .map(|next| {
                let mut node = Node::EMPTY;
                node.set(3, &aabb, Child::Node(next));
                // Siblings fill the stack.
                let leaf = |slot: usize| Child::Leaf { first: 4 * (next - 1) + slot as u32 - 4, count: 1 };
                (4..8).for_each(|slot| node.set(slot, &aabb, leaf(slot)));
                node
            })
            .collect();
        chain.push(Node::EMPTY);
        let mut block = TriangleBlock::EMPTY;
        block.set(0, &[Vec3::ZERO, Vec3::X, Vec3::Y], 9);
        let blocks = vec![block; 4 * (chain.len() - 1)];
        match BvhView::new(&chain, &blocks) {
            Ok(tree) => {
                assert!(sound);
                check_accepted(&tree, &[Ray::new(Vec3::new(0.2, 0.2, 2.0), Vec3::NEG_Z), Ray::new(Vec3::ONE, Vec3::X)]);
            }
            Err(error) => {
                assert!(!sound && matches!(error, Error::InvalidTree(InvalidTree::TooDeep { .. })), "{error}")
            }
        }
    }
}
