//! A triangle, a ray, a hit, and a row of rays drawn as text: `cargo run -p halfdome-kernel --example triangle`.

use glam::{Vec3, vec3};
use halfdome_kernel::{BuildOptions, Bvh, Hit, Ray};

fn main() -> Result<(), halfdome_kernel::Error> {
    let triangles = [[vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)]];
    let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default())?;
    let tree = bvh.view();

    let hit = tree.intersect(&Ray::new(vec3(0.0, 0.0, 3.0), Vec3::NEG_Z)).expect("straight at it");
    println!("hit triangle {} at t = {}, u = {}, v = {}", hit.prim_id, hit.t, hit.u, hit.v);

    for y in (-5..=5).rev() {
        let row = (-12..=12).map(|x| Ray::new(vec3(x as f32 / 10.0, y as f32 / 5.0, 3.0), Vec3::NEG_Z));
        let rays: Vec<Ray> = row.collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        tree.intersect_many(&rays, &mut hits);
        println!("{}", hits.iter().map(|hit| if hit.is_hit() { '#' } else { '.' }).collect::<String>());
    }
    Ok(())
}
