//! Perspective and orthographic cameras: a plane before the eye, and a lens.
//!
//! A point `(x, y)` of the film, in pixels from its top left corner, stands for the point `right * (2 x / width - 1)
//! tan(v/2) width / height + up * (1 - 2 y / height) tan(v/2)` of the plane at distance one, with `v` the vertical
//! field of view; an orthographic camera has half its height in place of `tan(v/2)`. A shift moves the plane.
//!
//! A thin lens sends all rays of a point of the film to where the ray through the lens's middle meets the plane that is
//! sharp. The field of view does not change with the focus: the distance from lens to film counts as the focal length
//! `f`, so that a point at depth `z` becomes a disc of the diameter `c = A f / s · |z - s| / z` on the film, with the
//! aperture `A` and the sharp plane at `s`. (Real lenses that focus by moving have `f / (s - f)`: the picture grows as
//! the focus comes near.)
//!
//! Source: Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, 5.2.3.

use glam::{DVec3, Vec2, Vec3};
use halfdome_kernel::Ray;

use super::Sight;
use super::aperture::Aperture;
use super::basis::Basis;
use crate::scene::{Clip, Lens};

/// The film in the view.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    pub(super) eye: Vec3,
    forward: DVec3,
    /// Steps in the plane for one pixel right and one down.
    step: [Vec3; 2],
    /// The film's top left corner in the plane: from the eye, or for parallel rays from the middle of the plane.
    corner: Vec3,
    pub(super) lens: Option<LensPlane>,
    pub(super) clip: Clip,
    pub(super) is_parallel: bool,
}

/// A lens with what it stands in.
#[derive(Clone, Debug)]
pub(super) struct LensPlane {
    aperture: Aperture,
    focus: f32,
    right: Vec3,
    up: Vec3,
}

impl Plane {
    /// The plane whose visible half height, at distance one if rays are not parallel, is `half_height`. `shift` is in
    /// parts of the film's longer side.
    pub(super) fn new(
        basis: &Basis,
        half_height: f64,
        is_parallel: bool,
        (width, height): (u32, u32),
        shift: Vec2,
    ) -> Self {
        let Basis { eye, right, up, forward } = *basis;
        let pixel = 2.0 * half_height / f64::from(height);
        let [across, upwards] = shift.to_array().map(|part| f64::from(part) * f64::from(width.max(height)) * pixel);
        let middle = if is_parallel { DVec3::ZERO } else { forward };
        // The shift is added to the factors: so a zero shift changes no value, not even the sign of a 0.
        let corner = middle - right * (0.5 * pixel * f64::from(width) - across) + up * (half_height + upwards);
        Self {
            eye,
            forward,
            step: [(right * pixel).as_vec3(), (-up * pixel).as_vec3()],
            corner: corner.as_vec3(),
            lens: None,
            clip: Clip::NONE,
            is_parallel,
        }
    }

    /// The same with a lens.
    pub(super) fn with_lens(self, basis: &Basis, lens: &Lens) -> Self {
        let (right, up) = (basis.right.as_vec3(), basis.up.as_vec3());
        Self { lens: Some(LensPlane { aperture: Aperture::new(lens), focus: lens.focus, right, up }), ..self }
    }

    #[inline(always)]
    fn place(&self, x: f32, y: f32) -> Vec3 {
        self.corner + self.step[0] * x + self.step[1] * y
    }

    /// The direction of a pinhole camera's ray.
    #[inline(always)]
    pub(super) fn direction(&self, x: f32, y: f32) -> Vec3 {
        self.place(x, y).normalize()
    }

    /// The ray through a point of the film and the lens's middle.
    pub(super) fn central_ray(&self, Vec2 { x, y }: Vec2) -> Ray {
        if self.is_parallel {
            return self.clipped(self.eye + self.place(x, y), self.forward.as_vec3(), 1.0);
        }
        self.clipped(self.eye, self.direction(x, y), self.place(x, y).length())
    }

    /// The ray through a point of the film and that of the lens for `u` in [0, 1)².
    pub(super) fn ray(&self, film: Vec2, u: Vec2) -> Ray {
        let Some(LensPlane { aperture, focus, right, up }) = &self.lens else { return self.central_ray(film) };
        let Vec2 { x, y } = aperture.point(u);
        let (place, offset) = (self.place(film.x, film.y), *right * x + *up * y);
        let (origin, vector) = if self.is_parallel {
            (self.eye + place + offset, self.forward.as_vec3() * *focus - offset)
        } else {
            (self.eye + offset, place * *focus - offset)
        };
        self.clipped(origin, vector.normalize(), vector.length() / focus)
    }

    /// The ray with the planes' distances along it, `stretch` times those along the view.
    fn clipped(&self, origin: Vec3, direction: Vec3, stretch: f32) -> Ray {
        Ray { origin, t_min: self.clip.near * stretch, direction, t_max: self.clip.far * stretch }
    }

    /// The projection of a point through the lens's middle.
    pub(super) fn sight(&self, point: Vec3) -> Option<Sight> {
        let vector = point.as_dvec3() - self.eye.as_dvec3();
        let depth = vector.dot(self.forward);
        let is_seen = depth > 0.0 && depth >= f64::from(self.clip.near) && depth <= f64::from(self.clip.far);
        // Steps are along right and down; the corner is at distance one.
        let across = if self.is_parallel { vector - self.forward * depth } else { vector / depth };
        let in_plane = is_seen.then(|| across.as_vec3() - self.corner)?;
        let film = Vec2::from_array(self.step.map(|step| in_plane.dot(step) / step.length_squared()));
        let from = if self.is_parallel { self.eye + across.as_vec3() } else { self.eye };
        let near = (f64::from(self.clip.near) / depth) as f32;
        Some(Sight { film, ray: Ray { t_min: near, ..Ray::between(from, point) } })
    }

    /// The width of what a pixel sees in the middle of the film at a distance.
    pub(super) fn pixel_width(&self, distance: f32) -> f32 {
        let step = self.step[0].length();
        if self.is_parallel { step } else { distance * step }
    }
}
