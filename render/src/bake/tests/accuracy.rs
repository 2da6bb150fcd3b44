//! How near a bake from few gathers comes to gathers at each texel.

use rayon::prelude::*;

use super::*;
use crate::estimator::GatherPoint;
use crate::integrator::{self, Uncached};
use crate::settings::CachedOptions;

/// Rays of each of the two gathers at a texel that others are held against.
const MANY: u32 = 1 << 15;

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
    let many = CachedOptions { rays: MANY, ..CachedOptions::default() };
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
            let uncached = Uncached::new(&world, &many, integrator::GatherSource::paths(&many), seed);
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
        let rms = (errors.iter().map(|[a, b]| a * b).sum::<f32>() / errors.len() as f32).sqrt();
        let mut sizes: Vec<f32> = errors.iter().map(|[a, b]| 0.5 * (a + b).abs()).collect();
        sizes.sort_by(f32::total_cmp);
        let of_99 = sizes[sizes.len() * 99 / 100];
        let share = bake.statistics.gathers as f64 / bake.statistics.texels as f64;
        println!("--cache-error {cache_error}: {share:.3} gathers a texel, RMSE {rms:.4}, of 99% {of_99:.4}");
        assert!(share < most_gathers && rms < most_rms && of_99 < most_of_99);
    }
}
