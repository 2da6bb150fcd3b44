//! Where records may go: what a camera sees, points that somebody asks for, and where the rays of their gathers end.

use glam::Vec3;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use halfdome_kernel::{Hit, Ray};
use rayon::prelude::*;

use super::level::Candidate;
use super::spacing::spacings;
use crate::cache::{Bounds, Pass, Place};
use crate::camera::Camera;
use crate::estimator::GatherPoint;
use crate::settings::Settings;
use crate::world::{Surface, World};

/// Steps between the camera's candidates, in pixels.
const STEPS: [u32; 6] = [64, 32, 16, 8, 4, 2];
/// The fewest pixels that a record reaches where the camera sees it, over the error: in a corner it is these that decide
/// how many records there are, which should be as many times fewer as elsewhere where the error may be greater ...
const LEAST_PIXELS: f32 = 6.0;
/// ... but no fewer than these, so that most of the pixels beside a candidate are within the reach of its record ...
const LEAST_FOR_ALL: f32 = 1.75;
/// ... and the most pixels.
const MOST_PIXELS: f32 = 40.0;
/// Parts of the scene's diagonal that make up the unit of spacing where there is no camera ...
const PARTS: f32 = 1024.0;
/// ... if candidates are no nearer to each other than so many, ...
const UNITS_APART: f32 = 5.0;
/// ... and the greatest part of the diagonal that a record reaches.
const MOST_OF_DIAGONAL: f32 = 160.0 / 1024.0;
/// The least part of the diagonal that a unit is, as floats have so many digits.
const LEAST_OF_DIAGONAL: f32 = 1e-7;
/// Of the neighbours of a scout's candidate, which lie at random, the one whose distance counts.
const SCOUTS_NEIGHBOUR: usize = 4;
/// Rays by which a candidate finds candidates for the next deeper cache.
const SCOUTS: u32 = 8;
/// The most candidates that send scouts.
const MAX_SCOUTING: usize = 8192;
/// The most surfaces that a camera's ray may meet.
const MAX_SURFACES: u32 = 16;
/// Keys of what is seen in mirrors begin with the number of mirrors.
const DEPTH_SHIFT: u32 = 48;
/// Keys of deeper caches begin with the number of reflections.
const LEVEL_SHIFT: u32 = 56;

/// What the camera sees through the middles of pixels in ever finer grids: candidates, a pass or two for each grid, and
/// the number of rays.
pub(super) fn camera_candidates<'w>(
    world: &'w World,
    settings: &Settings,
    camera: &Camera,
    error: f32,
) -> (Vec<Candidate<'w>>, Vec<Pass>, u64) {
    let (mut candidates, mut passes, mut traced) = (Vec::new(), Vec::new(), 0);
    for (number, step) in STEPS.into_iter().enumerate() {
        let coarser = number.checked_sub(1).map(|before| STEPS[before]);
        let is_new =
            |x: u32, y: u32| coarser.is_none_or(|coarser| !x.is_multiple_of(coarser) || !y.is_multiple_of(coarser));
        let grid = (0..settings.height).step_by(step as usize).flat_map(|y| {
            (0..settings.width).step_by(step as usize).filter(move |&x| is_new(x, y)).map(move |x| (x, y))
        });
        let pixels: Vec<(u32, u32)> = grid.collect();
        let found: Vec<(Vec<Candidate>, u64)> =
            pixels.par_chunks(1024).map(|pixels| seen_candidates(world, settings, camera, error, pixels)).collect();
        traced += found.iter().map(|(_, rays)| rays).sum::<u64>();
        candidates.extend(found.into_iter().flat_map(|(candidates, _)| candidates));
        let places = candidates.len();
        passes.extend([1.4, 0.95].map(|part| Pass { places, separation: part * step as f32 }));
    }
    (candidates, passes, traced)
}

/// A ray from the camera, or what mirrors and glass made of it.
struct View {
    pixel: u64,
    ray: Ray,
    /// The way from the camera to where the ray begins.
    distance: f32,
}

/// The candidates that the camera sees in the middles of pixels, and the number of rays: all surfaces that scatter light
/// up to the first that shows no other.
fn seen_candidates<'w>(
    world: &'w World,
    settings: &Settings,
    camera: &Camera,
    error: f32,
    pixels: &[(u32, u32)],
) -> (Vec<Candidate<'w>>, u64) {
    let view = |&(x, y): &(u32, u32)| View {
        pixel: u64::from(y) * u64::from(settings.width) + u64::from(x),
        ray: camera.ray(x as f32 + 0.5, y as f32 + 0.5),
        distance: 0.0,
    };
    let mut views: Vec<View> = pixels.iter().map(view).collect();
    let (mut candidates, mut traced) = (Vec::new(), 0);
    for depth in 0..MAX_SURFACES {
        let rays: Vec<Ray> = views.iter().map(|view| view.ray).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        world.intersect_many(&rays, &mut hits);
        traced += rays.len() as u64;
        let mut next = Vec::new();
        for (View { pixel, ray, distance }, hit) in views.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
            let surface = world.surface_at(hit).facing(ray.direction);
            let distance = distance + hit.t;
            if surface.diffuse != Vec3::ZERO {
                let key = u64::from(depth) << DEPTH_SHIFT | pixel;
                candidates.push(camera_candidate(camera, error, surface, ray, distance, key));
            }
            let sampler = Sampler::new(Pattern::Sobol, !settings.seed, *pixel as u32, depth);
            let bounce = surface.sample(ray.direction, sampler.uniform2(0));
            if let Some(bounce) = bounce.filter(|bounce| bounce.density == f32::INFINITY) {
                let ray = Ray::new(surface.origin_towards(bounce.direction), bounce.direction);
                next.push(View { pixel: *pixel, ray, distance });
            }
        }
        if next.is_empty() {
            break;
        }
        views = next;
    }
    (candidates, traced)
}

/// The candidate that is seen at this distance from the camera.
fn camera_candidate<'w>(
    camera: &Camera,
    error: f32,
    surface: Surface<'w>,
    ray: &Ray,
    distance: f32,
    key: u64,
) -> Candidate<'w> {
    // The root of the area that a pixel covers; at most that of a surface seen under 6 degrees. What is seen in a mirror
    // counts as if it stood as far behind the mirror: a curved one would make of a pixel anything from nothing to all.
    let cosine = surface.normal.dot(ray.direction).abs().max(0.1);
    let spacing = distance * camera.pixel_angle() / cosine.sqrt();
    Candidate {
        point: GatherPoint { key, surface },
        place: Place { position: surface.position, normal: surface.shading_normal, spacing },
        bounds: Bounds { lower: (LEAST_PIXELS * error).max(LEAST_FOR_ALL) * spacing, upper: MOST_PIXELS * spacing },
    }
}

/// Candidates that no camera looks at, with keys by their order. Their unit is a part of the scene's diagonal, or of the
/// distance to their nearest `neighbour` (by its number) if that is less.
pub(super) fn loose_candidates<'w>(
    world: &World,
    surfaces: &[Surface<'w>],
    level: u32,
    least_units: f32,
    neighbour: usize,
) -> Vec<Candidate<'w>> {
    let diagonal = world.diagonal();
    let points: Vec<(Vec3, Vec3)> = surfaces.iter().map(|surface| (surface.position, surface.shading_normal)).collect();
    let candidate = |((number, &surface), apart): ((u64, &Surface<'w>), f32)| {
        let spacing = (apart / UNITS_APART).clamp(LEAST_OF_DIAGONAL * diagonal, diagonal / PARTS);
        Candidate {
            point: GatherPoint { key: u64::from(level) << LEVEL_SHIFT | number, surface },
            place: Place { position: surface.position, normal: surface.shading_normal, spacing },
            bounds: Bounds { lower: least_units * spacing, upper: MOST_OF_DIAGONAL * diagonal },
        }
    };
    (0..).zip(surfaces).zip(spacings(&points, neighbour)).map(candidate).collect()
}

/// Passes over loose candidates, from half the scene down to less than a record's reach, in steps of √2.
pub(super) fn loose_passes(places: usize) -> Vec<Pass> {
    let separations = (0..18).map(|step| 0.5 * PARTS * 0.5f32.powf(0.5 * step as f32));
    separations.map(|separation| Pass { places, separation }).collect()
}

/// Candidates for the next deeper cache: where rays from the candidates above end.
pub(super) fn scout<'w>(
    world: &'w World,
    above: &[Candidate<'w>],
    seed: u64,
    level: u32,
    least_units: f32,
) -> Vec<Candidate<'w>> {
    let above = &above[..above.len().min(MAX_SCOUTING)];
    let ends: Vec<Vec<Surface>> = (0u32..)
        .zip(above)
        .collect::<Vec<_>>()
        .par_chunks(256)
        .map(|above| {
            let rays: Vec<Ray> = above
                .iter()
                .flat_map(|(number, candidate)| {
                    let surface = candidate.point.surface;
                    (0..SCOUTS).map(move |scout| {
                        let sampler = Sampler::new(Pattern::Sobol, !seed ^ u64::from(level), *number, scout);
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
    loose_candidates(world, &scattering, level, least_units, SCOUTS_NEIGHBOUR)
}
