//! The world: a scene prepared for tracing.

mod assemble;
mod bodies;
mod emission_cells;
mod faults;
mod hit;
mod labels;
mod light_estimates;
mod media;
mod opacity_micromaps;
mod placement;
mod ray_counts;
mod specular;
mod surface;
mod trace;

use halfdome_kernel::bvh::TreeStatistics;
use halfdome_kernel::geometry::Aabb;
use halfdome_kernel::{BuildOptions, BuildReport, Bvh, BvhView, Error, Executor, Isa};

use crate::camera::Camera;
use crate::executor::RayonExecutor;
use crate::light::LightSampler;
use crate::material::Kind;
use crate::scene::{CameraPose, LightLabel, Material, Mesh, Optics, Scene, SceneFault, Texture};
pub(crate) use bodies::Bodies;
pub(crate) use hit::{Hit, MIDDLE, time_of};
pub use light_estimates::seen_points::LightQuery;
pub(crate) use light_estimates::seen_points::Side;
pub(crate) use media::Boundary;
use media::Solids;
use opacity_micromaps::OpacityMicromaps;
pub(crate) use placement::instances::InstanceRecord;
use placement::instances::Instances;
pub(crate) use placement::motion::Motion;
use ray_counts::RayCounters;
pub(crate) use ray_counts::RayCounts;
use specular::Specular;
pub(crate) use specular::{Between, LightEnd, LightInMirrors, Pane, SpecularConnection, Start, Starts};
use surface::closures::ClosureCell;
pub(crate) use surface::inputs::InputChange;
pub(crate) use surface::shading_records::{EmitterRecord, MaterialRecord, TriangleRecord};
use surface::shadow_terminator::Convexity;
pub(crate) use surface::shadow_terminator::TerminatorOffset;
pub(crate) use surface::{Surface, WHITE, interpolate};
pub(crate) use trace::chance;

/// Geometry in a tree, materials, lights and a camera.
#[derive(Debug)]
pub struct World {
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    /// Whether any surface has holes.
    has_holes: bool,
    /// Where these are; empty if there are none.
    opacity_micromaps: OpacityMicromaps,
    /// What kind of closure each material needs, and whether that of any mesh is not matte.
    kinds: Vec<Kind>,
    /// The convexity of each `prim_id`.
    bulges: Vec<Convexity>,
    has_closures: bool,
    /// The absorption of solids.
    solids: Solids,
    /// Glass that shadow rays cross.
    specular: Specular,
    /// The closures of each material.
    closures: Vec<ClosureCell>,
    /// The record of each `prim_id`: first all triangles in world space, then those of each object.
    triangle_records: Vec<TriangleRecord>,
    /// The number of the former, and of those of them that do not move, which come first.
    placed: usize,
    still: usize,
    /// The data of each material for plain surfaces.
    material_records: Vec<MaterialRecord>,
    /// The record of each light that is a triangle, by its index.
    emitter_records: Vec<EmitterRecord>,
    /// The `prim_id` of each mesh's first triangle.
    first_faces: Vec<u32>,
    /// The tree of the triangles in world space.
    bvh: Bvh,
    /// All other triangles.
    instances: Option<Instances>,
    motion: Option<Motion>,
    isa: Isa,
    report: BuildReport,
    /// All that emits and can be aimed at.
    pub(crate) lights: LightSampler,
    bounds: Aabb,
    pub(crate) camera: CameraPose,
    optics: Optics,
    /// Of each punctual light, in the scene's order.
    light_labels: Vec<LightLabel>,
    surroundings_hash: u64,
    ray_counters: RayCounters,
}

/// Why a scene cannot be made ready.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// The scene was not made well.
    #[error("{0}")]
    Scene(#[from] SceneFault),
    /// The scene has no camera.
    #[error("the scene has no camera\n  help: give the camera's eye and target")]
    NoCamera,
    /// An instance has a transform that no ray can be taken back by.
    #[error(
        "instance {number}, of object {object}: {error}\n  help: give it a transform that keeps its extent; a scale of 0 hides it"
    )]
    Instance {
        /// Its index in [`Scene::instances`].
        number: usize,
        /// Its object's index.
        object: usize,
        /// The error of the transform.
        error: Error,
    },
    /// No tree can be built.
    #[error("{0}")]
    Tree(#[from] Error),
}

impl World {
    /// Makes a scene ready, with the best tree, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// [`WorldError::Scene`] with what [`Scene::check`] finds, [`WorldError::NoCamera`] without a camera,
    /// [`WorldError::Tree`] with more triangles than a tree can hold.
    pub fn new(scene: Scene) -> Result<Self, WorldError> {
        Self::for_light_query(scene, LightQuery::Camera)
    }

    /// Likewise, to find light elsewhere than in a picture of its camera.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new).
    pub fn for_light_query(scene: Scene, from: LightQuery) -> Result<Self, WorldError> {
        // Only pictures are taken for a time.
        let motion = if matches!(from, LightQuery::Camera) { scene.motion } else { None };
        let scene = Scene { motion, ..scene };
        let mut world = Self::assemble(scene, &BuildOptions::default(), &RayonExecutor::UNWATCHED)?;
        world.look(from);
        Ok(world)
    }

    /// Makes a scene ready, with a tree that is built where `executor` says.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new).
    pub fn build<E: Executor>(scene: Scene, options: &BuildOptions, executor: &E) -> Result<Self, WorldError> {
        let mut world = Self::assemble(scene, options, executor)?;
        world.look(LightQuery::Camera);
        Ok(world)
    }

    /// Finds out how far lights reach, and what they light fiercely; what was found before is forgotten.
    fn look(&mut self, from: LightQuery) {
        self.lights.forget_visibility();
        self.forget_secondary_lights();
        if let Some(points) = self.seen_points(from) {
            // First, by the irradiance that lights would cause if they reached all.
            self.find_secondary_lights(&points);
            self.estimate_light_visibility(&points);
            self.find_openings(&points);
        }
    }

    /// The tree of all triangles that are in world space.
    pub fn tree(&self) -> BvhView<'_> {
        self.bvh.view()
    }

    /// The instruction set of loops in lanes: that of the tree.
    #[inline(always)]
    pub(crate) fn isa(&self) -> Isa {
        self.isa
    }

    /// The tree in figures.
    pub fn tree_statistics(&self) -> TreeStatistics {
        self.bvh.statistics()
    }

    /// The report of the tree's build.
    pub fn build_report(&self) -> BuildReport {
        self.report
    }

    /// How many instances reach beyond [`MAX_COORDINATE`](halfdome_kernel::MAX_COORDINATE), and are invisible.
    pub fn instances_out_of_range(&self) -> usize {
        self.instances.as_ref().map_or(0, |instances| instances.out_of_range)
    }

    /// Memory of what is known of instances, their tree included, in bytes.
    pub fn instance_bytes(&self) -> usize {
        self.instances.as_ref().map_or(0, Instances::bytes)
    }

    /// A hash of all in the scene that a picture depends on.
    pub fn hash(&self) -> u64 {
        self.optics.hash_in(self.camera.hash_in(self.surroundings_hash))
    }

    /// A hash of all in the scene that light depends on: all but the camera.
    pub fn surroundings_hash(&self) -> u64 {
        self.surroundings_hash
    }

    /// The camera.
    pub fn camera(&self) -> CameraPose {
        self.camera
    }

    /// The camera's optics.
    pub fn optics(&self) -> &Optics {
        &self.optics
    }

    /// The camera for a picture of `width` by `height` pixels.
    pub(crate) fn camera_on(&self, width: u32, height: u32) -> Camera {
        Camera::new(&self.camera, &self.optics, width, height)
    }

    /// The camera at each key of the shutter's time; empty if it is static.
    pub(crate) fn cameras_on(&self, width: u32, height: u32) -> Vec<Camera> {
        let poses = self.motion.as_ref().map_or(&[][..], Motion::cameras);
        poses.iter().map(|pose| Camera::new(pose, &self.optics, width, height)).collect()
    }

    /// Takes pictures from another pose, one that [`Overrides::apply`](crate::scene::Overrides::apply) has let pass.
    pub fn set_camera(&mut self, camera: CameraPose) {
        self.camera = camera;
        if let Some(motion) = &mut self.motion {
            motion.stop_camera();
        }
    }

    /// The same, and prepares for the view from there, so that pictures have the noise of a world that was made with
    /// this camera, to the bit. It takes a while, as making the world does: less by what its tree takes.
    pub fn look_through(&mut self, camera: CameraPose) {
        self.set_camera(camera);
        self.look(LightQuery::Camera);
    }

    /// The record of each triangle.
    #[inline(always)]
    pub(crate) fn triangle_records(&self) -> &[TriangleRecord] {
        &self.triangle_records
    }

    /// The data of each material for plain triangles.
    #[inline(always)]
    pub(crate) fn material_records(&self) -> &[MaterialRecord] {
        &self.material_records
    }

    /// The record of each light that is a triangle, by its index.
    #[inline(always)]
    pub(crate) fn emitter_records(&self) -> &[EmitterRecord] {
        &self.emitter_records
    }

    /// The records of the triangles in world space, not in an object.
    #[inline(always)]
    pub(crate) fn placed_records(&self) -> &[TriangleRecord] {
        &self.triangle_records[..self.placed]
    }

    /// The same of those that do not move.
    pub(super) fn still_records(&self) -> &[TriangleRecord] {
        &self.triangle_records[..self.still]
    }

    /// The box around all surfaces, instances counting with the boxes around them; empty if there are none.
    pub(crate) fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Length of the diagonal of the scene's bounds; 1 if it is empty or a point.
    pub(crate) fn diagonal(&self) -> f32 {
        let bounds = self.bounds();
        let diagonal = (bounds.max - bounds.min).length();
        if !bounds.is_empty() && diagonal > 0.0 { diagonal } else { 1.0 }
    }
}
