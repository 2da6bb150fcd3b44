//! `KHR_draco_mesh_compression`: a primitive's triangles and attributes in one compressed buffer view, decoded by the
//! crate `draco-core`.

use std::collections::BTreeMap;

use ::gltf::json::Index;
use ::gltf::json::mesh::{Primitive, Semantic};
use draco_core::FaceIndex;
use draco_core::decoder_buffer::DecoderBuffer;
use draco_core::mesh_decoder::MeshDecoder;
use serde::Deserialize;

use super::{Document, accessor};
use crate::scene::SceneError;

const NAME: &str = "KHR_draco_mesh_compression";

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compression {
    buffer_view: u32,
    attributes: BTreeMap<String, u32>,
}

/// A decoded primitive.
pub(super) struct DracoMesh {
    mesh: draco_core::Mesh,
    /// Numbers of attributes in the stream.
    attributes: BTreeMap<String, u32>,
}

/// The primitive's compressed triangles; `None` if it has none.
pub(super) fn read(document: &Document, primitive: &Primitive, place: &str) -> Result<Option<DracoMesh>, SceneError> {
    let extensions = primitive.extensions.as_ref();
    let Some(value) = extensions.and_then(|extensions| extensions.others.get(NAME)) else { return Ok(None) };
    let Compression { buffer_view, attributes } = Compression::deserialize(value).map_err(|error| {
        let remedy = format!("write it as the specification of {NAME} has it");
        document.error(place, format!("its {NAME} is wrong: {error}"), remedy)
    })?;
    let bytes = accessor::view(document, Index::new(buffer_view), place)?;
    let mut mesh = draco_core::Mesh::new();
    MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes), &mut mesh).map_err(|error| {
        document.error(
            place,
            format!("its Draco data cannot be read: {error}"),
            "export the model again, without Draco",
        )
    })?;
    Ok(Some(DracoMesh { mesh, attributes }))
}

impl DracoMesh {
    /// Corners of triangles.
    pub(super) fn indices(&self) -> Vec<u32> {
        let faces = (0..self.mesh.num_faces()).map(|face| self.mesh.face(FaceIndex(face as u32)));
        faces.flatten().map(|point| point.0).collect()
    }

    /// Vertices.
    pub(super) fn count(&self) -> usize {
        self.mesh.num_points()
    }

    /// `N` numbers for each vertex; integers are normalised if `normalised`, so that their greatest is 1.
    pub(super) fn attribute<const N: usize>(&self, semantic: &Semantic, normalised: bool) -> Option<Vec<[f32; N]>> {
        let number = self.attributes.get(&semantic.to_string())?;
        let attribute = self.mesh.attribute_by_unique_id(*number)?;
        if usize::from(attribute.num_components()) < N {
            return None;
        }
        let greatest = if normalised { greatest(attribute.data_type()) } else { 1.0 };
        let numbers = attribute.read_f32s(self.count(), N);
        Some(numbers.chunks_exact(N).map(|numbers| core::array::from_fn(|slot| numbers[slot] / greatest)).collect())
    }
}

/// What an integer of this type is divided by; 1 of floats.
fn greatest(kind: draco_core::DataType) -> f32 {
    use draco_core::DataType::{Int8, Int16, Uint8, Uint16};
    match kind {
        Uint8 => 255.0,
        Int8 => 127.0,
        Uint16 => 65535.0,
        Int16 => 32767.0,
        _ => 1.0,
    }
}
