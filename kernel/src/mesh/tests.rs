//! Trees over meshes of all layouts, against trees over the same triangles in a slice.

use alloc::vec::Vec;

use glam::{Vec3, vec3};

use super::*;
use crate::traverse::tests::{Random, rays_at};
use crate::{Bvh, Error, Executor, InvalidMesh, Quality, RefitError};

/// The second part first.
struct Backwards;

impl Executor for Backwards {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        let b = b();
        (a(), b)
    }
}

/// Vertices of a sheet of `n` by `n` squares, and the indices of its triangles.
fn sheet(n: usize, random: &mut Random) -> (Vec<Vec3>, Vec<u32>) {
    let vertices = (0..(n + 1) * (n + 1))
        .map(|i| vec3((i % (n + 1)) as f32, (i / (n + 1)) as f32, random.unit()) * (1.0 / n as f32))
        .collect();
    let square = |i: usize| {
        let a = (i / n * (n + 1) + i % n) as u32;
        let c = a + n as u32 + 1;
        [a, a + 1, c + 1, a, c + 1, c]
    };
    (vertices, (0..n * n).flat_map(square).collect())
}

fn soup(mesh: &impl Mesh) -> Vec<Triangle> {
    (0..mesh.len()).map(|prim_id| mesh.triangle(prim_id)).collect()
}

/// Bits, as NaN of unused lanes are not equal.
fn bits(bvh: &Bvh) -> (Vec<u32>, Vec<u32>) {
    let tree = bvh.view();
    (bytemuck::cast_slice(tree.nodes()).to_vec(), bytemuck::cast_slice(tree.blocks()).to_vec())
}

#[test]
fn trees_over_any_layout_are_those_over_the_same_triangles() {
    let mut random = Random(61);
    let (vertices, indices) = sheet(60, &mut random);
    let narrow: Vec<u16> = indices.iter().map(|&index| index as u16).collect();
    let strided: Vec<[f32; 8]> = vertices.iter().map(|p| [9.0, 9.0, p.x, p.y, p.z, 9.0, f32::NAN, 9.0]).collect();
    let strided = Positions::f32(bytemuck::cast_slice(&strided), 8, 32).unwrap();
    let (scale, offset) = (vec3(1.5, -2.0, 1.0) / 65535.0, vec3(-3.0, 0.5, 7.0));
    let unsigned: Vec<[u16; 4]> =
        vertices.iter().map(|p| (*p * 60000.0).to_array().map(|x| x as u16)).map(|[x, y, z]| [x, y, z, 7]).collect();
    let signed: Vec<[i16; 3]> = vertices.iter().map(|p| (*p * 30000.0 - 9000.0).to_array().map(|x| x as i16)).collect();
    let unsigned = Positions::u16(bytemuck::cast_slice(&unsigned), 0, 8, scale, offset).unwrap();
    let signed = Positions::i16(bytemuck::cast_slice(&signed), 0, 6, scale, offset).unwrap();
    let in_order: Vec<Vec3> = indices.iter().map(|&index| vertices[index as usize]).collect();
    let meshes = [
        IndexedMesh::new(&vertices[..], Indices::U32(&indices)),
        IndexedMesh::new(&vertices[..], Indices::U16(&narrow)),
        IndexedMesh::new(&in_order[..], Indices::InOrder),
        IndexedMesh::new(strided, Indices::U32(&indices)),
        IndexedMesh::new(strided, Indices::U16(&narrow)),
        IndexedMesh::new(unsigned, Indices::U16(&narrow)),
        IndexedMesh::new(signed, Indices::U32(&indices)),
    ]
    .map(Result::unwrap);
    let first = soup(&meshes[0]);
    assert!(meshes[..5].iter().all(|mesh| soup(mesh) == first));
    assert_eq!(meshes[5].triangle(0)[0], Vec3::from_array(unsigned.get(0).to_array()));
    for (i, mesh) in meshes.iter().enumerate() {
        let triangles = soup(mesh);
        assert_eq!((triangles.len(), mesh.is_empty()), (7200, false));
        let (flat, report) = Bvh::build(&triangles, &Quality::Medium.into()).unwrap();
        let (tree, same) = Bvh::build_mesh_on(&Backwards, mesh, &Quality::Medium.into()).unwrap();
        assert!(bits(&tree) == bits(&flat) && report == same, "{i}");
        let hits = rays_at(&triangles, &mut random, 30);
        assert!(hits.iter().all(|ray| tree.view().intersect(ray) == flat.view().intersect(ray)));
    }
}

#[test]
fn refits_do_not_depend_on_layout_or_executor() {
    let mut random = Random(62);
    let (vertices, indices) = sheet(180, &mut random);
    let mesh = IndexedMesh::new(&vertices[..], Indices::U32(&indices)).unwrap();
    let (tree, _) = Bvh::build_mesh(&mesh, &Quality::Fast.into()).unwrap();
    assert!(tree.view().nodes().len() > 1 << 10);
    let moved: Vec<Vec3> = vertices.iter().map(|p| *p * vec3(2.0, 1.0, 3.0) + random.vector() * 1e-3).collect();
    let mesh = IndexedMesh::new(&moved[..], Indices::U32(&indices)).unwrap();
    let (mut one, mut two, mut three) = (tree.clone(), tree.clone(), tree.clone());
    let refit = one.refit(&soup(&mesh)).unwrap();
    assert_eq!(two.refit_mesh(&mesh).unwrap(), refit);
    assert_eq!(three.refit_mesh_on(&Backwards, &mesh).unwrap(), refit);
    assert!(bits(&one) == bits(&two) && bits(&one) == bits(&three) && bits(&one) != bits(&tree));
    let tree = one.view();
    assert!(crate::BvhView::new(tree.nodes(), tree.blocks()).is_ok());
    assert_eq!(tree.bounds(), tree.nodes()[0].bounds());

    let fewer = IndexedMesh::new(&moved[..], Indices::U32(&indices[..300])).unwrap();
    let refused = |error| Err(Error::Refit(error));
    let shrunk = two.refit_mesh(&fewer);
    assert!(matches!(shrunk, Err(Error::Refit(RefitError::Missing { count: 100, .. }))), "{shrunk:?}");
    let mut broken = moved.clone();
    broken[indices[9] as usize] = Vec3::NAN;
    let broken = IndexedMesh::new(&broken[..], Indices::U32(&indices)).unwrap();
    let vanished = two.refit_mesh(&broken);
    assert!(matches!(vanished, Err(Error::Refit(RefitError::Vanished { .. }))), "{vanished:?}");
    let more: Vec<u32> = indices.iter().chain(&indices[..3]).copied().collect();
    let more = IndexedMesh::new(&moved[..], Indices::U32(&more)).unwrap();
    assert_eq!(two.refit_mesh(&more), refused(RefitError::Appeared { count: 1 }));
    assert!(bits(&one) == bits(&two));
}

#[test]
fn what_is_no_mesh_is_refused() {
    let vertices = [Vec3::ZERO; 4];
    let check = |indices| IndexedMesh::new(&vertices[..], indices).map(|mesh| mesh.len());
    assert_eq!(check(Indices::U16(&[0, 1, 2, 3, 3, 3])), Ok(2));
    assert_eq!(check(Indices::U32(&[])), Ok(0));
    assert_eq!(check(Indices::InOrder), Err(InvalidMesh::IncompleteTriangle { count: 4 }));
    assert_eq!(check(Indices::U16(&[0, 1])), Err(InvalidMesh::IncompleteTriangle { count: 2 }));
    let out = |place, index| Err(InvalidMesh::IndexOutOfRange { place, index, count: 4 });
    assert_eq!(check(Indices::U16(&[0, 1, 4, 65535])), out(2, 4));
    assert_eq!(check(Indices::U32(&[u32::MAX])), out(0, u32::MAX));
}
