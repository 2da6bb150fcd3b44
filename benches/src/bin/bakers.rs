//! Bakes the Cornell box's lightmap with our baker and with Blender's Cycles, one thread each, onto the same texels,
//! and prints the time of each for the same error.
//!
//! `setup-renderers.sh` installs Cycles; without it only our line is printed. Errors are relative to each texel's
//! irradiance, root mean square over the texels whose neighbours lie on the same chart, against two bakes of ours in
//! which each texel gathers for itself, by paths: `mean((x - a)(x - b))` is free of their noise. `brighter` shows that
//! Cycles' maps converge to them too. Cycles' error falls with the root of its samples while it is noise: the time for
//! our error follows from that.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use clap::Parser;
use glam::Vec3;
use halfdome::bake::atlas::{Atlas, NO_CHART};
use halfdome::bake::{self, Bake, BakeOptions, Checkpoint, TexelSource};
use halfdome::driver::Watch;
use halfdome::scene::{Scene, cornell_box};
use halfdome::world::World;
use rayon::ThreadPoolBuilder;
use serde_json::{Value, json};

/// What went wrong, from whatever thread.
type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Irradiance counts as at least this part of the mean where errors are relative to it.
const DARK: f64 = 0.1;

/// Compares our baker with Cycles.
#[derive(Parser)]
struct Options {
    /// Texels across and down the map
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(16..=4096))]
    size: u32,
    /// Samples a texel of Cycles, once each
    #[arg(long, value_name = "N", num_args = 1.., default_values_t = [64, 256])]
    spp: Vec<u32>,
    /// Rays of a gather of each of the two references, and four times their samples of direct light
    #[arg(long, value_name = "N", default_value_t = 4096)]
    reference: u32,
}

/// A map, and how long it took.
struct Timed {
    name: String,
    /// E/π of each texel; `None` where nothing lies.
    texels: Vec<Option<Vec3>>,
    seconds: f64,
}

fn main() -> ExitCode {
    match compare(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn compare(options: &Options) -> Result<(), Failure> {
    let scene = cornell_box();
    let defaults = BakeOptions { size: options.size, ..BakeOptions::default() };
    let reference = |seed| -> Result<Timed, Failure> {
        let mut options = BakeOptions { brute: true, spp: options.reference / 4, seed, ..defaults.clone() };
        options.cache.rays = 4 * options.spp;
        Ok(ours("reference", &scene, &options, 0)?.1)
    };
    let references = [reference(1)?, reference(2)?];
    println!("The references are there.");
    let (bake, own) = ours("halfdome", &scene, &defaults, 1)?;
    let inner = inner(&bake);
    let ours = Distance::of(&own, &references, &inner);
    println!("{} texels are compared", inner.len());
    println!("{:<16} {:>8} {:>8} {:>9} {:>24}", "", "seconds", "error", "brighter", "seconds for our error");
    println!("{}", ours.line(&own, own.seconds));
    match cycles(&scene, &bake.atlas, &options.spp) {
        Ok(maps) => {
            for map in maps {
                let error = Distance::of(&map, &references, &inner);
                println!("{}", error.line(&map, map.seconds * (error.rms / ours.rms).powi(2)));
            }
        }
        Err(error) => eprintln!("no Cycles: {error}"),
    }
    Ok(())
}

/// Our bake on so many threads, 0 for as many as there are.
fn ours(name: &str, scene: &Scene, options: &BakeOptions, threads: usize) -> Result<(Bake, Timed), Failure> {
    struct NeverStops;
    impl Watch for NeverStops {
        fn advance(&self, _: u64, _: u64) {}
        fn stop(&self) -> bool {
            false
        }
    }
    let atlas = Atlas::new(scene, options).map_err(|error| error.problem)?;
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    pool.install(|| {
        let start = Instant::now();
        let world = World::new(scene.clone())?;
        let bake =
            bake::bake(scene, &world, atlas, options, &Checkpoint::new(0), &NeverStops).ok_or("it was stopped")?;
        let seconds = start.elapsed().as_secs_f64();
        let map = &bake.maps[0];
        let texel = |(value, source): (&Vec3, &TexelSource)| {
            (*source == TexelSource::Light).then_some(*value * std::f32::consts::FRAC_1_PI)
        };
        let texels = map.layers[0].texels.iter().zip(&map.sources).map(texel).collect();
        Ok((bake, Timed { name: name.to_owned(), texels, seconds }))
    })
}

/// The texels with light whose neighbours are on the same chart, and have light too.
fn inner(bake: &Bake) -> Vec<usize> {
    let (map, width) = (&bake.maps[0], bake.atlas.pages[0].width as usize);
    let is_inner = |&texel: &usize| {
        let near = [texel.wrapping_sub(width), texel.wrapping_sub(1), texel, texel + 1, texel + width];
        let is_own = |&texel: &usize| map.sources.get(texel) == Some(&TexelSource::Light);
        map.owners[texel] != NO_CHART
            && near.iter().all(is_own)
            && near.iter().all(|&other| map.owners[other] == map.owners[texel])
    };
    (0..map.owners.len()).filter(is_inner).collect()
}

/// How far a map is from the references.
struct Distance {
    rms: f64,
    /// By how much it is brighter on the whole.
    brighter: f64,
}

impl Distance {
    fn of(map: &Timed, [a, b]: &[Timed; 2], texels: &[usize]) -> Self {
        let value = |map: &Timed, texel: usize| map.texels[texel].map(|value| f64::from(value.element_sum()));
        let of_texel = |&texel: &usize| Some([value(map, texel)?, value(a, texel)?, value(b, texel)?]);
        let values: Vec<[f64; 3]> = texels.iter().filter_map(of_texel).collect();
        let mean = |of: &dyn Fn(&[f64; 3]) -> f64| values.iter().map(of).sum::<f64>() / values.len() as f64;
        let exact = mean(&|[_, a, b]| 0.5 * (a + b));
        let square = |[x, a, b]: &[f64; 3]| (x - a) * (x - b) / (0.5 * (a + b)).max(DARK * exact).powi(2);
        Self { rms: mean(&square).max(0.0).sqrt(), brighter: mean(&|values| values[0]) / exact - 1.0 }
    }

    fn line(&self, map: &Timed, for_our_error: f64) -> String {
        let (rms, brighter) = (100.0 * self.rms, 100.0 * self.brighter);
        format!("{:<16} {:>8.2} {rms:>7.2}% {brighter:>+8.2}% {for_our_error:>24.2}", map.name, map.seconds)
    }
}

/// Cycles' maps on the same texels, one for each number of samples.
fn cycles(scene: &Scene, atlas: &Atlas, spp: &[u32]) -> Result<Vec<Timed>, Failure> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = root.join("../target/renderers/bin/python");
    if !python.is_file() {
        return Err("run benches/setup-renderers.sh".into());
    }
    let folder = tempfile::tempdir()?;
    let (file, picture) = (folder.path().join("level.json"), folder.path().join("map"));
    fs::write(&file, description(scene, atlas).to_string())?;
    let mut process = Command::new(python)
        .arg(root.join("renderers/cycles_baker.py"))
        .arg(&file)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let mut requests = process.stdin.take().ok_or("it has no input")?;
    // A first map that does not count.
    let asked: Vec<u32> = std::iter::once(1).chain(spp.iter().copied()).collect();
    for (number, spp) in asked.iter().enumerate() {
        let picture = picture.with_extension(number.to_string());
        writeln!(requests, "{}", json!({ "spp": spp, "seed": number, "picture": picture }))?;
    }
    drop(requests);
    let output = process.wait_with_output()?;
    let answers = str::from_utf8(&output.stdout)?.lines();
    let answers = answers.map(serde_json::from_str).collect::<Result<Vec<Value>, _>>()?;
    let mut maps = Vec::new();
    // After the header line.
    for (number, (spp, answer)) in asked.iter().zip(answers.iter().skip(1)).enumerate().skip(1) {
        let seconds = answer["seconds"].as_f64().ok_or_else(|| format!("it gives no time: {answer}"))?;
        let bytes = fs::read(picture.with_extension(number.to_string()))?;
        let numbers: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|&value| f32::from_ne_bytes(value)).collect();
        let texels = numbers.as_chunks::<4>().0.iter().map(|&[r, g, b, a]| (a > 0.0).then_some(Vec3::new(r, g, b)));
        maps.push(Timed { name: format!("Cycles, {spp} spp"), texels: texels.collect(), seconds });
    }
    if maps.len() == spp.len() { Ok(maps) } else { Err(format!("it ended early: {}", output.status).into()) }
}

/// The level as JSON for `cycles_baker.py`.
fn description(scene: &Scene, atlas: &Atlas) -> Value {
    let meshes = atlas.parts.iter().map(|part| {
        let mesh = &scene.meshes[part.mesh];
        let material = &scene.materials[mesh.material];
        let corner = |vertex: &bake::atlas::Vertex| mesh.positions[vertex.source as usize].to_array();
        json!({
            "name": mesh.name,
            "positions": part.vertices.iter().map(corner).collect::<Vec<_>>(),
            "coordinates": part.vertices.iter().map(|vertex| vertex.uv.to_array()).collect::<Vec<_>>(),
            "triangles": part.triangles,
            "diffuse": material.inputs.base_color.to_array(),
            "emission": material.emission.to_array(),
        })
    });
    let page = atlas.pages[0];
    // Bounces until roulette, as our paths have them.
    json!({ "width": page.width, "height": page.height, "sure_bounces": 2, "meshes": meshes.collect::<Vec<_>>() })
}
