//! New binary data of a file: bytes, the views of them, and accessors.
//!
//! In a GLB container they are put behind the chunk that is there; otherwise they become one more buffer, in a data
//! URI.

use ::gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Accessor, Index};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::{Vec2, Vec3};
use serde_json::json;

use crate::scene::SceneError;
use crate::scene::formats::gltf::{Document, accessor};

/// `bufferView.target` of vertices and of indices.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Additions to a file.
pub(super) struct Data {
    /// The buffer that it goes to.
    buffer: usize,
    /// Where in the buffer it begins.
    offset: usize,
    /// How many views and accessors the file has.
    first_view: usize,
    first_accessor: usize,
    bytes: Vec<u8>,
    /// As JSON texts.
    pub(super) views: Vec<String>,
    pub(super) accessors: Vec<String>,
}

impl Data {
    /// Nothing yet; it will be `offset` bytes into `buffer`.
    pub(super) fn new(document: &Document, buffer: usize, offset: usize) -> Self {
        let (first_view, first_accessor) = (document.root.buffer_views.len(), document.root.accessors.len());
        let (bytes, views, accessors) = (Vec::new(), Vec::new(), Vec::new());
        Self { buffer, offset, first_view, first_accessor, bytes, views, accessors }
    }

    /// Adds a view of these bytes; gives its index.
    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.push_view(bytes, json!({}))
    }

    fn push_view(&mut self, bytes: &[u8], mut view: serde_json::Value) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        view["buffer"] = self.buffer.into();
        view["byteOffset"] = (self.offset + self.bytes.len()).into();
        view["byteLength"] = bytes.len().into();
        self.bytes.extend(bytes);
        self.views.push(view.to_string());
        self.first_view + self.views.len() - 1
    }

    fn push_accessor(&mut self, view: usize, mut accessor: serde_json::Value) -> usize {
        accessor["bufferView"] = view.into();
        self.accessors.push(accessor.to_string());
        self.first_accessor + self.accessors.len() - 1
    }

    /// Adds an accessor of texture coordinates; gives its index.
    pub(super) fn texcoords(&mut self, pairs: &[Vec2]) -> usize {
        let bytes: Vec<u8> = pairs.iter().flat_map(|pair| pair.to_array()).flat_map(f32::to_le_bytes).collect();
        let view = self.push_view(&bytes, json!({"byteStride": 8, "target": VERTICES}));
        self.push_accessor(view, json!({"componentType": 5126, "count": pairs.len(), "type": "VEC2"}))
    }

    /// Adds an accessor of the corners of triangles; gives its index.
    pub(super) fn indices(&mut self, corners: impl Iterator<Item = u32> + Clone) -> usize {
        // The greatest 16-bit number restarts strips, and must not be an index.
        let short = corners.clone().all(|corner| corner < u32::from(u16::MAX));
        let (bytes, kind): (Vec<u8>, u32) = match short {
            true => (corners.clone().flat_map(|corner| (corner as u16).to_le_bytes()).collect(), 5123),
            false => (corners.clone().flat_map(u32::to_le_bytes).collect(), 5125),
        };
        let view = self.push_view(&bytes, json!({"target": INDICES}));
        self.push_accessor(view, json!({"componentType": kind, "count": corners.count(), "type": "SCALAR"}))
    }

    /// Adds an accessor whose elements are those of accessor `index` at the indices `sources`; gives its index.
    /// `user` is what refers to it. `bounded`: these are positions, whose bounds the file must have.
    pub(super) fn gather(
        &mut self,
        document: &Document,
        index: usize,
        sources: &[u32],
        user: &str,
        bounded: bool,
    ) -> Result<usize, SceneError> {
        let index = Index::<Accessor>::new(index as u32);
        let old = document.object(index, "accessor", user)?;
        let (Checked::Valid(GenericComponentType(component)), Checked::Valid(shape)) = (old.component_type, old.type_)
        else {
            let place = format!("accessor {}", index.value());
            return Err(document.error(place, "its type is unknown", "use the types of glTF 2.0"));
        };
        let size = component.size() * shape.multiplicity();
        let elements = accessor::elements(document, index, size, user)?;
        let stride = size.next_multiple_of(4);
        let mut bytes = vec![0; stride * sources.len()];
        for (to, &source) in bytes.chunks_exact_mut(stride).zip(sources) {
            let from = elements.chunks_exact(size).nth(source as usize).ok_or_else(|| {
                let problem = format!("it has fewer elements than vertex {source} needs");
                document.error(format!("accessor {}", index.value()), problem, "give every vertex all attributes")
            })?;
            to[..size].copy_from_slice(from);
        }
        let view = self.push_view(&bytes, json!({"byteStride": stride, "target": VERTICES}));
        let mut accessor =
            json!({"componentType": component.as_gl_enum(), "count": sources.len(), "type": type_name(shape)});
        if old.normalized {
            accessor["normalized"] = true.into();
        }
        if bounded && component == ComponentType::F32 && shape == Type::Vec3 {
            let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            let positions = bytes.chunks_exact(12).map(|p| Vec3::new(number(p), number(&p[4..]), number(&p[8..])));
            let bounds = positions.map(|p| (p, p)).reduce(|(low, high), (p, _)| (low.min(p), high.max(p)));
            let (low, high) = bounds.unwrap_or_default();
            accessor["min"] = json!(low.to_array());
            accessor["max"] = json!(high.to_array());
        }
        Ok(self.push_accessor(view, accessor))
    }

    /// Whether there is nothing to add.
    pub(super) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// The bytes, and how long the buffer is with them.
    pub(super) fn finish(&self) -> (&[u8], usize) {
        (&self.bytes, self.offset + self.bytes.len())
    }

    /// A buffer of its own for these bytes, as JSON.
    pub(super) fn as_data_uri(&self) -> String {
        let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bytes));
        json!({"byteLength": self.bytes.len(), "uri": uri}).to_string()
    }
}

fn type_name(shape: Type) -> &'static str {
    match shape {
        Type::Scalar => "SCALAR",
        Type::Vec2 => "VEC2",
        Type::Vec3 => "VEC3",
        Type::Vec4 => "VEC4",
        Type::Mat2 => "MAT2",
        Type::Mat3 => "MAT3",
        Type::Mat4 => "MAT4",
    }
}
