//! Closures of surfaces. For a material without maps they depend only on the side, and are made once; where only the
//! base colour varies, the parts independent of it are made once.

use std::sync::OnceLock;

use crate::material::{Closure, Prepared};
use crate::scene::{CoatNormal, Input, Material};
use crate::world::{InputChange, Surface, World};

/// The closures of a material, made when the first is asked for: the tables that they need are made then.
pub(crate) type ClosureCell = OnceLock<MaterialClosures>;

/// The precomputed closures of a material.
#[derive(Debug)]
pub(crate) struct MaterialClosures {
    varies: Varies,
    /// The closures from outside and from inside, without maps.
    sides: [Closure; 2],
}

/// The inputs of a material that vary over a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Varies {
    Nothing,
    BaseColor,
    More,
}

impl MaterialClosures {
    fn new(material: &Material) -> Self {
        let (kind, inputs) = (material.kind(), material.even_inputs());
        let sides = [false, true].map(|is_inside| Closure::of_kind(kind, &inputs, is_inside));
        Self { varies: Varies::of(material), sides }
    }
}

impl Varies {
    fn of(material: &Material) -> Self {
        let is_mapped =
            |is: fn(Input) -> bool| material.maps.iter().flat_map(|map| &map.targets).any(|target| is(target.input));
        let is_anisotropy_mapped = material.anisotropy.as_ref().is_some_and(|anisotropy| anisotropy.map.is_some());
        let has_coat_normal = material.coat_normal != CoatNormal::OfBase;
        if is_anisotropy_mapped || has_coat_normal || is_mapped(|input| input != Input::BaseColor) {
            Self::More
        } else if material.uses_vertex_colors || is_mapped(|input| input == Input::BaseColor) {
            Self::BaseColor
        } else {
            Self::Nothing
        }
    }
}

impl World {
    /// The closure of a surface that is not matte, of the type that its kind has, or [`Closure`].
    #[inline]
    pub(crate) fn closure<B: Prepared>(&self, surface: &Surface) -> B {
        let material = self.triangle_records[surface.prim_id as usize].material as usize;
        let of_material = self.closures[material].get_or_init(|| MaterialClosures::new(&self.materials[material]));
        let prepared = B::of(&of_material.sides[usize::from(surface.is_back)]);
        if surface.change != InputChange::NONE {
            return prepared.with_inputs(&self.inputs(surface), surface.is_back);
        }
        match of_material.varies {
            Varies::Nothing => *prepared,
            Varies::BaseColor => prepared.with_base_color(&self.inputs(surface), surface.is_back),
            Varies::More => prepared.with_inputs(&self.inputs(surface), surface.is_back),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3, Vec4, vec3};

    use super::*;
    use crate::material::{Inputs, Kind};
    use crate::scene::{CameraPose, Channel, ColorSpace, Mesh, Scene, Texture, TextureMap};

    /// A square that has a texture, vertex colours and this material.
    fn square(material: Material) -> World {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let texels = (0..16u8).map(|i| [16 * i, 255 - 9 * i, 100 + 7 * i, 255]).collect();
        World::new(Scene {
            meshes: vec![Mesh {
                positions: corners.map(|(x, y)| vec3(x, y, 0.0)).to_vec(),
                texcoords: corners.map(|(x, y)| Vec2::new(x, 1.0 - y)).to_vec(),
                colors: vec![Vec4::new(0.3, 0.9, 1.0, 1.0), Vec4::ONE, Vec4::splat(0.5), Vec4::new(1.0, 0.1, 0.2, 1.0)],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                ..Mesh::default()
            }],
            materials: vec![material],
            textures: vec![Texture::new(4, 4, texels)],
            camera: Some(CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 }),
            ..Scene::default()
        })
        .unwrap()
    }

    /// Materials of all kinds but matte ones, in which nothing varies.
    fn even() -> Vec<Material> {
        let plain = Inputs { specular_weight: 1.0, base_color: vec3(0.7, 0.4, 0.2), ..Inputs::default() };
        [
            plain,
            Inputs { base_metalness: 1.0, specular_roughness: 0.0, metal_edge_color: vec3(0.8, 0.7, 0.6), ..plain },
            Inputs { base_metalness: 0.4, base_diffuse_roughness: 0.5, specular_anisotropy: 0.6, ..plain },
            Inputs { transmission_weight: 0.8, specular_roughness: 0.2, ..plain },
            Inputs { diffuse_transmission_weight: 0.3, ..plain },
            Inputs { coat_weight: 0.5, coat_color: vec3(0.9, 0.5, 0.5), coat_roughness: 0.1, ..plain },
            Inputs { fuzz_weight: 0.7, thin_film_weight: 1.0, base_metalness: 0.5, ..plain },
        ]
        .map(|inputs| Material { inputs, ..Material::default() })
        .to_vec()
    }

    fn mapped(material: &Material, input: Input, channel: Channel) -> Material {
        let mut material = material.clone();
        material.add_map(TextureMap { space: ColorSpace::Srgb, ..TextureMap::default() }, input, channel, 0.0);
        material
    }

    /// All but [`Kind::Matte`] have closures; each must be the one that is made from the inputs at the point, in all
    /// its bits.
    fn is_as_made_there(material: &Material, expected: Varies) {
        assert_eq!(Varies::of(material), expected, "{material:?}");
        let world = square(material.clone());
        let kind = material.kind();
        assert_ne!(kind, Kind::Matte);
        for (prim, u, v) in [(0, 0.2, 0.3), (1, 0.7, 0.1), (0, 0.0, 0.9)] {
            for direction in [vec3(0.3, 0.1, -1.0), vec3(-0.2, 0.4, 1.0)].map(Vec3::normalize) {
                let surface = world.surface(prim, u, v).facing(direction);
                let made = Closure::of_kind(kind, &world.inputs(&surface), surface.is_back);
                let found = world.closure::<Closure>(&surface);
                assert_eq!(format!("{found:?}"), format!("{made:?}"), "{material:?}");
            }
        }
    }

    #[test]
    fn closures_without_maps_are_made_once() {
        for material in even() {
            is_as_made_there(&material, Varies::Nothing);
        }
    }

    #[test]
    fn closures_take_another_base_color() {
        for material in even() {
            let picture = mapped(&material, Input::BaseColor, Channel::Rgb);
            is_as_made_there(&picture, Varies::BaseColor);
            is_as_made_there(&Material { uses_vertex_colors: true, ..material }, Varies::BaseColor);
            let tinted = Material { base_color_tints_transmission: true, ..picture.clone() };
            is_as_made_there(&tinted, Varies::BaseColor);
            is_as_made_there(&Material { uses_vertex_colors: true, ..picture }, Varies::BaseColor);
        }
    }

    /// Formats say of any material that vertex colours count. Where no mesh has some, closures are made once.
    #[test]
    fn vertex_colors_that_no_mesh_has_do_not_count() {
        let glass = Inputs { transmission_weight: 1.0, ..Inputs::default() };
        let scene = |colors: Vec<Vec4>| {
            let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
            let mesh = Mesh { positions, triangles: vec![[0, 1, 2]], colors, ..Mesh::default() };
            let material = Material { inputs: glass, uses_vertex_colors: true, ..Material::default() };
            let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };
            // The first material is of no mesh.
            let meshes = vec![Mesh { material: 1, ..mesh }];
            Scene { meshes, materials: vec![material.clone(), material], camera: Some(camera), ..Scene::default() }
        };
        let varies = |colors| World::new(scene(colors)).unwrap().materials.iter().map(Varies::of).collect::<Vec<_>>();
        assert_eq!(varies(Vec::new()), [Varies::Nothing; 2]);
        assert_eq!(varies(vec![Vec4::ONE; 3]), [Varies::Nothing, Varies::BaseColor]);
    }

    #[test]
    fn closures_of_which_more_varies_are_made_where_they_are() {
        for material in even() {
            is_as_made_there(&mapped(&material, Input::SpecularRoughness, Channel::G), Varies::More);
            let both = mapped(&material, Input::BaseColor, Channel::Rgb);
            is_as_made_there(&mapped(&both, Input::BaseMetalness, Channel::B), Varies::More);
        }
        let coated = Inputs { coat_weight: 1.0, ..Inputs::default() };
        let of_vertices = CoatNormal::OfVertices;
        is_as_made_there(&Material { inputs: coated, coat_normal: of_vertices, ..Material::default() }, Varies::More);
    }
}
