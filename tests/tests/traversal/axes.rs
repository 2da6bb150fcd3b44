//! Rays along axes and diagonals, on faces and planes and in flat boxes: the same hits in all ways, after few visits.

use glam::{Vec3, vec3};
use halfdome_kernel::traverse::reference;
use halfdome_kernel::{BuildOptions, Bvh, Quality, Ray, Triangle};
use halfdome_tests::check::{check, check_tree};

/// The 26 directions to the neighbours of a cell, with their zeros in both signs.
fn directions() -> Vec<Vec3> {
    let steps = [-1.0f32, 0.0, -0.0, 1.0];
    let all = (0..64).map(|i| vec3(steps[i & 3], steps[i >> 2 & 3], steps[i >> 4]));
    all.filter(|&direction| direction != Vec3::ZERO).collect()
}

/// A cube of `side` cells' walls, of two triangles each: boxes that are flat, and touch each other.
fn walls(side: usize) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for i in 0..side.pow(3) {
            let cell = [i % side, i / side % side, i / side / side].map(|x| x as f32);
            let [u, v] = [1, 2].map(|next| Vec3::AXES[(axis + next) % 3]);
            let corner = Vec3::from(cell);
            triangles.extend([[corner, corner + u, corner + u + v], [corner, corner + u + v, corner + v]]);
        }
    }
    triangles
}

#[test]
fn there_are_26_directions_whatever_their_zeros() {
    let mut distinct: Vec<[i32; 3]> = directions().iter().map(|d| d.to_array().map(|x| x as i32)).collect();
    assert_eq!(distinct.len(), 56);
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!(distinct.len(), 26);
}

#[test]
fn all_directions_from_corners_edges_faces_and_cells() {
    let triangles = walls(4);
    let mut rays = Vec::new();
    for origin in [0.0f32, 0.5, 2.0, 2.25, 4.0, -1.0, 5.0] {
        for other in [0.0f32, 1.5, 3.0] {
            for direction in directions() {
                for origin in [vec3(origin, other, other), vec3(other, origin, 1.0), vec3(1.0, other, origin)] {
                    rays.push(Ray::new(origin, direction));
                }
            }
        }
    }
    let hits = check(&triangles, &rays);
    assert!(hits.iter().flatten().count() > rays.len() / 3);
    // What starts on a wall and crosses it hits it there.
    let on_wall = Ray::new(vec3(2.0, 1.5, 1.25), Vec3::NEG_X);
    assert_eq!(check(&triangles, &[on_wall])[0].map(|hit| hit.t), Some(0.0));
}

#[test]
fn zeros_of_either_sign_give_the_same_hits() {
    let triangles = walls(3);
    let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
    for direction in directions() {
        for origin in [vec3(1.5, 1.5, 1.5), vec3(1.0, 1.5, 0.5), vec3(1.0, 1.0, 1.0), vec3(-2.0, 0.0, 1.25)] {
            let hit = |direction| reference::intersect(&bvh.view(), &Ray::new(origin, direction));
            assert_eq!(hit(direction), hit(direction + 0.0), "{origin} {direction}");
        }
    }
}

/// Terrain of 20,000 triangles. From above a ray must not visit much more than it would a little aslant.
#[test]
fn rays_along_axes_visit_little() {
    const SIDE: usize = 100;
    let height = |x: usize, z: usize| ((x * 37 + z * 61) % 17) as f32 * 0.2;
    let point = |x: usize, z: usize| vec3(x as f32, height(x, z), z as f32);
    let triangles: Vec<Triangle> = (0..SIDE * SIDE)
        .flat_map(|cell| {
            let (x, z) = (cell % SIDE, cell / SIDE);
            let [a, b, c, d] = [point(x, z), point(x + 1, z), point(x + 1, z + 1), point(x, z + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    for quality in Quality::ALL {
        let (bvh, _) = Bvh::build(&triangles, &quality.into()).unwrap();
        let tree = bvh.view();
        let all = (tree.nodes().len() + tree.blocks().len()) as u64;
        let mut rays = Vec::new();
        for i in 0..50 {
            // On grid lines, on split planes, between them.
            let (x, z) = (i as f32 * 2.0, (i * 7 % 50) as f32 * 1.5);
            for zero in [0.0f32, -0.0] {
                let down = Ray::new(vec3(x, 10.0, z), vec3(zero, -1.0, zero));
                let visits = tree.intersect_visits(&down).total();
                assert!(visits * 20 < all, "{quality}: {visits} visits of {all}, {down:?}");
                // A thousandth aslant it may meet other boxes, but no fewer by much.
                let aslant = tree.intersect_visits(&Ray { direction: vec3(1e-3, -1.0, 1e-3), ..down }).total();
                assert!(visits <= 4 * aslant + 16, "{quality}: {visits} and {aslant} visits, {down:?}");
                rays.push(down);
            }
        }
        let expected: Vec<_> = rays.iter().map(|ray| reference::intersect(&tree, ray)).collect();
        assert!(expected.iter().all(Option::is_some));
        check_tree(&tree, &rays, &expected);
    }
}
