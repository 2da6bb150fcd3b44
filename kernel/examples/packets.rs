//! Rays side by side, eight at a time: a ball and its shadow, as text.
//! `cargo run --release -p halfdome-kernel --example packets`

use core::f32::consts::TAU;

use glam::vec3;
use halfdome_kernel::{BuildOptions, Bvh, Error, HitPacket, Ray, RayPacket, Triangle, offset_origin, triangle_normal};

/// A ball of radius 1 on the plane z = 0, and a square of that plane.
fn scene() -> Vec<Triangle> {
    let on_ball = |i: usize, j: usize| {
        let (azimuth, angle) = (TAU * i as f32 / 48.0, 0.5 * TAU * j as f32 / 24.0);
        vec3(angle.sin() * azimuth.cos(), angle.sin() * azimuth.sin(), 1.0 - angle.cos())
    };
    let mut triangles = Vec::new();
    for (i, j) in (0..48).flat_map(|i| (0..24).map(move |j| (i, j))) {
        let [a, b, c, d] = [on_ball(i, j), on_ball(i + 1, j), on_ball(i + 1, j + 1), on_ball(i, j + 1)];
        triangles.extend([[a, c, b], [a, d, c]]);
    }
    let [a, b, c, d] = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| vec3(x, y, 0.0));
    triangles.extend([[a, b, c], [a, c, d]]);
    triangles
}

fn main() -> Result<(), Error> {
    let triangles = scene();
    let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default())?;
    let tree = bvh.view();
    let (eye, to_light) = (vec3(0.0, -6.0, 2.5), vec3(-0.6, -0.3, 1.0).normalize());
    for row in 0..24 {
        for column in (0..72).step_by(8) {
            // Eight pixels in a row run alike, which is what packets are for.
            let ray = |i: usize| {
                let (x, y) = ((column + i) as f32 / 36.0 - 1.0, 1.0 - row as f32 / 12.0);
                Ray::new(eye, vec3(0.55 * x, 1.0, 0.4 * y - 0.3))
            };
            let rays: [Ray; 8] = core::array::from_fn(ray);
            let mut hits = HitPacket::<8>::MISS;
            tree.intersect_packet(&RayPacket::<8>::from_rays(&rays), &mut hits);

            let to_shadow = |i: usize| {
                let hit = hits.hit(i);
                let triangle = triangles.get(hit.prim_id as usize)?;
                let normal = triangle_normal(triangle);
                Some((
                    Ray::new(offset_origin(triangle, normal, hit.u, hit.v, to_light), to_light),
                    normal.dot(to_light),
                ))
            };
            let shadow: [Option<(Ray, f32)>; 8] = core::array::from_fn(to_shadow);
            let mut packet = RayPacket::<8>::from_rays(&shadow.map(|ray| ray.map_or(rays[0], |(ray, _)| ray)));
            // Nothing was hit there, or it faces away from the light.
            packet.active =
                (0..8).filter(|&i| shadow[i].is_some_and(|(_, cos)| cos > 0.0)).fold(0, |bits, i| bits | 1 << i);
            let occluded = tree.occluded_packet(&packet);
            for (i, shadow) in shadow.iter().enumerate() {
                let lit = packet.active & !occluded & 1 << i != 0;
                let light = shadow.map_or(0.0, |(_, cos)| if lit { cos.max(0.0) } else { 0.0 });
                print!(
                    "{}",
                    if shadow.is_none() { ' ' } else { ['.', ':', '-', '=', '+', '*', '#'][(light * 6.99) as usize] }
                );
            }
        }
        println!();
    }
    Ok(())
}
