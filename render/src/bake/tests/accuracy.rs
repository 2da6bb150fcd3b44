//! The error of a bake from few gathers against gathers at each texel.

use rayon::prelude::*;

use super::*;
use crate::estimator::GatherPoint;
use crate::integrator::{self, DirectGatherer};
use crate::settings::CachedOptions;

/// Rays of each of the two gathers at a texel that others are held against.
const REFERENCE_RAYS: u32 = 1 << 13;

/// Castaño's gathers: one for six texels or fewer tells as much as one for each, one for thirty nearly as much.
///
/// Errors are relative to a texel's irradiance, or to a tenth of the mean where that is more. What is true is not known
/// without noise either; but that of two gathers is independent, and `mean((x - a)(x - b))` is free of it.
#[test]
fn a_cache_tells_what_gathers_do() {
    let room = scene(
        vec![
            hollow("room", Vec3::ZERO, vec3(1.0, 1.0, 1.0), true),
            hollow("crate", vec3(0.55, 0.0, 0.2), vec3(0.85, 0.4, 0.5), false),
            Mesh { material: 1, ..hollow("lamp", vec3(0.2, 0.9, 0.3), vec3(0.5, 0.95, 0.7), false) },
        ],
        vec![glowing(0.0, 0.6), glowing(10.0, 0.0)],
    );
    let world = World::new(room.clone()).unwrap();
    let many = CachedOptions { rays: REFERENCE_RAYS, ..CachedOptions::default() };
    let mut options = BakeOptions { mode: Mode::Indirect, size: 512, ..BakeOptions::default() };
    let atlas = Atlas::new(&room, &options).unwrap();
    let surfaces = Surfaces::new(&room, &atlas);
    let mut texels = surfaces.texels();
    let (is_free, _) = uncover(&world, &surfaces, &mut texels);
    let free = texels.iter().zip(is_free).filter(|(_, is_free)| *is_free);
    let some: Vec<Texel> = free.map(|(texel, _)| *texel).step_by(texels.len() / 200).collect();
    let gathered = |seed: u64| -> Vec<f32> {
        let irradiance = |(key, texel): (usize, &Texel)| {
            let surface = world.receiver(texel.point.prim_id, texel.point.barycentric);
            let uncached = DirectGatherer::new(&world, &many, integrator::GatherSource::paths(&many), seed);
            uncached.irradiance(&[GatherPoint { key: key as u64, surface }]).0[0].x
        };
        some.par_iter().enumerate().map(irradiance).collect()
    };
    let exact: Vec<[f32; 2]> = gathered(98).into_iter().zip(gathered(99)).map(|(a, b)| [a, b]).collect();
    let mean = exact.iter().flatten().sum::<f32>() / (2 * exact.len()) as f32;
    for (cache_error, most_gathers, most_rms, most_of_99) in [(0.2, 0.15, 0.01, 0.04), (0.6, 0.035, 0.04, 0.12)] {
        options.cache.error = cache_error;
        let bake = baked(&room, &options);
        let found = |texel: &Texel| bake.maps[texel.page as usize].layers[0].texels[texel.index as usize].x;
        let errors: Vec<[f32; 2]> = some
            .iter()
            .zip(&exact)
            .map(|(texel, exact)| {
                let scale = (0.5 * (exact[0] + exact[1])).max(0.1 * mean);
                exact.map(|exact| (found(texel) - exact) / scale)
            })
            .collect();
        // Below zero where the error is less than noise can tell.
        let rms = (errors.iter().map(|[a, b]| a * b).sum::<f32>() / errors.len() as f32).max(0.0).sqrt();
        let mut sizes: Vec<f32> = errors.iter().map(|[a, b]| 0.5 * (a + b).abs()).collect();
        sizes.sort_by(f32::total_cmp);
        let of_99 = sizes[sizes.len() * 99 / 100];
        let share = bake.statistics.gathers as f64 / bake.statistics.texels as f64;
        println!("--cache-error {cache_error}: {share:.3} gathers a texel, RMSE {rms:.4}, of 99% {of_99:.4}");
        assert!(share < most_gathers && rms < most_rms && of_99 < most_of_99);
    }
}

/// The position and normal of each texel, and the ratio of its indirect light to what gathers at each texel find.
fn indirect_by_gathers(room: &Scene, density: f32) -> Vec<(Vec3, Vec3, f32)> {
    let mut options = BakeOptions { mode: Mode::Indirect, density: Some(density), ..BakeOptions::default() };
    let [by_cache, by_gathers] = [false, true].map(|brute| {
        options.brute = brute;
        options.cache.rays = if brute { 2048 } else { CachedOptions::default().rays };
        baked(room, &options)
    });
    let world = World::new(room.clone()).unwrap();
    let atlas = Atlas::new(room, &options).unwrap();
    let texels = Surfaces::new(room, &atlas).texels();
    let ratio = |texel: &Texel| {
        let surface = world.receiver(texel.point.prim_id, texel.point.barycentric);
        let value = |bake: &Bake| bake.maps[texel.page as usize].layers[0].texels[texel.index as usize].x;
        (surface.position, surface.normal, value(&by_cache) / value(&by_gathers))
    };
    texels.iter().map(ratio).collect()
}

/// Records of the dark behind what hangs close in front of a wall serve neither its front nor the wall beside it.
#[test]
fn things_close_in_front_of_a_wall_are_as_bright_as_by_gathers() {
    const DEPTH: f32 = 0.005;
    for gap in [0.002, 0.01] {
        let room = scene(
            vec![
                hollow("room", Vec3::ZERO, vec3(4.0, 2.6, 4.0), true),
                hollow("poster", vec3(1.5, 1.0, gap), vec3(2.5, 1.7, gap + DEPTH), false),
                Mesh { material: 1, ..hollow("lamp", vec3(1.6, 2.3, 1.6), vec3(2.4, 2.32, 2.4), false) },
            ],
            vec![glowing(0.0, 0.7), glowing(10.0, 0.0)],
        );
        let ratios = indirect_by_gathers(&room, 4.0);
        let of = |is_one: &dyn Fn(Vec3) -> bool| -> Vec<f32> {
            let of_one =
                |&(position, normal, ratio): &(Vec3, Vec3, f32)| (normal.z > 0.9 && is_one(position)).then_some(ratio);
            ratios.iter().filter_map(of_one).collect()
        };
        let front = of(&|position| position.z > gap);
        let mean = front.iter().sum::<f32>() / front.len() as f32;
        assert!(front.len() > 8 && (mean - 1.0).abs() < 0.03, "gap {gap}: {mean}");
        // Texels whose middle is outside.
        let beside = of(&|Vec3 { x, y, z }| {
            z < 1e-4 && x > 1.1 && x < 2.9 && y > 0.6 && y < 2.1 && !(x > 1.45 && x < 2.55 && y > 0.95 && y < 1.75)
        });
        let darkest = beside.iter().copied().fold(f32::INFINITY, f32::min);
        assert!(beside.len() > 12 && darkest > 0.8, "gap {gap}: {darkest}");
    }
}

/// Panels that shine at the ceiling close above them, too: what is bright in the gap does not light the room.
#[test]
fn lit_gaps_do_not_shine_at_the_room() {
    let panel = |x: f32, z: f32| Mesh {
        material: 1,
        ..hollow("panel", vec3(x, 2.394, z), vec3(x + 0.3, 2.395, z + 0.6), false)
    };
    let panels = [(0.5, 0.4), (0.5, 1.8), (1.7, 0.4), (1.7, 1.8)].map(|(x, z)| panel(x, z));
    let room = hollow("room", Vec3::ZERO, vec3(2.6, 2.4, 2.9), true);
    let room = scene([&[room][..], &panels].concat(), vec![glowing(0.0, 0.7), glowing(10.0, 0.0)]);
    let ratios = indirect_by_gathers(&room, 6.0);
    let floor = ratios.iter().filter(|(position, normal, _)| position.y < 1e-3 && normal.y > 0.9);
    let floor: Vec<f32> = floor.map(|(.., ratio)| *ratio).collect();
    let mean = floor.iter().sum::<f32>() / floor.len() as f32;
    assert!(floor.len() > 200 && (mean - 1.0).abs() < 0.025, "{mean}");
}
