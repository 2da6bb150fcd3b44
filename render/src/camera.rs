//! The pinhole camera.
//!
//! A point `(x, y)` of the film, in pixels from its top left corner, is seen in the direction
//! `forward + right * (2 x / width - 1) tan(v/2) width / height + up * (1 - 2 y / height) tan(v/2)`,
//! with `v` the vertical field of view.

use glam::{DVec3, Vec2, Vec3};
use halfdome_kernel::Ray;

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
        Ray::new(self.eye, (self.corner + self.step[0] * x + self.step[1] * y).normalize())
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

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
