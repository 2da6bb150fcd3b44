//! Typed reads through accessors (glTF 2.0, section 3.6.2), with every range checked.

use std::borrow::Cow;

use ::gltf::json::accessor::{ComponentType, GenericComponentType, IndexComponentType, Type};
use ::gltf::json::buffer::View;
use ::gltf::json::validation::Checked;
use ::gltf::json::{Accessor, Index};

use rayon::prelude::*;

use super::{Document, PARALLEL};
use crate::scene::SceneError;

/// The most elements of an accessor that stores none, or only those of its sparse part: the rest is zero, which asks
/// for memory without a byte in the file.
const MAX_ZEROS: usize = 1 << 22;

/// One number of an accessor, in the type that it is stored in.
#[derive(Clone, Copy)]
pub(super) enum Component {
    I8(i8),
    I16(i16),
    U8(u8),
    U16(u16),
    U32(u32),
    F32(f32),
}

/// `N` components for each element of the accessor: 1 to 4, or 16 of a matrix. `what` it is used for, and the types
/// that this allows, go into errors; `user` is what refers to it.
pub(super) fn read<const N: usize>(
    document: &Document,
    index: Index<Accessor>,
    user: &str,
    what: &str,
    allowed: &[ComponentType],
) -> Result<Vec<[Component; N]>, SceneError> {
    read_as(document, index, user, what, allowed, |element| element)
}

/// What `make` makes of each element, read as [`read`] does.
pub(super) fn read_as<const N: usize, T: Send>(
    document: &Document,
    index: Index<Accessor>,
    user: &str,
    what: &str,
    allowed: &[ComponentType],
    make: impl Fn([Component; N]) -> T + Sync,
) -> Result<Vec<T>, SceneError> {
    let (bytes, component) = typed_elements::<N>(document, index, user, what, allowed)?;
    Ok(map_numbers(&bytes, component, make))
}

/// Whole numbers in threes; those that make no three are left out.
pub(super) fn read_threes(
    document: &Document,
    index: Index<Accessor>,
    user: &str,
    what: &str,
    allowed: &[ComponentType],
) -> Result<Vec<[u32; 3]>, SceneError> {
    let (bytes, component) = typed_elements::<1>(document, index, user, what, allowed)?;
    Ok(map_numbers(&bytes, component, |three: [Component; 3]| three.map(Component::index)))
}

/// What `make` makes of every `N` numbers in `bytes`.
fn map_numbers<const N: usize, T: Send>(
    bytes: &[u8],
    component: ComponentType,
    make: impl Fn([Component; N]) -> T + Sync,
) -> Vec<T> {
    let size = component.size();
    let element = |bytes: &[u8]| make(core::array::from_fn(|slot| number(&bytes[slot * size..], component)));
    bytes.par_chunks_exact(N * size).with_min_len(PARALLEL).map(element).collect()
}

/// The bytes of all elements, and the type of their numbers.
fn typed_elements<'a, const N: usize>(
    document: &'a Document,
    index: Index<Accessor>,
    user: &str,
    what: &str,
    allowed: &[ComponentType],
) -> Result<(Cow<'a, [u8]>, ComponentType), SceneError> {
    let accessor = document.object(index, "accessor", user)?;
    let place = format!("accessor {}", index.value());
    let type_ = match N {
        16 => Type::Mat4,
        _ => [Type::Scalar, Type::Vec2, Type::Vec3, Type::Vec4][N - 1],
    };
    let component = match accessor.component_type {
        Checked::Valid(GenericComponentType(component))
            if allowed.contains(&component) && accessor.type_ == Checked::Valid(type_) =>
        {
            component
        }
        _ => {
            let found = match accessor.component_type {
                Checked::Valid(GenericComponentType(component)) => name(component),
                Checked::Invalid => "unknown",
            };
            let shape = match accessor.type_ {
                Checked::Valid(shape) => format!("{shape:?}").to_uppercase(),
                Checked::Invalid => "unknown".to_owned(),
            };
            let allowed: Vec<&str> = allowed.iter().map(|&component| name(component)).collect();
            return Err(document.error(
                place,
                format!("it is {shape} of {found}, and serves as {what}"),
                format!("{what} must be {} of {}", format!("{type_:?}").to_uppercase(), allowed.join(" or ")),
            ));
        }
    };
    Ok((elements(document, index, N * component.size(), user)?, component))
}

/// The bytes of all elements of an accessor, `size` of them each, with nothing in between. `user` is what refers to it.
pub(crate) fn elements<'a>(
    document: &'a Document,
    index: Index<Accessor>,
    size: usize,
    user: &str,
) -> Result<Cow<'a, [u8]>, SceneError> {
    let accessor = document.object(index, "accessor", user)?;
    let place = format!("accessor {}", index.value());
    let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
    let mut bytes = match accessor.buffer_view {
        Some(view) => {
            let start = accessor.byte_offset.unwrap_or_default().0;
            slices(document, view, start, count, size, &place)?.packed()
        }
        None if count > MAX_ZEROS => {
            return Err(document.error(
                place,
                format!("it has {count} elements and no bufferView"),
                "give it a bufferView",
            ));
        }
        None => Cow::Owned(vec![0; count * size]),
    };
    if let Some(sparse) = &accessor.sparse {
        let replaced = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        let Checked::Valid(IndexComponentType(kind)) = sparse.indices.component_type else {
            return Err(document.error(
                place,
                "its sparse indices have an unknown type",
                "store them as unsigned integers",
            ));
        };
        let (view, start) = (sparse.indices.buffer_view, sparse.indices.byte_offset.0);
        let targets = slices(document, view, start, replaced, kind.size(), &place)?.iter();
        let (view, start) = (sparse.values.buffer_view, sparse.values.byte_offset.0);
        let values = slices(document, view, start, replaced, size, &place)?.iter();
        let bytes = bytes.to_mut();
        for (target, value) in targets.zip(values) {
            let target = number(target, kind).index();
            let Some(target) = bytes.chunks_exact_mut(size).nth(target as usize) else {
                let problem = format!("a sparse index is {target}, and it has {count} elements");
                return Err(document.error(place, problem, "keep sparse indices below the count"));
            };
            target.copy_from_slice(value);
        }
    }
    Ok(bytes)
}

/// Slices of one size in a buffer view.
struct Slices<'a> {
    bytes: &'a [u8],
    count: usize,
    size: usize,
    stride: usize,
}

impl<'a> Slices<'a> {
    fn iter(self) -> impl Iterator<Item = &'a [u8]> {
        let Self { bytes, count, size, stride } = self;
        (0..count).map(move |index| &bytes[index * stride..index * stride + size])
    }

    /// The elements without gaps.
    fn packed(self) -> Cow<'a, [u8]> {
        if self.stride == self.size { Cow::Borrowed(self.bytes) } else { self.iter().flatten().copied().collect() }
    }
}

/// The bytes of a buffer view; `place` is what refers to it.
pub(super) fn view<'a>(document: &'a Document, view: Index<View>, place: &str) -> Result<&'a [u8], SceneError> {
    let user = format!("bufferView {}", view.value());
    if let Some(decoded) = document.decompressed.get(&view.value()) {
        return Ok(decoded);
    }
    let view = document.object(view, "bufferView", place)?;
    document.object(view.buffer, "buffer", &user)?;
    let buffer = &document.buffers[view.buffer.value()];
    let (offset, length) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
    range(buffer, offset, length).ok_or_else(|| {
        let (index, has) = (view.buffer.value(), buffer.len());
        let problem = format!("it goes from byte {offset} for {length} bytes, but buffer {index} has {has}");
        document.error(user, problem, "keep it within its buffer")
    })
}

/// `count` slices of `size` bytes each, `start` bytes into a buffer view, at its stride. `place` is the accessor.
fn slices<'a>(
    document: &'a Document,
    view: Index<View>,
    start: u64,
    count: usize,
    size: usize,
    place: &str,
) -> Result<Slices<'a>, SceneError> {
    let number = view.value();
    let bytes = self::view(document, view, place)?;
    let (view, user) = (document.object(view, "bufferView", place)?, format!("bufferView {number}"));
    let length = bytes.len();
    let stride = view.byte_stride.map_or(0, |stride| stride.0);
    let stride = if stride == 0 { size } else { stride };
    if stride < size {
        let problem = format!("its stride is {stride} bytes, but an element of {place} has {size}");
        return Err(document.error(user, problem, "make the stride as large as an element, or larger"));
    }
    // The last element need not fill its stride.
    let needed =
        if count == 0 { 0 } else { (count as u64 - 1).saturating_mul(stride as u64).saturating_add(size as u64) };
    let bytes = range(bytes, start, needed).ok_or_else(|| {
        let problem = format!("its {count} elements need {needed} bytes from byte {start} on, but {user} has {length}");
        document.error(place, problem, "keep it within its bufferView")
    })?;
    Ok(Slices { bytes, count, size, stride })
}

fn range(bytes: &[u8], start: u64, length: u64) -> Option<&[u8]> {
    let end = start.checked_add(length)?;
    bytes.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?)
}

/// The number that `bytes` begin with.
fn number(bytes: &[u8], component: ComponentType) -> Component {
    match component {
        ComponentType::F32 => Component::F32(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        ComponentType::U32 => Component::U32(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        ComponentType::U16 => Component::U16(u16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::I16 => Component::I16(i16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::U8 => Component::U8(bytes[0]),
        ComponentType::I8 => Component::I8(bytes[0] as i8),
    }
}

fn name(component: ComponentType) -> &'static str {
    match component {
        ComponentType::I8 => "byte",
        ComponentType::U8 => "unsigned byte",
        ComponentType::I16 => "short",
        ComponentType::U16 => "unsigned short",
        ComponentType::U32 => "unsigned int",
        ComponentType::F32 => "float",
    }
}

impl Component {
    /// As a number; integers are normalised, so that their greatest is 1.
    pub(super) fn normalised(self) -> f32 {
        match self {
            Self::I8(number) => (f32::from(number) / 127.0).max(-1.0),
            Self::I16(number) => (f32::from(number) / 32767.0).max(-1.0),
            Self::U8(number) => f32::from(number) / 255.0,
            Self::U16(number) => f32::from(number) / 65535.0,
            Self::U32(number) => (f64::from(number) / f64::from(u32::MAX)) as f32,
            Self::F32(number) => number,
        }
    }

    /// As the number that it is.
    pub(super) fn raw(self) -> f32 {
        match self {
            Self::I8(number) => number.into(),
            Self::I16(number) => number.into(),
            Self::U8(number) => number.into(),
            Self::U16(number) => number.into(),
            Self::U32(number) => number as f32,
            Self::F32(number) => number,
        }
    }

    /// As an index.
    pub(super) fn index(self) -> u32 {
        match self {
            Self::U8(number) => number.into(),
            Self::U16(number) => number.into(),
            Self::U32(number) => number,
            Self::I8(_) | Self::I16(_) | Self::F32(_) => self.raw() as u32,
        }
    }
}
