//! Numbers of the samplers, what warps and frames make of them, and what gathers sum up, with every instruction set.

use super::scenes::Scene;
use super::{Checksum, compare};
use crate::irradiance::{Hemicube, Layout, Stratified};
use crate::sampling::warp::{
    ConcentricDisc, ConcentricHemisphere, Cone, CosineHemisphere, MalleyHemisphere, PolarDisc, PowerCosineHemisphere,
    Triangle, UniformHemisphere, UniformSphere, Warp,
};
use crate::sampling::{
    AliasEntry, AliasTable, Frame, Pattern, SampleId, Strata, Stream, fill2, fill4, sin_cos_turns, unit_double,
};
use crate::simd::isas;
use crate::{Isa, offset_origin, triangle_normal};
use glam::{Vec2, Vec3};

#[test]
fn numbers_are_those_that_are_kept() {
    let mut lines = vec!["# what, FNV-1a of the bits".to_owned()];
    let mut add = |name: &str, floats: &dyn Fn(Isa) -> Vec<f32>| {
        let mut sums = isas().map(|isa| (isa, Checksum::of_floats(floats(isa))));
        let (_, first) = sums.next().unwrap();
        sums.for_each(|(isa, sum)| assert_eq!(first, sum, "{name}, {}", isa.level()));
        lines.push(format!("{name} {first}"));
    };
    for (name, pattern) in [("random", Pattern::Random), ("sobol", Pattern::Sobol), ("r2", Pattern::R2)] {
        add(name, &|isa| samples(isa, pattern));
    }
    add("sin-cos", &|_| pairs().iter().flat_map(|u| <[f32; 2]>::from(sin_cos_turns(u.x))).collect());
    add("disc-polar", &|isa| warp2(isa, PolarDisc));
    add("disc-concentric", &|isa| warp2(isa, ConcentricDisc));
    add("triangle", &|isa| warp2(isa, Triangle));
    add("sphere", &|isa| warp3(isa, UniformSphere));
    add("hemisphere-uniform", &|isa| warp3(isa, UniformHemisphere));
    add("hemisphere-concentric", &|isa| warp3(isa, ConcentricHemisphere));
    add("hemisphere-cosine", &|isa| warp3(isa, CosineHemisphere));
    add("hemisphere-malley", &|isa| warp3(isa, MalleyHemisphere));
    add("hemisphere-power", &|isa| warp3(isa, PowerCosineHemisphere { exponent: 7.5 }));
    add("cone", &|isa| warp3(isa, Cone::from_angle(0.3)));
    add("frames", &frames);
    add("alias", &|_| alias());
    add("origins", &|_| origins());
    add("gather-strata", &|isa| {
        let strata = Strata::new(13, 41).unwrap();
        gather(&Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)]).unwrap().with_isa(isa))
    });
    add("gather-hemicube", &|isa| {
        gather(&Hemicube::new(18, vec![0.0; Hemicube::table_len(18)]).unwrap().with_isa(isa))
    });
    compare("numbers", include_str!("../../../tests/checksums/numbers.txt"), &lines);
}

/// Pairs and sets of four of many samples of a few pixels, and of few samples of many pixels.
fn samples(isa: Isa, pattern: Pattern) -> Vec<f32> {
    let few = (0..4000).map(|i| SampleId { pixel: i / 1000, sample: i % 1000 });
    let addresses: Vec<_> = few.chain((0..1001).map(|pixel| SampleId { pixel, sample: !pixel })).collect();
    let (mut pairs, mut fours) = (vec![Vec2::ZERO; addresses.len()], vec![[0.0; 4]; addresses.len()]);
    fill2(isa, pattern, 42, 3, &addresses, &mut pairs);
    fill4(isa, pattern, u64::MAX, 7, &addresses, &mut fours);
    pairs.iter().flat_map(|pair| pair.to_array()).chain(fours.into_iter().flatten()).collect()
}

fn pairs() -> Vec<Vec2> {
    (0..5003).map(|i| Stream::new(8, i, 0).uniform2(0)).collect()
}

fn warp2(isa: Isa, warp: impl Warp<Point = Vec2>) -> Vec<f32> {
    let (u, mut points) = (pairs(), vec![Vec2::ZERO; 5003]);
    warp.map_many(isa, &u, &mut points);
    points.iter().flat_map(|&p| [p.x, p.y, warp.pdf(p)].into_iter().chain(warp.inverse(p).to_array())).collect()
}

fn warp3(isa: Isa, warp: impl Warp<Point = Vec3>) -> Vec<f32> {
    let (u, mut points) = (pairs(), vec![Vec3::ZERO; 5003]);
    warp.map_many(isa, &u, &mut points);
    points.iter().flat_map(|&p| [p.x, p.y, p.z, warp.pdf(p)].into_iter().chain(warp.inverse(p).to_array())).collect()
}

fn frames(isa: Isa) -> Vec<f32> {
    let normals: Vec<Vec3> = pairs().into_iter().map(|u| UniformSphere.map(u)).collect();
    let mut frames = vec![Frame::from_normal(Vec3::Z); normals.len()];
    Frame::from_normals(isa, &normals, &mut frames);
    frames.iter().flat_map(|frame| [frame.tangent, frame.bitangent, frame.normal]).flat_map(|v| v.to_array()).collect()
}

fn alias() -> Vec<f32> {
    let weights: Vec<f32> = pairs().iter().map(|u| u.x * u.x * u.y).collect();
    let none = AliasEntry { probability: 0.0, alias: 0, mass: 0.0 };
    let table = AliasTable::build(&weights, vec![none; weights.len()]).unwrap();
    let draws = pairs().into_iter().map(|u| table.sample(unit_double(u)));
    draws.flat_map(|(index, mass, rest)| [index as f32, mass, rest as f32]).collect()
}

/// Where rays start that leave the triangles of all scenes.
fn origins() -> Vec<f32> {
    let triangles = Scene::all().into_iter().flat_map(|scene| scene.triangles);
    let within_limits = triangles.filter(|triangle| triangle.iter().all(|p| p.abs().max_element() <= 1e6));
    let origin = |triangle| {
        let normal = triangle_normal(&triangle);
        offset_origin(&triangle, normal, 0.3, 0.45, Vec3::new(0.5, -0.25, 1.0))
    };
    within_limits.map(origin).flat_map(|p| p.to_array()).collect()
}

/// What a layout makes of light and distances from all sides, some of them none.
fn gather(layout: &impl Layout) -> Vec<f32> {
    let cells = layout.cells();
    let mut directions = vec![Vec3::ZERO; cells];
    layout.directions(&mut |cell| Stream::new(1, cell as u32, 0).uniform2(0), &mut directions).unwrap();
    let found: Vec<[f32; 4]> = (0..cells as u32).map(|cell| Stream::new(2, cell, 0).uniform4(0)).collect();
    let radiance: Vec<Vec3> = found.iter().map(|&[r, g, b, _]| Vec3::new(r, g, b)).collect();
    let distance: Vec<f32> = found.iter().map(|&[.., t]| if t < 0.9 { 0.1 + t } else { f32::INFINITY }).collect();
    let gather = layout.accumulate(&radiance, &distance).unwrap();
    let hessian = layout.hessian(&directions, &radiance, &distance).unwrap();
    let ellipse = hessian.radii(0.1);
    let mut vectors = directions;
    vectors.push(gather.irradiance);
    vectors.extend(gather.rotational);
    vectors.extend(gather.translational);
    vectors.extend(ellipse.axes);
    let mut floats: Vec<f32> = vectors.iter().flat_map(|v| v.to_array()).collect();
    floats.extend([gather.harmonic_mean_distance, gather.minimum_distance, hessian.xx, hessian.xy, hessian.yy]);
    floats.extend(ellipse.radii);
    floats
}
