//! Lenses: what is sharp, and how wide what is not becomes.

use super::*;

/// The points of the film whose rays hit a small thing at depth `z` are those whose rays through some point of the lens
/// pass it: a disc of the diameter `A f / s · |z - s| / z`, with the focal length `f` in the units of the film.
#[test]
fn the_circle_of_confusion_has_the_size_of_a_thin_lens() {
    const SIDE: u32 = 1000;
    let (focus, aperture) = (4.0, 0.5);
    let point_at = |depth: f32| FRONT.eye + vec3(0.0, 0.0, -depth);
    for (is_parallel, depth) in [(false, 2.0), (false, 3.0), (false, 8.0), (false, 40.0), (true, 2.0), (true, 10.0)] {
        let height = 8.0;
        let projection = if is_parallel { Projection::Orthographic { height } } else { Projection::Perspective };
        let lens = Lens { radius: 0.5 * aperture, focus, blades: 0, rotation: 0.0, ratio: 1.0 };
        let camera = Camera::new(&FRONT, &Optics { projection, lens: Some(lens), ..Optics::default() }, SIDE, SIDE);
        // In parts of the film's height the focal length is 1 / (2 tan(v/2)), here 1/2. Parallel rays make a disc of
        // A |z - s| / s, of the height that is seen.
        let blur: f32 = (depth - focus) / focus;
        let expected = if is_parallel { aperture * blur.abs() / height } else { 0.5 * aperture * blur.abs() / depth };
        let (mut hits, mut reach, steps) = (0, 0.0f32, 600);
        let extent = 1.5 * expected * SIDE as f32;
        // From every point of the film around, whether some ray passes: where the lens would have to be crossed.
        for (i, j) in (0..steps).flat_map(|j| (0..steps).map(move |i| (i, j))) {
            let at = |k: i32| ((k as f32 + 0.5) / steps as f32 - 0.5) * extent;
            let film = FilmPoint::within(Vec2::new(500.0 + at(i), 500.0 + at(j)));
            // Rays of a point of the film meet in the plane that is sharp.
            let sharp = {
                let central = camera.central_ray(&film).unwrap();
                central.at(focus / -central.direction.z)
            };
            let way = point_at(depth) - sharp;
            let crossing = sharp + way * ((FRONT.eye.z - sharp.z) / way.z);
            let middle = if is_parallel { camera.central_ray(&film).unwrap().origin } else { FRONT.eye };
            if (crossing - middle).length() <= 0.5 * aperture {
                hits += 1;
                reach = reach.max(at(i).hypot(at(j)));
            }
        }
        let area = hits as f32 * (extent / steps as f32).powi(2);
        let diameter = 2.0 * (area / std::f32::consts::PI).sqrt() / SIDE as f32;
        assert!((diameter / expected - 1.0).abs() < 0.01, "{depth}: {diameter} {expected}");
        assert!((2.0 * reach / SIDE as f32 / expected - 1.0).abs() < 0.01);
    }
}

/// The rays of a sample do go from the lens to where its central ray meets the sharp plane, and fill the lens evenly.
#[test]
fn the_rays_of_a_lens_meet_in_the_sharp_plane() {
    let lens = Lens { radius: 0.25, focus: 4.0, blades: 0, rotation: 0.0, ratio: 1.0 };
    for projection in [Projection::Perspective, Projection::Orthographic { height: 3.0 }] {
        let camera = Camera::new(&POSE, &Optics { projection, lens: Some(lens), ..Optics::default() }, 30, 20);
        let forward = (POSE.target - POSE.eye).normalize();
        let film = FilmPoint::within(Vec2::new(22.2, 3.4));
        let central = camera.central_ray(&film).unwrap();
        let sharp = central.at(4.0 / central.direction.dot(forward));
        let mut squares = 0.0;
        for i in 0..1024 {
            let u = Vec2::new((i % 32) as f32 + 0.5, (i / 32) as f32 + 0.5) / 32.0;
            let ray = camera.ray(&FilmSample { film, lens: u });
            let offset = ray.origin - central.origin;
            assert!(offset.dot(forward).abs() < 1e-6 && offset.length() <= 0.25);
            squares += offset.length_squared() / 1024.0;
            assert!((ray.direction.length() - 1.0).abs() < 1e-6);
            assert!((sharp - ray.origin).normalize().cross(ray.direction).length() < 1e-6);
        }
        // Over a disc of radius R the mean square of the distance is R²/2.
        assert!((squares / (0.5 * 0.25 * 0.25) - 1.0).abs() < 0.02, "{squares}");
    }
}
