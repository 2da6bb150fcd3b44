//! `[[object]]` and `[[instance]]` in scene files: instanced models.
//!
//! ```toml
//! [[object]]
//! name = "tree"
//! file = "tree.glb"             # its lights and cameras are left out
//!
//! [[instance]]
//! of = "tree"
//! at = [4, 0, -2]               # the rest may be left out
//! rotate = [0, 30, 0]           # degrees about x, then y, then z
//! scale = 1.2                   # or [x, y, z]
//! # or, instead of these: matrix = [12 or 16 numbers, row by row]
//! table = "trees.csv"           # or .ply: many places, before the above
//! materials = { leaf = "autumn" }   # other materials than the object's own
//! ```
//!
//! An object's contents have its name as a prefix: its material `leaf` is `tree/leaf`, in `[[material]]` too. An object
//! without an instance is invisible. See `objects/place_table.rs` for tables.

mod place_table;
mod tables;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::Affine3A;

use crate::scene::error::count;
use crate::scene::nearest::suggestion;
use crate::scene::{Animation, Instance, LoadOptions, Mesh, Moment, Object, Place, Scene, SceneError, load_with};
pub use tables::{InstanceTable, ObjectTable};
pub(super) use tables::{read_instances, read_objects};

/// The most instances of a scene: more than fit into any memory.
const MAX_INSTANCES: usize = 1 << 28;

/// The result of an object of a scene file.
struct Loaded {
    /// The object of those meshes that its model has in its own space, if there are any.
    own: Option<usize>,
    /// What its model itself shows several times.
    inner: Vec<Instance>,
}

/// The models of a scene file at `path`, in the scene but not shown anywhere.
pub(super) struct Objects<'a> {
    path: &'a Path,
    loaded: BTreeMap<&'a str, Loaded>,
    /// Copies of objects with other materials, by these: the object's own and the new one.
    copies: BTreeMap<(usize, Vec<(usize, usize)>), usize>,
}

impl<'a> Objects<'a> {
    /// Loads them into the scene.
    pub(crate) fn load(
        tables: &'a [ObjectTable],
        path: &'a Path,
        scene: &mut Scene,
        options: &LoadOptions,
    ) -> Result<Self, SceneError> {
        // The names of animations are those of the scene's own model: of an object all play.
        let moment = options.moment.as_ref().map(|moment| Moment { time: moment.time, animations: Vec::new() });
        let options = LoadOptions { moment, camera: None, is_object: true, ..options.clone() };
        let mut loaded = BTreeMap::new();
        for ObjectTable { name, file, line } in tables {
            let model = load_with(file, &options)?;
            let place = format!("{}:{line}", path.display());
            if loaded.insert(name.as_str(), append(scene, model, name, &place)).is_some() {
                let problem = format!("there is another object {name:?}");
                return Err(SceneError::new(path, Place::Line(*line), problem, "give each object a name of its own"));
            }
        }
        Ok(Self { path, loaded, copies: BTreeMap::new() })
    }

    /// Shows them where instances are.
    pub(crate) fn place(mut self, tables: &[InstanceTable], scene: &mut Scene) -> Result<(), SceneError> {
        for table in tables {
            let error = |problem: String, remedy: String| {
                Err(SceneError::new(self.path, Place::Line(table.line), problem, remedy))
            };
            let Some(object) = self.loaded.get(table.of.as_str()) else {
                let names: Vec<&str> = self.loaded.keys().copied().collect();
                return error(format!("there is no object {:?}", table.of), suggestion(&table.of, &names));
            };
            let places = match &table.file {
                Some(file) => {
                    scene.files.push(file.clone());
                    place_table::read(file)?
                }
                None => vec![Affine3A::IDENTITY],
            };
            let own = object.own.map(|object| Instance { object, to_world: Affine3A::IDENTITY });
            let parts: Vec<Instance> = own.into_iter().chain(object.inner.iter().copied()).collect();
            if scene.instances.len().saturating_add(parts.len().saturating_mul(places.len())) > MAX_INSTANCES {
                let problem = format!("the scene has more than {MAX_INSTANCES} instances");
                return error(problem, "show fewer".to_owned());
            }
            let flat = places.iter().filter(|place| flattens(&table.to_world) || flattens(place)).count();
            if flat > 0 {
                let flat = count(flat, "instance of", "instances of");
                scene.warnings.push(format!(
                    "{}:{}: {flat} {:?} may not be seen: the transform flattens it, for example by a scale of 0, and flat \
                     instances are hidden where they are shared",
                    self.path.display(),
                    table.line,
                    table.of
                ));
            }
            let materials = table.materials(self.path, scene)?;
            let parts: Vec<Instance> = parts
                .into_iter()
                .map(|part| Instance { object: self.with_materials(part.object, &materials, scene), ..part })
                .collect();
            for (number, place) in places.iter().enumerate() {
                let to_world = table.to_world * *place;
                if !to_world.is_finite() {
                    return error(
                        format!("instance {number} has no finite transform"),
                        "use smaller numbers".to_owned(),
                    );
                }
                let placed = |part: &Instance| Instance { to_world: to_world * part.to_world, ..*part };
                scene.instances.extend(parts.iter().map(placed));
            }
        }
        Ok(())
    }

    /// The object with these materials in place of its own: itself, or a copy of its meshes.
    fn with_materials(&mut self, object: usize, materials: &[(usize, usize)], scene: &mut Scene) -> usize {
        if materials.is_empty() {
            return object;
        }
        let key = (object, materials.to_vec());
        if let Some(copy) = self.copies.get(&key) {
            return *copy;
        }
        let copy = scene.objects.len();
        scene.objects.push(scene.objects[object].clone());
        let changed = |mesh: &Mesh| {
            let material =
                materials.iter().find(|(own, _)| *own == mesh.material).map_or(mesh.material, |(_, new)| *new);
            Mesh { material, object: Some(copy), ..mesh.clone() }
        };
        let meshes = scene.meshes.iter().filter(|mesh| mesh.object == Some(object));
        let mut meshes: Vec<Mesh> = meshes.map(changed).collect();
        scene.meshes.append(&mut meshes);
        self.copies.insert(key, copy);
        copy
    }
}

/// Adds a model's meshes, materials and textures to the scene, all called after `name`; `place` is that of its table.
fn append(scene: &mut Scene, model: Scene, name: &str, place: &str) -> Loaded {
    let (first_texture, first_material) = (scene.textures.len(), scene.materials.len());
    let own = model.meshes.iter().any(|mesh| mesh.object.is_none()).then_some(scene.objects.len());
    if own.is_some() {
        scene.objects.push(Object { name: name.to_owned() });
    }
    let first_object = scene.objects.len();
    let called = |own: &str| if own.is_empty() { name.to_owned() } else { format!("{name}/{own}") };
    scene.objects.extend(model.objects.iter().map(|object| Object { name: called(&object.name) }));
    scene.meshes.extend(model.meshes.into_iter().map(|mesh| Mesh {
        name: called(&mesh.name),
        added_at: Some(Arc::from(place)),
        material: first_material + mesh.material,
        object: mesh.object.map_or(own, |object| Some(first_object + object)),
        ..mesh
    }));
    scene.materials.extend(model.materials.into_iter().map(|mut material| {
        material.name = called(&material.name);
        material.texture_maps_mut().for_each(|map| map.texture += first_texture);
        material
    }));
    scene.textures.extend(model.textures);
    scene.animations.extend(model.animations.into_iter().map(|it| Animation { name: called(&it.name), ..it }));
    scene.files.extend(model.files);
    scene.warnings.extend(model.warnings);
    if !model.lights.is_empty() || model.camera.is_some() {
        scene.warnings.push(format!("{place}: object {name:?}: its model's lights and cameras are left out"));
    }
    let inner = model.instances.iter().map(|inner| Instance { object: first_object + inner.object, ..*inner });
    Loaded { own, inner: inner.collect() }
}

/// Whether a transform has no volume. Single precision would take small scales for 0.
fn flattens(transform: &Affine3A) -> bool {
    transform.matrix3.as_dmat3().determinant() == 0.0
}

impl InstanceTable {
    /// The names of the materials that it gives its object.
    pub(super) fn new_materials(&self) -> impl Iterator<Item = &str> {
        self.materials.iter().map(|(_, new)| new.as_str())
    }

    /// The materials that the object has by itself, each with the one that it gets.
    fn materials(&self, path: &Path, scene: &Scene) -> Result<Vec<(usize, usize)>, SceneError> {
        let find = |name: &str, what: &str| {
            let found = scene.materials.iter().position(|material| material.name == name);
            found.ok_or_else(|| {
                let names: Vec<&str> = scene.materials.iter().map(|material| material.name.as_str()).collect();
                let problem = format!("{what} {name:?}");
                SceneError::new(path, Place::Line(self.line), problem, suggestion(name, &names))
            })
        };
        let each = |(own, new): &(String, String)| {
            let own = find(&format!("{}/{own}", self.of), "the object has no material")?;
            Ok((own, find(new, "the scene has no material")?))
        };
        self.materials.iter().map(each).collect()
    }
}

#[cfg(test)]
mod tests;
