//! Materials by one or two parameters.

use glam::Vec3;

use super::Material;
use crate::material::Inputs;

impl Material {
    /// Diffuse reflection of this albedo, 0 to 1 a channel.
    pub fn matte(albedo: Vec3) -> Self {
        Self::of(Inputs { base_color: albedo, ..Inputs::default() })
    }

    /// A smooth metal of this reflectance at normal incidence, 0 to 1 a channel.
    pub fn mirror(reflectance: Vec3) -> Self {
        Self::of(Inputs { base_color: reflectance, base_metalness: 1.0, specular_roughness: 0.0, ..Inputs::default() })
    }

    /// Diffuse reflection under a smooth clear varnish of this index of refraction, 1 and above.
    pub fn varnished(albedo: Vec3, ior: f32) -> Self {
        let (specular_weight, specular_roughness, specular_ior) = (1.0, 0.0, ior);
        Self::of(Inputs { base_color: albedo, specular_weight, specular_roughness, specular_ior, ..Inputs::default() })
    }

    /// Clear glass of this index of refraction, 1 and above.
    pub fn glass(ior: f32) -> Self {
        Self::of(Inputs { transmission_weight: 1.0, ..Self::varnished(Vec3::ONE, ior).inputs })
    }

    /// A material of these inputs everywhere.
    pub fn of(inputs: Inputs) -> Self {
        Self { inputs, ..Self::default() }
    }
}
