//! Lightmaps: irradiance at every texel of the pages that a level's surfaces are laid out on.
//!
//! The steps are those of Castaño's baker for The Witness (2010 to 2014), in the order of the modules: texture
//! coordinates ([`atlas`]), the point on a surface that stands for each texel (`texels`), moved where something covers
//! it (`covered`), its light (`baker`, `cached`), then what makes a map of it: less noise (`denoise`), gutters
//! (`dilate`) and borders of charts that cannot be seen (`seams`). A texel's value is irradiance E in W/m², on the
//! front of its surface; a white surface there reflects the radiance E/π.
//!
//! A bake depends on the scene, the options and the seed alone; one that was stopped goes on from its [`Checkpoint`]
//! and ends with the same bytes.

mod files;
mod finish;
mod layout;
mod light;
mod options;
mod result;
mod visibility;
mod warnings;

use glam::{Vec2, Vec3};

use crate::cache::{MORE_RECORDS, Record, missed_accuracy};
use crate::scene::Scene;
use crate::settings::{Invalid, Shard};
use crate::watch::Watch;
use crate::world::World;

use finish::denoise::denoise;
use finish::dilate::PageTexels;
pub use finish::errors::ErrorSummary;
use finish::errors::errors;
use finish::seams::{Seams, cuts};
use layout::atlas::{Atlas, NO_CHART};
use layout::edges::shared_edges;
use layout::texels::{Surfaces, Texel};
use light::baker::Baker;
use light::moments::DirectionalBasis;
use visibility::covered::{Uncovered, uncover};
use warnings::warnings;

pub use files::checkpoint::{Checkpoint, STATE_EXTENSION};
pub use files::hashes::{combined, hashes};
pub use files::picture::charts_picture;
pub use files::relocated::way;
pub use files::{gltf, manifest, obj, report};
pub use finish::dilate::TexelSource;
pub use layout::left_out::LeftOut;
pub use layout::room::{LayoutStep, LayoutWatch};
pub use layout::{atlas, check};
pub use options::{BakeOptions, Coordinates, Directional, Mode, Preset, Sampling};
pub use result::{Bake, Layer, Map, Statistics};
pub use warnings::model_warnings;

impl Atlas {
    /// Lays a scene's surfaces out on pages.
    ///
    /// # Errors
    /// If pages are too small or texels too many, if there is no surface, or if the model's own coordinates are to be
    /// kept and cannot be.
    pub fn new(scene: &Scene, options: &BakeOptions) -> Result<Self, Invalid> {
        Self::without(scene, &LeftOut::default(), options)
    }

    /// The same, of what is not left out: new coordinates of other triangles lie on one point.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn without(scene: &Scene, left_out: &LeftOut, options: &BakeOptions) -> Result<Self, Invalid> {
        Self::watched(scene, left_out, options, &|_| {})
    }

    /// The same; `watch` receives the progress, if new charts are made.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn watched(
        scene: &Scene,
        left_out: &LeftOut,
        options: &BakeOptions,
        watch: LayoutWatch,
    ) -> Result<Self, Invalid> {
        Self::build(scene, &shared_edges(scene), left_out, options, watch)
    }
}

/// Finds the light of all pages; `world` must be of `scene`, and `atlas` as well. `None` if the watcher stops: the
/// results so far are in the checkpoint. The watcher receives texels in place of samples, [`work`] in all.
pub fn bake(
    scene: &Scene,
    world: &World,
    atlas: Atlas,
    options: &BakeOptions,
    checkpoint: &Checkpoint,
    watch: &dyn Watch,
) -> Option<Bake> {
    let surfaces = Surfaces::new(scene, &atlas);
    let (lit, covered, uncovered) = free_texels(world, &surfaces);
    let light = Baker { world, surfaces: &surfaces, options, checkpoint, watch }.bake_texels(&lit)?;

    let mut page_texels = page_texels(&atlas, &lit, &covered);
    let names: Vec<&'static str> = std::iter::once("")
        .chain(DirectionalBasis::layers(options.directional).iter().copied())
        .take(light.layers())
        .collect();
    let mut layers: Vec<Vec<Vec<Vec3>>> = names.iter().map(|_| black(&atlas)).collect();
    for (texel, values) in lit.iter().zip(light.values()) {
        for (layer, value) in layers.iter_mut().zip(values) {
            layer[texel.page as usize][texel.index as usize] = *value;
        }
    }
    if options.denoise {
        smooth(world, &atlas, &page_texels, &lit, &mut layers);
    }
    for (page, grid) in page_texels.iter_mut().enumerate() {
        grid.add_gutters(options.padding());
        for mean in grid.means() {
            for layer in &mut layers {
                let sum: Vec3 = mean.of.iter().map(|&texel| layer[page][texel as usize]).sum();
                layer[page][mean.texel as usize] = sum / mean.of.len() as f32;
            }
        }
    }
    let cuts = cuts(&atlas, scene.meshes.len(), &shared_edges(scene));
    let brightness: Vec<Vec<f32>> =
        layers[0].iter().map(|page| page.iter().map(|value| value.element_sum()).collect()).collect();
    let seams = Seams::new(&atlas, &cuts, &page_texels, &brightness, options.sampling);
    seams.solve(&mut layers);
    for (layer, name) in layers.iter_mut().zip(&names) {
        // Harmonics have signs, all else has not.
        if !name.starts_with("sh.") {
            layer.iter_mut().flatten().for_each(|value| *value = value.max(Vec3::ZERO));
        }
    }

    let gutter =
        page_texels.iter().flat_map(|grid| &grid.sources).filter(|source| **source == TexelSource::Gutter).count();
    let (cache, usage) = light.cache.unzip();
    let errors = errors(world, &page_texels, &lit, cache.as_ref(), &layers[0]);
    let usage = usage.unwrap_or_default();
    // A record's key is the index of its texel.
    let place = |record: &Record| {
        let texel = &lit[record.key as usize];
        let size = atlas.pages[texel.page as usize];
        let (x, y) = (texel.index % size.width, texel.index / size.width);
        (texel.page as usize, (Vec2::new(x as f32, y as f32) + 0.5) / Vec2::new(size.width as f32, size.height as f32))
    };
    let record_places = cache.map(|cache| cache.records().iter().map(place).collect()).unwrap_or_default();
    let statistics = Statistics {
        texels: (lit.len() + covered.len()) as u64,
        gathers: light.gathers,
        rays: light.rays,
        moved: uncovered.moved,
        covered: uncovered.lost,
        gutter: gutter as u64,
        seams: seams.len() as u64,
        mixed: seams.mixed as u64,
        misses: usage.misses,
        negative: usage.negative,
    };
    let maps = maps(page_texels, layers, errors, &names);
    let mixed: Vec<usize> = seams.mixed_meshes.into_iter().collect();
    let mut warnings = warnings(world, options, &maps, &statistics, &mixed);
    let asked = options.cache.accuracy.zip(light.error);
    warnings.extend(asked.and_then(|(asked, estimated)| missed_accuracy(asked, estimated, MORE_RECORDS)));
    Some(Bake { atlas, maps, record_places, statistics, warnings, accuracy: light.error })
}

/// Computes the light of a shard's texels that needs no irradiance cache, and keeps it in the checkpoint: direct light,
/// ambient occlusion, or all of a bake without a cache. A bake that continues from the checkpoints of all shards,
/// [merged](Checkpoint::merge), ends with the bytes of one without shards. Whether it came to its end before the
/// watcher stopped. The watcher receives texels in place of samples, [`shard_work`] in all.
pub fn bake_shard(
    scene: &Scene,
    world: &World,
    atlas: &Atlas,
    options: &BakeOptions,
    checkpoint: &Checkpoint,
    shard: Shard,
    watch: &dyn Watch,
) -> bool {
    let surfaces = Surfaces::new(scene, atlas);
    let (lit, ..) = free_texels(world, &surfaces);
    Baker { world, surfaces: &surfaces, options, checkpoint, watch }.bake_shard(&lit, shard).is_some()
}

/// The approximate number of texels that a shard reports to its watcher.
pub fn shard_work(scene: &Scene, atlas: &Atlas, shard: Shard) -> u64 {
    shard.items(Surfaces::new(scene, atlas).texels().len()) as u64
}

/// The texels that have light of their own, those that something covers as a whole, and how many of both.
fn free_texels(world: &World, surfaces: &Surfaces) -> (Vec<Texel>, Vec<Texel>, Uncovered) {
    let mut texels = surfaces.texels();
    let (is_free, uncovered) = uncover(world, surfaces, &mut texels);
    let (mut lit, mut covered) = (Vec::new(), Vec::new());
    for (texel, is_free) in texels.into_iter().zip(is_free) {
        if is_free { lit.push(texel) } else { covered.push(texel) }
    }
    (lit, covered, uncovered)
}

/// The approximate number of texels that a bake reports to its watcher: those on surfaces, once for each cache that
/// serves them.
pub fn work(scene: &Scene, atlas: &Atlas, options: &BakeOptions) -> u64 {
    let texels = Surfaces::new(scene, atlas).texels().len() as u64;
    let by_cache = options.has_cache();
    texels * (1 + u64::from(by_cache) + u64::from(by_cache && options.cache.bounces.is_none()))
}

/// The data of each page's texels.
fn page_texels(atlas: &Atlas, lit: &[Texel], covered: &[Texel]) -> Vec<PageTexels> {
    let grid = |page: &atlas::Page| PageTexels {
        page: *page,
        owners: vec![NO_CHART; page.texels()],
        sources: vec![TexelSource::Nothing; page.texels()],
    };
    let mut page_texels: Vec<PageTexels> = atlas.pages.iter().map(grid).collect();
    let mut set = |texel: &Texel, source| {
        let grid = &mut page_texels[texel.page as usize];
        grid.owners[texel.index as usize] = texel.chart;
        grid.sources[texel.index as usize] = source;
    };
    lit.iter().for_each(|texel| set(texel, TexelSource::Light));
    covered.iter().for_each(|texel| set(texel, TexelSource::Covered));
    page_texels
}

/// A black layer.
fn black(atlas: &Atlas) -> Vec<Vec<Vec3>> {
    atlas.pages.iter().map(|page| vec![Vec3::ZERO; page.texels()]).collect()
}

/// Takes noise out of all pages.
fn smooth(world: &World, atlas: &Atlas, page_texels: &[PageTexels], lit: &[Texel], layers: &mut [Vec<Vec<Vec3>>]) {
    let mut normals = black(atlas);
    for texel in lit {
        let normal = world.receiver(texel.point.prim_id, texel.point.barycentric).shading_normal;
        normals[texel.page as usize][texel.index as usize] = normal;
    }
    for (page, grid) in page_texels.iter().enumerate() {
        let mut of_page: Vec<Vec<Vec3>> = layers.iter_mut().map(|layer| std::mem::take(&mut layer[page])).collect();
        denoise(grid, &normals[page], &mut of_page, atlas.charts.len());
        layers.iter_mut().zip(of_page).for_each(|(layer, smoothed)| layer[page] = smoothed);
    }
}

/// Puts layers together by page.
fn maps(
    page_texels: Vec<PageTexels>,
    layers: Vec<Vec<Vec<Vec3>>>,
    errors: Vec<Vec<f32>>,
    names: &[&'static str],
) -> Vec<Map> {
    let map = |(grid, errors): (PageTexels, Vec<f32>)| Map {
        layers: Vec::new(),
        owners: grid.owners,
        sources: grid.sources,
        errors,
    };
    let mut maps: Vec<Map> = page_texels.into_iter().zip(errors).map(map).collect();
    for (pages, &name) in layers.into_iter().zip(names) {
        for (map, texels) in maps.iter_mut().zip(pages) {
            map.layers.push(Layer { name, texels });
        }
    }
    maps
}

#[cfg(test)]
mod tests;
