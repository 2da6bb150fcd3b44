//! The attributes of a primitive, from accessors or a compressed stream.
//!
//! Integers are normalised, so that their greatest is 1: those of colours and texture coordinates always, as glTF 2.0
//! has it; with `KHR_mesh_quantization`, which allows them for all attributes, where the accessor says so.

use ::gltf::json::accessor::ComponentType::{self, F32, I8, I16, U8, U16, U32};
use ::gltf::json::accessor::Type;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Accessor, Index};
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::draco::{self, DracoMesh};
use super::{Document, PARALLEL, accessor};
use crate::scene::SceneError;
use crate::scene::count;
use crate::scene::description::unit;

/// What morph targets and skins move, for each vertex; normals and tangents may be empty.
pub(super) struct Vertices {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    /// Tangents with the sign of the bitangent.
    pub(super) tangents: Vec<Vec4>,
}

/// Four joints that a vertex follows, with their weights.
pub(super) type Influences = [(u32, f32); 4];

/// A primitive's attributes.
pub(super) struct Attributes<'a> {
    document: &'a Document<'a>,
    primitive: &'a Primitive,
    /// The place for errors.
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
            && let Some(numbers) = draco.attribute(&semantic, true)
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
        self.read(index, &name, kinds).map(Some)
    }

    /// `N` numbers for each element of an accessor.
    fn read<const N: usize>(
        &self,
        index: Index<Accessor>,
        name: &str,
        kinds: &[ComponentType],
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let kinds: &[ComponentType] = if self.is_quantized { &[F32, I8, U8, I16, U16] } else { kinds };
        let accessor = self.document.object(index, "accessor", self.place)?;
        let is_normalised = accessor.normalized || !self.is_quantized;
        let number = |it: accessor::Component| if is_normalised { it.normalised() } else { it.raw() };
        accessor::read_as(self.document, index, self.place, name, kinds, |numbers: [_; N]| numbers.map(number))
    }

    /// The deltas of a morph target for an attribute.
    pub(super) fn deltas(&self, index: Index<Accessor>, name: &str, vertices: usize) -> Result<Vec<Vec3>, SceneError> {
        let deltas = self.read::<3>(index, name, &[F32])?.into_iter().map(Vec3::from_array).collect();
        let deltas = self.complete(Some(deltas), vertices, "delta of a morph target", "deltas of a morph target")?;
        if let Some(vertex) = deltas.iter().position(|delta| !delta.is_finite()) {
            return Err(self.error(format!("{name}: the delta of vertex {vertex} is not finite"), "export it again"));
        }
        Ok(deltas)
    }

    /// The joints that each vertex follows, with their weights, which are finite and not negative: four for each of the
    /// sets `JOINTS_0`, `JOINTS_1` and so on.
    pub(super) fn influences(&self, vertices: usize) -> Result<Vec<Vec<Influences>>, SceneError> {
        let mut sets = Vec::new();
        while let Some(index) = self.accessor(Semantic::Joints(sets.len() as u32)) {
            let set = sets.len() as u32;
            let (joints, weights) = (Semantic::Joints(set), Semantic::Weights(set));
            let joints: Vec<[u32; 4]> = match self.draco.as_ref().and_then(|draco| draco.attribute(&joints, false)) {
                Some(joints) => joints.into_iter().map(|joints| joints.map(|joint: f32| joint as u32)).collect(),
                None => accessor::read(self.document, index, self.place, &joints.to_string(), &[U8, U16])?
                    .into_iter()
                    .map(|joints: [accessor::Component; 4]| joints.map(accessor::Component::index))
                    .collect(),
            };
            let Some(weights) = self.numbers::<4>(weights, &[F32, U8, U16])? else {
                return Err(self.error(format!("it has JOINTS_{set} without WEIGHTS_{set}"), "give it both"));
            };
            for (found, name) in [(joints.len(), "JOINTS"), (weights.len(), "WEIGHTS")] {
                if found != vertices {
                    let problem =
                        format!("it has {} but {found} of {name}_{set}", count(vertices, "position", "positions"));
                    return Err(self.error(problem, "give every vertex all attributes"));
                }
            }
            let is_wrong = |weights: &[f32; 4]| weights.iter().any(|weight| !(*weight >= 0.0 && weight.is_finite()));
            if let Some(vertex) = weights.iter().position(is_wrong) {
                let problem = format!("WEIGHTS_{set} of vertex {vertex} are {:?}", weights[vertex]);
                return Err(self.error(problem, "write finite numbers that are 0 or more"));
            }
            let pairs = |(joints, weights): ([u32; 4], [f32; 4])| core::array::from_fn(|it| (joints[it], weights[it]));
            sets.push(joints.into_iter().zip(weights).map(pairs).collect());
        }
        Ok(sets)
    }

    /// An error about the primitive.
    pub(super) fn error(&self, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        self.document.error(self.place, problem, remedy)
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

    /// Colours of three or four numbers, linear; NaN becomes white.
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

    /// The triangles of a mode, with corners below the number of vertices.
    pub(super) fn triangles(&self, mode: Mode, vertices: usize) -> Result<Vec<[u32; 3]>, SceneError> {
        let index = self.index_accessor();
        let wrong_count = |corners: usize| {
            let problem = format!("its triangles have {} together", count(corners, "corner", "corners"));
            self.error(problem, "give each triangle 3")
        };
        let triangles = match (index, mode) {
            (Some(index), Mode::Triangles) => {
                let corners = self.document.object(index, "accessor", self.place)?.count.0;
                if corners % 3 != 0 {
                    return Err(wrong_count(usize::try_from(corners).unwrap_or(usize::MAX)));
                }
                accessor::read_threes(self.document, index, self.place, "indices", &INDICES)?
            }
            _ => {
                let corners = self.all_indices(vertices)?;
                if mode == Mode::Triangles && !corners.len().is_multiple_of(3) {
                    return Err(wrong_count(corners.len()));
                }
                self::triangles(mode, &corners)
            }
        };
        let wrong = triangles.par_iter().with_min_len(PARALLEL).flatten_iter();
        match wrong.find_first(|index| **index as usize >= vertices) {
            Some(&wrong) => Err(self.wrong_index(wrong, vertices)),
            None => Ok(triangles),
        }
    }

    /// The vertices of points and lines, in their order, below the number of vertices.
    pub(super) fn indices(&self, vertices: usize) -> Result<Vec<u32>, SceneError> {
        let indices = self.all_indices(vertices)?;
        match indices.iter().find(|&&index| index as usize >= vertices) {
            Some(&wrong) => Err(self.wrong_index(wrong, vertices)),
            None => Ok(indices),
        }
    }

    fn all_indices(&self, vertices: usize) -> Result<Vec<u32>, SceneError> {
        Ok(match (self.index_accessor(), &self.draco) {
            (Some(index), _) => {
                accessor::read_as(self.document, index, self.place, "indices", &INDICES, |[it]| it.index())?
            }
            (None, Some(draco)) => draco.indices(),
            (None, None) => (0..vertices as u32).collect(),
        })
    }

    fn index_accessor(&self) -> Option<Index<Accessor>> {
        self.primitive.indices.filter(|_| self.draco.is_none())
    }

    fn wrong_index(&self, wrong: u32, vertices: usize) -> SceneError {
        let holder = match self.index_accessor() {
            Some(index) => format!("accessor {}", index.value()),
            None => self.place.to_owned(),
        };
        let vertices = count(vertices, "vertex", "vertices");
        let problem = format!("it holds the index {wrong}, but {} has {vertices}", self.place);
        self.document.error(holder, problem, "keep indices below that number")
    }
}

/// What numbers of vertices are stored as.
const INDICES: [ComponentType; 3] = [U8, U16, U32];

/// Corners of triangles, strips and fans in the order that keeps the winding (glTF 2.0, section 3.7.2.1).
pub(super) fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let windows = indices.windows(3).enumerate();
            windows.map(|(place, v)| if place % 2 == 0 { [v[0], v[1], v[2]] } else { [v[0], v[2], v[1]] }).collect()
        }
        Mode::TriangleFan => indices.windows(2).skip(1).map(|v| [v[0], v[1], indices[0]]).collect(),
        _ => indices.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect(),
    }
}
