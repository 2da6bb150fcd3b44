//! A sample of surface points that paths reach: camera hits or requested points, and the hits of cosine-distributed
//! rays from there.

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Triangle, UniformSphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};

use crate::camera::FilmPoint;
use crate::light::area;
use crate::world::{Hit, Surface, World};

/// Camera rays, along each side of the picture.
const SIDE: u32 = 32;
/// The points that are begun with, at most.
const POINTS: usize = (SIDE * SIDE) as usize;

/// The points at which light is needed. A [`World`] prepares for them, which affects only noise.
#[derive(Clone, Copy, Debug)]
pub enum LightQuery<'a> {
    /// In a picture of its camera.
    Camera,
    /// Anywhere on the front of its surfaces.
    Surfaces,
    /// At these places, on surfaces with these unit normals.
    Sensors(&'a [(Vec3, Vec3)]),
    /// At these places, from all directions.
    Places(&'a [Vec3]),
}

/// Such points.
pub(crate) struct SeenPoints {
    seen: Vec<SeenPoint>,
    next: Vec<SeenPoint>,
    /// The part of scattered rays that leave the scene.
    pub escaped: f32,
}

/// A side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Front,
    Back,
}

/// One of them.
enum SeenPoint {
    /// A hit, and the direction of its ray.
    Hit(Hit, Vec3),
    /// A place and a normal.
    Sensor(Vec3, Vec3),
}

impl SeenPoints {
    /// The surfaces from which rays were scattered, with normals that face the viewer.
    pub(crate) fn all<'a>(&'a self, world: &'a World) -> impl Iterator<Item = Surface<'a>> {
        self.seen.iter().chain(&self.next).map(|point| point.surface(world))
    }
}

impl SeenPoint {
    fn surface<'w>(&self, world: &'w World) -> Surface<'w> {
        match *self {
            Self::Hit(hit, direction) => world.surface_at(&hit).facing(direction),
            Self::Sensor(position, normal) => world.sensor(position, normal),
        }
    }
}

impl World {
    /// Points that paths come to; `None` if nothing is seen.
    pub(crate) fn seen_points(&self, from: LightQuery) -> Option<SeenPoints> {
        let seen = match from {
            LightQuery::Camera => {
                let camera = self.camera_on(SIDE, SIDE);
                let pixels = (0..SIDE * SIDE).map(|i| FilmPoint::middle(i % SIDE, i / SIDE));
                self.points_along(&pixels.filter_map(|pixel| camera.central_ray(&pixel)).collect::<Vec<_>>())
            }
            LightQuery::Surfaces => self.points_by_area(),
            LightQuery::Sensors(sensors) => {
                some_of(sensors).map(|&(position, normal)| SeenPoint::Sensor(position, normal)).collect()
            }
            LightQuery::Places(places) => {
                let each = POINTS.div_ceil(places.len().max(1)) as u32;
                let rays = some_of(places).zip(0..).flat_map(|(&place, number)| {
                    let u = move |i| Sampler::new(Pattern::Sobol, 0, number, i).uniform2(0);
                    (0..each).map(move |i| Ray::new(place, UniformSphere.map(u(i))))
                });
                self.points_along(&rays.collect::<Vec<_>>())
            }
        };
        let (rays, next) = self.scatter(&seen, 0);
        let (further, last) = self.scatter(&next, 1);
        let scattered = rays + further;
        let escaped = (scattered - next.len() - last.len()) as f32 / scattered as f32;
        (scattered > 0).then_some(SeenPoints { seen, next, escaped })
    }

    /// Points on the front of surfaces, spread by area.
    fn points_by_area(&self) -> Vec<SeenPoint> {
        let records = self.placed_records();
        let sums: Vec<f64> = records
            .iter()
            .scan(0.0, |sum, record| {
                *sum += f64::from(area(&record.corners));
                Some(*sum)
            })
            .collect();
        let Some(&all) = sums.last().filter(|&&all| all > 0.0) else { return Vec::new() };
        let point = |i: usize| {
            let place = all * (i as f64 + 0.5) / POINTS as f64;
            let prim = sums.partition_point(|&sum| sum <= place).min(records.len() - 1);
            let on_triangle = Triangle.map(Sampler::new(Pattern::Sobol, 0, 3, i as u32).uniform2(0));
            let hit = Hit { prim_id: prim as u32, u: on_triangle.x, v: on_triangle.y, ..Hit::MISS };
            SeenPoint::Hit(hit, -self.receiver(hit.prim_id, [hit.u, hit.v]).normal)
        };
        (0..POINTS).map(point).collect()
    }

    /// Rays by the cosine from one side of points that are spread over the surfaces by their area.
    pub(crate) fn rays_from_surfaces(&self, side: Side) -> Vec<Ray> {
        let turned = |point: SeenPoint| match (side, point) {
            (Side::Back, SeenPoint::Hit(hit, direction)) => SeenPoint::Hit(hit, -direction),
            (_, point) => point,
        };
        self.rays_by_cosine(&self.points_by_area().into_iter().map(turned).collect::<Vec<_>>(), 0)
    }

    /// Sends a ray by the cosine from each point; gives their number, and where they hit something.
    fn scatter(&self, points: &[SeenPoint], set: u32) -> (usize, Vec<SeenPoint>) {
        let rays = self.rays_by_cosine(points, set);
        (rays.len(), self.points_along(&rays))
    }

    /// A ray by the cosine from each point.
    fn rays_by_cosine(&self, points: &[SeenPoint], set: u32) -> Vec<Ray> {
        let ray = |(point, number): (&SeenPoint, u32)| {
            let point = point.surface(self);
            let u: Vec2 = Sampler::new(Pattern::Sobol, 0, 1, number).uniform2(set);
            let direction = point.frame().to_world(CosineHemisphere.map(u));
            (point.normal.dot(direction) > 0.0).then(|| Ray::new(point.origin_towards(direction), direction))
        };
        points.iter().zip(0..).filter_map(ray).collect()
    }

    /// Hits of rays.
    fn points_along(&self, rays: &[Ray]) -> Vec<SeenPoint> {
        let mut hits = vec![Hit::MISS; rays.len()];
        self.intersect_many(rays, &mut hits);
        let hits = hits.into_iter().zip(rays).filter(|(hit, _)| hit.is_hit());
        hits.map(|(hit, ray)| SeenPoint::Hit(hit, ray.direction)).collect()
    }
}

/// As many of them as points are begun with, at even steps.
fn some_of<T>(all: &[T]) -> impl Iterator<Item = &T> {
    all.iter().step_by(all.len().div_ceil(POINTS).max(1))
}
