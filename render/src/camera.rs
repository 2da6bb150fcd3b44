//! The pinhole camera.
//!
//! A point `(x, y)` of the film, in pixels from its top left corner, is seen in the direction
//! `forward + right * (2 x / width - 1) tan(v/2) width / height + up * (1 - 2 y / height) tan(v/2)`,
//! with `v` the vertical field of view.

use glam::{DVec3, Vec2, Vec3};
use halfdome_kernel::{Isa, Ray, Task, columns};

use crate::scene::CameraPose;

/// A camera for a film of a given size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    eye: Vec3,
    /// The view: right, up and forward, orthonormal.
    axes: [DVec3; 3],
    /// Steps in the view plane at distance one, for one pixel right and one down.
    step: [Vec3; 2],
    /// The film's top left corner in the view plane.
    corner: Vec3,
}

impl Camera {
    /// The camera at a valid pose for a film of `width` by `height` pixels.
    pub(crate) fn new(pose: &CameraPose, width: u32, height: u32) -> Self {
        let forward = (pose.target.as_dvec3() - pose.eye.as_dvec3()).normalize();
        let right = forward.cross(pose.up.as_dvec3()).normalize();
        let up = right.cross(forward);
        let half_height = (0.5 * f64::from(pose.vfov).to_radians()).tan();
        let pixel = 2.0 * half_height / f64::from(height);
        let corner = forward - right * (0.5 * pixel * f64::from(width)) + up * half_height;
        Self {
            eye: pose.eye,
            axes: [right, up, forward],
            step: [(right * pixel).as_vec3(), (-up * pixel).as_vec3()],
            corner: corner.as_vec3(),
        }
    }

    /// The ray through the film's point `(x, y)`, in pixels from the top left corner; its direction is a unit vector.
    pub(crate) fn ray(&self, x: f32, y: f32) -> Ray {
        Ray::new(self.eye, self.direction(x, y))
    }

    #[inline(always)]
    fn direction(&self, x: f32, y: f32) -> Vec3 {
        (self.corner + self.step[0] * x + self.step[1] * y).normalize()
    }

    /// Writes the [`ray`](Self::ray) through each of the film's `points`, with the instructions of `isa`: equal bit for bit.
    pub(crate) fn rays(&self, isa: Isa, points: &[Vec2], rays: &mut [Ray]) {
        isa.run(Rays { camera: self, isa, points, rays });
    }

    /// The point of the film at which a point in space is seen, in pixels from the top left corner, be it on the film or
    /// not; `None` behind the camera.
    pub(crate) fn project(&self, point: Vec3) -> Option<Vec2> {
        let way = point.as_dvec3() - self.eye.as_dvec3();
        let depth = way.dot(self.axes[2]);
        // Steps are along right and down; the corner is at distance one.
        let in_view = (depth > 0.0).then(|| (way / depth).as_vec3() - self.corner)?;
        Some(Vec2::from_array(self.step.map(|step| in_view.dot(step) / step.length_squared())))
    }

    /// The angle between the rays of neighbouring pixels in the middle of the film, in radians, if it is small.
    pub(crate) fn pixel_angle(&self) -> f32 {
        self.step[0].length()
    }

    /// Rows of the matrix that takes world points, as column vectors, to camera space: right, up, backwards.
    pub(crate) fn world_to_camera(&self) -> [[f32; 4]; 4] {
        let [right, up, forward] = self.axes;
        let row = |axis: DVec3| {
            let shift = -axis.dot(self.eye.as_dvec3());
            [axis.x as f32, axis.y as f32, axis.z as f32, shift as f32]
        };
        [row(right), row(up), row(-forward), [0.0, 0.0, 0.0, 1.0]]
    }
}

struct Rays<'a> {
    camera: &'a Camera,
    isa: Isa,
    points: &'a [Vec2],
    rays: &'a mut [Ray],
}

impl Task for Rays<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        const LANES: usize = 64;
        let (mut x, mut y, eye) = ([0.0; LANES], [0.0; LANES], self.camera.eye);
        let mut columns = [[0.0; LANES]; 8];
        [columns[0], columns[1], columns[2]] = [[eye.x; LANES], [eye.y; LANES], [eye.z; LANES]];
        columns[7] = [f32::INFINITY; LANES];
        for (points, rays) in self.points.chunks(LANES).zip(self.rays.chunks_mut(LANES)) {
            for (i, point) in points.iter().enumerate().take(LANES) {
                (x[i], y[i]) = (point.x, point.y);
            }
            for i in 0..LANES {
                let direction = self.camera.direction(x[i], y[i]);
                (columns[4][i], columns[5][i], columns[6][i]) = (direction.x, direction.y, direction.z);
            }
            columns::compress(self.isa, &columns, &[1; LANES][..points.len()], bytemuck::cast_slice_mut(rays));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;
    use halfdome_kernel::Level;

    #[test]
    fn corners_and_middle_of_the_film_are_where_the_field_of_view_puts_them() {
        let pose = CameraPose { eye: vec3(1.0, 2.0, 3.0), target: vec3(1.0, 2.0, -7.0), up: Vec3::Y, vfov: 90.0 };
        let camera = Camera::new(&pose, 200, 100);
        let at = |x, y| camera.ray(x, y).direction;
        let near = |a: Vec3, b: Vec3| assert!((a - b.normalize()).length() < 1e-6, "{a} {b}");
        near(at(100.0, 50.0), vec3(0.0, 0.0, -1.0));
        near(at(0.0, 0.0), vec3(-2.0, 1.0, -1.0));
        near(at(200.0, 100.0), vec3(2.0, -1.0, -1.0));
        assert_eq!(camera.ray(3.0, 4.0).origin, pose.eye);
    }

    #[test]
    fn rays_in_lanes_are_those_one_by_one() {
        let pose = CameraPose { eye: vec3(1.0, 2.0, 3.0), target: vec3(4.0, 6.0, 3.5), up: Vec3::Z, vfov: 30.0 };
        let camera = Camera::new(&pose, 30, 20);
        let points: Vec<Vec2> = (0..150).map(|i| Vec2::new(0.3 * i as f32, 20.0 - 0.17 * i as f32)).collect();
        for isa in Level::ALL.into_iter().filter_map(Isa::new) {
            let mut rays = vec![Ray::new(Vec3::ZERO, Vec3::ZERO); points.len()];
            camera.rays(isa, &points, &mut rays);
            let one_by_one: Vec<Ray> = points.iter().map(|point| camera.ray(point.x, point.y)).collect();
            assert_eq!(rays, one_by_one, "{isa:?}");
        }
    }

    #[test]
    fn projection_undoes_the_rays() {
        let pose = CameraPose { eye: vec3(1.0, 2.0, 3.0), target: vec3(4.0, 6.0, 3.5), up: Vec3::Z, vfov: 30.0 };
        let camera = Camera::new(&pose, 30, 20);
        for (x, y) in [(0.0, 0.0), (12.5, 3.25), (40.0, -5.0)] {
            let point = camera.ray(x, y).at(7.0);
            assert!((camera.project(point).unwrap() - Vec2::new(x, y)).length() < 1e-3);
            assert_eq!(camera.project(camera.ray(x, y).at(-7.0)), None);
        }
    }

    #[test]
    fn the_matrix_takes_the_target_to_the_negative_z_axis() {
        let pose = CameraPose { eye: vec3(1.0, 2.0, 3.0), target: vec3(4.0, 6.0, 3.0), up: Vec3::Z, vfov: 30.0 };
        let rows = Camera::new(&pose, 10, 10).world_to_camera();
        let point = [4.0, 6.0, 3.0, 1.0];
        let seen = rows.map(|row| (0..4).map(|i| row[i] * point[i]).sum::<f32>());
        for (value, expected) in seen.iter().zip([0.0, 0.0, -5.0, 1.0]) {
            assert!((value - expected).abs() < 1e-5, "{seen:?}");
        }
    }
}
