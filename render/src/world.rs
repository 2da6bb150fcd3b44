//! The world: a scene prepared for tracing.

mod bodies;
mod closures;
mod faults;
mod glass;
mod hit;
mod inputs;
mod instances;
mod light_colors;
mod light_shares;
mod light_visibility;
mod lit_triangles;
mod media;
mod motion;
mod moved;
mod names;
mod ray_counts;
mod reflected;
mod rounding;
mod seen_points;
mod shading_records;
mod surface;
mod trace;

use glam::Vec3;
use halfdome_kernel::bvh::TreeStatistics;
use halfdome_kernel::geometry::Aabb;
use halfdome_kernel::{
    BuildOptions, BuildReport, Bvh, BvhView, Error, Executor, Isa, Triangle, offset_distance, triangle_normal,
};

use crate::camera::Camera;
use crate::executor::RayonExecutor;
use crate::light::{Light, LightSampler, SkyLight, area};
use crate::material::Kind;
use crate::scene::{CameraPose, LightLabel, Material, Mesh, Optics, Scene, SceneFault, Texture};
pub(crate) use bodies::Bodies;
use closures::ClosureCell;
use glass::Glass;
pub(crate) use glass::{BentLight, Between, LightEnd};
pub(crate) use hit::{Hit, MIDDLE, time_of};
pub(crate) use instances::InstanceRecord;
use instances::Instances;
pub(crate) use media::Boundary;
use media::Solids;
pub(crate) use motion::Motion;
use ray_counts::RayCounters;
pub(crate) use ray_counts::RayCounts;
use rounding::Bulge;
pub(crate) use rounding::Rounding;
pub use seen_points::LookFrom;
pub(crate) use seen_points::Side;
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
    /// The convexity of each `prim_id`.
    bulges: Vec<Bulge>,
    has_closures: bool,
    /// The absorption of solids.
    solids: Solids,
    /// Glass that shadow rays cross.
    glass: Glass,
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
    /// The lit triangles that are plain otherwise.
    plain_lit: Vec<u32>,
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
        /// Its number in [`Scene::instances`].
        number: usize,
        /// Its object's number.
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
    /// [`WorldError::Scene`] with what [`Scene::check`] finds, [`WorldError::NoCamera`] without a camera, [`WorldError::Tree`]
    /// with more triangles than a tree can hold.
    pub fn new(scene: Scene) -> Result<Self, WorldError> {
        Self::looking_from(scene, LookFrom::Camera)
    }

    /// Likewise, to find light elsewhere than in a picture of its camera.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new).
    pub fn looking_from(scene: Scene, from: LookFrom) -> Result<Self, WorldError> {
        // Only pictures are taken for a time.
        let motion = if matches!(from, LookFrom::Camera) { scene.motion } else { None };
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
        world.look(LookFrom::Camera);
        Ok(world)
    }

    /// Finds out how far lights reach, and what they light fiercely; what was found before is forgotten.
    fn look(&mut self, from: LookFrom) {
        self.lights.forget_visibility();
        self.forget_lit_triangles();
        if let Some(points) = self.seen_points(from) {
            self.estimate_light_visibility(&points);
            self.find_lit_triangles(&points);
        }
    }

    fn assemble<E: Executor>(mut scene: Scene, options: &BuildOptions, executor: &E) -> Result<Self, WorldError> {
        scene.check()?;
        let camera = scene.camera.ok_or(WorldError::NoCamera)?;
        scene.complete_tangents();
        let surroundings_hash = scene.surroundings_hash();
        scene.name_parts();
        scene.place_emitters();
        scene.place_distorted();
        let motion = scene.motion.take();
        let (in_world, of_objects) = scene.meshes_by_object();
        let is_moving = |number: &usize| motion.as_ref().is_some_and(|motion| motion.meshes.contains_key(number));
        let (moving, in_world): (Vec<usize>, Vec<usize>) = in_world.into_iter().partition(is_moving);
        let Scene { meshes, materials, textures, lights, mut light_labels, instances, sky, optics, .. } = scene;
        light_labels.resize(lights.len(), LightLabel::default());
        let mut triangles = TriangleTable::new(&meshes, &materials);
        let mut corners = triangles.add(&in_world);
        let (bvh, report) = Bvh::build_on(executor, &corners, options)?;
        let still = corners.len();
        corners.extend(triangles.add(&moving));
        let mut objects = Vec::with_capacity(of_objects.len());
        for numbers in &of_objects {
            let first = triangles.records.len() as u32;
            objects.push((triangles.add(numbers), first));
        }
        let TriangleTable { records: mut triangle_records, bulges, first_faces, .. } = triangles;
        let spread = motion.as_ref().map(|motion| motion.spread_lights(&lights)).unwrap_or_default();
        let motion = motion.map(|motion| Motion::new(motion, &meshes, &moving, still as u32));
        // Moving surfaces are shaded one by one.
        let of_moving = objects.iter().enumerate().filter(|(object, _)| {
            let mut all = instances.iter().enumerate().filter(|(_, instance)| instance.object == *object);
            all.any(|(number, _)| motion.as_ref().is_some_and(|motion| motion.instance(number).is_some()))
        });
        let of_moving = of_moving.map(|(_, (corners, first))| *first as usize..*first as usize + corners.len());
        for range in of_moving.chain(std::iter::once(still..corners.len())) {
            triangle_records[range].iter_mut().for_each(|record| record.is_plain = 0);
        }
        let instances = match instances.is_empty() && moving.is_empty() {
            true => None,
            false => Some(Instances::build(executor, &objects, instances, motion.as_ref(), options)?),
        };
        drop(objects);
        let even: Vec<Material> = materials.iter().map(|material| material.without_maps(&textures)).collect();
        let material = |prim: usize| &even[triangle_records[prim].material as usize];
        let front = |prim: usize| front(&triangle_records[prim], &meshes, &first_faces, prim);
        let bounds = instances.as_ref().map_or(bvh.view().bounds(), |all| all.bounds().union(&bvh.view().bounds()));
        let mut shown = lights;
        let moved: Vec<_> =
            spread.into_iter().map(|(it, spread)| (it, std::mem::replace(&mut shown[it], spread))).collect();
        let mut lights = LightSampler::new(&corners, material, front, shown, SkyLight::new(sky), bounds);
        moved.into_iter().for_each(|(number, light)| lights.replace_punctual(number, light));
        let material_records = materials.iter().map(MaterialRecord::of).collect();
        let emitter = |light: &Light| match *light {
            Light::Triangle(prim_id) => {
                let face = &triangle_records[prim_id as usize];
                let material = &materials[face.material as usize];
                let mut record = EmitterRecord::of(face, front(prim_id as usize), material, area(&face.corners));
                record.is_plain &= u32::from((prim_id as usize) < still);
                record
            }
            _ => EmitterRecord::NONE,
        };
        let emitter_records = lights.lights().iter().map(emitter).collect();
        let has_holes = meshes.iter().any(|mesh| materials[mesh.material].has_holes() || has_colors(mesh, &materials));
        let kinds: Vec<Kind> = materials.iter().map(Material::kind).collect();
        let solids = Solids::new(&materials);
        let has_punctual = lights.lights().iter().any(|light| matches!(light, Light::Punctual(_)));
        let glass = Glass::new(&materials, &triangle_records, &corners[..still], has_punctual);
        let has_closures = meshes.iter().any(|mesh| kinds[mesh.material] != Kind::Matte);
        let mut world = Self {
            closures: materials.iter().map(|_| ClosureCell::new()).collect(),
            meshes,
            materials,
            textures,
            has_holes,
            kinds,
            bulges,
            has_closures,
            solids,
            glass,
            triangle_records,
            placed: corners.len(),
            still,
            motion,
            material_records,
            emitter_records,
            first_faces,
            isa: bvh.view().isa(),
            bvh,
            instances,
            report,
            lights,
            bounds,
            camera,
            optics,
            light_labels,
            surroundings_hash,
            plain_lit: Vec::new(),
            ray_counters: RayCounters::default(),
        };
        world.send_photons();
        Ok(world)
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
        self.look(LookFrom::Camera);
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

/// The triangles of meshes, one mesh after the other.
struct TriangleTable<'a> {
    meshes: &'a [Mesh],
    materials: &'a [Material],
    records: Vec<TriangleRecord>,
    bulges: Vec<Bulge>,
    /// The number of each mesh's first triangle.
    first_faces: Vec<u32>,
}

impl<'a> TriangleTable<'a> {
    fn new(meshes: &'a [Mesh], materials: &'a [Material]) -> Self {
        Self { meshes, materials, records: Vec::new(), bulges: Vec::new(), first_faces: vec![0; meshes.len()] }
    }

    /// Adds the meshes of these numbers, and gives the corners of their triangles.
    fn add(&mut self, numbers: &[usize]) -> Vec<Triangle> {
        let corners = |&number: &usize| {
            let mesh = &self.meshes[number];
            (0..mesh.triangles.len()).map(|face| mesh.corners(face))
        };
        let triangles: Vec<Triangle> = numbers.iter().flat_map(corners).collect();
        self.records.reserve(triangles.len());
        let first = self.records.len();
        for &number in numbers {
            let mesh = &self.meshes[number];
            self.first_faces[number] = self.records.len() as u32;
            let own = &triangles[self.records.len() - first..][..mesh.triangles.len()];
            let is_plain = u32::from(is_plain(mesh, self.materials));
            self.bulges.extend(Bulge::of_mesh(mesh, &self.materials[mesh.material]));
            self.records.extend(own.iter().map(|&corners| {
                let normal = triangle_normal(&corners);
                let offset = offset_distance(&corners, normal);
                TriangleRecord {
                    corners,
                    normal,
                    offset,
                    mesh: number as u32,
                    material: mesh.material as u32,
                    is_plain,
                }
            }));
        }
        triangles
    }
}

fn has_colors(mesh: &Mesh, materials: &[Material]) -> bool {
    materials[mesh.material].uses_vertex_colors && !mesh.colors.is_empty()
}

/// Whether nothing varies over its triangles.
fn is_plain(mesh: &Mesh, materials: &[Material]) -> bool {
    mesh.normals.is_empty() && materials[mesh.material].is_uniform() && !has_colors(mesh, materials)
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
