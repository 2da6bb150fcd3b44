//! A hash of a scene: FNV-1a, 64 bits (Fowler, Noll and Vo), over the bits of all inputs of a picture.

use glam::{Affine2, Vec2, Vec3};

use super::{
    BumpMap, CameraPose, Clip, CoatNormal, GltfAnisotropy, Input, InputMap, Instance, Lens, Material, Mesh, Motion,
    NormalMap, Opacity, Optics, Projection, PunctualLight, Scene, Sky, SkyPicture, Target, TextureMap,
};

impl Scene {
    /// Scenes with equal hashes give equal pictures, chance collisions aside; names and warnings do not count. Scenes
    /// with different hashes may give equal pictures, too: an unused material counts.
    pub fn hash(&self) -> u64 {
        let surroundings = self.surroundings_hash();
        self.camera.map_or(surroundings, |camera| self.optics.hash_in(camera.hash_in(surroundings)))
    }

    /// The same without the camera.
    pub fn surroundings_hash(&self) -> u64 {
        let mut hash = Fnv::new();
        let Self { meshes, instances, materials, textures, lights, sky: Sky { radiance, picture }, .. } = self;
        hash.count(meshes.len());
        for mesh in meshes {
            let Mesh { positions, normals, texcoords, triangles, material, colors, tangents, .. } = mesh;
            hash.count(positions.len());
            positions.iter().for_each(|&p| hash.vector(p));
            hash.count(normals.len());
            normals.iter().for_each(|&n| hash.vector(n));
            hash.count(texcoords.len());
            texcoords.iter().for_each(|&Vec2 { x, y }| hash.floats(&[x, y]));
            hash.count(triangles.len());
            triangles.iter().flatten().for_each(|&index| hash.word(index));
            hash.count(*material);
            hash.count(colors.len());
            colors.iter().for_each(|color| hash.floats(&color.to_array()));
            hash.count(tangents.len());
            tangents.iter().flatten().for_each(|tangent| hash.floats(&tangent.to_array()));
            if let Some(object) = mesh.object {
                hash.count(object);
            }
            // Few materials use them.
            if materials.get(*material).into_iter().flat_map(Material::texture_maps).any(|map| map.set == 1) {
                mesh.lightmap_texcoords.iter().for_each(|&Vec2 { x, y }| hash.floats(&[x, y]));
            }
        }
        for Instance { object, to_world } in instances {
            hash.count(*object);
            hash.floats(&to_world.to_cols_array());
        }
        hash.count(materials.len());
        materials.iter().for_each(|material| hash.material(material));
        hash.count(textures.len());
        for texture in textures {
            let (width, height) = texture.size();
            [width, height, texture.channels() as u32, texture.bits() as u32].into_iter().for_each(|it| hash.word(it));
            hash.bytes(texture.texel_bytes());
        }
        if let Some(motion) = &self.motion {
            hash.motion(motion);
        }
        hash.count(lights.len());
        lights.iter().for_each(|light| hash.light(light));
        hash.vector(*radiance);
        if let Some(SkyPicture { width, height, texels, rotation }) = picture {
            [*width, *height].into_iter().for_each(|size| hash.word(size));
            texels.iter().for_each(|&texel| hash.vector(texel));
            hash.floats(&[*rotation]);
        }
        hash.0
    }
}

impl CameraPose {
    /// The hash of a scene of which this is the camera and `surroundings` the hash of all else.
    pub(crate) fn hash_in(&self, surroundings: u64) -> u64 {
        let Self { eye, target, up, vfov } = *self;
        let mut hash = Fnv(surroundings);
        [eye, target, up].into_iter().for_each(|v| hash.vector(v));
        hash.floats(&[vfov]);
        hash.0
    }
}

impl Optics {
    /// The hash with that of the pose, which is the whole of a pinhole's.
    pub(crate) fn hash_in(&self, posed: u64) -> u64 {
        if *self == Self::default() {
            return posed;
        }
        let Self { projection, lens, shift, clip: Clip { near, far } } = self;
        let mut hash = Fnv(posed);
        hash.bytes(projection.name().as_bytes());
        match projection {
            Projection::Perspective | Projection::Cube => {}
            Projection::Orthographic { height } => hash.floats(&[*height]),
            Projection::Panorama { eye_distance } => {
                hash.word(eye_distance.is_some().into());
                hash.floats(&[eye_distance.unwrap_or(0.0)]);
            }
            Projection::Fisheye { mapping, field_of_view } => {
                hash.word(*mapping as u32);
                hash.floats(&[*field_of_view]);
            }
            Projection::Rays(table) => {
                [table.width, table.height].into_iter().for_each(|size| hash.word(size));
                table.rays.iter().flatten().for_each(|&v| hash.vector(v));
            }
        }
        hash.word(lens.is_some().into());
        if let Some(Lens { radius, focus, blades, rotation, ratio }) = lens {
            hash.word(*blades);
            hash.floats(&[*radius, *focus, *rotation, *ratio]);
        }
        hash.floats(&[shift.x, shift.y, *near, *far]);
        hash.0
    }
}

/// FNV-1a of these bytes.
pub(crate) fn fnv(bytes: &[u8]) -> u64 {
    let mut hash = Fnv::new();
    hash.bytes(bytes);
    hash.0
}

struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    fn word(&mut self, word: u32) {
        self.bytes(&word.to_le_bytes());
    }

    fn count(&mut self, count: usize) {
        self.word(count as u32);
        self.word((count as u64 >> 32) as u32);
    }

    fn floats(&mut self, values: &[f32]) {
        values.iter().for_each(|value| self.word(value.to_bits()));
    }

    fn vector(&mut self, v: Vec3) {
        self.floats(&v.to_array());
    }

    /// All but its name and light group.
    fn material(&mut self, material: &Material) {
        let Material { name: _, inputs, maps, uses_vertex_colors, base_color_tints_transmission: tints, .. } = material;
        let Material { tangent_rotation, anisotropy, normal_map, bump_map, opacity, unlit, dispersion, .. } = material;
        let Material { emission, emission_map, emits_both_sides, coat_normal, .. } = material;
        Input::ALL.iter().for_each(|input| self.vector(input.get(inputs)));
        self.vector(inputs.absorption);
        [inputs.thin_walled, *uses_vertex_colors, *tints, *unlit].into_iter().for_each(|flag| self.word(flag.into()));
        self.count(maps.len());
        for InputMap { texture, targets } in maps {
            self.map(Some(texture));
            self.count(targets.len());
            for &Target { input, channel, zero } in targets {
                [input as u32, channel as u32, zero.to_bits()].into_iter().for_each(|word| self.word(word));
            }
        }
        self.floats(&[*tangent_rotation, *dispersion]);
        if let Some(GltfAnisotropy { strength, is_by_blender, map }) = anisotropy {
            self.word((*is_by_blender).into());
            self.floats(&[*strength]);
            self.map(map.as_ref());
        }
        if let Some(NormalMap { texture, scale }) = normal_map {
            self.map(Some(texture));
            self.floats(&scale.to_array());
        }
        match coat_normal {
            CoatNormal::OfBase => {}
            CoatNormal::OfVertices => self.word(1),
            CoatNormal::Map(NormalMap { texture, scale }) => {
                self.word(2);
                self.map(Some(texture));
                self.floats(&scale.to_array());
            }
        }
        if let Some(BumpMap { texture, channel, height }) = bump_map {
            self.map(Some(texture));
            self.word(*channel as u32);
            self.floats(&[*height]);
        }
        let Opacity { value, map, cutoff } = opacity;
        self.floats(&[*value, cutoff.unwrap_or(-1.0)]);
        self.map(map.as_ref().map(|(map, _)| map));
        self.word(map.as_ref().map_or(0, |&(_, channel)| channel as u32));
        self.vector(*emission);
        self.word((*emits_both_sides).into());
        self.map(emission_map.as_ref());
    }

    fn map(&mut self, map: Option<&TextureMap>) {
        self.word(map.is_some().into());
        if let Some(TextureMap { texture, set, transform: Affine2 { matrix2, translation }, wrap, filter, space }) = map
        {
            self.count(*texture);
            self.floats(&matrix2.to_cols_array());
            self.floats(&translation.to_array());
            [*set, wrap[0] as u32, wrap[1] as u32, *filter as u32, *space as u32]
                .into_iter()
                .for_each(|word| self.word(word));
        }
    }

    fn motion(&mut self, motion: &Motion) {
        let Motion { keys, ramp, meshes, instances, lights, cameras } = motion;
        self.count(*keys);
        self.floats(&[*ramp]);
        for (number, keys) in meshes {
            self.count(*number);
            keys.iter().flatten().for_each(|&position| self.vector(position));
        }
        for (number, keys) in instances {
            self.count(*number);
            keys.iter().for_each(|key| self.floats(&key.to_cols_array()));
        }
        for (number, keys) in lights {
            self.count(*number);
            keys.iter().for_each(|light| self.light(light));
        }
        for CameraPose { eye, target, up, vfov } in cameras {
            [eye, target, up].into_iter().for_each(|&v| self.vector(v));
            self.floats(&[*vfov]);
        }
    }

    fn light(&mut self, light: &PunctualLight) {
        match light {
            PunctualLight::Point { position, intensity, radius } => {
                self.word(0);
                [*position, *intensity].into_iter().for_each(|v| self.vector(v));
                self.floats(&[*radius]);
            }
            PunctualLight::Spot { position, direction, intensity, radius, cos_inner, cos_outer, edge } => {
                self.word(1);
                self.word(*edge as u32);
                [*position, *direction, *intensity].into_iter().for_each(|v| self.vector(v));
                self.floats(&[*radius, *cos_inner, *cos_outer]);
            }
            PunctualLight::Profiled { position, frame, intensity, radius, profile } => {
                self.word(3);
                [*position, frame.axis, frame.zero, *intensity].into_iter().for_each(|v| self.vector(v));
                self.floats(&[*radius]);
                profile.numbers().for_each(|number| self.word(number.to_bits()));
            }
            PunctualLight::Directional { direction, irradiance, half_angle } => {
                self.word(2);
                [*direction, *irradiance].into_iter().for_each(|v| self.vector(v));
                self.floats(&[*half_angle]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{FisheyeMapping, RayTable, Texture, cornell_box};

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
}
