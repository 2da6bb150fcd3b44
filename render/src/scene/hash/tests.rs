//! Hashes follow what is seen.

use glam::Vec3;

use super::*;
use crate::scene::{CoatNormal, FisheyeMapping, NormalMap, RayTable, Texture, TextureMap, cornell_box};

#[test]
fn the_hash_follows_what_is_seen_and_nothing_else() {
    let scene = cornell_box();
    let mut same = scene.clone();
    same.warnings.push("anything".to_owned());
    same.meshes[0].name.clear();
    assert_eq!(scene.hash(), same.hash());
    let mut moved = scene.clone();
    moved.meshes[0].positions[0].x = moved.meshes[0].positions[0].x.next_up();
    let mut darker = scene.clone();
    darker.materials[0].inputs.base_color *= 0.5;
    let mut lit = scene.clone();
    lit.sky.radiance.z = 1.0;
    let mut mirror = scene.clone();
    mirror.materials[0].inputs.base_metalness = 1.0;
    let mut rough = scene.clone();
    rough.materials[0].inputs.specular_roughness = 0.9;
    let mut bumpy = scene.clone();
    bumpy.materials[0].normal_map = Some(NormalMap { texture: TextureMap::default(), scale: Vec2::ONE });
    let mut smooth_coat = scene.clone();
    smooth_coat.materials[0].coat_normal = CoatNormal::OfVertices;
    let mut bumpy_coat = scene.clone();
    bumpy_coat.materials[0].coat_normal = CoatNormal::Map(bumpy.materials[0].normal_map.clone().unwrap());
    let mut faint = scene.clone();
    faint.materials[0].opacity.value = 0.5;
    let mut holes = scene.clone();
    holes.materials[0].opacity.cutoff = Some(0.5);
    let mut textured = scene.clone();
    textured.textures.push(Texture::new(1, 1, vec![[1; 4]]));
    let mut other = scene.clone();
    other.textures.push(Texture::new(1, 1, vec![[2; 4]]));
    let mut turned = scene.clone();
    turned.camera.as_mut().unwrap().vfov += 1.0;
    let all = [&scene, &moved, &darker, &lit, &mirror, &holes, &textured, &other, &turned, &rough, &bumpy, &faint];
    let all = all.into_iter().chain([&smooth_coat, &bumpy_coat]).collect::<Vec<_>>();
    let hashes: Vec<u64> = all.iter().map(|scene| scene.hash()).collect();
    assert!((0..all.len()).all(|i| (0..i).all(|j| hashes[i] != hashes[j])), "{hashes:?}");
    assert_eq!(scene.surroundings_hash(), turned.surroundings_hash());
}

/// Everything that a camera has changes the hash, and a pinhole's is that of its pose.
#[test]
fn the_hash_follows_the_optics() {
    let scene = cornell_box();
    assert_eq!(scene.hash(), scene.camera.unwrap().hash_in(scene.surroundings_hash()));
    let lens = Lens { radius: 0.1, focus: 1.0, blades: 0, rotation: 0.0, ratio: 1.0 };
    let of = |projection: Projection| Optics { projection, ..Optics::default() };
    let with = |lens: Lens| Optics { lens: Some(lens), ..Optics::default() };
    let fisheye = |mapping, field_of_view| of(Projection::Fisheye { mapping, field_of_view });
    let rays = |x: f32| {
        let table = RayTable { width: 1, height: 1, rays: vec![[Vec3::ZERO, Vec3::new(x, 0.0, 0.0)]] };
        of(Projection::Rays(std::sync::Arc::new(table)))
    };
    let all = [
        Optics::default(),
        of(Projection::Orthographic { height: 1.0 }),
        of(Projection::Orthographic { height: 2.0 }),
        of(Projection::Panorama { eye_distance: None }),
        of(Projection::Panorama { eye_distance: Some(0.0) }),
        of(Projection::Panorama { eye_distance: Some(0.1) }),
        fisheye(FisheyeMapping::Equidistant, 180.0),
        fisheye(FisheyeMapping::Equisolid, 180.0),
        fisheye(FisheyeMapping::Equidistant, 190.0),
        of(Projection::Cube),
        rays(1.0),
        rays(-1.0),
        with(lens),
        with(Lens { radius: 0.2, ..lens }),
        with(Lens { focus: 2.0, ..lens }),
        with(Lens { blades: 5, ..lens }),
        with(Lens { rotation: 5.0, ..lens }),
        with(Lens { ratio: 2.0, ..lens }),
        Optics { shift: Vec2::X, ..Optics::default() },
        Optics { shift: Vec2::Y, ..Optics::default() },
        Optics { clip: Clip { near: 1.0, ..Clip::NONE }, ..Optics::default() },
        Optics { clip: Clip { far: 1.0, ..Clip::NONE }, ..Optics::default() },
    ];
    let hashes = all.map(|optics| Scene { optics, ..scene.clone() }.hash());
    assert!((0..hashes.len()).all(|i| (0..i).all(|j| hashes[i] != hashes[j])), "{hashes:?}");
}
