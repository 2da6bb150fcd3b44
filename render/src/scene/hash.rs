//! A hash of a scene: FNV-1a, 64 bits (Fowler, Noll and Vo), over the bits of all inputs of a picture.

mod fnv;
mod material;
#[cfg(test)]
mod tests;

use glam::Vec2;

use super::{
    CameraPose, Clip, Instance, Lens, Material, Mesh, Motion, Optics, Projection, PunctualLight, Scene, Sky, SkyPicture,
};
use fnv::Fnv;

pub(crate) use fnv::fnv;

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
            let Mesh { positions, normals, texcoords, triangles, material, colors, tangents, map_space, .. } = mesh;
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
            if let Some(space) = map_space {
                hash.floats(&space.to_cols_array());
            }
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

impl Fnv {
    fn motion(&mut self, motion: &Motion) {
        let Motion { keys, ramp, meshes, instances, lights, cameras } = motion;
        self.count(*keys);
        self.floats(&[*ramp]);
        for (index, keys) in meshes {
            self.count(*index);
            keys.iter().flatten().for_each(|&position| self.vector(position));
        }
        for (index, keys) in instances {
            self.count(*index);
            keys.iter().for_each(|key| self.floats(&key.to_cols_array()));
        }
        for (index, keys) in lights {
            self.count(*index);
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
