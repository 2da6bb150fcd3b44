//! Does to a scene what the tables say.

use std::path::Path;

use glam::{Affine2, Vec3};

use super::maps::MapFile;
use super::{Change, MaterialTable, Target};
use crate::scene::Scene;
use crate::scene::description::Mesh;
use crate::scene::error::{Place, SceneError};
use crate::scene::files::{Disk, Recorded};
use crate::scene::material::{BumpMap, Channel, CoatNormal, Input, Material, Opacity};
use crate::scene::nearest::suggestion;
use crate::scene::texture::{ColorSpace, TextureMap, TextureStore};

/// Does to the scene what the tables of the scene file at `path` say. Those whose names are `used` may be new ones.
pub(crate) fn apply(tables: &[MaterialTable], used: &[&str], path: &Path, scene: &mut Scene) -> Result<(), SceneError> {
    let files = Recorded::new(&Disk);
    let mut store = TextureStore::new(&files, core::mem::take(&mut scene.textures));
    for table in tables {
        let number = table.material(used, path, scene)?;
        for (line, change) in &table.changes {
            let material = &mut scene.materials[number];
            material.change(change, &mut store).map_err(|(problem, remedy)| {
                let problem = format!("material {:?}: {problem}", table.name);
                SceneError::new(path, Place::Line(*line), problem, remedy)
            })?;
        }
    }
    scene.textures = store.list;
    scene.files.extend(files.into_paths());
    Ok(())
}

impl MaterialTable {
    /// The index of the material that is meant, which becomes that of the meshes that are named.
    fn material(&self, used: &[&str], path: &Path, scene: &mut Scene) -> Result<usize, SceneError> {
        let error = |problem, remedy| Err(SceneError::new(path, Place::Line(self.line), problem, remedy));
        let known = scene.materials.iter().position(|material| material.name == self.name);
        if known.is_none() && self.meshes.is_empty() && !used.contains(&self.name.as_str()) {
            let names: Vec<&str> = scene.materials.iter().map(|material| material.name.as_str()).collect();
            let problem = format!("the model has no material {:?}", self.name);
            return error(problem, format!("a new one names its meshes = [\"…\"]; {}", suggestion(&self.name, &names)));
        }
        let number = known.unwrap_or_else(|| {
            let inputs = crate::material::Inputs { specular_weight: 1.0, ..Default::default() };
            scene.materials.push(Material { name: self.name.clone(), inputs, ..Material::default() });
            scene.materials.len() - 1
        });
        for name in &self.meshes {
            let named = |mesh: &&mut Mesh| mesh.name == *name;
            let mut found = false;
            for mesh in scene.meshes.iter_mut().filter(named) {
                (mesh.material, found) = (number, true);
            }
            if !found {
                let names: Vec<&str> = scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
                let problem = format!("material {:?}: the model has no mesh {name:?}", self.name);
                return error(problem, suggestion(name, &names));
            }
        }
        Ok(number)
    }
}

impl Material {
    fn change(&mut self, change: &Change, store: &mut TextureStore) -> Result<(), (String, String)> {
        match *change {
            Change::Input(input, value) => {
                input.set(&mut self.inputs, value);
                match input {
                    Input::TransmissionColor => self.base_color_tints_transmission = false,
                    Input::SpecularAnisotropy | Input::SpecularRoughness => self.anisotropy = None,
                    _ => {}
                }
            }
            Change::LightGroup(ref group) => self.light_group = group.clone(),
            Change::Opacity(value) => self.opacity.value = value,
            Change::Cutoff(cutoff) => self.opacity.cutoff = Some(cutoff),
            Change::ThinWalled(thin) => self.inputs.thin_walled = thin,
            Change::EmissionColor(color) => {
                let luminance = self.emission.max_element();
                self.emission = color * if luminance > 0.0 { luminance } else { 1.0 };
            }
            Change::EmissionLuminance(luminance) => {
                let greatest = self.emission.max_element();
                let color = if greatest > 0.0 { self.emission / greatest } else { Vec3::ONE };
                self.emission = color * luminance;
            }
            Change::TransmissionDepth(depth) => {
                let color = self.inputs.transmission_color.max(Vec3::splat(1e-6));
                self.inputs.absorption = -color.map(f32::ln) / depth;
                (self.inputs.transmission_color, self.base_color_tints_transmission) = (Vec3::ONE, false);
            }
            Change::AbbeNumber(abbe) => self.dispersion = 20.0 / abbe,
            Change::TangentRotation(degrees) => self.tangent_rotation = degrees.to_radians(),
            Change::NoMap(target) => self.remove(target),
            Change::Map(target, ref map) => self.map(target, map, store)?,
        }
        Ok(())
    }

    fn remove(&mut self, target: Target) {
        match target {
            Target::Input(input) => self.remove_map(input),
            Target::Emission => self.emission_map = None,
            Target::Opacity => self.opacity.map = None,
            Target::Normal => self.normal_map = None,
            Target::CoatNormal => self.coat_normal = CoatNormal::OfVertices,
            Target::Bump => self.bump_map = None,
        }
    }

    fn map(&mut self, target: Target, map: &MapFile, store: &mut TextureStore) -> Result<(), (String, String)> {
        let texture = store.load(&map.file).map_err(|it| (it.problem, it.remedy))?;
        let is_color = matches!(target, Target::Emission) || matches!(target, Target::Input(input) if input.is_color());
        let space = map.space.unwrap_or(if is_color { ColorSpace::Srgb } else { ColorSpace::Linear });
        let transform = Affine2::from_scale_angle_translation(map.scale, -map.rotation.to_radians(), map.offset);
        let texture = TextureMap { texture, set: map.set, transform, wrap: [map.wrap; 2], filter: map.filter, space };
        let channel = map.channel.unwrap_or(if is_color { Channel::Rgb } else { Channel::R });
        match target {
            Target::Input(input) => self.add_map(texture, input, channel, map.zero),
            Target::Emission => self.emission_map = Some(texture),
            Target::Opacity => {
                let map = Some((texture, map.channel.unwrap_or(Channel::A)));
                self.opacity = Opacity { map, ..self.opacity.clone() };
            }
            Target::Normal => self.normal_map = Some(map.normal_map(texture)),
            Target::CoatNormal => self.coat_normal = CoatNormal::Map(map.normal_map(texture)),
            Target::Bump => self.bump_map = Some(BumpMap { texture, channel, height: map.height }),
        }
        Ok(())
    }
}
