//! The world: a scene made ready for tracing.

mod bodies;
mod inputs;
mod light_shares;
mod light_visibility;
mod lit_triangles;
mod reflected;
mod seen_points;
mod shading_records;
mod surface;
mod trace;

use glam::Vec3;
use halfdome_kernel::bvh::TreeStatistics;
use halfdome_kernel::{
    BuildOptions, BuildReport, Bvh, BvhView, Error, Executor, Isa, Triangle, offset_distance, triangle_normal,
};

use crate::camera::Camera;
use crate::executor::RayonExecutor;
use crate::light::{Light, LightSampler, SkyLight, area};
use crate::material::Kind;
use crate::scene::{CameraPose, Material, Mesh, Optics, Scene, Texture};
pub(crate) use bodies::Bodies;
pub use seen_points::LookFrom;
pub(crate) use shading_records::{EmitterRecord, MaterialRecord, TriangleRecord};
pub(crate) use surface::{Surface, WHITE, interpolate};

/// Geometry in a tree, materials, lights and a camera.
#[derive(Debug)]
pub struct World {
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    /// Whether any surface has holes.
    has_holes: bool,
    /// What kind of closure each material needs, and whether that of any mesh is not matte.
    kinds: Vec<Kind>,
    has_closures: bool,
    /// What is behind each `prim_id`.
    triangle_records: Vec<TriangleRecord>,
    /// What each material says of plain surfaces.
    material_records: Vec<MaterialRecord>,
    /// What is known of each light that is a triangle, by its index.
    emitter_records: Vec<EmitterRecord>,
    /// The `prim_id` of each mesh's first triangle.
    first_faces: Vec<u32>,
    bvh: Bvh,
    isa: Isa,
    report: BuildReport,
    /// All that emits and can be aimed at.
    pub(crate) lights: LightSampler,
    pub(crate) camera: CameraPose,
    optics: Optics,
    surroundings_hash: u64,
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
        Self::looking_from(scene, LookFrom::Camera)
    }

    /// Likewise, to find light elsewhere than in a picture of its camera.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn looking_from(scene: Scene, from: LookFrom) -> Result<Self, WorldError> {
        let mut world = Self::assemble(scene, &BuildOptions::default(), &RayonExecutor::UNWATCHED)?;
        world.look(from);
        Ok(world)
    }

    /// Makes a scene ready, with a tree that is built where `executor` says.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn build<E: Executor>(scene: Scene, options: &BuildOptions, executor: &E) -> Result<Self, WorldError> {
        let mut world = Self::assemble(scene, options, executor)?;
        world.look(LookFrom::Camera);
        Ok(world)
    }

    /// Finds out how far lights reach, and what they light fiercely.
    fn look(&mut self, from: LookFrom) {
        if let Some(points) = self.seen_points(from) {
            self.estimate_light_visibility(&points);
            self.find_lit_triangles(&points);
        }
    }

    fn assemble<E: Executor>(mut scene: Scene, options: &BuildOptions, executor: &E) -> Result<Self, WorldError> {
        let camera = scene.camera.ok_or(WorldError::NoCamera)?;
        scene.complete_tangents();
        let surroundings_hash = scene.surroundings_hash();
        let Scene { meshes, materials, textures, lights, sky, optics, .. } = scene;
        let triangles: Vec<Triangle> =
            meshes.iter().flat_map(|mesh| (0..mesh.triangles.len()).map(|face| mesh.corners(face))).collect();
        let has_colors = |mesh: &Mesh| materials[mesh.material].uses_vertex_colors && !mesh.colors.is_empty();
        let is_plain =
            |mesh: &Mesh| mesh.normals.is_empty() && materials[mesh.material].is_uniform() && !has_colors(mesh);
        let (mut triangle_records, mut first_faces) = (Vec::with_capacity(triangles.len()), Vec::new());
        for (number, mesh) in (0..).zip(&meshes) {
            first_faces.push(triangle_records.len() as u32);
            let (material, is_plain) = (mesh.material as u32, is_plain(mesh));
            let corners = &triangles[triangle_records.len()..][..mesh.triangles.len()];
            triangle_records.extend(corners.iter().map(|&corners| {
                let normal = triangle_normal(&corners);
                let offset = offset_distance(&corners, normal);
                TriangleRecord { corners, normal, offset, mesh: number, material, is_plain: is_plain.into() }
            }));
        }
        let (bvh, report) = Bvh::build_on(executor, &triangles, options)?;
        let even: Vec<Material> = materials.iter().map(|material| material.without_maps(&textures)).collect();
        let material = |prim: usize| &even[triangle_records[prim].material as usize];
        let front = |prim: usize| front(&triangle_records[prim], &meshes, &first_faces, prim);
        let lights = LightSampler::new(&triangles, material, front, lights, SkyLight::new(sky), bvh.view().bounds());
        let material_records = materials.iter().map(MaterialRecord::of).collect();
        let emitter = |light: &Light| match *light {
            Light::Triangle(prim_id) => {
                let face = &triangle_records[prim_id as usize];
                let material = &materials[face.material as usize];
                EmitterRecord::of(face, front(prim_id as usize), material, area(&face.corners))
            }
            _ => EmitterRecord::NONE,
        };
        let emitter_records = lights.lights().iter().map(emitter).collect();
        let has_holes = meshes.iter().any(|mesh| materials[mesh.material].has_holes() || has_colors(mesh));
        let kinds: Vec<Kind> = materials.iter().map(Material::kind).collect();
        let has_closures = meshes.iter().any(|mesh| kinds[mesh.material] != Kind::Matte);
        Ok(Self {
            meshes,
            materials,
            textures,
            has_holes,
            kinds,
            has_closures,
            triangle_records,
            material_records,
            emitter_records,
            first_faces,
            isa: bvh.view().isa(),
            bvh,
            report,
            lights,
            camera,
            optics,
            surroundings_hash,
        })
    }

    /// The tree, for tracing.
    pub fn tree(&self) -> BvhView<'_> {
        self.bvh.view()
    }

    /// What loops in lanes are run with: that with which the tree is traced.
    #[inline(always)]
    pub(crate) fn isa(&self) -> Isa {
        self.isa
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
        self.optics.hash_in(self.camera.hash_in(self.surroundings_hash))
    }

    /// A hash of all in the scene that light depends on: all but the camera.
    pub fn surroundings_hash(&self) -> u64 {
        self.surroundings_hash
    }

    /// Where pictures are taken from.
    pub fn camera(&self) -> CameraPose {
        self.camera
    }

    /// How pictures are taken from there.
    pub fn optics(&self) -> &Optics {
        &self.optics
    }

    /// The camera for a picture of `width` by `height` pixels.
    pub(crate) fn camera_on(&self, width: u32, height: u32) -> Camera {
        Camera::new(&self.camera, &self.optics, width, height)
    }

    /// Takes pictures from another pose, one that [`Overrides::apply`](crate::scene::Overrides::apply) has let pass.
    pub fn set_camera(&mut self, camera: CameraPose) {
        self.camera = camera;
    }

    /// What is known of each triangle.
    #[inline(always)]
    pub(crate) fn triangle_records(&self) -> &[TriangleRecord] {
        &self.triangle_records
    }

    /// What each material says of plain triangles.
    #[inline(always)]
    pub(crate) fn material_records(&self) -> &[MaterialRecord] {
        &self.material_records
    }

    /// What is known of each light that is a triangle, by its index.
    #[inline(always)]
    pub(crate) fn emitter_records(&self) -> &[EmitterRecord] {
        &self.emitter_records
    }

    /// Length of the diagonal of the scene's bounds; 1 if it is empty or a point.
    pub(crate) fn diagonal(&self) -> f32 {
        let bounds = self.tree().bounds();
        let diagonal = (bounds.max - bounds.min).length();
        if !bounds.is_empty() && diagonal > 0.0 { diagonal } else { 1.0 }
    }
}

/// The unit normal of the side of a triangle that is its front, which its mesh's own normals say, whatever the winding;
/// `None` if they do not agree.
fn front(face: &TriangleRecord, meshes: &[Mesh], first_faces: &[u32], prim: usize) -> Option<Vec3> {
    let mesh = &meshes[face.mesh as usize];
    if mesh.normals.is_empty() {
        return Some(face.normal);
    }
    let corners = mesh.triangles[prim - first_faces[face.mesh as usize] as usize];
    let heights = corners.map(|corner| face.normal.dot(mesh.normals[corner as usize]));
    if heights.iter().all(|&height| height > 0.0) {
        Some(face.normal)
    } else if heights.iter().all(|&height| height < 0.0) {
        Some(-face.normal)
    } else {
        None
    }
}
