//! A camera that goes around its target, as in the browser's page (`embed/web/page/orbit.js`).
//!
//! With `n` for the up vector and `o` for the vector from the target to the eye, `o = d (cos e · a + sin e · n)`, where
//! `d` is the distance, `e` the elevation and `a` a unit vector across `n`. Orbiting turns `a` about `n` and changes
//! `e`.

use glam::{DVec3, Vec3};

use crate::scene::CameraPose;

/// The greatest angle between the view and the horizon, radians: straight up and down would have no direction.
const MAX_ELEVATION: f64 = 85.0 / 180.0 * std::f64::consts::PI;
/// The least and the greatest distance from the target, in parts of the scene's diagonal.
const MIN_DISTANCE: f64 = 1e-4;
const MAX_DISTANCE: f64 = 1e3;

/// The same view with its target beside the middle of the box, to go around that.
pub fn aim(pose: CameraPose, (lower, upper): (Vec3, Vec3)) -> CameraPose {
    let (eye, view) = (pose.eye.as_dvec3(), view(&pose));
    let middle = 0.5 * (lower.as_dvec3() + upper.as_dvec3());
    let distance = (middle - eye).dot(view);
    let is_ahead = distance > MIN_DISTANCE * (upper - lower).as_dvec3().length();
    if is_ahead { CameraPose { target: (eye + distance * view).as_vec3(), ..pose } } else { pose }
}

/// The pose after going around the target by two angles, in radians: to the right, and up.
pub fn orbit(pose: CameraPose, azimuth: f64, elevation: f64) -> CameraPose {
    let up = pose.up.as_dvec3().normalize();
    let from = pose.eye.as_dvec3() - pose.target.as_dvec3();
    let distance = from.length();
    let height = from.dot(up);
    let flat = from - up * height;
    let ahead = if flat.length() > 1e-6 * distance { flat.normalize() } else { up.any_orthonormal_vector() };
    let turned = ahead * azimuth.cos() + up.cross(ahead) * azimuth.sin();
    let angle = ((height / distance).clamp(-1.0, 1.0).asin() + elevation).clamp(-MAX_ELEVATION, MAX_ELEVATION);
    let offset = distance * (turned * angle.cos() + up * angle.sin());
    CameraPose { eye: (pose.target.as_dvec3() + offset).as_vec3(), ..pose }
}

/// The pose at `factor` times the distance from the target, within the useful range for a scene of this diagonal.
pub fn zoom(pose: CameraPose, factor: f64, diagonal: f32) -> CameraPose {
    let from = pose.eye.as_dvec3() - pose.target.as_dvec3();
    let (distance, diagonal) = (from.length(), f64::from(diagonal));
    let within = (factor * distance).clamp(MIN_DISTANCE * diagonal, MAX_DISTANCE * diagonal);
    CameraPose { eye: (pose.target.as_dvec3() + from * (within / distance)).as_vec3(), ..pose }
}

/// The pose moved across the view, in lengths of the distance to the target: to the right, and up.
pub fn pan(pose: CameraPose, right: f64, up: f64) -> CameraPose {
    let ahead = view(&pose);
    let across = ahead.cross(pose.up.as_dvec3()).normalize();
    let distance = pose.eye.as_dvec3().distance(pose.target.as_dvec3());
    let by = distance * (right * across + up * across.cross(ahead));
    let moved = |point: Vec3| (point.as_dvec3() + by).as_vec3();
    CameraPose { eye: moved(pose.eye), target: moved(pose.target), ..pose }
}

/// The pose rotated in place to look at a point; as it is if the point is at the eye, or straight above or below.
pub fn look_at(pose: CameraPose, point: Vec3) -> CameraPose {
    let turned = CameraPose { target: point, ..pose };
    let ahead = (point.as_dvec3() - pose.eye.as_dvec3()).normalize_or_zero();
    let is_across = ahead.cross(pose.up.as_dvec3().normalize()).length() > MAX_ELEVATION.cos();
    if is_across { turned } else { pose }
}

fn view(pose: &CameraPose) -> DVec3 {
    (pose.target.as_dvec3() - pose.eye.as_dvec3()).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSE: CameraPose = CameraPose { eye: Vec3::new(0.0, 0.0, 4.0), target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };

    fn assert_close(a: Vec3, b: Vec3) {
        assert!((a - b).length() < 1e-5, "{a} {b}");
    }

    #[test]
    fn a_quarter_turn_leads_to_the_side() {
        assert_close(orbit(POSE, std::f64::consts::FRAC_PI_2, 0.0).eye, Vec3::new(4.0, 0.0, 0.0));
        let raised = orbit(POSE, 0.0, std::f64::consts::FRAC_PI_6).eye;
        assert_close(raised, Vec3::new(0.0, 2.0, 12.0_f32.sqrt()));
        // There and back; never over the top.
        let there = orbit(orbit(POSE, 0.3, 0.2), -0.3, -0.2);
        assert_close(there.eye, POSE.eye);
        let top = orbit(POSE, 0.0, 9.0).eye;
        assert!(top.y < 4.0 && top.z > 0.0, "{top}");
        let overhead = CameraPose { eye: Vec3::new(0.0, 4.0, 0.0), up: Vec3::Y, ..POSE };
        assert!(orbit(overhead, 0.1, 0.0).eye.is_finite());
    }

    #[test]
    fn zooming_keeps_the_view_and_has_ends() {
        let near = zoom(POSE, 0.5, 1.0);
        assert_eq!((near.eye, near.target), (Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO));
        assert!(zoom(POSE, 0.0, 1.0).eye.z > 0.0 && zoom(POSE, f64::INFINITY, 1.0).eye.is_finite());
    }

    #[test]
    fn panning_moves_eye_and_target_alike() {
        let moved = pan(POSE, 0.25, -0.5);
        assert_close(moved.eye, Vec3::new(1.0, -2.0, 4.0));
        assert_close(moved.target, Vec3::new(1.0, -2.0, 0.0));
    }

    #[test]
    fn aiming_keeps_the_picture() {
        let pose = CameraPose { target: Vec3::new(0.0, 0.0, 3.0), ..POSE };
        assert_close(aim(pose, (Vec3::splat(-1.0), Vec3::splat(1.0))).target, Vec3::ZERO);
        // Points behind are ignored.
        let behind = (Vec3::splat(8.0), Vec3::splat(9.0));
        assert_eq!(aim(pose, behind), pose);
    }

    #[test]
    fn looking_at_a_point_leaves_the_eye() {
        assert_eq!(look_at(POSE, Vec3::new(1.0, 1.0, 0.0)).target, Vec3::new(1.0, 1.0, 0.0));
        for bad in [POSE.eye, POSE.eye + Vec3::Y] {
            assert_eq!(look_at(POSE, bad), POSE);
        }
    }
}
