//! Candidate positions of records: camera hits, given points, and the hits of their gathers' rays.

use glam::Vec3;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use rayon::prelude::*;

use super::clearance::{lookup_point, lookup_point_anywhere};
use super::level::RecordSite;
use super::spacing::spacings;
use crate::cache::{Bounds, Pass, Place};
use crate::camera::{Camera, FilmPoint};
use crate::estimator::GatherPoint;
use crate::settings::Settings;
use crate::world::{Hit, Surface, World};

/// Steps between the camera's sites, in pixels.
const STEPS: [u32; 6] = [64, 32, 16, 8, 4, 2];
/// The fewest pixels that a record reaches where the camera sees it, over the error: in corners this limit decides the
/// number of records, which should fall with a greater error as it does elsewhere ...
const LEAST_PIXELS: f32 = 6.0;
/// ... but no fewer than these, so that most of the pixels beside a site are within the reach of its record ...
const LEAST_FOR_ALL: f32 = 1.75;
/// ... and the most pixels.
const MOST_PIXELS: f32 = 40.0;
/// Parts of the scene's diagonal that make up the unit of spacing where there is no camera ...
const PARTS: f32 = 1024.0;
/// ... if sites are no nearer to each other than so many, ...
const UNITS_APART: f32 = 5.0;
/// ... and the greatest part of the diagonal that a record reaches.
const MOST_OF_DIAGONAL: f32 = 160.0 / 1024.0;
/// The least part of the diagonal that a unit is, as floats have so many digits.
const LEAST_OF_DIAGONAL: f32 = 1e-7;
/// The index of the neighbour, among the random neighbours of a ray's site, whose distance is used.
const DEEPER_NEIGHBOUR: usize = 4;
/// Rays by which a site finds sites for the next deeper cache.
const DEEPER_RAYS: u32 = 8;
/// The most sites that send rays.
const MAX_DEEPER_SITES: usize = 8192;
/// The most surfaces that a camera's ray may meet.
const MAX_SURFACES: u32 = 16;
/// The least part of light for which what glossy surfaces show gets sites.
const LEAST_SHARE: f32 = 0.02;
/// Keys of sites seen in mirrors begin with the number of mirrors.
const DEPTH_SHIFT: u32 = 48;
/// Keys of deeper caches begin with the number of reflections.
const LEVEL_SHIFT: u32 = 56;

/// The camera's hits through the middles of pixels in ever finer grids: sites, a pass or two for each grid, and the
/// number of rays.
pub(super) fn camera_sites<'w>(
    world: &'w World,
    settings: &Settings,
    camera: &Camera,
    error: f32,
) -> (Vec<RecordSite<'w>>, Vec<Pass>, u64) {
    let (mut sites, mut passes, mut traced) = (Vec::new(), Vec::new(), 0);
    for (number, step) in STEPS.into_iter().enumerate() {
        let coarser = number.checked_sub(1).map(|before| STEPS[before]);
        let is_new =
            |x: u32, y: u32| coarser.is_none_or(|coarser| !x.is_multiple_of(coarser) || !y.is_multiple_of(coarser));
        let grid = (0..settings.height).step_by(step as usize).flat_map(|y| {
            (0..settings.width).step_by(step as usize).filter(move |&x| is_new(x, y)).map(move |x| (x, y))
        });
        let pixels: Vec<(u32, u32)> = grid.collect();
        let found: Vec<(Vec<RecordSite>, u64)> =
            pixels.par_chunks(1024).map(|pixels| visible_sites(world, settings, camera, error, pixels)).collect();
        traced += found.iter().map(|(_, rays)| rays).sum::<u64>();
        sites.extend(found.into_iter().flat_map(|(sites, _)| sites));
        let places = sites.len();
        passes.extend([1.4, 0.95].map(|part| Pass { places, separation: part * step as f32 }));
    }
    (sites, passes, traced)
}

/// A ray from the camera, or what mirrors and glass made of it.
struct View {
    film: FilmPoint,
    pixel: u64,
    ray: Ray,
    /// The way from the camera to where the ray begins.
    distance: f32,
    /// How much of the light that arrives by the ray is seen, at most.
    share: f32,
}

/// The sites that the camera sees in the middles of pixels, and the number of rays: all scattering surfaces up to the
/// first that reflects no others; glossy ones count as mirrors.
fn visible_sites<'w>(
    world: &'w World,
    settings: &Settings,
    camera: &Camera,
    error: f32,
    pixels: &[(u32, u32)],
) -> (Vec<RecordSite<'w>>, u64) {
    let view = |&(x, y): &(u32, u32)| {
        let film = FilmPoint::middle(x, y);
        let pixel = u64::from(y) * u64::from(settings.width) + u64::from(x);
        Some(View { film, pixel, ray: camera.central_ray(&film)?, distance: 0.0, share: 1.0 })
    };
    let mut views: Vec<View> = pixels.iter().filter_map(view).collect();
    let (mut sites, mut traced) = (Vec::new(), 0);
    for depth in 0..MAX_SURFACES {
        let rays: Vec<Ray> = views.iter().map(|view| view.ray).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        world.intersect_many(&rays, &mut hits);
        traced += rays.len() as u64;
        let mut next = Vec::new();
        for (View { film, pixel, ray, distance, share }, hit) in views.iter().zip(&hits).filter(|(_, hit)| hit.is_hit())
        {
            let mut surface = world.surface_at(hit).facing(ray.direction);
            let scattering = world.scattering(&mut surface);
            let distance = distance + hit.t;
            if surface.diffuse != Vec3::ZERO {
                let key = u64::from(depth) << DEPTH_SHIFT | pixel;
                sites.push(camera_site(camera.pixel_width(film, distance), error, surface, ray, key));
            }
            let sampler = Sampler::new(Pattern::Sobol, !settings.seed, *pixel as u32, depth);
            let bounce = scattering.sample(sampler.uniform2(0));
            let mut go_on = |direction: Vec3, share: f32| {
                let ray = Ray::new(surface.origin_towards(direction), direction);
                next.push(View { film: *film, pixel: *pixel, ray, distance, share });
            };
            if let Some(bounce) = bounce.filter(|bounce| bounce.density == f32::INFINITY) {
                go_on(bounce.direction, *share);
            } else if !world.is_nearly_diffuse(hit.prim_id) {
                // The hit in the middle of a glossy lobe.
                let share = share * (scattering.albedo() - surface.diffuse).max_element();
                let direction =
                    ray.direction - 2.0 * surface.shading_normal.dot(ray.direction) * surface.shading_normal;
                if share > LEAST_SHARE && surface.normal.dot(direction) > 0.0 {
                    go_on(direction, share);
                }
            }
        }
        if next.is_empty() {
            break;
        }
        views = next;
    }
    (sites, traced)
}

/// The site that is seen where a pixel is so wide.
fn camera_site<'w>(pixel_width: f32, error: f32, surface: Surface<'w>, ray: &Ray, key: u64) -> RecordSite<'w> {
    // The root of the area that a pixel covers; at most that of a surface seen under 6 degrees. What is seen in a mirror
    // counts as if it stood as far behind the mirror: a curved one would make of a pixel anything from nothing to all.
    let cosine = surface.normal.dot(ray.direction).abs().max(0.1);
    let spacing = pixel_width / cosine.sqrt();
    RecordSite {
        point: GatherPoint { key, surface },
        place: Place { point: lookup_point_anywhere(&surface), spacing },
        bounds: Bounds { lower: (LEAST_PIXELS * error).max(LEAST_FOR_ALL) * spacing, upper: MOST_PIXELS * spacing },
        floor: LEAST_FOR_ALL * spacing,
    }
}

/// Sites without a camera, with keys by their order. Their unit is a part of the scene's diagonal, or of the distance
/// to their nearest `neighbour` (by its number) if that is less.
pub(super) fn point_sites<'w>(
    world: &World,
    surfaces: &[Surface<'w>],
    level: u32,
    least_units: f32,
    neighbour: usize,
) -> Vec<RecordSite<'w>> {
    let diagonal = world.diagonal();
    let points: Vec<(Vec3, Vec3)> = surfaces.iter().map(|surface| (surface.position, surface.smooth_normal)).collect();
    let site = |((number, &surface), apart): ((u64, &Surface<'w>), f32)| {
        let spacing = (apart / UNITS_APART).clamp(LEAST_OF_DIAGONAL * diagonal, diagonal / PARTS);
        RecordSite {
            point: GatherPoint { key: u64::from(level) << LEVEL_SHIFT | number, surface },
            place: Place { point: lookup_point(world, &surface), spacing },
            bounds: Bounds { lower: least_units * spacing, upper: MOST_OF_DIAGONAL * diagonal },
            floor: 0.0,
        }
    };
    (0..).zip(surfaces).zip(spacings(&points, neighbour)).map(site).collect()
}

/// Passes over loose sites, from half the scene down to less than a record's reach, in steps of √2.
pub(super) fn point_passes(places: usize) -> Vec<Pass> {
    let separations = (0..18).map(|step| 0.5 * PARTS * 0.5f32.powf(0.5 * step as f32));
    separations.map(|separation| Pass { places, separation }).collect()
}

/// Sites for the next deeper cache: where rays from the sites above end.
pub(super) fn deeper_sites<'w>(
    world: &'w World,
    above: &[RecordSite<'w>],
    seed: u64,
    level: u32,
    least_units: f32,
) -> Vec<RecordSite<'w>> {
    let above = &above[..above.len().min(MAX_DEEPER_SITES)];
    let ends: Vec<Vec<Surface>> = (0u32..)
        .zip(above)
        .collect::<Vec<_>>()
        .par_chunks(256)
        .map(|above| {
            let rays: Vec<Ray> = above
                .iter()
                .flat_map(|(number, site)| {
                    let surface = site.point.surface;
                    (0..DEEPER_RAYS).map(move |ray| {
                        let sampler = Sampler::new(Pattern::Sobol, !seed ^ u64::from(level), *number, ray);
                        let direction = surface.frame().to_world(CosineHemisphere.map(sampler.uniform2(0)));
                        Ray::new(surface.origin_towards(direction), direction)
                    })
                })
                .collect();
            let mut hits = vec![Hit::MISS; rays.len()];
            world.intersect_many(&rays, &mut hits);
            let ends = rays.iter().zip(&hits).filter(|(_, hit)| hit.is_hit());
            ends.map(|(ray, hit)| world.surface_at(hit).facing(ray.direction)).collect()
        })
        .collect();
    let scattering: Vec<Surface> = ends.into_iter().flatten().filter(|surface| surface.diffuse != Vec3::ZERO).collect();
    point_sites(world, &scattering, level, least_units, DEEPER_NEIGHBOUR)
}
