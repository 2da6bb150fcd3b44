//! What closures are made from: a material's inputs at a point, with its textures.

use glam::Vec3;

use super::{Surface, World};
use crate::material::{Inputs, Kind, Shading, bent_normal};
use crate::scene::{CoatNormal, MeshPoint};

impl World {
    /// What kind of closure a triangle's material needs.
    #[inline(always)]
    pub(crate) fn kind(&self, prim_id: u32) -> Kind {
        self.kinds[self.triangle_records[prim_id as usize].material as usize]
    }

    /// Whether materials of any mesh need another kind than [`Kind::Matte`].
    #[inline]
    pub(crate) fn has_closures(&self) -> bool {
        self.has_closures
    }

    /// Whether a triangle's material scatters nearly as a diffuse surface of its albedo would, so that what it reflects may be
    /// told by its irradiance where means over many such points are taken.
    pub(crate) fn is_nearly_diffuse(&self, prim_id: u32) -> bool {
        let material = &self.materials[self.triangle_records[prim_id as usize].material as usize];
        self.kind(prim_id) == Kind::Matte || material.is_nearly_diffuse()
    }

    /// The material's inputs at a surface.
    pub(crate) fn inputs(&self, surface: &Surface) -> Inputs {
        let [u, v] = surface.barycentric;
        let point = self.mesh_point(surface.prim_id, [1.0 - u - v, u, v]);
        let mut inputs = surface.material.inputs_at(&point);
        if inputs.coat_weight > 0.0 && surface.material.coat_normal != CoatNormal::OfBase {
            inputs.coat_normal = surface.coat_normal(&point);
        }
        inputs
    }
}

impl Surface<'_> {
    /// The normal of its coat, in the shading frame, on the side of `wo`.
    #[inline(never)]
    fn coat_normal(&self, point: &MeshPoint) -> Vec3 {
        // Maps are about the normal on the front.
        let side = if self.is_back { -1.0 } else { 1.0 };
        let Some(normal) = self.material.coat_normal_at(point, self.smooth_normal * side) else { return Vec3::Z };
        let normal = bent_normal(self.normal, normal * side, self.wo);
        Shading::new(self.normal, self.shading_normal, self.tangent, self.wo).frame().to_local(normal).normalize()
    }

    /// What is left of light after a way of this length to this surface, as far as it runs inside (Beer-Lambert).
    #[inline]
    pub(crate) fn transmittance(&self, inputs: &Inputs, distance: f32) -> Vec3 {
        let is_inside = self.is_back && !inputs.thin_walled && inputs.absorption != Vec3::ZERO;
        if is_inside { (-distance * inputs.absorption).exp() } else { Vec3::ONE }
    }
}
