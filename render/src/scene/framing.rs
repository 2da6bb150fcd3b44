//! A camera for a scene that brings none.
//!
//! It looks at the middle of the bounds from 30° to the right of the front and 20° above, from the distance at which
//! the sphere around the bounds just fits into the narrower field of view: `distance = radius / sin(angle / 2)`. The
//! front is the side of +z, as glTF has it, or of -y if z is up.

use glam::{DVec3, Vec3};

use super::CameraPose;

const AZIMUTH_DEGREES: f64 = 30.0;
const ELEVATION_DEGREES: f64 = 20.0;

/// The pose from which the box from `lower` to `upper` fills a picture of `aspect` (width over height). `up` is not
/// zero; `vfov` is in degrees, between 0 and 180.
pub fn frame((lower, upper): (Vec3, Vec3), up: Vec3, vfov: f32, aspect: f64) -> CameraPose {
    // In 64 bits, for the square of a long diagonal does not fit into 32.
    let (lower, upper) = (lower.as_dvec3(), upper.as_dvec3());
    let centre = 0.5 * (lower + upper);
    let radius = 0.5 * (upper - lower).length();
    let radius = if radius > 0.0 { radius } else { 1.0 };

    let tan_half = (0.5 * f64::from(vfov).to_radians()).tan();
    let half_angle = (tan_half * aspect.min(1.0)).atan();
    let distance = radius / half_angle.sin();

    let eye = centre + distance * towards_viewer(up.as_dvec3().normalize());
    CameraPose { eye: eye.as_vec3(), target: centre.as_vec3(), up, vfov }
}

/// The unit vector from the scene to the viewer. `up` has unit length.
fn towards_viewer(up: DVec3) -> DVec3 {
    let front = if up.z.abs() < 0.9 { DVec3::Z } else { DVec3::NEG_Y };
    let front = front.reject_from_normalized(up).normalize();
    let right = up.cross(front);
    let (azimuth, elevation) = (AZIMUTH_DEGREES.to_radians(), ELEVATION_DEGREES.to_radians());
    elevation.cos() * (azimuth.cos() * front + azimuth.sin() * right) + elevation.sin() * up
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: (Vec3, Vec3) = (Vec3::new(-1.0, 2.0, 3.0), Vec3::new(5.0, 4.0, 6.0));

    /// Tangents of the angles at which the corners of `BOUNDS` are seen: the greatest across and the greatest upwards.
    fn extent(pose: &CameraPose) -> (f32, f32) {
        let forward = (pose.target - pose.eye).normalize();
        let right = forward.cross(pose.up).normalize();
        let up = right.cross(forward);
        let corner = |i: u32| {
            let pick = |bit: u32, lower, upper| if i & bit == 0 { lower } else { upper };
            let (lower, upper) = BOUNDS;
            Vec3::new(pick(1, lower.x, upper.x), pick(2, lower.y, upper.y), pick(4, lower.z, upper.z)) - pose.eye
        };
        (0..8).map(corner).fold((0.0, 0.0), |(across, upwards), p| {
            let depth = p.dot(forward);
            assert!(depth > 0.0, "a corner is behind the camera");
            (f32::max(across, p.dot(right).abs() / depth), f32::max(upwards, p.dot(up).abs() / depth))
        })
    }

    #[test]
    fn the_whole_box_is_in_the_picture_and_fills_a_good_part_of_it() {
        for aspect in [0.5, 1.0, 2.0] {
            for vfov in [20.0_f32, 40.0, 90.0] {
                for up in [Vec3::Y, Vec3::Z, Vec3::X, Vec3::new(0.3, -0.2, 5.0)] {
                    let pose = frame(BOUNDS, up, vfov, aspect);
                    let tan_half = (0.5 * vfov.to_radians()).tan();
                    let (across, upwards) = extent(&pose);
                    let (across, upwards) = (across / (tan_half * aspect as f32), upwards / tan_half);
                    assert!(across < 1.0 && upwards < 1.0, "{across} {upwards} at {aspect} {vfov} {up}");
                    assert!(across.max(upwards) > 0.4, "{across} {upwards} at {aspect} {vfov} {up}");
                }
            }
        }
    }

    #[test]
    fn the_distance_is_that_at_which_the_sphere_fits() {
        let pose = frame((Vec3::splat(-1.0), Vec3::splat(1.0)), Vec3::Y, 60.0, 1.0);
        assert_eq!(pose.target, Vec3::ZERO);
        let expected = 3.0_f32.sqrt() * 2.0;
        assert!((pose.eye.length() - expected).abs() < 1e-5);
        let height = pose.eye.y / pose.eye.length();
        assert!((height - 20.0_f32.to_radians().sin()).abs() < 1e-6);
        assert!(pose.eye.z > pose.eye.x && pose.eye.x > 0.0, "in front, somewhat to the right");
    }

    #[test]
    fn with_z_up_the_front_is_minus_y() {
        let pose = frame((Vec3::splat(-1.0), Vec3::splat(1.0)), Vec3::Z, 40.0, 1.0);
        assert!(-pose.eye.y > pose.eye.x && pose.eye.x > 0.0 && pose.eye.z > 0.0, "{pose:?}");
    }

    #[test]
    fn a_single_point_and_huge_bounds_frame_too() {
        let point = frame((Vec3::ONE, Vec3::ONE), Vec3::Y, 40.0, 1.0);
        assert!(point.eye.is_finite() && point.eye != point.target);
        let huge = frame((Vec3::splat(-1e37), Vec3::splat(1e37)), Vec3::Y, 40.0, 1.0);
        assert!(huge.eye.is_finite());
    }
}
