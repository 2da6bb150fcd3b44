//! Transforms of meshes and objects into the world.

use glam::{Affine3A, DAffine3, DMat3, Mat3, Vec3};
use halfdome_kernel::scene::Item;
use rayon::prelude::*;

use super::turn::normal_matrix;
use crate::scene::description::unit;
use crate::scene::{Instance, Mesh, Scene};

/// The least number of vertices for a thread.
const PARALLEL: usize = 1 << 14;

/// The transform, if normal maps say something else before it than after it, and if it has an inverse.
fn map_space(linear: DMat3) -> Option<Mat3> {
    /// How much the lengths of perpendicular directions may differ, which no picture shows.
    const SIMILAR: f64 = 1e-4;
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = linear;
    let scale = x.length_squared();
    let differs = |found: f64, expected: f64| (found - expected).abs() > SIMILAR * scale;
    let distorts = differs(y.length_squared(), scale)
        || differs(z.length_squared(), scale)
        || [x.dot(y), y.dot(z), z.dot(x)].into_iter().any(|it| differs(it, 0.0));
    let has_inverse = linear.as_mat3().inverse().is_finite() && linear.as_mat3().determinant() != 0.0;
    (distorts && has_inverse).then(|| linear.as_mat3())
}

impl Mesh {
    /// The mesh where a transform takes it. A transform that mirrors exchanges the second and the third corner of each
    /// triangle, so that fronts stay fronts. Positions that leave the range of numbers are not finite afterwards.
    pub(crate) fn placed(mut self, to_world: &DAffine3) -> Self {
        let place = |position: &mut Vec3| *position = to_world.transform_point3(position.as_dvec3()).as_vec3();
        self.positions.par_iter_mut().with_min_len(PARALLEL).for_each(place);
        let linear = to_world.matrix3;
        let mirrors = linear.determinant() < 0.0;
        if mirrors {
            self.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
            self.tangents.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        let from_map_space = linear * self.map_space.map_or(DMat3::IDENTITY, |space| space.as_dmat3());
        self.map_space = self.map_space.and_then(|_| map_space(from_map_space));
        if self.map_space.is_none() {
            let sign = if from_map_space.determinant() < 0.0 { -1.0 } else { 1.0 };
            for tangent in self.tangents.iter_mut().flatten() {
                let along = (from_map_space * tangent.truncate().as_dvec3()).normalize_or_zero().as_vec3();
                *tangent = along.extend(tangent.w * sign);
            }
        }
        // Normals without a direction leave the mesh flat.
        let normals = normal_matrix(linear);
        let turned = |normal: Vec3| Some((normals * unit(normal)?.as_dvec3()).try_normalize()?.as_vec3());
        let turn = |normal: &mut Vec3| turned(*normal).map(|turned| *normal = turned);
        if self.normals.par_iter_mut().with_min_len(PARALLEL).try_for_each(turn).is_none() {
            self.normals = Vec::new();
        }
        self
    }
}

impl Scene {
    /// The numbers of the meshes in world space, and of those of each object.
    pub(crate) fn meshes_by_object(&self) -> (Vec<usize>, Vec<Vec<usize>>) {
        let (mut placed, mut of_objects) = (Vec::new(), vec![Vec::new(); self.objects.len()]);
        for (number, mesh) in self.meshes.iter().enumerate() {
            mesh.object.map_or(&mut placed, |object| &mut of_objects[object]).push(number);
        }
        (placed, of_objects)
    }

    /// Calls the meshes of each object that has a name after it: copies that are placed in the world keep it.
    pub(crate) fn name_parts(&mut self) {
        for mesh in &mut self.meshes {
            let Some(object) = mesh.object.map(|object| &self.objects[object]) else { continue };
            if !object.name.is_empty() {
                mesh.name.clone_from(&object.name);
            }
        }
    }

    /// Puts a copy of each emissive mesh of an object where each instance is, in place of the shared one.
    pub(crate) fn place_emitters(&mut self) {
        let emits = |mesh: &Mesh| mesh.object.is_some() && self.materials[mesh.material].emission != Vec3::ZERO;
        let mut shared = Vec::new();
        let mut numbers = Vec::new();
        for (number, mesh) in std::mem::take(&mut self.meshes).into_iter().enumerate() {
            if emits(&mesh) {
                shared.push(mesh);
            } else {
                numbers.push(number);
                self.meshes.push(mesh);
            }
        }
        if let Some(motion) = &mut self.motion {
            let now = |before: &usize| numbers.binary_search(before).expect("what moves by itself is not shared");
            motion.meshes = std::mem::take(&mut motion.meshes).into_iter().map(|(it, keys)| (now(&it), keys)).collect();
        }
        for mesh in shared {
            let Some(object) = mesh.object else { continue };
            let instances = self.instances.iter().enumerate().filter(|(_, instance)| instance.object == object);
            for (number, instance) in instances {
                if let Some(motion) = &mut self.motion
                    && let Some(keys) = motion.instances.get(&number)
                {
                    let at = |key: &Affine3A| mesh.positions.iter().map(|&it| key.transform_point3(it)).collect();
                    motion.meshes.insert(self.meshes.len(), keys.iter().map(at).collect());
                }
                let placed = mesh.clone().placed(&double(&instance.to_world));
                self.meshes.push(Mesh { object: None, ..placed });
            }
        }
    }

    /// Replaces static instances whose transforms are nearly singular, which the kernel cannot invert, by copies; the
    /// instances are hidden.
    pub(crate) fn place_distorted(&mut self) {
        let moves = |number: &usize| self.motion.as_ref().is_some_and(|motion| motion.instances.contains_key(number));
        let is_distorted =
            |instance: &Instance| instance.to_world.is_finite() && Item::nothing().placed(&instance.to_world).is_err();
        let distorted: Vec<usize> =
            (0..self.instances.len()).filter(|it| is_distorted(&self.instances[*it]) && !moves(it)).collect();
        if distorted.is_empty() {
            return;
        }
        let (_, of_objects) = self.meshes_by_object();
        for number in distorted {
            let instance = &mut self.instances[number];
            let to_world = std::mem::replace(&mut instance.to_world, Affine3A::from_scale(Vec3::ZERO));
            for &mesh in &of_objects[instance.object] {
                let placed = self.meshes[mesh].clone().placed(&double(&to_world));
                self.meshes.push(Mesh { object: None, ..placed });
            }
        }
    }

    /// Puts copies of all objects of a scene file where their instances are: editing and unwrapping need the model's
    /// surfaces in the world.
    ///
    /// Nothing moves yet.
    pub(crate) fn place_instances(&mut self) {
        debug_assert!(self.motion.is_none());
        let (_, of_objects) = self.meshes_by_object();
        let mut copies = Vec::new();
        for instance in std::mem::take(&mut self.instances) {
            for &number in &of_objects[instance.object] {
                let placed = self.meshes[number].clone().placed(&double(&instance.to_world));
                copies.push(Mesh { object: None, is_added: true, ..placed });
            }
        }
        let kept: Vec<bool> = self.meshes.iter().map(|mesh| mesh.object.is_none()).collect();
        let number = |mesh: usize| kept[..mesh].iter().filter(|kept| **kept).count();
        for variant in &mut self.variants {
            variant.materials.retain(|(mesh, _)| kept[*mesh]);
            variant.materials.iter_mut().for_each(|(mesh, _)| *mesh = number(*mesh));
        }
        self.meshes.retain(|mesh| mesh.object.is_none());
        self.meshes.append(&mut copies);
        self.objects.clear();
    }
}

/// The transform in double precision.
fn double(transform: &Affine3A) -> DAffine3 {
    DAffine3::from_cols_array(&transform.to_cols_array().map(f64::from))
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec2, Vec4};

    use super::*;
    use crate::scene::{Object, Turn};

    fn mesh() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::new(1.0, 0.0, 1.0).normalize(); 3],
            texcoords: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
            tangents: vec![[Vec4::new(1.0, 0.0, 0.0, 1.0); 3]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        }
    }

    #[test]
    fn normals_stay_normal_to_what_they_were_normal_to_and_fronts_stay_fronts() {
        let rotation = Quat::from_rotation_y(0.7);
        for scale in [Vec3::new(2.0, 1.0, 0.5), Vec3::new(-1.0, 3.0, 1.0)] {
            let to_world = Affine3A::from_scale_rotation_translation(scale, rotation, Vec3::new(1.0, 2.0, 3.0));
            let placed = mesh().placed(&double(&to_world));
            // The normal was normal to this vector.
            let across = to_world.transform_vector3(Vec3::new(1.0, 0.0, -1.0));
            assert!(placed.normals[0].dot(across).abs() < 1e-6);
            let [a, b, c] = placed.corners(0);
            assert!((b - a).cross(c - a).dot(placed.normals[0]) > 0.0, "{scale}");
            let bitangent = placed.normals[0].cross(placed.tangents[0][0].truncate()) * placed.tangents[0][0].w;
            assert!(bitangent.dot(to_world.transform_vector3(Vec3::Y)) > 0.0, "{scale}");
            // What instances do to directions is the same.
            let turn = Turn::new(to_world.matrix3.into());
            assert!(turn.normal(mesh().normals[0]).distance(placed.normals[0]) < 1e-6);
            assert!(turn.tangent(mesh().tangents[0][0]).distance(placed.tangents[0][0]) < 1e-6);
        }
    }

    #[test]
    fn the_space_of_normal_maps_is_kept_where_it_matters() {
        let own = Mesh { map_space: Some(Mat3::IDENTITY), ..mesh() };
        let turned = DAffine3::from_rotation_y(0.7) * DAffine3::from_scale(glam::DVec3::splat(-3.0));
        let similar = own.clone().placed(&turned);
        assert_eq!(similar, mesh().placed(&turned), "it is the mesh's own space, but for rounding");
        let stretched = own.clone().placed(&DAffine3::from_scale(glam::DVec3::new(2.0, -1.0, 1.0)));
        assert_eq!(stretched.map_space, Some(Mat3::from_diagonal(Vec3::new(2.0, -1.0, 1.0))));
        assert_eq!(stretched.tangents, mesh().tangents);
        // What flattens has no inverse: tangents follow it.
        let flat = DAffine3::from_scale(glam::DVec3::new(2.0, 0.0, 1.0));
        assert_eq!(own.placed(&flat).map_space, None);
        // Back again.
        let back = stretched.placed(&DAffine3::from_scale(glam::DVec3::new(0.5, -1.0, 1.0)));
        assert_eq!((back.map_space, back.tangents), (None, mesh().tangents));
    }

    #[test]
    fn emitters_are_placed_and_the_rest_is_shared() {
        use crate::scene::Material;

        let lamp = Material { emission: Vec3::ONE, ..Material::default() };
        let shared = |material| Mesh { object: Some(0), material, ..mesh() };
        let at = |x: f32| Instance { object: 0, to_world: Affine3A::from_translation(Vec3::X * x) };
        let mut scene = Scene {
            meshes: vec![mesh(), shared(1), shared(0)],
            materials: vec![Material::default(), lamp],
            objects: vec![Object::default()],
            instances: vec![at(5.0), at(7.0)],
            ..Scene::default()
        };
        let mut flat = scene.clone();
        assert_eq!(scene.triangle_count(), 5);
        scene.place_emitters();
        let objects: Vec<Option<usize>> = scene.meshes.iter().map(|mesh| mesh.object).collect();
        assert_eq!((objects, scene.triangle_count()), (vec![None, Some(0), None, None], 5));
        assert_eq!(scene.meshes[3].positions[1], Vec3::new(8.0, 0.0, 0.0));
        flat.place_instances();
        assert_eq!((flat.meshes.len(), flat.bounds()), (5, scene.bounds()));
    }

    #[test]
    fn what_a_transform_nearly_flattens_is_copied() {
        use crate::scene::{CameraPose, Material};
        use crate::world::World;

        let by = |scale: Vec3| Instance { object: 0, to_world: Affine3A::from_scale(scale) };
        let mut scene = Scene {
            meshes: vec![Mesh { object: Some(0), ..mesh() }],
            materials: vec![Material::default()],
            objects: vec![Object::default()],
            instances: vec![by(Vec3::ONE), by(Vec3::new(100.0, 100.0, 1e-4)), by(Vec3::new(1.0, 1.0, 0.0))],
            camera: Some(CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 }),
            ..Scene::default()
        };
        let world = World::new(scene.clone()).unwrap();
        let below = halfdome_kernel::Ray::new(Vec3::new(30.0, 30.0, 1.0), Vec3::NEG_Z);
        assert!(world.occluded(&below));
        scene.place_distorted();
        assert_eq!(scene.meshes.len(), 2);
        assert_eq!((scene.meshes[1].object, scene.meshes[1].positions[1]), (None, Vec3::X * 100.0));
        let scales: Vec<_> = scene.instances.iter().map(|it| it.to_world.matrix3.determinant()).collect();
        assert_eq!(scales, [1.0, 0.0, 0.0]);
    }
}
