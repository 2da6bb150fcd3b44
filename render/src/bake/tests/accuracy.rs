//! How near bakes from few gathers come to gathers at each texel.

use rayon::prelude::*;

use super::*;
use crate::estimator::GatherPoint;
use crate::integrator::{self, Uncached};
use crate::settings::{CachedOptions, Metric};

#[test]
#[ignore = "scratch"]
fn scratch_accuracy() {
    let room = scene(
        vec![
            hollow("room", Vec3::ZERO, vec3(1.0, 1.0, 1.0), true),
            hollow("crate", vec3(0.55, 0.0, 0.2), vec3(0.85, 0.4, 0.5), false),
            Mesh { material: 1, ..hollow("lamp", vec3(0.2, 0.9, 0.3), vec3(0.5, 0.95, 0.7), false) },
        ],
        vec![glowing(0.0, 0.6), glowing(10.0, 0.0)],
    );
    let mut options = BakeOptions { mode: Mode::Indirect, size: 256, ..BakeOptions::default() };
    let atlas = Atlas::new(&room, &options).unwrap();
    let world = World::new(room.clone()).unwrap();
    let surfaces = Surfaces::new(&room, &atlas);
    let mut texels = surfaces.texels();
    let (is_free, _) = uncover(&world, &surfaces, &mut texels);
    let some: Vec<Texel> =
        texels.iter().zip(is_free).filter(|(_, is_free)| *is_free).map(|(texel, _)| *texel).step_by(97).collect();
    let path = std::path::Path::new("/tmp/bake-reference.bin");
    let reference: Vec<f32> = match std::fs::read(path) {
        Ok(bytes) => bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect(),
        Err(_) => {
            let found: Vec<f32> = some
                .par_iter()
                .enumerate()
                .map(|(key, texel)| {
                    let many = CachedOptions { rays: 1 << 17, ..CachedOptions::default() };
                    let surface = world.receiver(texel.point.prim_id, texel.point.barycentric);
                    let source = integrator::Source::paths(&many);
                    Uncached::new(&world, &many, source, 99).irradiance(&[GatherPoint { key: key as u64, surface }]).0
                        [0]
                    .x
                })
                .collect();
            std::fs::write(path, found.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
            found
        }
    };
    println!("{} texels, {} compared", texels.len(), some.len());
    let mean = reference.iter().sum::<f32>() / reference.len() as f32;
    let list = std::env::var("LIST").unwrap_or_default();
    for words in list.split(';') {
        let w: Vec<&str> = words.split(',').collect();
        options.cache.rays = w[0].parse().unwrap();
        options.cache.error = w[1].parse().unwrap();
        options.brute = w[2] == "brute";
        options.cache.metric = Metric::ALL.into_iter().find(|m| m.name() == w[3]).unwrap();
        let start = std::time::Instant::now();
        let bake = baked(&room, &options);
        let time = start.elapsed().as_secs_f32();
        let found = |texel: &Texel| bake.maps[texel.page as usize].layers[0].texels[texel.index as usize].x;
        let relative = |(texel, exact): (&Texel, &f32)| (found(texel) - exact) / exact.max(0.1 * mean);
        let errors: Vec<f32> = some.iter().zip(&reference).map(relative).collect();
        let bias = errors.iter().sum::<f32>() / errors.len() as f32;
        let rms = (errors.iter().map(|error| error * error).sum::<f32>() / errors.len() as f32).sqrt();
        let mut sorted: Vec<f32> = errors.iter().map(|e| e.abs()).collect();
        sorted.sort_by(f32::total_cmp);
        let median = sorted[sorted.len() / 2];
        let most = sorted[sorted.len() * 99 / 100];
        let share = bake.statistics.gathers as f64 / bake.statistics.texels as f64;
        println!(
            "{words}: share {share:.4} rms {rms:.4} p99 {most:.4} median {median:.4} bias {bias:.4} misses {} rays {:.1}M {time:.1}s",
            bake.statistics.misses,
            bake.statistics.rays as f64 / 1e6
        );
        if w.len() > 4 {
            let mut worst: Vec<usize> = (0..some.len()).collect();
            worst.sort_by(|a, b| errors[*b].abs().total_cmp(&errors[*a].abs()));
            for i in &worst[..15] {
                let s = world.receiver(some[*i].point.prim_id, some[*i].point.barycentric);
                println!(
                    "   {:?} {:?} {:.3} of {:.3} spacing {}",
                    s.position, s.normal, errors[*i], reference[*i], some[*i].spacing
                );
            }
        }
    }
}
