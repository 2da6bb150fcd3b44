use glam::{Affine2, DAffine3, Mat3, Vec2};

use super::*;
use crate::scene::{Channel, ColorSpace, GltfAnisotropy, Input, Opacity, Scene, TextureFilter};

/// A square from (0, 0) to (1, 1) seen from +z, whose picture is upright, with normals if asked.
fn square(smooth: bool) -> Mesh {
    Mesh {
        positions: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0)).into(),
        texcoords: [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(Vec2::from).into(),
        lightmap_texcoords: [[0.5, 0.5]; 4].map(Vec2::from).into(),
        normals: if smooth { vec![Vec3::Z; 4] } else { Vec::new() },
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn linear(texture: usize) -> TextureMap {
    TextureMap { texture, space: ColorSpace::Linear, filter: TextureFilter::Nearest, ..TextureMap::default() }
}

/// The material at the point of the square with these coordinates.
fn at<T>(mesh: Mesh, material: &Material, textures: &[Texture], x: f32, y: f32, what: impl Fn(&MeshPoint) -> T) -> T {
    let mut scene = Scene { meshes: vec![mesh], materials: vec![material.clone()], ..Scene::default() };
    scene.complete_tangents();
    // Below the diagonal the point is (b + c, c), above it (b, b + c).
    let (triangle, weights) = if y <= x { (0, [1.0 - x, x - y, y]) } else { (1, [1.0 - y, x, y - x]) };
    what(&MeshPoint { textures, mesh: &scene.meshes[0], triangle, weights, turn: None })
}

/// A texture of one row of texels: a quarter of the square's width each.
fn quarters(texels: [[u8; 4]; 4]) -> Texture {
    Texture::new(4, 1, texels.into())
}

#[test]
fn maps_of_all_inputs_follow_their_own_coordinates() {
    let texture = quarters([[255, 0, 0, 0], [0, 255, 0, 51], [0, 0, 255, 102], [255, 255, 255, 255]]);
    let inputs = Inputs { base_color: Vec3::ONE, specular_roughness: 1.0, coat_weight: 0.5, ..Inputs::default() };
    let mut material = Material { inputs, emission: Vec3::splat(3.0), ..Material::default() };
    material.add_map(linear(0), Input::BaseColor, Channel::Rgb, 0.0);
    material.add_map(linear(0), Input::SpecularRoughness, Channel::G, 0.0);
    // The second set is (0.5, 0.5) everywhere: the third texel.
    material.add_map(TextureMap { set: 1, ..linear(0) }, Input::CoatWeight, Channel::A, 0.0);
    // Half of the picture over the whole square.
    let transform = Affine2::from_scale(Vec2::new(0.5, 1.0));
    material.emission_map = Some(TextureMap { transform, ..linear(0) });
    let found = |x| {
        at(square(false), &material, std::slice::from_ref(&texture), x, 0.3, |point| {
            material.shading_at(point, Vec3::Z)
        })
    };
    let [first, second, last] = [0.1, 0.3, 0.9].map(found);
    assert_eq!([first, second, last].map(|it| it.inputs.base_color), [Vec3::X, Vec3::Y, Vec3::ONE]);
    assert_eq!([first, second, last].map(|it| it.inputs.specular_roughness), [0.0, 1.0, 1.0]);
    assert!([first, second, last].iter().all(|it| (it.inputs.coat_weight - 0.2).abs() < 1e-6));
    assert_eq!([first, second, last].map(|it| it.emission), [Vec3::X, Vec3::X, Vec3::Y].map(|color| 3.0 * color));
}

#[test]
fn meshes_without_coordinates_get_the_mean_and_vertices_their_own_colour() {
    let texture = quarters([[255; 4], [255; 4], [0, 0, 0, 0], [0, 0, 0, 0]]);
    let mut material = Material { uses_vertex_colors: true, ..Material::default() };
    material.inputs.base_color = Vec3::ONE;
    material.add_map(linear(0), Input::BaseColor, Channel::Rgb, 0.0);
    material.opacity = Opacity { value: 1.0, map: Some((linear(0), Channel::A)), cutoff: None };
    let mut mesh = square(false);
    mesh.texcoords.clear();
    mesh.colors =
        [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 1.0]].map(Vec4::from).into();
    let (color, opacity) = at(mesh, &material, &[texture], 0.25, 0.5, |point| {
        (material.inputs_at(point).base_color, material.opacity_at(point))
    });
    assert!((color - Vec3::new(0.375, 0.0, 0.125)).abs().max_element() < 1e-6, "{color}");
    assert!((opacity - 0.375).abs() < 1e-6, "{opacity}");
}

/// Texels that tilt by 30°, to the right, up, and both at once on the way of neither.
#[test]
fn normal_maps_turn_to_the_right_and_up_as_pictures_have_it() {
    let code = |n: f32| ((n * 0.5 + 0.5) * 255.0).round() as u8;
    let texel = |n: Vec3| [code(n.x), code(n.y), code(n.z), 255];
    let (sin, cos) = (0.5, 0.75_f32.sqrt());
    let texture = quarters([
        texel(Vec3::Z),
        texel(Vec3::new(sin, 0.0, cos)),
        texel(Vec3::new(0.0, sin, cos)),
        [128, 128, 128, 255],
    ]);
    let material =
        |scale| Material { normal_map: Some(NormalMap { texture: linear(0), scale }), ..Material::default() };
    let normal = |mesh: Mesh, scale, x| {
        let material = material(scale);
        at(mesh, &material, std::slice::from_ref(&texture), x, 0.4, |point| material.frame_at(point, Vec3::Z))
    };
    let near = |frame: ShadingFrame, expected: Vec3| {
        assert!((frame.normal - expected).length() < 0.01, "{} not {expected}", frame.normal);
        assert_eq!(frame.tangent, Vec3::ZERO, "only anisotropy asks for it");
    };
    for smooth in [false, true] {
        near(normal(square(smooth), Vec2::ONE, 0.1), Vec3::Z);
        near(normal(square(smooth), Vec2::ONE, 0.3), Vec3::new(sin, 0.0, cos));
        near(normal(square(smooth), Vec2::ONE, 0.6), Vec3::new(0.0, sin, cos));
        // Without a direction it is the surface's.
        near(normal(square(smooth), Vec2::ONE, 0.9), Vec3::Z);
        // Green downwards, and no strength.
        near(normal(square(smooth), Vec2::new(1.0, -1.0), 0.6), Vec3::new(0.0, -sin, cos));
        near(normal(square(smooth), Vec2::ZERO, 0.3), Vec3::Z);
    }
    // The mirrored picture tilts to the left, and still up.
    let mut mirrored = square(true);
    mirrored.texcoords.iter_mut().for_each(|uv| uv.x = 1.0 - uv.x);
    near(normal(mirrored.clone(), Vec2::ONE, 0.7), Vec3::new(-sin, 0.0, cos));
    near(normal(mirrored, Vec2::ONE, 0.4), Vec3::new(0.0, sin, cos));
    // Without coordinates there is no tangent, and the normal stays.
    let mut bare = square(true);
    bare.texcoords.clear();
    near(normal(bare, Vec2::ONE, 0.3), Vec3::Z);
}

#[test]
fn bumps_have_the_slope_of_their_heights() {
    // Rises by 1 / 4 of the height a texel to the right: over a square of width 1, by the height in all.
    let texture = quarters([[0; 4], [64; 4], [128; 4], [192; 4]]);
    let smooth = TextureMap { filter: TextureFilter::Bilinear, ..linear(0) };
    for height in [0.1, -0.3] {
        let bump_map = Some(BumpMap { texture: smooth.clone(), channel: Channel::R, height });
        let material = Material { bump_map, ..Material::default() };
        for (scale, mesh) in [(1.0, square(false)), (1.0, square(true)), (2.0, square(true))] {
            let mut mesh = mesh;
            mesh.positions.iter_mut().for_each(|position| *position *= scale);
            let frame = at(mesh, &material, std::slice::from_ref(&texture), 0.5, 0.4, |point| {
                material.frame_at(point, Vec3::Z)
            });
            let slope = height * 256.0 / 255.0 / scale;
            let expected = Vec3::new(-slope, 0.0, 1.0).normalize();
            assert!((frame.normal - expected).length() < 1e-4, "{} not {expected}", frame.normal);
        }
    }
}

#[test]
fn anisotropy_turns_the_tangent() {
    // Right; up; and turned by both the material and the texel.
    let texture = quarters([[255, 128, 255, 255], [128, 255, 128, 255], [0, 128, 255, 255], [128, 0, 0, 255]]);
    let anisotropy = Some(GltfAnisotropy { strength: 1.0, is_by_blender: false, map: Some(linear(0)) });
    let mut material = Material { anisotropy, ..Material::default() };
    material.inputs.specular_roughness = 0.0;
    let found = |material: &Material, x| {
        at(square(true), material, std::slice::from_ref(&texture), x, 0.4, |point| material.shading_at(point, Vec3::Z))
    };
    let near = |found: Vec3, expected: Vec3| assert!((found - expected).length() < 0.01, "{found} not {expected}");
    for x in [0.1, 0.3, 0.6, 0.9] {
        let ShadingFrame { normal, tangent } = found(&material, x).frame;
        assert!(tangent.dot(normal).abs() < 1e-6 && (tangent.length() - 1.0).abs() < 1e-6);
    }
    near(found(&material, 0.1).frame.tangent, Vec3::X);
    near(found(&material, 0.3).frame.tangent, Vec3::Y);
    near(found(&material, 0.6).frame.tangent, Vec3::NEG_X);
    material.tangent_rotation = std::f32::consts::FRAC_PI_2;
    near(found(&material, 0.1).frame.tangent, Vec3::Y);
    near(found(&material, 0.3).frame.tangent, Vec3::NEG_X);
    assert_eq!(found(&material, 0.1).inputs.specular_anisotropy, 1.0);
    assert_eq!(found(&material, 0.9).inputs.specular_anisotropy, 0.0);
}

#[test]
fn normal_maps_apply_before_a_transform_that_distorts_if_the_mesh_asks_for_it() {
    // Normals that lean to the right, up, and both, as the map says them.
    let texels = [[218, 128, 218, 255], [128, 218, 218, 255], [200, 40, 200, 255], [128, 128, 255, 255]];
    let texture = quarters(texels);
    let map = NormalMap { texture: linear(0), scale: Vec2::ONE };
    let mut material = Material { normal_map: Some(map.clone()), ..Material::default() };
    material.coat_normal = CoatNormal::Map(map);
    material.anisotropy = Some(GltfAnisotropy { strength: 0.5, is_by_blender: false, map: None });
    for smooth in [false, true] {
        for linear in [
            Mat3::from_diagonal(Vec3::new(4.0, 0.5, 0.1)),
            Mat3::from_diagonal(Vec3::new(-1.0, 2.0, 1.0)),
            Mat3::from_rotation_x(0.4) * Mat3::from_diagonal(Vec3::new(1.0, 3.0, 1.0)) * Mat3::from_rotation_z(0.6),
        ] {
            let own = Mesh { map_space: Some(Mat3::IDENTITY), ..square(smooth) };
            let to_world = DAffine3::from_mat3_translation(linear.as_dmat3(), DVec3::ONE);
            let placed = own.clone().placed(&to_world);
            let turn = Turn::new(linear);
            let up = turn.normal(Vec3::Z);
            for (x, texel) in [0.1, 0.3, 0.6, 0.9].into_iter().zip(texels) {
                let leaning = Vec3::from([0, 1, 2].map(|it| f32::from(texel[it]) / 255.0 * 2.0 - 1.0));
                let expected = (linear.inverse().transpose() * leaning).normalize();
                let along = (linear * Vec3::X).reject_from_normalized(expected).normalize();
                // The corners of triangles change places where the transform mirrors: both orders are looked at.
                let by_mesh = |mesh: &Mesh, turn: Option<Turn>| {
                    let mirrored = mesh.triangles[0] == [0, 2, 1];
                    at(mesh.clone(), &material, std::slice::from_ref(&texture), x, 0.05, |point| {
                        let [a, b, c] = point.weights;
                        let weights = if mirrored { [a, c, b] } else { [a, b, c] };
                        let point = MeshPoint { weights, turn, ..*point };
                        (material.frame_at(&point, up), material.coat_normal_at(&point, up).unwrap())
                    })
                };
                for (ShadingFrame { normal, tangent }, coat) in [by_mesh(&placed, None), by_mesh(&own, Some(turn))] {
                    assert!(normal.distance(expected) < 1e-5, "{linear} {texel:?}: {normal}, not {expected}");
                    assert!(coat.distance(expected) < 1e-5, "{linear} {texel:?}: {coat}, not {expected}");
                    assert!(tangent.distance(along) < 1e-5, "{linear} {texel:?}: {tangent}, not {along}");
                }
            }
        }
    }
}
