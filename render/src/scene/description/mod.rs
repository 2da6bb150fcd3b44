//! The description of a scene, independent of its file format: meshes, instances, materials, lights, camera, sky.
//!
//! Lengths are in the units of the file. Radiance is in W/(m² sr), one number per linear sRGB (Rec. 709) channel.
//! Coordinates are right-handed. The front of a face is the side to which its vertex normals point, or without them the
//! side from which its corners run counter-clockwise.

pub(super) mod camera_pose;
pub(super) mod instance;
pub(super) mod moment;
pub(super) mod motion;
pub(super) mod optics;
pub(super) mod profile;
pub(super) mod punctual;
pub(super) mod sky;

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec3, Mat3, Vec2, Vec3, Vec4};

use super::{Animation, CameraPose, Clip, Instance, Material, Motion, Object, Optics, PunctualLight, Sky, Texture};

/// A scene as loaders deliver it and `World` takes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Meshes, in world space or in that of their object.
    pub meshes: Vec<Mesh>,
    /// Groups of meshes that are kept once, however often they are shown.
    pub objects: Vec<Object>,
    /// The instances of objects.
    pub instances: Vec<Instance>,
    /// Materials; meshes name them by index.
    pub materials: Vec<Material>,
    /// Pictures on surfaces; materials name them by index.
    pub textures: Vec<Texture>,
    /// Delta lights.
    pub lights: Vec<PunctualLight>,
    /// What light path expressions call them, in their order; those behind its end have no names.
    pub light_labels: Vec<LightLabel>,
    /// What the file's numbers of [`lights`](Self::lights) were taken for; `None` if it has none.
    pub light_units: Option<LightUnits>,
    /// Other materials that the file has for meshes (`KHR_materials_variants`).
    pub variants: Vec<Variant>,
    /// The animations of the model, whether they are played or not.
    pub animations: Vec<Animation>,
    /// The camera's pose; `None` when the file has no camera.
    pub camera: Option<CameraPose>,
    /// The width of the camera's picture by its height, if the file says.
    pub camera_aspect: Option<f32>,
    /// The width and height of the camera's picture in pixels, if the file says.
    pub film_size: Option<(u32, u32)>,
    /// The number of samples of a pixel, if the file says.
    pub film_spp: Option<u32>,
    /// The camera's optics.
    pub optics: Optics,
    /// The clipping planes of the file's camera, which are not used unless requested.
    pub camera_clip: Option<Clip>,
    /// The radiance of rays that leave the scene.
    pub sky: Sky,
    /// Motion while the shutter is open; `None` if nothing moves. Everything else here is at the middle of that time.
    pub motion: Option<Motion>,
    /// Warnings about skipped or changed content, one line each.
    pub warnings: Vec<String>,
    /// The files that it was read from.
    pub files: Vec<PathBuf>,
}

/// Triangles that share a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The file's own name for it, or empty.
    pub name: String,
    /// Finite positions, in world space if the mesh has no [`object`](Self::object).
    pub positions: Vec<Vec3>,
    /// One unit normal per position, or empty for flat shading.
    pub normals: Vec<Vec3>,
    /// One texture coordinate per position, or empty. (0, 0) is a picture's upper left corner.
    pub texcoords: Vec<Vec2>,
    /// One coordinate per position in a lightmap that the model was made for, or empty. They may be anything.
    pub lightmap_texcoords: Vec<Vec2>,
    /// One colour per position, linear with alpha, or empty.
    pub colors: Vec<Vec4>,
    /// For the corners of each triangle, a unit tangent and in `w` the sign of the bitangent, which is
    /// `w × (normal × tangent)` and points up in pictures; or empty.
    pub tangents: Vec<[Vec4; 3]>,
    /// The linear transform from the coordinates in which `tangents` are and normal maps apply to those of the mesh:
    /// Blender applies normal maps before it scales an object. `None` where both are the same, as glTF has it.
    pub map_space: Option<Mat3>,
    /// Three valid indices into `positions` each.
    pub triangles: Vec<[u32; 3]>,
    /// A valid index into [`Scene::materials`].
    pub material: usize,
    /// A valid index into [`Scene::objects`] if it belongs to one, in whose coordinates it is and whose instances show
    /// it.
    pub object: Option<usize>,
    /// The position in a glTF file; `None` for other formats.
    pub origin: Option<Origin>,
    /// Whether it is added to the model, as a lamp or an object by a scene file, or as balls or tubes for points or
    /// lines: it gets no lightmap.
    pub is_added: bool,
    /// The place in a scene file that added it, for messages: file and line of its object.
    pub added_at: Option<Arc<str>>,
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

/// The name of a light.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightLabel {
    /// The file's own name for it, or empty.
    pub name: String,
    /// The name of the group that it is in, or empty: then it is one of its own.
    pub group: String,
}

/// The units of a file's lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightUnits {
    /// Candela and lux, which are divided by 683 lm/W.
    Photometric,
    /// W/sr and W/m², or whatever unit emission has: they are taken as they are.
    Radiometric,
}

/// A set of materials in place of those that meshes have by themselves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variant {
    /// The file's own name for it.
    pub name: String,
    /// Meshes by index, each with its material.
    pub materials: Vec<(usize, usize)>,
}

impl Mesh {
    /// The corners of face `face`.
    pub fn corners(&self, face: usize) -> [Vec3; 3] {
        self.triangles[face].map(|index| self.positions[index as usize])
    }

    /// The texture coordinates of a set: 0 for `texcoords`, 1 for `lightmap_texcoords`; `None` if there are none.
    #[inline]
    pub(crate) fn texcoord_set(&self, set: u32) -> Option<&[Vec2]> {
        let texcoords = match set {
            0 => &self.texcoords,
            1 => &self.lightmap_texcoords,
            _ => return None,
        };
        (!texcoords.is_empty()).then_some(texcoords)
    }
}

impl Scene {
    /// Adds a delta light that is called so.
    pub fn add_light(&mut self, light: PunctualLight, label: LightLabel) {
        self.light_labels.resize(self.lights.len(), LightLabel::default());
        self.lights.push(light);
        self.light_labels.push(label);
    }

    /// Gives meshes the materials of the variant called `name`; whether there is one.
    pub fn choose_variant(&mut self, name: &str) -> bool {
        let Some(variant) = self.variants.iter().find(|variant| variant.name == name) else { return false };
        for &(mesh, material) in &variant.materials {
            self.meshes[mesh].material = material;
        }
        true
    }

    /// The number of triangles in all meshes, those of an object once for each instance.
    pub fn triangle_count(&self) -> usize {
        let mut of_objects = vec![0; self.objects.len()];
        let mut count = 0;
        for mesh in &self.meshes {
            *mesh.object.map_or(&mut count, |object| &mut of_objects[object]) += mesh.triangles.len();
        }
        count + self.instances.iter().map(|instance| of_objects[instance.object]).sum::<usize>()
    }

    /// The number of triangles that are kept: those of an object once.
    pub fn stored_triangle_count(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles.len()).sum()
    }

    /// A box around all positions that triangles use: lower and upper corner; `None` without triangles. It is the
    /// smallest one but for instances, of which each counts with the box around its object's.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        type Bounds = Option<(Vec3, Vec3)>;
        let add = |bounds: Bounds, p: Vec3| {
            let (lower, upper) = bounds.unwrap_or((p, p));
            Some((p.min(lower), p.max(upper)))
        };
        let mut of_objects: Vec<Bounds> = vec![None; self.objects.len()];
        let mut bounds = None;
        for mesh in &self.meshes {
            let bounds = mesh.object.map_or(&mut bounds, |object| &mut of_objects[object]);
            let corners = mesh.triangles.iter().flatten().map(|&index| mesh.positions[index as usize]);
            *bounds = corners.fold(*bounds, add);
        }
        for instance in &self.instances {
            let Some((lower, upper)) = of_objects[instance.object] else { continue };
            let corner = |i: u32| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), upper, lower);
            bounds = (0..8).map(|i| instance.to_world.transform_point3(corner(i))).fold(bounds, add);
        }
        bounds
    }

    /// Whether anything emits: the sky, a delta light, or a triangle.
    pub fn has_light(&self) -> bool {
        let emits = |mesh: &Mesh| !mesh.triangles.is_empty() && self.materials[mesh.material].emission != Vec3::ZERO;
        let shines = |light: &PunctualLight| light.power().0 != Vec3::ZERO;
        self.sky.mean() != Vec3::ZERO || self.lights.iter().any(shines) || self.meshes.iter().any(emits)
    }
}

/// `vector` at unit length, or `None` if it has no direction: zero, infinite or not a number.
pub(crate) fn unit(vector: Vec3) -> Option<Vec3> {
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
        dark.lights.push(PunctualLight::Point { position: Vec3::ZERO, intensity: Vec3::ONE, radius: 0.0 });
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
