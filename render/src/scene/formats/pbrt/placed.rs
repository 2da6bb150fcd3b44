//! From shapes to meshes of the scene: their transforms, objects, instances and materials.
//!
//! Names of materials and objects may be used before they are defined, so meshes get their materials when all is read:
//! a material of the file may become several, with and without emission and holes.

use std::collections::BTreeMap;

use glam::{DAffine3, Vec3};

use super::Reader;
use super::lights::AreaLight;
use super::parameters::Parameters;
use super::textures::Tex;
use super::tokens::At;
use crate::scene::nearest::suggestion;
use crate::scene::{Channel, Instance, Material, Mesh, Object, Opacity, SceneError, Sharing};

/// A material of the file.
pub(super) enum Definition {
    /// It has been named at a place, and not been defined yet.
    Awaited(At, String),
    Surface(Box<Material>),
    /// It is not seen.
    Interface,
}

/// The appearance of a mesh.
#[derive(PartialEq)]
pub(super) struct Look {
    /// The index of a material of the file; `None` for the default.
    material: Option<usize>,
    emission: Vec3,
    light: Option<std::rc::Rc<AreaLight>>,
    alpha: Tex,
}

/// Objects and where they are to be shown.
#[derive(Default)]
pub(super) struct Objects {
    /// The one whose shapes are being read.
    pub(super) current: Option<usize>,
    numbers: BTreeMap<String, usize>,
    instances: Vec<(String, At, DAffine3)>,
}

/// Looks that are compared with a new one: shapes that look alike mostly follow one another.
const RECENT: usize = 16;

impl Reader<'_> {
    /// `Shape`.
    pub(super) fn shape(&mut self, kind: &str, parameters: &Parameters) -> Result<(), SceneError> {
        let alpha = self.number(parameters, "alpha", 1.0)?;
        let Some(mesh) = self.shape_mesh(kind, parameters)? else { return Ok(()) };
        self.warn_of_unused(parameters);
        let object = self.objects.current;
        let to_world = if object.is_some() { self.state.transform } else { self.to_world() };
        let mut mesh = Mesh { name: kind.to_owned(), object, ..mesh }.placed(&to_world);
        if mesh.positions.iter().any(|position| !position.is_finite()) {
            let problem = format!("{} has positions beyond all numbers", parameters.of);
            return Err(parameters.at.error(problem, "use smaller coordinates or scales"));
        }
        if self.state.reverses {
            mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
            mesh.normals.iter_mut().for_each(|normal| *normal = -*normal);
        }
        let mut light = self.state.light.clone();
        if object.is_some() && light.take().is_some() {
            self.note(&parameters.at, "area lights in objects do not emit, as in pbrt");
        }
        // Each triangle and each patch of a mesh is a light of its own in pbrt.
        let lights = match kind {
            "trianglemesh" | "plymesh" => mesh.triangles.len(),
            "bilinearmesh" => parameters.integers("indices")?.map_or(1, |corners| corners.len() / 4),
            _ => 1,
        };
        let emission = light.as_ref().map_or(Vec3::ZERO, |light| light.radiance_of(&mesh, lights));
        let look = Look { material: self.state.material, emission, light, alpha };
        let recent = self.looks.len().saturating_sub(RECENT);
        let known = self.looks[recent..].iter().position(|known| *known == look);
        mesh.material = recent + known.unwrap_or(self.looks.len() - recent);
        if known.is_none() {
            self.looks.push(look);
        }
        self.scene.meshes.push(mesh);
        Ok(())
    }

    /// `Material`.
    pub(super) fn set_material(&mut self, kind: &str, parameters: &Parameters) -> Result<(), SceneError> {
        let definition = self.definition(kind, parameters)?;
        self.state.material = Some(self.materials.len());
        self.materials.push(definition);
        Ok(())
    }

    /// `MakeNamedMaterial`.
    pub(super) fn name_material(&mut self, name: String, parameters: &Parameters) -> Result<(), SceneError> {
        let Some(kind) = parameters.text("type")?.map(str::to_owned) else {
            let problem = format!("the material {name:?} has no type");
            return Err(parameters.at.error(problem, "write `\"string type\" \"diffuse\"`"));
        };
        let mut definition = self.definition(&kind, parameters)?;
        if let Definition::Surface(material) = &mut definition {
            material.name.clone_from(&name);
        }
        let number = self.named_material(name, &parameters.at);
        self.materials[number] = definition;
        Ok(())
    }

    fn definition(&mut self, kind: &str, parameters: &Parameters) -> Result<Definition, SceneError> {
        let material = self.material(kind, parameters)?;
        self.warn_of_unused(parameters);
        Ok(material.map_or(Definition::Interface, |material| Definition::Surface(Box::new(material))))
    }

    /// The index of the material with a name.
    pub(super) fn named_material(&mut self, name: String, at: &At) -> usize {
        let next = self.materials.len();
        let number = *self.material_names.entry(name.clone()).or_insert(next);
        if number == next {
            self.materials.push(Definition::Awaited(at.clone(), name));
        }
        number
    }

    /// `ObjectBegin`.
    pub(super) fn begin_object(&mut self, name: String, at: &At) -> Result<(), SceneError> {
        if self.objects.current.is_some() {
            return Err(at.error("an object begins in another one", "end that with `ObjectEnd` before"));
        }
        let number = self.scene.objects.len();
        if self.objects.numbers.insert(name.clone(), number).is_some() {
            return Err(at.error(format!("the object {name:?} is there already"), "give each object a name of its own"));
        }
        self.scene.objects.push(Object { name });
        self.objects.current = Some(number);
        Ok(())
    }

    /// `ObjectInstance`.
    pub(super) fn instance(&mut self, name: String, at: At) -> Result<(), SceneError> {
        if self.objects.current.is_some() {
            let problem = format!("the object {name:?} is shown in another object");
            return Err(at.error(problem, "end that with `ObjectEnd` before: objects do not hold objects"));
        }
        let to_world = self.to_world();
        self.objects.instances.push((name, at, to_world));
        Ok(())
    }

    /// Shows objects: by instances, or by copies where these are few.
    pub(super) fn finish_objects(&mut self, sharing: Sharing) -> Result<(), SceneError> {
        let mut places = vec![Vec::new(); self.scene.objects.len()];
        for (name, at, to_world) in &self.objects.instances {
            let Some(&number) = self.objects.numbers.get(name) else {
                let known: Vec<&str> = self.objects.numbers.keys().map(String::as_str).collect();
                let remedy = match known.is_empty() {
                    true => format!("define it: `ObjectBegin {name:?}`, its shapes, `ObjectEnd`"),
                    false => suggestion(name, &known),
                };
                return Err(at.error(format!("there is no object {name:?}"), remedy));
            };
            places[number].push(*to_world);
        }
        let (_, of_objects) = self.scene.meshes_by_object();
        let triangles = |meshes: &Vec<usize>| meshes.iter().map(|&it| self.scene.meshes[it].triangles.len()).sum();
        let uses: Vec<(usize, usize)> =
            of_objects.iter().zip(&places).map(|(meshes, places)| (triangles(meshes), places.len())).collect();
        let is_shared = sharing.shared(&uses);
        let mut numbers = vec![None; places.len()];
        let objects = std::mem::take(&mut self.scene.objects);
        for (number, object) in objects.into_iter().enumerate().filter(|(number, _)| is_shared[*number]) {
            numbers[number] = Some(self.scene.objects.len());
            let object_number = self.scene.objects.len();
            let instance = |to_world: &DAffine3| Instance { object: object_number, to_world: to_world.as_affine3a() };
            self.scene.instances.extend(places[number].iter().map(instance));
            self.scene.objects.push(object);
        }
        for mesh in std::mem::take(&mut self.scene.meshes) {
            let Some(number) = mesh.object else {
                self.scene.meshes.push(mesh);
                continue;
            };
            if is_shared[number] {
                self.scene.meshes.push(Mesh { object: numbers[number], ..mesh });
            } else {
                let copy = |to_world: &DAffine3| Mesh { object: None, ..mesh.clone() }.placed(to_world);
                self.scene.meshes.extend(places[number].iter().map(copy));
            }
        }
        Ok(())
    }

    /// Gives meshes the materials that they look like, and removes those that are not seen.
    pub(super) fn finish_materials(&mut self) -> Result<(), SceneError> {
        let looks = std::mem::take(&mut self.looks);
        let mut numbers = Vec::with_capacity(looks.len());
        for Look { material, emission, light, alpha } in looks {
            let mut material = match material.map(|number| &self.materials[number]) {
                None => Material::default(),
                Some(Definition::Surface(material)) => (**material).clone(),
                Some(Definition::Interface) => {
                    numbers.push(None);
                    continue;
                }
                Some(Definition::Awaited(at, name)) => {
                    let is_other = |known: &&str| *known != name.as_str();
                    let known: Vec<&str> = self.material_names.keys().map(String::as_str).filter(is_other).collect();
                    let remedy = match known.is_empty() {
                        true => format!("define it: `MakeNamedMaterial {name:?} \"string type\" \"diffuse\"`"),
                        false => suggestion(name, &known),
                    };
                    return Err(at.error(format!("there is no material {name:?}"), remedy));
                }
            };
            material.emission = emission;
            if let Some(light) = light {
                material.emits_both_sides = light.two_sided;
                material.emission_map.clone_from(&light.picture);
            }
            material.opacity = match alpha {
                Tex::Constant(value) => Opacity { value: value.x.clamp(0.0, 1.0), ..Opacity::default() },
                Tex::Image { map, scale } => {
                    Opacity { value: scale.x.max(0.0), map: Some((map, Channel::R)), cutoff: None }
                }
            };
            numbers.push(Some(self.scene.materials.len()));
            self.scene.materials.push(material);
        }
        self.scene.meshes.retain_mut(|mesh| match numbers[mesh.material] {
            Some(number) => {
                mesh.material = number;
                true
            }
            None => false,
        });
        Ok(())
    }
}
