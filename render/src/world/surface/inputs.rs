//! A material's inputs at a point, with its textures, from which closures are made.

use glam::Vec3;

use crate::material::{Inputs, Kind, Shading, bent_normal};
use crate::scene::{CoatNormal, MeshPoint};
use crate::world::{Hit, Surface, World};

/// What a path changes in the inputs of the material that it meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InputChange {
    /// The refractive index at the path's wavelength, minus the material's.
    pub ior: f32,
    /// The least roughness of what is rough at all.
    pub least_roughness: f32,
}

impl InputChange {
    pub(crate) const NONE: Self = Self { ior: 0.0, least_roughness: 0.0 };

    fn apply(self, inputs: &mut Inputs) {
        inputs.specular_ior = (inputs.specular_ior + self.ior).max(1.0);
        for roughness in [&mut inputs.specular_roughness, &mut inputs.coat_roughness] {
            // Mirrors and clear glass stay: their light is found in other ways.
            if *roughness > 0.0 {
                *roughness = roughness.max(self.least_roughness);
            }
        }
    }
}

impl World {
    /// The kind of closure of a triangle's material.
    #[inline(always)]
    pub(crate) fn kind(&self, prim_id: u32) -> Kind {
        self.kinds[self.triangle_records[prim_id as usize].material as usize]
    }

    /// Whether materials of any mesh need another kind than [`Kind::Matte`].
    #[inline]
    pub(crate) fn has_closures(&self) -> bool {
        self.has_closures
    }

    /// Whether a triangle's material scatters nearly as a diffuse surface of its albedo would, so that its reflected
    /// indirect light may be computed from its irradiance in means over many such points.
    pub(crate) fn is_nearly_diffuse(&self, prim_id: u32) -> bool {
        let material = &self.materials[self.triangle_records[prim_id as usize].material as usize];
        self.kind(prim_id) == Kind::Matte || material.is_nearly_diffuse()
    }

    /// The material's inputs at a surface.
    pub(crate) fn inputs(&self, surface: &Surface) -> Inputs {
        let [u, v] = surface.barycentric;
        let point = self.mesh_point(surface.prim_id, [1.0 - u - v, u, v]);
        let mut inputs = surface.material.inputs_at(&point);
        surface.change.apply(&mut inputs);
        if inputs.coat_weight > 0.0 && surface.material.coat_normal != CoatNormal::OfBase {
            let Surface { prim_id, instance, time, .. } = *surface;
            let turn = self.turn_at(&Hit { prim_id, instance, u, v, time, ..Hit::MISS });
            inputs.coat_normal = surface.coat_normal(&MeshPoint { turn, ..point });
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
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec2, vec3};
    use halfdome_kernel::Ray;

    use super::*;
    use crate::scene::{ColorSpace, Instance, Material, Mesh, NormalMap, Object, Scene, Texture, TextureMap};
    use crate::world::Hit;

    /// Texels without a slope, and of a normal that leans by 45° along the tangent.
    const FLAT: [u8; 4] = [128, 128, 255, 255];
    const LEANING: [u8; 4] = [218, 128, 218, 255];

    /// The normals of a coated square, which leans by its map, of the base and of the coat, as seen by a vertical ray.
    /// The square stands for itself, or is an object in an instance that is turned.
    fn normals(coat_normal: &CoatNormal, turn: Option<Affine3A>, from_above: bool) -> [Vec3; 2] {
        let map = |texture| TextureMap { texture, space: ColorSpace::Linear, ..TextureMap::default() };
        let mut material = Material { coat_normal: coat_normal.clone(), ..Material::default() };
        material.inputs.coat_weight = 1.0;
        material.normal_map = Some(NormalMap { texture: map(1), scale: Vec2::ONE });
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let mut scene = Scene {
            meshes: vec![Mesh {
                positions: corners.map(|(x, y)| vec3(x, y, 0.0)).to_vec(),
                texcoords: corners.map(|(x, y)| Vec2::new(x, 1.0 - y)).to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                object: turn.map(|_| 0),
                ..Mesh::default()
            }],
            materials: vec![material],
            textures: [FLAT, LEANING].map(|texel| Texture::new(1, 1, vec![texel])).into(),
            camera: crate::scene::cornell_box().camera,
            ..Scene::default()
        };
        if let Some(to_world) = turn {
            scene.objects.push(Object::default());
            scene.instances.push(Instance { object: 0, to_world });
        }
        scene.complete_tangents();
        let world = World::new(scene).unwrap();
        let side = if from_above { 1.0 } else { -1.0 };
        let (ray, mut hits) = (Ray::new(vec3(0.2, 0.1, 5.0 * side), vec3(0.0, 0.0, -side)), [Hit::MISS]);
        world.intersect_many(&[ray], &mut hits);
        let surface = world.surface_at(&hits[0]).facing(ray.direction);
        let Surface { normal, shading_normal, tangent, wo, .. } = surface;
        let shading = Shading::new(normal, shading_normal, tangent, wo);
        [shading_normal, shading.frame().to_world(world.inputs(&surface).coat_normal)]
    }

    #[test]
    fn a_coat_leans_as_its_own_map_says_wherever_it_is_seen() {
        let map = |texture, scale| {
            let texture = TextureMap { texture, space: ColorSpace::Linear, ..TextureMap::default() };
            CoatNormal::Map(NormalMap { texture, scale: Vec2::splat(scale) })
        };
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let (up, right, left) = (Vec3::Z, vec3(half, 0.0, half), vec3(-half, 0.0, half));
        let turns = [None, Some(Affine3A::IDENTITY), Some(Affine3A::from_rotation_z(std::f32::consts::PI))];
        for (number, turn) in turns.into_iter().enumerate() {
            let (with, against) = if number == 2 { (left, right) } else { (right, left) };
            for from_above in [true, false] {
                // Seen from below all normals are reversed.
                let side = if from_above { 1.0 } else { -1.0 };
                for (coat, expected) in [
                    (CoatNormal::OfBase, with),
                    (CoatNormal::OfVertices, up),
                    (map(0, 1.0), up),
                    (map(1, 1.0), with),
                    (map(1, -1.0), against),
                ] {
                    let [base, found] = normals(&coat, turn, from_above);
                    assert!(base.distance(side * with) < 0.01, "{turn:?}: {base}");
                    assert!(found.distance(side * expected) < 0.01, "{coat:?} {turn:?} {from_above}: {found}");
                }
            }
        }
    }
}
