//! From a scene to a world: its triangles, the trees over them, its lights, and what is looked up while it is shaded.

use glam::Vec3;
use halfdome_kernel::{BuildOptions, Bvh, Executor, Triangle, offset_distance, triangle_normal};
use rayon::prelude::*;

use super::emission_cells::EmissionCells;
use super::media::Solids;
use super::opacity_micromaps::OpacityMicromaps;
use super::placement::instances::Instances;
use super::placement::motion::Motion;
use super::ray_counts::RayCounters;
use super::specular::{GlassTree, Specular};
use super::surface::closures::ClosureCell;
use super::surface::shading_records::{EmitterRecord, MaterialRecord, TriangleRecord};
use super::surface::shadow_terminator::Convexity;
use super::{World, WorldError};
use crate::light::{Light, LightSampler, SkyLight, luminance_weight, most_slices, slices};
use crate::material::Kind;
use crate::scene::{LightLabel, Material, Mesh, Scene};

impl World {
    pub(super) fn assemble<E: Executor>(
        mut scene: Scene,
        options: &BuildOptions,
        executor: &E,
    ) -> Result<Self, WorldError> {
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
        let Scene { meshes, mut materials, textures, lights, mut light_labels, instances, sky, optics, .. } = scene;
        forget_missing_colors(&meshes, &mut materials);
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
        let cells = EmissionCells::new((&meshes, &first_faces), (&materials, &textures), &triangle_records[..still]);
        let emits = |prim: usize| material(prim).emission != Vec3::ZERO;
        let most = most_slices((0..corners.len()).into_par_iter().filter(|&prim| emits(prim)).count());
        let slices = |prim: usize| {
            let radiance = luminance_weight(material(prim).emission);
            slices(prim as u32, &corners[prim], radiance, most)
        };
        let emissive_parts = |prim: usize| cells.emissive_parts(prim).or_else(|| slices(prim));
        let others = (shown, SkyLight::new(sky));
        let mut lights = LightSampler::new(&corners, material, front, emissive_parts, others, bounds);
        moved.into_iter().for_each(|(number, light)| lights.replace_punctual(number, light));
        let material_records = materials.iter().map(MaterialRecord::of).collect();
        let emitter = |light: &Light| match *light {
            Light::Triangle(part) => {
                let prim = part.prim_id as usize;
                let face = &triangle_records[prim];
                let material = &materials[face.material as usize];
                let mut record = EmitterRecord::of(face, &part, front(prim), material);
                record.is_plain &= u32::from(prim < still);
                record
            }
            _ => EmitterRecord::NONE,
        };
        let emitter_records = lights.lights().iter().map(emitter).collect();
        let has_holes = meshes.iter().any(|mesh| materials[mesh.material].has_holes() || has_colors(mesh, &materials));
        let mut opacity_micromaps = OpacityMicromaps::default();
        if has_holes {
            opacity_micromaps =
                OpacityMicromaps::new((&meshes, &first_faces), (&materials, &textures), &triangle_records);
        }
        let kinds: Vec<Kind> = materials.iter().map(Material::kind).collect();
        let solids = Solids::new(&materials);
        let is_narrow = |light: &Light| matches!(light, Light::Punctual(_));
        let has_narrow = lights.sky.sun().is_some() || lights.lights().iter().any(is_narrow);
        let mut specular = Specular::new(&materials, &triangle_records, &corners[..still], has_narrow);
        let placed = (&triangle_records[..still], &corners[..still]);
        let glass = GlassTree::new((&meshes, &first_faces), &materials, placed, (executor, options))?;
        specular.set_glass(glass, &triangle_records);
        let has_closures = meshes.iter().any(|mesh| kinds[mesh.material] != Kind::Matte);
        let mut world = Self {
            closures: materials.iter().map(|_| ClosureCell::new()).collect(),
            meshes,
            materials,
            textures,
            has_holes,
            opacity_micromaps,
            kinds,
            bulges,
            has_closures,
            solids,
            specular,
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
            ray_counters: RayCounters::default(),
        };
        world.send_photons();
        Ok(world)
    }
}

/// The triangles of meshes, one mesh after the other.
struct TriangleTable<'a> {
    meshes: &'a [Mesh],
    materials: &'a [Material],
    records: Vec<TriangleRecord>,
    bulges: Vec<Convexity>,
    /// The index of each mesh's first triangle.
    first_faces: Vec<u32>,
}

impl<'a> TriangleTable<'a> {
    fn new(meshes: &'a [Mesh], materials: &'a [Material]) -> Self {
        Self { meshes, materials, records: Vec::new(), bulges: Vec::new(), first_faces: vec![0; meshes.len()] }
    }

    /// Adds the meshes of these indices, and gives the corners of their triangles.
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
            let is_even = is_even(mesh, self.materials);
            self.bulges.extend(Convexity::of_mesh(mesh, &self.materials[mesh.material]));
            self.records.extend(own.iter().zip(&mesh.triangles).map(|(&corners, &triangle)| {
                let normal = triangle_normal(&corners);
                let offset = offset_distance(&corners, normal);
                let is_plain = u32::from(is_even && TriangleRecord::is_flat(mesh, triangle, normal));
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

/// Clears the flag of materials none of whose meshes has vertex colours: formats set it for any material, and closures of
/// such a material are made at each point instead of once.
fn forget_missing_colors(meshes: &[Mesh], materials: &mut [Material]) {
    let mut are_there = vec![false; materials.len()];
    for mesh in meshes.iter().filter(|mesh| !mesh.colors.is_empty()) {
        are_there[mesh.material] = true;
    }
    materials.iter_mut().zip(are_there).for_each(|(material, are_there)| material.uses_vertex_colors &= are_there);
}

/// Whether nothing but the normals varies over its triangles.
fn is_even(mesh: &Mesh, materials: &[Material]) -> bool {
    let material = &materials[mesh.material];
    material.is_uniform() && !material.is_anisotropic() && !has_colors(mesh, materials)
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
