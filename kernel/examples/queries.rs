//! Queries of engines: filters, all hits, sides, the closest point, overlaps, refitting. `cargo run -p halfdome-kernel
//! --example queries`

use core::ops::ControlFlow;

use glam::{Vec3, vec3};
use halfdome_kernel::{
    Aabb, BuildOptions, Bvh, Error, Facing, Hit, Ray, Triangle, Verdict, offset_origin, triangle_normal,
};

/// A sheet of two triangles across the z axis, with its front towards +z.
fn sheet(z: f32) -> [Triangle; 2] {
    let [a, b, c, d] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| vec3(x, y, z));
    [[a, b, c], [a, c, d]]
}

fn main() -> Result<(), Error> {
    // Four sheets, one above the other: the numbers of their triangles are 0 and 1, 2 and 3, 4 and 5, 6 and 7.
    let mut triangles: Vec<Triangle> = (0..4).flat_map(|i| sheet(i as f32)).collect();
    let (mut bvh, _) = Bvh::build(&triangles, &BuildOptions::default())?;
    let tree = bvh.view();
    let down = Ray::new(vec3(0.5, 0.25, 10.0), Vec3::NEG_Z);

    // The topmost sheet is glass, say, and the second has a hole to the right of the middle.
    let solid = |hit: &Hit| {
        let is_glass = hit.prim_id >= 6;
        let is_hole = (4..6).contains(&hit.prim_id) && down.at(hit.t).x > 0.0;
        if is_glass || is_hole { Verdict::Reject } else { Verdict::Accept }
    };
    println!("the nearest hit is {:?}", tree.intersect(&down));
    println!("the nearest on what is solid is {:?}", tree.intersect_filtered(&down, solid));
    println!("the nearest on a back is {:?}", tree.intersect_facing(&down, Facing::Back));

    println!("{} hits in all, nearest first:", tree.count_hits(&down));
    for hit in tree.hits(&down) {
        println!("  triangle {} at t = {}", hit.prim_id, hit.t);
    }
    let mut two = [Hit::MISS; 2];
    let found = tree.nearest_hits(&down, &mut two);
    println!("the nearest {found} are of the triangles {:?}", two.map(|hit| hit.prim_id));

    // A ray that starts on a surface, without hitting it.
    let first = tree.intersect(&down).expect("above the sheets");
    let triangle = &triangles[first.prim_id as usize];
    let origin = offset_origin(triangle, triangle_normal(triangle), first.u, first.v, down.direction);
    let next = tree.intersect(&Ray::new(origin, down.direction)).expect("there are more sheets");
    println!("onwards from {origin}: triangle {} at t = {}", next.prim_id, next.t);

    let closest = tree.closest_point(vec3(3.0, 0.5, 1.75), f32::INFINITY).expect("there are triangles");
    println!("the closest point is {} on triangle {}, {} away", closest.point, closest.prim_id, closest.distance);
    println!("within 1.5 there is {:?}", tree.closest_point(vec3(3.0, 0.5, 1.75), 1.5));

    let aabb = Aabb { min: vec3(0.2, -0.9, 0.5), max: vec3(0.9, -0.5, 2.5) };
    let _ = tree.for_each_overlap(&aabb, |prim_id| {
        println!("triangle {prim_id} overlaps the box");
        ControlFlow::Continue(())
    });

    // The sheets turn, and the tree follows.
    for triangle in triangles.as_flattened_mut() {
        *triangle = vec3(triangle.z - 1.5, triangle.y, triangle.x);
    }
    let refit = bvh.refit(&triangles)?;
    println!(
        "refitted: a ray costs {}, {} of before; build again: {}",
        refit.cost,
        refit.cost_ratio,
        refit.should_rebuild()
    );
    println!("the nearest hit is now {:?}", bvh.view().intersect(&down));
    Ok(())
}
