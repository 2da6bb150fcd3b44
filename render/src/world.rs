//! The world: a scene made ready for tracing.

mod holes;

use std::sync::LazyLock;

use glam::{Vec2, Vec3};
use halfdome_kernel::bvh::TreeStatistics;
use halfdome_kernel::sampling::Frame;
use halfdome_kernel::{
    BuildOptions, BuildReport, Bvh, BvhView, Error, Executor, Hit, Triangle, offset_origin, triangle_normal,
};

use crate::light::{Lights, SkyLight};
use crate::scene::{CameraPose, Material, Mesh, Scene, Specular, Texture, TextureMap};
use crate::threads::Threads;

/// Geometry in a tree, materials, lights and a camera.
#[derive(Debug)]
pub struct World {
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    /// Whether any surface has holes.
    has_holes: bool,
    /// What is behind each `prim_id`.
    faces: Vec<Face>,
    bvh: Bvh,
    report: BuildReport,
    /// All that emits and can be aimed at.
    pub(crate) lights: Lights,
    pub(crate) sky: SkyLight,
    pub(crate) camera: CameraPose,
    surroundings_hash: u64,
}

/// The material of whatever measures light.
static WHITE: LazyLock<Material> = LazyLock::new(|| Material { diffuse: Vec3::ONE, ..Material::default() });

/// A triangle of a mesh.
#[derive(Clone, Copy, Debug)]
struct Face {
    mesh: u32,
    index: u32,
    /// Unit normal by the winding.
    normal: Vec3,
}

/// Where a ray met the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface<'w> {
    pub position: Vec3,
    /// Unit normal of the triangle, on its front side.
    pub normal: Vec3,
    /// Interpolated unit normal, on the same side.
    pub shading_normal: Vec3,
    /// Texture coordinates, or the barycentric ones if the mesh has none.
    pub uv: Vec2,
    pub material: &'w Material,
    /// Diffuse reflectance here.
    pub diffuse: Vec3,
    /// Radiance emitted here, from the sides that emit.
    emission: Vec3,
    pub prim_id: u32,
    /// Whether the normals were turned: it is seen from behind, or from within.
    pub is_back: bool,
    triangle: Triangle,
    barycentric: [f32; 2],
}

/// Why a scene cannot be made ready.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// The scene has no camera.
    #[error("the scene has no camera, and no bounds to make one from\n  help: give the camera's eye and target")]
    NoCamera,
    /// No tree can be built.
    #[error("{0}")]
    Tree(#[from] Error),
}

impl World {
    /// Makes a scene ready, with the best tree, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// [`WorldError::NoCamera`] without a camera, [`WorldError::Tree`] with more triangles than a tree can hold.
    pub fn new(scene: Scene) -> Result<Self, WorldError> {
        Self::build(scene, &BuildOptions::default(), &Threads::UNWATCHED)
    }

    /// Makes a scene ready, with a tree that is built where `executor` says.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn build<E: Executor>(scene: Scene, options: &BuildOptions, executor: &E) -> Result<Self, WorldError> {
        let camera = scene.camera.ok_or(WorldError::NoCamera)?;
        let surroundings_hash = scene.surroundings_hash();
        let Scene { meshes, materials, textures, lights, sky, .. } = scene;
        let triangles: Vec<Triangle> =
            meshes.iter().flat_map(|mesh| (0..mesh.triangles.len()).map(|face| mesh.corners(face))).collect();
        let places =
            (0..).zip(&meshes).flat_map(|(mesh, m)| (0..m.triangles.len() as u32).map(move |face| (mesh, face)));
        let faces: Vec<Face> = places
            .zip(&triangles)
            .map(|((mesh, index), triangle)| Face { mesh, index, normal: triangle_normal(triangle) })
            .collect();
        let (bvh, report) = Bvh::build_on(executor, &triangles, options)?;
        let even: Vec<Material> = materials.iter().map(|material| material.without_maps(&textures)).collect();
        let material = |prim: usize| &even[meshes[faces[prim].mesh as usize].material];
        let sky = SkyLight::new(sky);
        let lights = Lights::new(&triangles, material, lights, sky.mean(), bvh.view().bounds());
        let has_holes = meshes.iter().any(|mesh| materials[mesh.material].cutout.is_some());
        Ok(Self { meshes, materials, textures, has_holes, faces, bvh, report, lights, sky, camera, surroundings_hash })
    }

    /// The tree, for tracing.
    pub fn tree(&self) -> BvhView<'_> {
        self.bvh.view()
    }

    /// The tree in figures.
    pub fn tree_statistics(&self) -> TreeStatistics {
        self.bvh.statistics()
    }

    /// What was left out of the tree.
    pub fn build_report(&self) -> BuildReport {
        self.report
    }

    /// A hash of all in the scene that a picture depends on.
    pub fn hash(&self) -> u64 {
        self.camera.hash_in(self.surroundings_hash)
    }

    /// A hash of all in the scene that light depends on: all but the camera.
    pub fn surroundings_hash(&self) -> u64 {
        self.surroundings_hash
    }

    /// Where pictures are taken from.
    pub fn camera(&self) -> CameraPose {
        self.camera
    }

    /// Takes pictures from another pose, one that [`Overrides::apply`](crate::scene::Overrides::apply) has let pass.
    pub fn look_from(&mut self, camera: CameraPose) {
        self.camera = camera;
    }

    /// Length of the diagonal of the scene's bounds; 1 if it is empty or a point.
    pub(crate) fn diagonal(&self) -> f32 {
        let bounds = self.tree().bounds();
        let diagonal = (bounds.max - bounds.min).length();
        if !bounds.is_empty() && diagonal > 0.0 { diagonal } else { 1.0 }
    }

    /// A small white surface at a point in space, which receives what a sensor with this unit normal would. Rays leave
    /// it as they would leave a triangle there that is as large as the scene.
    pub(crate) fn sensor(&self, position: Vec3, normal: Vec3) -> Surface<'_> {
        let bounds = self.tree().bounds();
        let [b, c] = if bounds.is_empty() { [position; 2] } else { [bounds.min, bounds.max] };
        Surface {
            position,
            normal,
            shading_normal: normal,
            uv: Vec2::ZERO,
            material: &WHITE,
            diffuse: Vec3::ONE,
            emission: Vec3::ZERO,
            prim_id: Hit::NO_PRIM,
            is_back: false,
            triangle: [position, b, c],
            barycentric: [0.0; 2],
        }
    }

    /// The front of a triangle at barycentric coordinates, as if it were white: what it reflects is what it receives.
    pub(crate) fn receiver(&self, prim_id: u32, [u, v]: [f32; 2]) -> Surface<'_> {
        Surface { material: &WHITE, diffuse: Vec3::ONE, ..self.surface(prim_id, u, v) }
    }

    /// The surface at barycentric coordinates of a triangle.
    pub(crate) fn surface(&self, prim_id: u32, u: f32, v: f32) -> Surface<'_> {
        let Face { mesh, index, mut normal } = self.faces[prim_id as usize];
        let mesh = &self.meshes[mesh as usize];
        let indices = mesh.triangles[index as usize].map(|index| index as usize);
        let triangle = indices.map(|index| mesh.positions[index]);
        let weights = [1.0 - u - v, u, v];
        let interpolate = |values: [Vec3; 3]| values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2];
        let mut shading_normal = normal;
        if !mesh.normals.is_empty() {
            shading_normal = interpolate(indices.map(|index| mesh.normals[index])).normalize_or(normal);
            // A model's own normals say which side is the front, whatever the winding.
            if normal.dot(shading_normal) < 0.0 {
                normal = -normal;
            }
        }
        let uv = if mesh.texcoords.is_empty() {
            Vec2::new(u, v)
        } else {
            let [a, b, c] = indices.map(|index| mesh.texcoords[index]);
            a * weights[0] + b * weights[1] + c * weights[2]
        };
        let material = &self.materials[mesh.material];
        let textured = |color: Vec3, map: &Option<TextureMap>| match map {
            Some(map) => color * self.mapped(map, mesh, index, weights).truncate(),
            None => color,
        };
        Surface {
            position: interpolate(triangle),
            normal,
            shading_normal,
            uv,
            material,
            diffuse: textured(material.diffuse, &material.diffuse_map),
            emission: textured(material.emission, &material.emission_map),
            prim_id,
            is_back: false,
            triangle,
            barycentric: [u, v],
        }
    }

    /// The surface at a hit.
    pub(crate) fn surface_at(&self, hit: &Hit) -> Surface<'_> {
        self.surface(hit.prim_id, hit.u, hit.v)
    }
}

impl Surface<'_> {
    /// Where a ray starts that leaves in `direction`.
    pub(crate) fn origin_towards(&self, direction: Vec3) -> Vec3 {
        offset_origin(&self.triangle, self.normal, self.barycentric[0], self.barycentric[1], direction)
    }

    /// Where a ray from `point` ends that comes as far as this surface, and does not hit it. Its test sees the corners at
    /// the distance of `point`, and errs by units in the last place of that, which are more than those of a ray that
    /// leaves.
    pub(crate) fn end_from(&self, point: Vec3) -> Vec3 {
        const ERROR: f32 = 8.0 / (1u32 << 24) as f32;
        let back = point - self.position;
        let distance = ERROR * back.abs().max_element() * self.normal.abs().element_sum();
        self.origin_towards(back) + self.normal * distance.copysign(self.normal.dot(back))
    }

    /// The same surface with its normals on the side from which a ray in `direction` comes.
    pub(crate) fn facing(self, direction: Vec3) -> Self {
        if self.normal.dot(direction) > 0.0 {
            Self { normal: -self.normal, shading_normal: -self.shading_normal, is_back: !self.is_back, ..self }
        } else {
            self
        }
    }

    /// The frame about the shading normal.
    pub(crate) fn frame(&self) -> Frame {
        Frame::from_normal(self.shading_normal)
    }

    /// Whether a ray in `direction` hits the back of a body here, coming from within. Surfaces that are meant to be seen from
    /// both sides have no back, and glass is no body.
    pub(crate) fn is_back_of_body(&self, direction: Vec3) -> bool {
        let is_glass = matches!(self.material.specular, Specular::Glass { .. });
        !self.material.emits_both_sides && !is_glass && self.normal.dot(direction) > 0.0
    }

    /// Radiance emitted towards the origin of a ray in `direction`.
    pub(crate) fn emitted(&self, direction: Vec3) -> Vec3 {
        if self.material.emits_both_sides || self.normal.dot(direction) < 0.0 { self.emission } else { Vec3::ZERO }
    }
}
