//! Cameras: from points of the film to rays, and from points in space to the film.
//!
//! Kinds of cameras are an enum, matched once for many rays. A pinhole's rays are computed in lanes, the rays of other
//! kinds one by one, which costs little beside tracing them.

mod aperture;
mod basis;
mod cube;
mod face;
mod fisheye;
mod moving;
mod panorama;
mod plane;
mod table;

use glam::{DVec2, Vec2, Vec3};
use halfdome_kernel::{Isa, Ray, Task, columns};

use self::basis::Basis;
use self::cube::Cube;
use self::fisheye::Fisheye;
use self::panorama::Panorama;
use self::plane::Plane;
use self::table::Table;
use crate::scene::{CameraPose, Clip, Optics, Projection};

pub use face::Face;
pub(crate) use moving::MovingCamera;

/// A camera for a film of a given size.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    basis: Basis,
    clip: Clip,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Plane(Plane),
    Panorama(Panorama),
    Fisheye(Fisheye),
    Cube(Cube),
    Table(Table),
}

/// A point of the film, and the pixel whose sample it is: filters reach beyond their pixel, and may not come to another
/// face of a cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FilmPoint {
    /// Column from the left, row from the top.
    pub pixel: (u32, u32),
    /// In pixels from the top left corner.
    pub point: Vec2,
}

/// The input of a camera for a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FilmSample {
    pub film: FilmPoint,
    /// Numbers in [0, 1) for the place on the lens, if the camera has one.
    pub lens: Vec2,
}

/// The projection of a point in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sight {
    /// In pixels from the film's top left corner, be it on the film or not.
    pub film: Vec2,
    /// The ray that sees it, whose `t` is 1 there and whose ends are the camera's planes and the point.
    pub ray: Ray,
}

impl FilmPoint {
    /// The middle of a pixel.
    pub(crate) fn middle(x: u32, y: u32) -> Self {
        Self { pixel: (x, y), point: Vec2::new(x as f32 + 0.5, y as f32 + 0.5) }
    }

    /// A point of the pixel that it lies in.
    pub(crate) fn within(point: Vec2) -> Self {
        Self { pixel: (point.x as u32, point.y as u32), point }
    }
}

impl Camera {
    /// The camera at a valid pose for a film of `width` by `height` pixels.
    pub(crate) fn new(pose: &CameraPose, optics: &Optics, width: u32, height: u32) -> Self {
        let (basis, size) = (Basis::new(pose), (width, height));
        let plane = |half_height: f64, is_parallel: bool| {
            let mut plane = Plane::new(&basis, half_height, is_parallel, size, optics.shift);
            plane.clip = optics.clip;
            Kind::Plane(match &optics.lens {
                Some(lens) => plane.with_lens(&basis, lens),
                None => plane,
            })
        };
        let kind = match &optics.projection {
            Projection::Perspective => plane((0.5 * f64::from(pose.vfov).to_radians()).tan(), false),
            Projection::Orthographic { height } => plane(0.5 * f64::from(*height), true),
            Projection::Panorama { eye_distance } => Kind::Panorama(Panorama::new(size, *eye_distance)),
            Projection::Fisheye { mapping, field_of_view } => {
                Kind::Fisheye(Fisheye::new(size, *mapping, *field_of_view))
            }
            Projection::Cube => Kind::Cube(Cube::new(size)),
            Projection::Rays(rays) => Kind::Table(Table::new(rays.clone(), size)),
        };
        Self { basis, clip: optics.clip, kind }
    }

    /// Whether rays need a place on a lens.
    pub(crate) fn has_lens(&self) -> bool {
        matches!(&self.kind, Kind::Plane(Plane { lens: Some(_), .. }))
    }

    /// Whether parts of the film have no rays, so that a picture has holes.
    pub(crate) fn has_border(&self) -> bool {
        matches!(self.kind, Kind::Fisheye(_))
    }

    /// Whether a point of the film sees anything.
    #[inline]
    pub(crate) fn covers(&self, film: &FilmPoint) -> bool {
        match &self.kind {
            Kind::Fisheye(fisheye) => fisheye.covers(film.point),
            _ => true,
        }
    }

    /// The ray through a point of the film and the lens's middle, `None` where the film has no ray; its direction is a
    /// unit vector.
    pub(crate) fn central_ray(&self, film: &FilmPoint) -> Option<Ray> {
        self.covers(film).then(|| match &self.kind {
            Kind::Plane(plane) => plane.central_ray(film.point),
            _ => self.ray(&FilmSample { film: *film, lens: Vec2::ZERO }),
        })
    }

    /// The ray of a sample; its direction is a unit vector.
    fn ray(&self, FilmSample { film, lens }: &FilmSample) -> Ray {
        let Clip { near, far } = self.clip;
        let clipped = |origin: Vec3, direction: Vec3| Ray { origin, t_min: near, direction, t_max: far };
        let turned = |direction: [f64; 3]| self.basis.to_world(direction).normalize().as_vec3();
        match &self.kind {
            Kind::Plane(plane) => plane.ray(film.point, *lens),
            Kind::Panorama(panorama) => {
                let [origin, direction] = panorama.line(film);
                clipped(self.moved(origin), turned(direction))
            }
            Kind::Fisheye(fisheye) => clipped(self.basis.eye, turned(fisheye.direction(film.point))),
            Kind::Cube(cube) => clipped(self.basis.eye, turned(cube.direction(film))),
            Kind::Table(table) => {
                let [origin, direction] = table.ray(film);
                clipped(origin, direction)
            }
        }
    }

    /// The eye, moved to the right, up and forward.
    fn moved(&self, by: [f64; 3]) -> Vec3 {
        (self.basis.eye.as_dvec3() + self.basis.to_world(by)).as_vec3()
    }

    /// Writes the ray of each sample, with the instructions of `isa`, which make no difference. The film must
    /// [see](Self::covers) something at each.
    pub(crate) fn rays(&self, isa: Isa, samples: &[FilmSample], rays: &mut [Ray]) {
        match &self.kind {
            Kind::Plane(plane @ Plane { lens: None, clip: Clip::NONE, is_parallel: false, .. }) => {
                isa.run(PinholeRays { plane, isa, samples, rays });
            }
            _ => samples.iter().zip(rays).for_each(|(sample, ray)| *ray = self.ray(sample)),
        }
    }

    /// How far a point of a sample's ray is: along the view of a camera with a flat film, along the ray of others.
    pub(crate) fn depth(&self, ray: &Ray, t: f32) -> f32 {
        match &self.kind {
            Kind::Plane(_) => self.basis.to_view(ray.at(t))[2] as f32,
            _ => t,
        }
    }

    /// How many pictures of the world the film has side by side: one for each eye.
    pub(crate) fn views(&self) -> u32 {
        if let Kind::Panorama(panorama) = &self.kind { panorama.views() } else { 1 }
    }

    /// How a point in space is seen in one of the views, through the lens's middle; `None` if the film cannot see it,
    /// as behind the camera. Where a table has the rays it is never known.
    pub(crate) fn sight(&self, point: Vec3, view: u32) -> Option<Sight> {
        let of_view = self.basis.to_view(point);
        let (from, film) = match &self.kind {
            Kind::Plane(plane) => return plane.sight(point),
            Kind::Panorama(panorama) => panorama.sight(of_view, view)?,
            Kind::Fisheye(fisheye) => ([0.0; 3], fisheye.film(of_view)?),
            Kind::Cube(cube) => ([0.0; 3], cube.film(of_view)?),
            Kind::Table(_) => return None,
        };
        let ray = Ray::between(self.moved(from), point);
        let distance = ray.direction.length();
        let is_seen = distance > 0.0 && (self.clip.near..=self.clip.far).contains(&distance);
        let film = DVec2::from_array(film).as_vec2();
        is_seen.then(|| Sight { film, ray: Ray { t_min: self.clip.near / distance, ..ray } })
    }

    /// Whether what lies between two points of the film lies between them in space, too: not across a panorama's
    /// border, or the edges of a cube.
    pub(crate) fn joins(&self, a: Vec2, b: Vec2) -> bool {
        match &self.kind {
            Kind::Panorama(panorama) => panorama.joins(a.to_array(), b.to_array()),
            Kind::Cube(cube) => cube.joins(a.to_array(), b.to_array()),
            _ => true,
        }
    }

    /// The width of what a pixel sees at this distance along its ray, about: the root of the area on a surface that
    /// faces it.
    pub(crate) fn pixel_width(&self, film: &FilmPoint, distance: f32) -> f32 {
        distance
            * match &self.kind {
                Kind::Plane(plane) => return plane.pixel_width(distance),
                Kind::Panorama(panorama) => panorama.pixel_angle(),
                Kind::Fisheye(fisheye) => fisheye.pixel_angle(),
                Kind::Cube(cube) => cube.pixel_angle(film),
                Kind::Table(table) => return table.pixel_width(film, distance),
            }
    }

    /// Rows of the matrix that takes world points, as column vectors, to camera space: right, up, backwards; `None`
    /// where a table has the rays.
    pub(crate) fn world_to_camera(&self) -> Option<[[f32; 4]; 4]> {
        (!matches!(self.kind, Kind::Table(_))).then(|| self.basis.world_to_camera())
    }
}

struct PinholeRays<'a> {
    plane: &'a Plane,
    isa: Isa,
    samples: &'a [FilmSample],
    rays: &'a mut [Ray],
}

impl Task for PinholeRays<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        const LANES: usize = 64;
        let (mut x, mut y, eye) = ([0.0; LANES], [0.0; LANES], self.plane.eye);
        let mut columns = [[0.0; LANES]; 8];
        [columns[0], columns[1], columns[2]] = [[eye.x; LANES], [eye.y; LANES], [eye.z; LANES]];
        columns[7] = [f32::INFINITY; LANES];
        for (samples, rays) in self.samples.chunks(LANES).zip(self.rays.chunks_mut(LANES)) {
            for (i, sample) in samples.iter().enumerate().take(LANES) {
                (x[i], y[i]) = (sample.film.point.x, sample.film.point.y);
            }
            for i in 0..LANES {
                let direction = self.plane.direction(x[i], y[i]);
                (columns[4][i], columns[5][i], columns[6][i]) = (direction.x, direction.y, direction.z);
            }
            columns::compress(self.isa, &columns, &[1; LANES][..samples.len()], bytemuck::cast_slice_mut(rays));
        }
    }
}

#[cfg(test)]
mod tests;
