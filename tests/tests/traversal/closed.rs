//! A closed mesh has no leaks.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use halfdome_kernel::traverse::reference;
use halfdome_kernel::{BuildOptions, Bvh, HitPacket, Ray, RayPacket, Triangle};
use halfdome_tests::check::check_tree;
use halfdome_tests::random::Pcg;

/// A sphere: an icosahedron whose faces are quartered `levels` times.
fn icosphere(levels: u32) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points: Vec<DVec3> = [0, 1, 2]
        .into_iter()
        .flat_map(|axis| [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(a, b)| (axis, a, b)))
        .map(|(axis, a, b)| {
            let mut point = [0.0; 3];
            (point[axis], point[(axis + 1) % 3]) = (a, b * golden);
            DVec3::from(point).normalize()
        })
        .collect();
    let near = |a: usize, b: usize, points: &[DVec3]| points[a].dot(points[b]) > 0.4;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b, &points) && near(b, c, &points) && near(a, c, &points) {
                    faces.push([a, b, c]);
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in faces {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    points.push((points[a] + points[b]).normalize());
                    points.len() - 1
                })
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        faces = finer;
    }
    (points, faces)
}

/// A bumpy sphere that every ray from its middle crosses once.
fn bumpy_sphere() -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let (points, faces) = icosphere(5);
    let bump = |p: DVec3| p * (1.0 + 0.2 * (5.0 * p.x).sin() * (7.0 * p.y).cos() + 0.1 * (11.0 * p.z).sin());
    (points.into_iter().map(|p| bump(p).as_vec3()).collect(), faces)
}

#[test]
fn a_closed_mesh_leaks_through_no_corner_edge_or_face() {
    let (points, faces) = bumpy_sphere();
    let triangles: Vec<Triangle> = faces.iter().map(|face| face.map(|i| points[i])).collect();
    assert_eq!((triangles.len(), points.len()), (20_480, 10_242));
    let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
    let tree = bvh.view();
    // From the middle all aims are at distance one. The last number tells whether the index is certain.
    let mut aims: Vec<(Vec3, Option<usize>)> = points.iter().map(|&point| (point, None)).collect();
    for (index, [a, b, c]) in triangles.iter().enumerate() {
        aims.extend([((a + b) * 0.5, None), (a * 0.3 + c * 0.7, None), ((a + b + c) / 3.0, Some(index))]);
    }
    for &(aim, prim) in &aims {
        let ray = Ray::new(Vec3::ZERO, aim);
        let hit = tree.intersect(&ray).unwrap_or_else(|| panic!("the ray to {aim} leaks"));
        assert!((hit.t - 1.0).abs() < 1e-4 && prim.is_none_or(|prim| prim == hit.prim_id as usize), "{hit:?} {aim}");
        assert!(tree.occluded(&ray));
    }
    // From anywhere inside, packed.
    let mut random = Pcg::new(5);
    for _ in 0..20 {
        let origin = (random.in_cube() * 0.3).as_vec3();
        for chunk in aims.chunks(8) {
            let rays: Vec<Ray> = chunk.iter().map(|(aim, _)| Ray::new(origin, aim - origin)).collect();
            let packet = RayPacket::<8>::from_rays(&rays);
            assert_eq!(tree.occluded_packet(&packet), packet.active, "from {origin}");
            let mut hits = HitPacket::MISS;
            tree.intersect_packet(&packet, &mut hits);
            assert!((0..rays.len()).all(|lane| hits.t[lane] <= 1.0001), "from {origin}");
        }
    }
}

/// What is far from the origin is coarse, but closed: corners that were rounded are still shared.
#[test]
fn no_ray_gets_into_or_out_of_a_sphere_wherever_it_is() {
    let (points, faces) = icosphere(3);
    let mut random = Pcg::new(6);
    for center in [DVec3::ZERO, DVec3::splat(1e3), DVec3::splat(1e5), DVec3::new(148_376.0, 1234.0, -223_423.0)] {
        let points: Vec<Vec3> = points.iter().map(|&p| (p + center).as_vec3()).collect();
        let triangles: Vec<Triangle> = faces.iter().map(|face| face.map(|i| points[i])).collect();
        let mut aims = points.clone();
        aims.extend(triangles.iter().flat_map(|&[a, b, c]| [(a + b) * 0.5, b.lerp(c, 0.3), (a + b + c) / 3.0]));
        let mut rays: Vec<Ray> = Vec::new();
        for &aim in &aims {
            // Out through the aim, and in through it on the way to the point inside.
            let inside = (center + random.in_cube() * 0.3).as_vec3();
            rays.push(Ray::new(inside, aim - inside));
            rays.push(Ray::between(inside + (aim - inside) * (2.0 + 10.0 * random.unit() as f32), inside));
        }
        // Along the axes from the middle.
        let middle = center.as_vec3();
        rays.extend(Vec3::AXES.iter().flat_map(|&axis| [Ray::new(middle, axis), Ray::new(middle, -axis)]));
        let (bvh, report) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
        assert_eq!(report.dropped(), report.degenerate);
        let expected: Vec<_> = rays.iter().map(|ray| reference::intersect(&bvh.view(), ray)).collect();
        let leak = rays.iter().zip(&expected).find(|(_, hit)| hit.is_none());
        assert_eq!(leak, None, "at {center}");
        let third = |at: usize| (rays[at], expected[at]);
        let (rays, expected): (Vec<Ray>, Vec<_>) = (0..rays.len()).step_by(3).map(third).unzip();
        check_tree(&bvh.view(), &rays, &expected);
    }
}
