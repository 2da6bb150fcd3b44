//! The attributes of a primitive, from accessors or a compressed stream.
//!
//! Integers are normalised, so that their greatest is 1: those of colours and texture coordinates always, as glTF 2.0 has it;
//! with `KHR_mesh_quantization`, which allows them for all attributes, where the accessor says so.

use ::gltf::json::accessor::ComponentType::{self, F32, I8, I16, U8, U16, U32};
use ::gltf::json::accessor::Type;
use ::gltf::json::mesh::{Primitive, Semantic};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Accessor, Index};
use glam::{Vec2, Vec3, Vec4};

use super::draco::{self, DracoMesh};
use super::{Document, accessor};
use crate::scene::SceneError;
use crate::scene::count;
use crate::scene::description::unit;

/// A primitive's attributes.
pub(super) struct Attributes<'a> {
    document: &'a Document<'a>,
    primitive: &'a Primitive,
    /// For errors.
    place: &'a str,
    draco: Option<DracoMesh>,
    is_quantized: bool,
}

impl<'a> Attributes<'a> {
    pub(super) fn new(
        document: &'a Document<'a>,
        primitive: &'a Primitive,
        place: &'a str,
    ) -> Result<Self, SceneError> {
        let draco = draco::read(document, primitive, place)?;
        let is_quantized = document.uses("KHR_mesh_quantization");
        Ok(Self { document, primitive, place, draco, is_quantized })
    }

    fn accessor(&self, semantic: Semantic) -> Option<Index<Accessor>> {
        self.primitive.attributes.get(&Checked::Valid(semantic)).copied()
    }

    /// `N` numbers for each vertex; integers of `kinds` are allowed besides floats.
    fn numbers<const N: usize>(
        &self,
        semantic: Semantic,
        kinds: &[ComponentType],
    ) -> Result<Option<Vec<[f32; N]>>, SceneError> {
        if let Some(draco) = &self.draco
            && let Some(numbers) = draco.attribute(&semantic)
        {
            return Ok(Some(numbers));
        }
        let name = semantic.to_string();
        let Some(index) = self.accessor(semantic) else { return Ok(None) };
        let accessor = self.document.object(index, "accessor", self.place)?;
        if self.draco.is_some() && accessor.buffer_view.is_none() {
            let problem = format!("its Draco data have no {name}");
            return Err(self.document.error(self.place, problem, "export the model again, without Draco"));
        }
        let kinds: &[ComponentType] = if self.is_quantized { &[F32, I8, U8, I16, U16] } else { kinds };
        let is_normalised = accessor.normalized || !self.is_quantized;
        let numbers = accessor::read::<N>(self.document, index, self.place, &name, kinds)?;
        let number = |it: accessor::Component| if is_normalised { it.normalised() } else { it.raw() };
        Ok(Some(numbers.into_iter().map(|numbers| numbers.map(number)).collect()))
    }

    /// Checks that there is one for each vertex.
    fn complete<T>(&self, found: Option<Vec<T>>, vertices: usize, one: &str, many: &str) -> Result<Vec<T>, SceneError> {
        let found = found.unwrap_or_default();
        if found.is_empty() || found.len() == vertices {
            return Ok(found);
        }
        let vertices = count(vertices, "position", "positions");
        let problem = format!("it has {vertices} but {}", count(found.len(), one, many));
        Err(self.document.error(self.place, problem, "give every vertex all attributes"))
    }

    /// Finite positions.
    pub(super) fn positions(&self) -> Result<Vec<Vec3>, SceneError> {
        let positions = self
            .numbers(Semantic::Positions, &[F32])?
            .ok_or_else(|| self.document.error(self.place, "it has no POSITION", "give it the attribute POSITION"))?;
        let positions: Vec<Vec3> = positions.into_iter().map(Vec3::from_array).collect();
        if let Some(vertex) = positions.iter().position(|position| !position.is_finite()) {
            let problem = format!("the POSITION of vertex {vertex} is not finite");
            return Err(self.document.error(self.place, problem, "export the model again"));
        }
        Ok(positions)
    }

    pub(super) fn normals(&self, vertices: usize) -> Result<Vec<Vec3>, SceneError> {
        let normals = self.numbers(Semantic::Normals, &[F32])?;
        let normals = normals.map(|normals| normals.into_iter().map(Vec3::from_array).collect());
        self.complete(normals, vertices, "normal", "normals")
    }

    pub(super) fn texcoords(&self, set: u32, vertices: usize) -> Result<Vec<Vec2>, SceneError> {
        let pairs = self.numbers(Semantic::TexCoords(set), &[F32, U8, U16])?;
        let pairs = pairs.map(|pairs| pairs.into_iter().map(Vec2::from_array).collect());
        self.complete(pairs, vertices, "texture coordinate", "texture coordinates")
    }

    /// Colours of three or four numbers, linear; what is no number is white.
    pub(super) fn colors(&self, vertices: usize) -> Result<Vec<Vec4>, SceneError> {
        let semantic = Semantic::Colors(0);
        let kinds = [F32, U8, U16];
        let Some(index) = self.accessor(semantic.clone()) else { return Ok(Vec::new()) };
        let has_alpha = self.document.object(index, "accessor", self.place)?.type_ == Checked::Valid(Type::Vec4);
        let colors: Option<Vec<Vec4>> = if has_alpha {
            self.numbers(semantic, &kinds)?.map(|colors| colors.into_iter().map(Vec4::from_array).collect())
        } else {
            let colors = self.numbers(semantic, &kinds)?;
            colors.map(|colors| colors.into_iter().map(|color| Vec3::from_array(color).extend(1.0)).collect())
        };
        let usable = |color: Vec4| if color.is_finite() { color.clamp(Vec4::ZERO, Vec4::ONE) } else { Vec4::ONE };
        let colors = colors.map(|colors| colors.into_iter().map(usable).collect());
        self.complete(colors, vertices, "colour", "colours")
    }

    /// Tangents, of which those without a direction are zero.
    pub(super) fn tangents(&self, vertices: usize) -> Result<Vec<Vec4>, SceneError> {
        let tangents = self.numbers(Semantic::Tangents, &[F32])?;
        let tangent = |it: [f32; 4]| {
            let it = Vec4::from_array(it);
            unit(it.truncate()).map_or(Vec4::ZERO, |along| along.extend(if it.w < 0.0 { -1.0 } else { 1.0 }))
        };
        let tangents = tangents.map(|tangents| tangents.into_iter().map(tangent).collect());
        self.complete(tangents, vertices, "tangent", "tangents")
    }

    /// Corners of triangles, strips or fans, below the number of vertices.
    pub(super) fn indices(&self, vertices: usize) -> Result<Vec<u32>, SceneError> {
        let (indices, holder) = match (&self.draco, self.primitive.indices) {
            (Some(draco), _) => (draco.indices(), self.place.to_owned()),
            (None, Some(index)) => {
                let indices = accessor::read::<1>(self.document, index, self.place, "indices", &[U8, U16, U32])?;
                (indices.into_iter().map(|[index]| index.index()).collect(), format!("accessor {}", index.value()))
            }
            (None, None) => return Ok((0..vertices as u32).collect()),
        };
        if let Some(wrong) = indices.iter().find(|&&index| index as usize >= vertices) {
            let vertices = count(vertices, "vertex", "vertices");
            let problem = format!("it holds the index {wrong}, but {} has {vertices}", self.place);
            return Err(self.document.error(holder, problem, "keep indices below that number"));
        }
        Ok(indices)
    }
}
