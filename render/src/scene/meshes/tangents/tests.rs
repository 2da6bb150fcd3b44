use halfdome_kernel::sampling::Stream;

use super::*;
use crate::scene::{ColorSpace, Material, NormalMap, TextureMap};

/// A square seen from +z; texture coordinates go right and down, or are given.
fn square(texcoords: [[f32; 2]; 4]) -> Mesh {
    Mesh {
        positions: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0)).into(),
        texcoords: texcoords.map(Vec2::from).into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

const UPRIGHT: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];

#[test]
fn tangents_point_right_and_bitangents_up_in_pictures() {
    for (texcoords, expected) in [
        (UPRIGHT, Vec4::new(1.0, 0.0, 0.0, 1.0)),
        // The mirrored picture: right is -x, and up needs the other sign.
        (UPRIGHT.map(|[u, v]| [1.0 - u, v]), Vec4::new(-1.0, 0.0, 0.0, -1.0)),
        // A quarter turn: u goes up, v right.
        (UPRIGHT.map(|[u, v]| [1.0 - v, u]), Vec4::new(0.0, 1.0, 0.0, 1.0)),
    ] {
        for corner in tangents(&square(texcoords), 0).into_iter().flatten() {
            assert!((corner - expected).abs().max_element() < 1e-6, "{corner}, not {expected}");
        }
    }
}

#[test]
fn only_meshes_that_need_tangents_get_them() {
    let texture = TextureMap { space: ColorSpace::Linear, ..TextureMap::default() };
    let normal_map = Some(NormalMap { texture, scale: Vec2::ONE });
    let mut bare = square(UPRIGHT);
    bare.texcoords.clear();
    bare.material = 1;
    let mut given = square(UPRIGHT);
    (given.material, given.tangents) = (1, vec![[Vec4::X; 3]; 2]);
    let needy = Mesh { material: 1, ..square(UPRIGHT) };
    let materials = vec![Material::default(), Material { normal_map, ..Material::default() }];
    let mut scene = Scene { meshes: vec![square(UPRIGHT), bare, given, needy], materials, ..Scene::default() };
    scene.complete_tangents();
    let lengths = scene.meshes.iter().map(|mesh| mesh.tangents.len()).collect::<Vec<_>>();
    assert_eq!(lengths, [0, 0, 2, 2]);
    assert_eq!(scene.meshes[2].tangents[0][0], Vec4::X);
}

#[test]
fn triangles_without_extent_have_no_tangent_and_no_nan() {
    let found = tangents(&square([[0.5; 2]; 4]), 0);
    assert!(found.iter().flatten().all(|tangent| tangent.is_finite()), "{found:?}");
    let mut point = square(UPRIGHT);
    point.positions = vec![Vec3::ONE; 4];
    assert!(tangents(&point, 0).iter().flatten().all(|tangent| tangent.is_finite()));
}

/// A grid of two islands, one of them mirrored, with all that the library treats apart: vertices that are split, triangles
/// that are repeated, that have no extent, or whose pictures have none, and mirrored ones among others.
fn patchwork(seed: u64) -> Mesh {
    const SIDE: u32 = 24;
    let random = |place: u32, set| Stream::new(seed, place, set).uniform2(0);
    let mut mesh = Mesh::default();
    for i in 0..SIDE * SIDE {
        let (x, y) = ((i % SIDE) as f32, (i / SIDE) as f32);
        let bent = random(i, 0);
        mesh.positions.push(Vec3::new(x - 1.0, y - 30.0, 0.3 * bent.y - 1.0));
        mesh.normals.push(Vec3::new(0.2 * bent.x, 0.2 * bent.y, 1.0).normalize());
        mesh.texcoords.push(Vec2::new((x - 11.5).abs() + 0.2 * bent.y, y));
    }
    for i in 0..(SIDE - 1) * SIDE {
        let (chance, a) = (random(i, 1), i);
        if i % SIDE == SIDE - 1 {
            continue;
        }
        let (b, c, d) = (a + 1, a + SIDE, a + SIDE + 1);
        mesh.triangles.extend([[a, b, c], [b, d, c]]);
        match (16.0 * chance.x) as u32 {
            // Without extent, ...
            0 => mesh.triangles.push([a, c, c]),
            // ... another at the same place, ...
            1 => mesh.triangles.push([c, b, a]),
            2 => mesh.triangles.push([a, b, c]),
            // ... a point of the map for all corners, ...
            3 => mesh.texcoords[b as usize] = mesh.texcoords[a as usize],
            // ... and a corner with a vertex of its own, of the same normal or of another.
            4 | 5 => {
                let copy = mesh.positions.len() as u32;
                // A zero may have either sign.
                let [x, y, z] = mesh.positions[b as usize].to_array();
                mesh.positions.push(Vec3::new(if x == 0.0 { -0.0 } else { x }, y, z));
                mesh.texcoords.push(mesh.texcoords[b as usize]);
                mesh.normals.push(if chance.y < 0.5 { mesh.normals[b as usize] } else { Vec3::Z });
                let last = mesh.triangles.len() - 1;
                mesh.triangles[last][0] = copy;
            }
            _ => {}
        }
    }
    mesh
}

#[test]
fn parts_give_what_the_whole_mesh_gives() {
    for seed in 0..40 {
        let mut mesh = patchwork(seed);
        if seed % 4 == 3 {
            // No neighbour has a neighbour's number.
            mesh.triangles.sort_by_key(|triangle| (7919 * triangle[0]) % 1009);
        }
        if seed % 5 == 4 {
            mesh.map_space = Some(Mat3::from_diagonal(Vec3::new(1.0, -2.0, 0.5)));
        }
        let whole = tangents_in_parts(&mesh, 0, usize::MAX, usize::MAX);
        assert!(whole.iter().flatten().any(|it| it.w < 0.0) && whole.iter().flatten().any(|it| it.w > 0.0));
        for part in [1, 7, 100] {
            assert_eq!(tangents_in_parts(&mesh, 0, part, usize::MAX), whole, "seed {seed}, parts of {part}");
        }
        // Too many around a part.
        assert_eq!(tangents_in_parts(&mesh, 0, 100, 120), whole);
    }
}

/// A disc of as many triangles as would overflow the stack of the thread.
#[test]
fn many_triangles_may_meet() {
    let count = 5000;
    let rim = (0..count).map(|i| {
        let (y, x) = (std::f32::consts::TAU * i as f32 / count as f32).sin_cos();
        Vec3::new(x, y, 0.0)
    });
    let positions: Vec<Vec3> = std::iter::once(Vec3::ZERO).chain(rim).collect();
    let disc = Mesh {
        texcoords: positions.iter().map(|position| Vec2::new(position.x, -position.y)).collect(),
        triangles: (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect(),
        positions,
        ..Mesh::default()
    };
    let small = std::thread::Builder::new().stack_size(1 << 19).spawn(move || tangents(&disc, 0));
    let found = small.unwrap().join().unwrap();
    assert!(found.iter().flatten().all(|tangent| (*tangent - Vec4::new(1.0, 0.0, 0.0, 1.0)).length() < 1e-3));
}
