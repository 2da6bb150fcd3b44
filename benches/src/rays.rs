//! The rays to trace: those of a camera, and those that a renderer traces from the camera's hits.
//!
//! They depend on the scene alone. All start at `t_min` 0 with directions of unit length; those that leave a surface
//! start a ten-thousandth of the scene's diagonal above it, far enough that tracers with other rounding hit the same.

use glam::Vec3;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Frame, Strata, Stream};
use halfdome_kernel::{BvhView, Hit, Ray, Triangle};

use crate::scenes::{self, Camera, Scene};

/// How far above a surface secondary rays start, in diagonals of the scene's box.
const OFFSET: f32 = 1e-4;
/// Pixels along a side of a tile, and strata along a side of one.
const TILE: u32 = 4;
/// Rings and sectors of a gather.
const STRATA: u32 = 16;

/// What rays are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// One ray through the middle of each pixel, in tiles of 4 × 4.
    Primary,
    /// One ray from each point that the camera sees, cosine-distributed.
    Diffuse,
    /// 16 × 16 cosine-weighted strata from some of the points, in tiles of 4 × 4: what an irradiance record traces.
    Gather,
    /// One ray from each point to the light, where the light stands above the surface; any hit will do.
    Shadow,
}

impl RayKind {
    /// A short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Diffuse => "diffuse",
            Self::Gather => "gather",
            Self::Shadow => "shadow",
        }
    }

    /// Whether any hit will do; else the nearest is asked for.
    pub fn any_hit(self) -> bool {
        self == Self::Shadow
    }
}

/// Rays of one kind.
#[derive(Clone, Debug)]
pub struct RaySet {
    /// Their kind.
    pub kind: RayKind,
    /// The rays, in the order in which they are traced.
    pub rays: Vec<Ray>,
}

/// How many rays to make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayCounts {
    /// Pixels along a side of the picture; a multiple of 4.
    pub side: u32,
    /// Points that gather, of 256 rays each, as far as the camera sees so many.
    pub gathers: usize,
}

impl RayCounts {
    /// Half a million rays of each kind, for comparing with peers.
    pub const FULL: Self = Self { side: 768, gathers: 2304 };
    /// An eighth of a million, for comparing entry points in a minute.
    pub const QUICK: Self = Self { side: 384, gathers: 576 };
    /// A thousand, for seeing that everything works.
    pub const TINY: Self = Self { side: 32, gathers: 4 };
}

/// A point on a surface: where rays leave it, and the unit normal on the side they leave to.
struct SurfacePoint {
    origin: Vec3,
    normal: Vec3,
}

/// The rays of all kinds for `scene`, whose tree is `tree`.
pub fn generate(scene: &Scene, tree: &BvhView, counts: RayCounts) -> [RaySet; 4] {
    let bounds = scenes::bounds(&scene.triangles);
    let trace = |rays: &[Ray]| {
        let mut hits = vec![Hit::MISS; rays.len()];
        tree.intersect_many(rays, &mut hits);
        let surface = |hit: Hit| hit.is_hit().then(|| (hit.t, normal(&scene.triangles[hit.prim_id as usize])));
        hits.into_iter().map(surface).collect()
    };
    generate_from(&scene.camera, scene.light, (bounds.max - bounds.min).length(), counts, trace)
}

/// The rays of all kinds for a camera, a light and a scene of this diagonal. `trace` gives for each ray the nearest
/// hit's `t` and the surface's normal, on either side.
pub fn generate_from(
    camera: &Camera,
    light: Vec3,
    diagonal: f32,
    counts: RayCounts,
    trace: impl Fn(&[Ray]) -> Vec<Option<(f32, Vec3)>>,
) -> [RaySet; 4] {
    let primary = primary(camera, counts.side);
    let points = visible(OFFSET * diagonal, &primary, &trace(&primary));
    let step = (points.len() / counts.gathers).max(1);
    let gather = points.iter().step_by(step).take(counts.gathers).zip(0..).flat_map(|(p, i)| gather(p, i)).collect();
    let diffuse = points.iter().zip(0..).map(|(point, i)| diffuse(point, i)).collect();
    let shadow = points.iter().filter_map(|point| shadow(point, light)).collect();
    [(RayKind::Primary, primary), (RayKind::Diffuse, diffuse), (RayKind::Gather, gather), (RayKind::Shadow, shadow)]
        .map(|(kind, rays)| RaySet { kind, rays })
}

/// The unit normal of a triangle's front: in `f64`, where a sliver's edges have a cross product.
pub fn normal(triangle: &Triangle) -> Vec3 {
    let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
    (b - a).cross(c - a).normalize().as_vec3()
}

/// A ray for each of `side` × `side` pixels, tile by tile.
fn primary(camera: &Camera, side: u32) -> Vec<Ray> {
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let on_film = |pixel: u32| ((pixel as f32 + 0.5) / side as f32 * 2.0 - 1.0) * camera.half_side;
    let ray = |(y, x)| Ray::new(camera.eye, (forward + on_film(x) * right - on_film(y) * up).normalize());
    tiled(side).map(ray).collect()
}

/// All cells of a `side` × `side` grid as (row, column), in tiles of 4 × 4; `side` is a multiple of 4.
fn tiled(side: u32) -> impl Iterator<Item = (u32, u32)> {
    let cells = move |step: u32, end: u32| {
        (0..end)
            .step_by(step as usize)
            .flat_map(move |row| (0..end).step_by(step as usize).map(move |column| (row, column)))
    };
    cells(TILE, side).flat_map(move |(row, column)| cells(1, TILE).map(move |(i, j)| (row + i, column + j)))
}

/// The points that `rays` hit, `offset` above the surface.
fn visible(offset: f32, rays: &[Ray], surfaces: &[Option<(f32, Vec3)>]) -> Vec<SurfacePoint> {
    let point = |(ray, surface): (&Ray, &Option<(f32, Vec3)>)| {
        let (t, front) = (*surface)?;
        let normal = if front.dot(ray.direction) > 0.0 { -front } else { front };
        Some(SurfacePoint { origin: ray.at(t) + offset * normal, normal })
    };
    rays.iter().zip(surfaces).filter_map(point).collect()
}

fn diffuse(point: &SurfacePoint, index: u32) -> Ray {
    let local = CosineHemisphere.map(Stream::new(3, index, 0).uniform2(0));
    Ray::new(point.origin, Frame::from_normal(point.normal).to_world(local).normalize())
}

fn gather(point: &SurfacePoint, index: u32) -> impl Iterator<Item = Ray> {
    let (origin, frame) = (point.origin, Frame::from_normal(point.normal));
    let strata = Strata::new(STRATA, STRATA).expect("16 is a valid count of rings and sectors");
    tiled(STRATA).map(move |(ring, sector)| {
        let jitter = Stream::new(4, index, STRATA * ring + sector).uniform2(0);
        Ray::new(origin, frame.to_world(strata.direction(ring, sector, jitter)).normalize())
    })
}

fn shadow(point: &SurfacePoint, light: Vec3) -> Option<Ray> {
    let towards = light - point.origin;
    let distance = towards.length();
    let ray = Ray { t_max: distance, ..Ray::new(point.origin, towards / distance) };
    (point.normal.dot(towards) > 0.0).then_some(ray)
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfdome_kernel::{BuildOptions, Bvh};

    #[test]
    fn tiles_cover_the_grid_once() {
        let cells: Vec<_> = tiled(8).collect();
        assert_eq!(cells[..6], [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 1)]);
        assert_eq!((cells[15], cells[16], cells[32]), ((3, 3), (0, 4), (4, 0)));
        let mut sorted = cells.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq((0..8).flat_map(|row| (0..8).map(move |column| (row, column)))));
    }

    #[test]
    fn rays_of_the_cornell_box_are_what_they_say() {
        let scene = scenes::by_name("cornell").unwrap();
        let (bvh, _) = Bvh::build(&scene.triangles, &BuildOptions::default()).unwrap();
        let [primary, diffuse, gather, shadow] = generate(&scene, &bvh.view(), RayCounts::TINY);
        // The Cornell box fills its camera's picture, save some pixels of its rim.
        assert_eq!(primary.rays.len(), 32 * 32);
        assert!((900..=1024).contains(&diffuse.rays.len()), "{}", diffuse.rays.len());
        assert_eq!(gather.rays.len(), 4 * 256);
        // The light of the benchmark hangs below the ceiling, which is the only surface it leaves dark.
        assert!(shadow.rays.len() > diffuse.rays.len() / 2 && shadow.rays.len() < diffuse.rays.len());
        for set in [&primary, &diffuse, &gather, &shadow] {
            assert!(set.rays.iter().all(|ray| (ray.direction.length() - 1.0).abs() < 1e-6));
            assert!(set.rays.iter().all(|ray| ray.t_min == 0.0));
        }
        for ray in &shadow.rays {
            assert!((ray.at(ray.t_max) - scene.light).length() < 1e-6);
        }
        for rays in gather.rays.chunks(256) {
            assert!(rays.iter().all(|ray| ray.origin == rays[0].origin));
            // The mean of cosine-distributed directions is 2/3 of the normal, which strata meet closely.
            let mean = rays.iter().map(|ray| ray.direction).sum::<Vec3>() / 256.0;
            assert!((mean.length() - 2.0 / 3.0).abs() < 0.01, "{mean}");
        }
    }

    #[test]
    fn rays_are_the_same_every_time() {
        let scene = scenes::by_name("terrain:20").unwrap();
        let (bvh, _) = Bvh::build(&scene.triangles, &BuildOptions::default()).unwrap();
        let [first, second] = [0, 1].map(|_| generate(&scene, &bvh.view(), RayCounts::TINY));
        for (first, second) in first.iter().zip(&second) {
            assert!(!first.rays.is_empty());
            assert_eq!(first.rays, second.rays, "{}", first.kind.name());
        }
    }
}
