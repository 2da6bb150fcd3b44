//! Tufts of grass, round curves with a tip, and drops of dew, spheres, drawn as a PGM picture:
//! `cargo run --release -p halfdome-kernel --example curves > curves.pgm`.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{Affine3A, Vec3, vec3};
use halfdome_kernel::scene::{Item, Scene, SceneHit, SceneRay};
use halfdome_kernel::{CubicCurve, Error, LinearCurve, Quality, Ray, RoundBvh, RoundSurface, Sphere};

/// The fractional parts of multiples of a number that is not a fraction: evenly spread.
fn spread(i: usize, step: f32) -> f32 {
    (i as f32 * step).fract()
}

/// A blade in four points, bent over, which becomes three cubic curves.
fn blade(i: usize) -> [Sphere; 4] {
    let (sin, cos) = (spread(i, 0.618_034) * TAU).sin_cos();
    let (root, bend) = (vec3(cos, sin, 0.0) * spread(i, 0.754_878).sqrt() * 0.6, 0.3 + 0.7 * spread(i, 0.569_84));
    let lean = vec3(cos, sin, 0.0) * bend;
    [0.0, 1.0, 2.0, 3.0].map(|k: f32| {
        let height = k * (0.36 - 0.05 * bend * k);
        Sphere::new(root + lean * (0.07 * k * k) + Vec3::Z * height, 0.035 * (1.0 - k / 3.0))
    })
}

fn main() -> Result<(), Error> {
    let blades: Vec<[Sphere; 4]> = (0..90).map(blade).collect();
    let grass: Vec<CubicCurve> = blades.iter().flat_map(|points| CubicCurve::strand(points)).collect();
    let dew: Vec<Sphere> =
        blades.iter().step_by(7).map(|points| Sphere::new(points[2].center + vec3(0.0, 0.0, 0.05), 0.05)).collect();
    let rail: Vec<LinearCurve> = (0..9)
        .map(|i| {
            let post = vec3(i as f32 - 4.0, 2.6, 0.0);
            LinearCurve { ends: [Sphere::new(post, 0.12), Sphere::new(post + vec3(0.0, 0.0, 1.6), 0.06)] }
        })
        .chain([LinearCurve {
            ends: [Sphere::new(vec3(-5.0, 2.6, 1.1), 0.05), Sphere::new(vec3(5.0, 2.6, 1.1), 0.05)],
        }])
        .collect();
    let floor = [Sphere::new(vec3(0.0, 0.0, -400.0), 400.0)];

    let options = Quality::High.into();
    let (tuft, report) = RoundBvh::build(&grass, &options)?;
    eprintln!("{report}");
    let tuft = Arc::new(tuft);
    let drops = Arc::new(RoundBvh::build(&dew, &options)?.0);
    let mut scene: Scene<'static> = Scene::new(options);
    scene.insert(Item::new(Arc::new(RoundBvh::build(&floor, &options)?.0)))?;
    scene.insert(Item::new(Arc::new(RoundBvh::build(&rail, &options)?.0)))?;
    // The same tuft many times.
    for i in 0..24 {
        let place = vec3((i % 8) as f32 - 3.5, (i / 8) as f32 * 1.1 - 0.8, 0.0)
            + vec3(spread(i, 0.73), spread(i, 0.39), 0.0) * 0.4;
        let place = Affine3A::from_translation(place) * Affine3A::from_rotation_z(i as f32);
        scene.insert(Item::new(tuft.clone()).placed(&place)?)?;
        scene.insert(Item::new(drops.clone()).placed(&place)?)?;
    }
    scene.commit()?;
    let view = scene.view();

    let (width, height) = (480, 270);
    let rays: Vec<SceneRay> = (0..width * height)
        .map(|i| {
            let (x, y) = ((i % width) as f32 / width as f32 - 0.5, 0.5 - (i / width) as f32 / height as f32);
            Ray::new(vec3(0.0, -9.0, 3.6), vec3(x, 1.0, -0.32) + vec3(0.0, 0.3, 0.95) * y * 0.56).into()
        })
        .collect();
    let mut hits = vec![SceneHit::MISS; rays.len()];
    view.intersect_many(&rays, &mut hits);

    println!("P2 {width} {height} 255");
    let light = vec3(-0.6, -0.5, 0.62);
    for (ray, found) in rays.iter().zip(&hits) {
        // The surface is told in the item's own space.
        let shade = view.to_scene(found, 0.0).and_then(|to_scene| {
            let (to_item, prim) = (to_scene.inverse(), found.hit.prim_id as usize);
            let local =
                Ray::new(to_item.transform_point3(ray.ray.origin), to_item.transform_vector3(ray.ray.direction));
            let surface = match found.item {
                0 => RoundSurface::of(&local, &floor[prim]),
                1 => RoundSurface::of(&local, &rail[prim]),
                id if id % 2 == 0 => RoundSurface::of(&local, &grass[prim]),
                _ => RoundSurface::of(&local, &dew[prim]),
            }?;
            let origin = to_scene.transform_point3(surface.origin(to_item.transform_vector3(light)));
            let cosine = to_scene.transform_vector3(surface.shading_normal).dot(light).max(0.0);
            let is_lit = !view.occluded(&Ray::new(origin, light).into());
            Some(0.15 + if is_lit { 0.85 * cosine } else { 0.0 })
        });
        println!("{}", (shade.unwrap_or(0.6) * 255.0) as u8);
    }
    Ok(())
}
