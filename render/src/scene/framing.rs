//! A camera for a scene without one.
//!
//! In a closed room it is inside, where it sees farthest towards the middle: a camera outside would see walls. A room
//! is closed if nearly all rays from positions all over it hit the front of a surface; inside a statue they hit backs.
//! Other scenes are viewed from outside:
//!
//! It looks at the middle of the bounds from 30° to the right of the front and 20° above, from the distance at which
//! the sphere around the bounds just fits into the narrower field of view: `distance = radius / sin(angle / 2)`. The
//! front is the side of +z, as glTF has it, or of -y if z is up.

use glam::{DVec3, Vec3};

use halfdome_kernel::sampling::Frame;
use halfdome_kernel::{Bvh, Quality, Ray, Triangle, triangle_normal};

use super::{CameraPose, Scene};

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

/// The part of the rays from inside that must meet fronts, on the whole and at the camera. Windows are open, and some
/// places are within furniture.
const MIN_FRONTS: f32 = 0.85;

/// Vertical field of view inside of rooms, in degrees.
const INSIDE_VFOV: f32 = 60.0;

/// Places along each horizontal axis of the bounds, and their height, as parts of its extents.
const PLACES: [f32; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
const EYE_HEIGHT: f32 = 0.55;

/// The pose inside of a closed room, looking at its middle; `None` if the scene is not a closed room. `vfov` as in
/// [`frame`].
pub(super) fn frame_inside(scene: &Scene, up: Vec3, vfov: Option<f32>) -> Option<CameraPose> {
    let (lower, upper) = scene.bounds()?;
    let triangles: Vec<Triangle> = scene
        .meshes
        .iter()
        .filter(|mesh| mesh.object.is_none())
        .flat_map(|mesh| (0..mesh.triangles.len()).map(|face| mesh.corners(face)))
        .collect();
    let (tree, _) = Bvh::build(&triangles, &Quality::Fast.into()).ok()?;
    let tree = tree.view();
    let up = up.as_dvec3().normalize().as_vec3();
    let axes = Frame::from_normal(up);
    let extent = upper - lower;
    let at = |x: f32, y: f32, height: f32| {
        let across = |axis: Vec3, part: f32| axis * (part - 0.5) * extent.dot(axis.abs());
        0.5 * (lower + upper) + across(axes.tangent, x) + across(axes.bitangent, y) + across(up, height)
    };
    let free = |from: Vec3, direction: Vec3| tree.intersect(&Ray::new(from, direction));
    let fronts = |from: Vec3| {
        let meets_front = |&direction: &Vec3| {
            free(from, direction)
                .is_some_and(|hit| triangle_normal(&triangles[hit.prim_id as usize]).dot(direction) < 0.0)
        };
        directions().filter(meets_front).count() as f32 / directions().count() as f32
    };
    let places: Vec<(f32, Vec3)> = PLACES
        .into_iter()
        .flat_map(|x| PLACES.map(|y| at(x, y, EYE_HEIGHT)))
        .map(|place| (fronts(place), place))
        .collect();
    let mean = places.iter().map(|(fronts, _)| fronts).sum::<f32>() / places.len() as f32;
    if mean < MIN_FRONTS {
        return None;
    }
    let target = at(0.5, 0.5, 0.5 * EYE_HEIGHT + 0.15);
    let view = |&eye: &Vec3| {
        let direction = (target - eye).try_normalize()?;
        let far = free(eye, direction).map_or(f32::INFINITY, |hit| hit.t).min((target - eye).length());
        let clearance = directions().filter_map(|direction| free(eye, direction)).map(|hit| hit.t).fold(far, f32::min);
        (clearance > 0.02 * extent.length()).then_some((far, eye))
    };
    let enclosed = places.iter().filter(|(fronts, _)| *fronts >= MIN_FRONTS).filter_map(|(_, eye)| view(eye));
    let (_, eye) = enclosed.fold(None, |best: Option<(f32, Vec3)>, next| match best {
        Some(best) if best.0 >= next.0 => Some(best),
        _ => Some(next),
    })?;
    (eye.distance(target) > 0.0).then(|| CameraPose { eye, target, up, vfov: vfov.unwrap_or(INSIDE_VFOV) })
}

/// Unit vectors all around: 64 of Fibonacci's spiral.
fn directions() -> impl Iterator<Item = Vec3> {
    const COUNT: usize = 64;
    let golden = core::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..COUNT).map(move |index| {
        let z = 1.0 - (2 * index + 1) as f64 / COUNT as f64;
        let (sin, cos) = (golden * index as f64).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cos, radius * sin, z).as_vec3()
    })
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

    /// A box of walls of some thickness around the origin, without the walls in `missing`, whose fronts are outside.
    fn room(half: Vec3, missing: &[usize]) -> Scene {
        let wall = |side: usize| {
            let (axis, sign) = (side / 2, [-1.0, 1.0][side % 2]);
            let (mut centre, mut size) = (Vec3::ZERO, half + 0.1);
            centre[axis] = sign * (half[axis] + 0.1);
            size[axis] = 0.1;
            solid(centre, size)
        };
        let meshes = (0..6).filter(|side| !missing.contains(side)).map(wall).collect();
        Scene { meshes, materials: vec![super::super::Material::default()], ..Scene::default() }
    }

    /// A box whose fronts are outside.
    fn solid(centre: Vec3, half: Vec3) -> super::super::Mesh {
        let corner = |i: u32| {
            centre
                + half
                    * Vec3::new(
                        [-1.0, 1.0][i as usize & 1],
                        [-1.0, 1.0][i as usize >> 1 & 1],
                        [-1.0, 1.0][i as usize >> 2],
                    )
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        super::super::Mesh { positions: (0..8).map(corner).collect(), triangles, ..Default::default() }
    }

    #[test]
    fn in_a_closed_room_the_camera_stands_inside_with_a_free_view() {
        let half = Vec3::new(3.0, 1.25, 2.0);
        for up in [Vec3::Y, Vec3::Z] {
            let mut scene = room(half, &[]);
            scene.meshes.push(solid(Vec3::new(0.0, -1.0, 0.0), Vec3::new(0.5, 0.25, 0.5)));
            let pose = frame_inside(&scene, up, None).expect("a room");
            assert!(pose.eye.abs().cmplt(half).all(), "{pose:?}");
            assert!(pose.eye.distance(pose.target) > 1.5, "{pose:?}");
        }
        assert_eq!(frame_inside(&room(half, &[]), Vec3::Y, Some(30.0)).unwrap().vfov, 30.0);
    }

    #[test]
    fn open_rooms_and_solids_are_seen_from_outside() {
        let half = Vec3::new(3.0, 1.25, 2.0);
        assert_eq!(frame_inside(&room(half, &[3, 4]), Vec3::Y, None), None);
        assert_eq!(frame_inside(&super::super::cornell_box(), Vec3::Y, None), None);
        let statue = Scene { meshes: vec![solid(Vec3::ZERO, half)], ..room(half, &[]) };
        assert_eq!(frame_inside(&statue, Vec3::Y, None), None);
        assert_eq!(frame_inside(&Scene::default(), Vec3::Y, None), None);
    }
}
