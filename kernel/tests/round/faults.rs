//! Invalid primitives, extremes, and their reports.

use super::*;
use halfdome_kernel::MAX_COORDINATE;
use halfdome_kernel::bvh::{CubicCurveBlock, LinearCurveBlock, Node, RoundBlock, SphereBlock};
use halfdome_kernel::{Error, InvalidTree};

#[test]
fn what_cannot_be_hit_is_left_out_and_told() {
    let at = |center: Vec3, radius: f32| Sphere { center, radius };
    let far = MAX_COORDINATE;
    let spheres = [
        at(Vec3::ZERO, 1.0),
        at(Vec3::X, 0.0),
        at(Vec3::X, -1.0),
        at(Vec3::X, f32::NAN),
        at(vec3(0.0, f32::NAN, 0.0), 1.0),
        at(vec3(0.0, f32::INFINITY, 0.0), 1.0),
        at(Vec3::X, f32::INFINITY),
        at(Vec3::X * far, 1e6),
        at(Vec3::X, far * 2.0),
        at(Vec3::X, -0.0),
        at(Vec3::X, f32::MIN_POSITIVE),
        at(Vec3::ZERO, far * 0.5),
    ];
    let (tree, report) = RoundBvh::build(&spheres, &BuildOptions::default()).unwrap();
    let counts = (report.kept, report.degenerate, report.not_finite, report.out_of_range);
    assert_eq!((counts, report.first_dropped, report.dropped()), ((3, 3, 4, 2), Some(1), 9));
    assert_eq!(
        format!("{report}"),
        "3 primitives kept, 9 dropped, the first of them 1: 3 degenerate, 4 not finite, 2 too far away"
    );
    for (prim_id, sphere) in (0..).zip(&spheres) {
        let ray = Ray::new(sphere.center - Vec3::Z * 3.0, Vec3::Z);
        if sphere.fault().is_some() {
            assert_eq!((intersect_round(&ray, sphere), RoundSurface::of(&ray, sphere)), (None, None), "{prim_id}");
        }
    }
    let hit = tree.view().intersect(&Ray::new(Vec3::NEG_Z * 3.0, Vec3::Z)).unwrap();
    assert_eq!((hit.t, hit.prim_id), (2.0, 0));
    let curve = |a: f32, b: f32| LinearCurve { ends: [at(Vec3::ZERO, a), at(Vec3::X, b)] };
    assert_eq!([curve(0.0, 0.1).fault(), curve(0.1, 0.0).fault()], [None; 2]);
    for bad in [curve(0.0, 0.0), curve(0.1, -0.1)] {
        assert_eq!(bad.fault(), Some(PrimitiveFault::Degenerate));
    }
    let disc = |normal: Vec3| Disc { center: Vec3::ZERO, radius: 1.0, normal };
    assert_eq!(disc(Vec3::ZERO).fault(), Some(PrimitiveFault::Degenerate));
    assert_eq!(disc(Vec3::NAN).fault(), Some(PrimitiveFault::NotFinite));
    assert_eq!(disc(Vec3::X * f32::MAX).fault(), Some(PrimitiveFault::OutOfRange));
    let (empty, report) = RoundBvh::build(&[disc(Vec3::ZERO)], &BuildOptions::default()).unwrap();
    assert_eq!((report.kept, empty.view().intersect(&Ray::new(Vec3::NEG_Z, Vec3::Z))), (0, None));
}

#[test]
fn extremes_and_random_bits_do_no_harm() {
    let mut random = Random::new(111);
    let mut hits = 0;
    for i in 0..60_000 {
        let number = |random: &mut Random| match random.bits() % 8 {
            0 => f32::from_bits(random.bits()),
            1 => 0.0,
            2 => 1e-20 * random.unit(),
            3 => 1e12 * random.unit(),
            4 => -random.unit(),
            _ => (random.unit() * 8.0).round() / 4.0 - 1.0,
        };
        let vector = |random: &mut Random| vec3(number(random), number(random), number(random));
        let sphere = |random: &mut Random| {
            let (center, radius) = (vector(random), number(random));
            Sphere::new(center, if random.bits().is_multiple_of(8) { radius } else { radius.abs() })
        };
        let mut controls = [(); 4].map(|()| sphere(&mut random));
        match i % 6 {
            0 => controls = [controls[0]; 4],
            1 => controls[3] = controls[0],
            2 => {
                let first = controls[0].center;
                controls.iter_mut().for_each(|c| c.center = first + (c.center - first) * 1e-7);
            }
            _ => {}
        }
        let origin = vector(&mut random);
        let direction = if i % 2 == 0 { vector(&mut random) } else { controls[1].center - origin };
        let (t_min, t_max) = if i % 3 == 0 { (number(&mut random), number(&mut random)) } else { (0.0, f32::INFINITY) };
        let ray = Ray { origin, t_min, direction, t_max };
        let [a, b, ..] = controls;
        let disc = Disc { center: a.center, radius: a.radius, normal: b.center };
        let found = [
            intersect_round(&ray, &a),
            intersect_round(&ray, &disc),
            intersect_round(&ray, &LinearCurve { ends: [a, b] }),
            intersect_round(&ray, &CubicCurve { controls }),
        ];
        for hit in found.into_iter().flatten() {
            hits += 1;
            assert!(t_min <= hit.t && hit.t <= t_max && (0.0..=1.0).contains(&hit.u), "{ray:?} {hit:?}");
        }
        let _ = (RoundSurface::of(&ray, &disc), RoundSurface::of(&ray, &CubicCurve { controls }));
    }
    assert!(hits > 2000, "{hits}");
}

#[test]
fn a_borrowed_tree_is_checked() {
    let spheres: [Sphere; 20] = core::array::from_fn(|i| Sphere::new(Vec3::X * i as f32, 0.25));
    let (tree, _) = RoundBvh::build(&spheres, &BuildOptions::default()).unwrap();
    let view = tree.view();
    let halfdome_kernel::bvh::RoundBlocks::Spheres(blocks) = view.blocks() else { panic!("other blocks") };
    let ray = Ray::new(vec3(7.0, 0.0, -3.0), Vec3::Z);
    let borrowed = RoundBvhView::new(view.nodes(), blocks).unwrap();
    assert_eq!(borrowed.intersect(&ray).map(|hit| hit.prim_id), Some(7));
    let error = |nodes: &[Node], blocks: &[SphereBlock]| match RoundBvhView::new(nodes, blocks) {
        Err(Error::InvalidTree(error)) => Some(error),
        _ => None,
    };
    let mut other = blocks.to_vec();
    other[1].numbers[3][0] = -1.0;
    assert_eq!(error(view.nodes(), &other), Some(InvalidTree::BadPrimitive { block: 1, lane: 0 }));
    let mut other = blocks.to_vec();
    let unused = blocks.iter().position(|block| block.prim_id[7] == u32::MAX).unwrap();
    other[unused].numbers[2][7] = 1.0;
    assert_eq!(error(view.nodes(), &other), Some(InvalidTree::BadPrimitive { block: unused as u32, lane: 7 }));
    let mut other = blocks.to_vec();
    other[0].numbers[1][0] += 1.0;
    assert!(matches!(error(view.nodes(), &other), Some(InvalidTree::BadBox { .. })));
    assert!(error(view.nodes(), &blocks[1..]).is_some());
    assert_eq!(error(&[], blocks), Some(InvalidTree::NoRoot));
    // Trees without primitives, of any kind.
    assert!(RoundBvhView::new(&[Node::EMPTY], &[] as &[CubicCurveBlock]).unwrap().bounds().is_empty());
}

#[test]
fn blocks_keep_what_is_put_into_them() {
    let curve = LinearCurve { ends: [Sphere::new(Vec3::X, 0.5), Sphere::new(vec3(1.0, 2.0, 3.0), 0.25)] };
    let mut block = LinearCurveBlock::EMPTY;
    block.set(5, &curve, 77);
    assert_eq!((block.primitive(5), block.prim_id[5]), (curve, 77));
    assert!(block.numbers.iter().all(|row| row[4].is_nan()));
    assert_eq!((size_of::<SphereBlock>(), size_of::<CubicCurveBlock>()), (160, 544));
}
