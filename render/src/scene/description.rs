//! What a scene is, whatever file it came from: meshes in world space, materials, lights, camera, sky.
//!
//! Lengths are in the units of the file. Radiance is in W/(m² sr), one number per linear sRGB (Rec. 709) channel.
//! Coordinates are right-handed. The front of a face is where its vertex normals point, or without them the side from
//! which its corners run counter-clockwise.

use glam::{DVec3, Vec2, Vec3};

use super::{Sky, Texture, TextureMap};

/// A scene as loaders deliver it and `World` takes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Meshes, already in world space.
    pub meshes: Vec<Mesh>,
    /// Materials; meshes name them by index.
    pub materials: Vec<Material>,
    /// Pictures on surfaces; materials name them by index.
    pub textures: Vec<Texture>,
    /// Delta lights.
    pub lights: Vec<PunctualLight>,
    /// Where the picture is taken from; `None` when the file has no camera.
    pub camera: Option<CameraPose>,
    /// What rays see that leave the scene.
    pub sky: Sky,
    /// What the loader skipped or changed: shown to the user, one line each.
    pub warnings: Vec<String>,
}

/// Triangles that share a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The file's own name for it, or empty.
    pub name: String,
    /// Finite positions in world space.
    pub positions: Vec<Vec3>,
    /// One unit normal per position, or empty for flat shading.
    pub normals: Vec<Vec3>,
    /// One texture coordinate per position, or empty.
    pub texcoords: Vec<Vec2>,
    /// One coordinate per position in a lightmap that the model was made for, or empty. They may be anything.
    pub lightmap_texcoords: Vec<Vec2>,
    /// Three valid indices into `positions` each.
    pub triangles: Vec<[u32; 3]>,
    /// A valid index into [`Scene::materials`].
    pub material: usize,
    /// Where in a glTF file it stands; `None` for other formats.
    pub origin: Option<Origin>,
}

/// A mesh's place in a glTF file. Its vertices are the primitive's, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Origin {
    /// The node that shows it.
    pub node: usize,
    /// The mesh.
    pub mesh: usize,
    /// Its primitive.
    pub primitive: usize,
    /// Whether the node mirrors it: the second and third corner of each triangle have changed places.
    pub mirrored: bool,
}

/// How a surface reflects and emits.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The file's own name for it, or empty.
    pub name: String,
    /// Diffuse reflectance (albedo) in 0..=1 per channel, on both sides.
    pub diffuse: Vec3,
    /// What diffuse reflectance is multiplied by, if it is not the same everywhere.
    pub diffuse_map: Option<TextureMap>,
    /// Emitted radiance; zero for most surfaces.
    pub emission: Vec3,
    /// What emission is multiplied by, likewise.
    pub emission_map: Option<TextureMap>,
    /// Where the surface has holes, if it has any.
    pub cutout: Option<Cutout>,
    /// Whether the back emits too; the front alone by default, as in glTF, pbrt and Mitsuba.
    pub emits_both_sides: bool,
    /// What the surface reflects like a mirror, or lets through, on top of that.
    pub specular: Specular,
    /// What the file says of reflection, as it says it; integrators do not look at it.
    pub gloss: Gloss,
}

/// Holes: where the alpha of [`Material::diffuse_map`] is low, there is no surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutout {
    /// What alpha is multiplied by.
    pub alpha: f32,
    /// Where the product is less than this, is a hole.
    pub cutoff: f32,
}

/// Perfectly smooth reflection and refraction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Specular {
    /// None.
    #[default]
    None,
    /// A mirror.
    Mirror {
        /// Reflectance per channel. With [`Material::diffuse`] it should add up to no more than 1.
        reflectance: Vec3,
    },
    /// The border between air, in front, and glass, behind: reflects by Fresnel's equations and refracts the rest. It
    /// leaves nothing for diffuse reflection: [`Material::diffuse`] should be black.
    Glass {
        /// Index of refraction, more than 0; about 1.5 for glass, 1.33 for water.
        ior: f32,
        /// What part of the refracted light gets through, in 0..=1 per channel; twice through a pane or a ball.
        transmittance: Vec3,
    },
}

/// Wavefront MTL's `Ks`, `Tf`, `Ns`, `Ni`, `d` and `illum`; by default a surface without gloss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    /// Specular reflectance (`Ks`).
    pub specular: Vec3,
    /// Transmission filter (`Tf`).
    pub transmittance: Vec3,
    /// Phong exponent (`Ns`).
    pub exponent: f32,
    /// Index of refraction (`Ni`).
    pub ior: f32,
    /// Opacity, 1 for opaque (`d`).
    pub opacity: f32,
    /// Illumination model (`illum`).
    pub model: u32,
}

/// A light that has no surface. Intensities are per linear sRGB channel.
#[derive(Clone, Debug, PartialEq)]
pub enum PunctualLight {
    /// Shines alike in every direction.
    Point {
        /// Where it stands.
        position: Vec3,
        /// Radiant intensity, W/sr.
        intensity: Vec3,
    },
    /// Shines into a cone, as `KHR_lights_punctual` has it.
    Spot {
        /// Where it stands.
        position: Vec3,
        /// Unit vector along the cone's axis.
        direction: Vec3,
        /// Radiant intensity on the axis, W/sr.
        intensity: Vec3,
        /// Cosine of the angle up to which the intensity is full.
        cos_inner: f32,
        /// Cosine of the angle from which it is zero; less than `cos_inner`.
        cos_outer: f32,
    },
    /// Shines from infinitely far away.
    Directional {
        /// Unit vector along which the light travels.
        direction: Vec3,
        /// Irradiance on a surface that faces it, W/m².
        irradiance: Vec3,
    },
}

/// A pinhole camera's pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPose {
    /// The pinhole.
    pub eye: Vec3,
    /// A point in the middle of the picture.
    pub target: Vec3,
    /// A vector that points up in the picture; not parallel to the view.
    pub up: Vec3,
    /// Vertical field of view in degrees, between 0 and 180.
    pub vfov: f32,
}

impl Default for Material {
    /// A matte grey, for faces that name no material.
    fn default() -> Self {
        Self {
            name: String::new(),
            diffuse: Vec3::splat(0.5),
            diffuse_map: None,
            emission: Vec3::ZERO,
            emission_map: None,
            cutout: None,
            emits_both_sides: false,
            specular: Specular::None,
            gloss: Gloss::default(),
        }
    }
}

impl Default for Gloss {
    fn default() -> Self {
        Self { specular: Vec3::ZERO, transmittance: Vec3::ONE, exponent: 0.0, ior: 1.0, opacity: 1.0, model: 1 }
    }
}

impl Material {
    /// The material with the mean of each texture in the texture's place.
    pub(crate) fn without_maps(&self, textures: &[Texture]) -> Self {
        let mean =
            |map: &Option<TextureMap>| map.as_ref().map_or(Vec3::ONE, |map| textures[map.texture].mean().truncate());
        Self {
            diffuse: self.diffuse * mean(&self.diffuse_map),
            emission: self.emission * mean(&self.emission_map),
            diffuse_map: None,
            emission_map: None,
            ..self.clone()
        }
    }
}

impl Mesh {
    /// The corners of face `face`.
    pub fn corners(&self, face: usize) -> [Vec3; 3] {
        self.triangles[face].map(|index| self.positions[index as usize])
    }
}

impl Scene {
    /// The number of triangles in all meshes.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles.len()).sum()
    }

    /// The smallest box around all positions that triangles use: lower and upper corner; `None` without triangles.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let corners = self
            .meshes
            .iter()
            .flat_map(|mesh| mesh.triangles.iter().flatten().map(|&index| mesh.positions[index as usize]));
        corners.fold(None, |bounds, p| {
            let (lower, upper) = bounds.unwrap_or((p, p));
            Some((p.min(lower), p.max(upper)))
        })
    }

    /// Whether anything emits: the sky, a delta light, or a triangle.
    pub fn has_light(&self) -> bool {
        let emits = |mesh: &Mesh| !mesh.triangles.is_empty() && self.materials[mesh.material].emission != Vec3::ZERO;
        self.sky.mean() != Vec3::ZERO || !self.lights.is_empty() || self.meshes.iter().any(emits)
    }
}

/// `vector` at unit length, or `None` if it has no direction: zero, infinite or not a number.
pub(super) fn unit(vector: Vec3) -> Option<Vec3> {
    // Double precision, because the squares of a small or large vector leave the range of single precision.
    vector.as_dvec3().try_normalize().map(DVec3::as_vec3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::cornell_box;

    #[test]
    fn light_is_a_sky_a_lamp_or_a_triangle_that_emits() {
        assert!(cornell_box().has_light());
        let mut dark = cornell_box();
        let lamp = dark.meshes.pop().unwrap();
        assert_eq!(lamp.name, "light");
        assert!(!dark.has_light(), "an emitting material without a triangle does not count");
        let mut sky = dark.clone();
        sky.sky.radiance = Vec3::X;
        assert!(sky.has_light());
        dark.lights.push(PunctualLight::Point { position: Vec3::ZERO, intensity: Vec3::ONE });
        assert!(dark.has_light());
    }

    #[test]
    fn unit_vectors_of_any_magnitude() {
        assert_eq!(unit(Vec3::new(0.0, -3e38, 0.0)), Some(Vec3::NEG_Y));
        assert_eq!(unit(Vec3::new(1e-44, 0.0, 0.0)), Some(Vec3::X));
        assert_eq!(unit(Vec3::ZERO), None);
        assert_eq!(unit(Vec3::new(f32::NAN, 1.0, 0.0)), None);
        assert_eq!(unit(Vec3::new(f32::INFINITY, 1.0, 0.0)), None);
    }
}
