//! Kinds of materials by the work that shading needs.

use std::f32::consts::FRAC_1_SQRT_2;

use glam::{Vec3, Vec4};

use super::{Input, InputMap, Material};
use crate::material::ggx::Ggx;
use crate::material::{Bsdf, Closure, Inputs, Kind};

/// A direction halfway between the normal and the horizon.
const OBLIQUE: Vec3 = Vec3::new(FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2);
/// The least reflectance at 45° of what counts as a mirror.
const MIN_MIRROR_REFLECTANCE: f32 = 0.01;
/// Below this roughness faces reflect nearly as mirrors do.
const NEARLY_SMOOTH: f32 = 0.1;

impl Material {
    /// The kind of closure that it needs wherever it is: that of the greatest values of its inputs.
    pub(crate) fn kind(&self) -> Kind {
        if self.unlit { Kind::Matte } else { Kind::of(&self.greatest_inputs()) }
    }

    /// The albedo of diffuse reflection, about, without textures.
    pub(crate) fn mean_diffuse(&self) -> Vec3 {
        let Inputs { base_color, base_metalness, transmission_weight, diffuse_transmission_weight, .. } = self.inputs;
        let part = (1.0 - base_metalness) * (1.0 - transmission_weight) * (1.0 - diffuse_transmission_weight);
        if self.unlit { Vec3::ZERO } else { base_color * part }
    }

    /// The part of light that it scatters, about, without textures.
    pub(crate) fn mean_albedo(&self) -> Vec3 {
        if self.unlit { Vec3::ZERO } else { Closure::new(&self.inputs, false).albedo(OBLIQUE) }
    }

    /// The part of light that it reflects into about one direction, without textures: as a mirror, or nearly so.
    fn mean_mirror_reflectance(&self) -> Vec3 {
        let smoothed = |roughness: f32| if roughness < NEARLY_SMOOTH { 0.0 } else { roughness };
        let Inputs { specular_roughness, coat_roughness, .. } = self.inputs;
        let (specular_roughness, coat_roughness) = (smoothed(specular_roughness), smoothed(coat_roughness));
        let smoothed = Inputs { specular_roughness, coat_roughness, ..self.inputs };
        if self.unlit { Vec3::ZERO } else { Closure::new(&smoothed, false).mirror_reflectance(OBLIQUE) }
    }

    /// The parts of light that it reflects and transmits to many directions, about, without textures. Smooth glass and
    /// mirrors send light on in one direction, and count as black.
    pub(crate) fn mean_scattering(&self) -> [Vec3; 2] {
        let (mut albedo, inputs) = (self.mean_albedo(), self.even_inputs());
        if !self.is_glass() {
            albedo = (albedo - self.mean_mirror_reflectance()).max(Vec3::ZERO);
            let transmitted = albedo * inputs.diffuse_transmission_weight;
            return [albedo - transmitted, transmitted];
        }
        let share = (1.0 - inputs.base_metalness) * inputs.transmission_weight;
        let is_smooth = Ggx::new(inputs.specular_roughness, inputs.specular_anisotropy).is_delta();
        let transmitted = if is_smooth { Vec3::ZERO } else { share * inputs.transmission_color };
        [(albedo - share).max(Vec3::ZERO), transmitted]
    }

    /// Whether it scatters indirect light nearly as a diffuse surface of its albedo would.
    pub(crate) fn is_nearly_diffuse(&self) -> bool {
        const ROUGH: f32 = 0.25;
        let Inputs { base_metalness, transmission_weight, diffuse_transmission_weight, coat_weight, .. } = self.inputs;
        let is_opaque = transmission_weight == 0.0 && diffuse_transmission_weight == 0.0;
        is_opaque && base_metalness < 0.5 && coat_weight == 0.0 && self.inputs.specular_roughness >= ROUGH
    }

    /// Whether light goes through, so that one may see it from within.
    pub(crate) fn is_glass(&self) -> bool {
        self.kind() >= Kind::Transmissive && self.inputs.transmission_weight > 0.0
    }

    /// The inputs of smooth glass that is the same everywhere, and nothing else: what it does not reflect goes through.
    pub(crate) fn clear_glass_inputs(&self) -> Option<Inputs> {
        let is_dark = self.emission == Vec3::ZERO && self.emission_map.is_none();
        if !(self.is_glass() && self.is_uniform() && is_dark && self.opacity.is_whole()) {
            return None;
        }
        let inputs = self.inputs_by(|_| Vec4::ONE, Vec3::ONE);
        let is_bare = inputs.coat_weight == 0.0 && inputs.fuzz_weight == 0.0 && inputs.thin_film_weight == 0.0;
        let is_smooth = Ggx::new(inputs.specular_roughness, inputs.specular_anisotropy).is_delta();
        (is_bare && is_smooth && inputs.transmission_weight == 1.0 && inputs.base_metalness == 0.0).then_some(inputs)
    }

    /// Whether it reflects as a mirror does, at least in part and everywhere: normal maps make it scatter.
    pub(crate) fn is_mirror(&self) -> bool {
        let has_flat_normals = !self.tilts_normals() && self.coat_normal.map().is_none();
        let reflectance = || Closure::new(&self.greatest_inputs(), false).mirror_reflectance(OBLIQUE).max_element();
        !self.unlit && has_flat_normals && reflectance() > MIN_MIRROR_REFLECTANCE
    }

    /// Whether light neither goes through nor comes from it, anywhere.
    pub(crate) fn is_opaque_and_dark(&self) -> bool {
        let Inputs { transmission_weight, diffuse_transmission_weight, .. } = self.greatest_inputs();
        let is_opaque = transmission_weight == 0.0 && diffuse_transmission_weight == 0.0;
        is_opaque && self.emission == Vec3::ZERO && !self.unlit
    }

    /// Whether it is the same all over a mesh, vertex normals and colours left aside.
    pub(crate) fn is_uniform(&self) -> bool {
        let has_maps = !self.maps.is_empty() || self.emission_map.is_some() || self.anisotropy.is_some();
        let turns_normals = self.tilts_normals() || self.coat_normal.map().is_some();
        !has_maps && !turns_normals && self.tangent_rotation == 0.0
    }

    /// Whether reflections may be wider in one direction than in another.
    pub(crate) fn is_anisotropic(&self) -> bool {
        let is_mapped = |map: &InputMap| map.targets.iter().any(|target| target.input == Input::SpecularAnisotropy);
        self.inputs.specular_anisotropy > 0.0 || self.anisotropy.is_some() || self.maps.iter().any(is_mapped)
    }

    /// Whether it has holes, or is there in part, vertex colours left aside.
    pub(crate) fn has_holes(&self) -> bool {
        !self.opacity.is_whole()
    }
}
