//! Trees as bytes: written once, then traced in place, in flash, in a memory map or in a program's data.
//!
//! A blob is a header of 64 bytes, the nodes (256 bytes each) and the blocks (320 bytes each), with the same layout as
//! in memory:
//!
//! | offset | bytes | |
//! | --- | --- | --- |
//! | 0 | 8 | `89 48 44 42 56 48 0d 0a` (as in PNG, what text conversions would spoil) |
//! | 8 | 4 | the number 0x01020304: in which order bytes are |
//! | 12 | 4 | version |
//! | 16 | 4 | children a node |
//! | 20 | 4 | entries that a traversal's stack needs |
//! | 24, 28 | 4, 4 | numbers of nodes and of blocks |
//! | 32, 44 | 12, 12 | lower and upper corner of the scene's box |
//! | 56 | 4 | expected cost of a random ray, as in `TreeStatistics` |
//! | 60 | 4 | CRC-32 (ISO-HDLC, as in PNG and zip) of all bytes but these four |
//!
//! Numbers have the byte order of the machine that wrote them. Blobs of the other byte order are refused, as swapping
//! bytes would take memory; so are other versions. Everything that traversal relies on is checked when a blob is
//! opened, in one pass: an accepted blob is safe to trace, whoever wrote it.

use bytemuck::{Pod, Zeroable};

use super::blob_header::{BlobHeader, HEADER};
use super::{BvhView, Node, TriangleBlock, WIDTH, validate};
use crate::error::{Error, InvalidTree};
use crate::geometry::Aabb;

/// The version of the blobs that this crate writes, and the only one that it reads.
pub const BLOB_VERSION: u32 = 1;

/// The alignment that a blob needs to be traced in place.
pub const BLOB_ALIGNMENT: usize = align_of::<Node>();

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Header {
    magic: [u8; 8],
    byte_order: u32,
    version: u32,
    width: u32,
    stack: u32,
    nodes: u32,
    blocks: u32,
    min: [f32; 3],
    max: [f32; 3],
    cost: f32,
    checksum: u32,
}

// Nodes follow the header, and lie aligned where it does.
const _: () = assert!(size_of::<Header>() == HEADER && HEADER.is_multiple_of(BLOB_ALIGNMENT));

/// A value at an address that suits a blob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(64))]
pub struct Aligned<T: ?Sized>(pub T);

/// The bytes of a file as a `&'static [u8]` that [`BvhView::from_bytes`] can borrow; the path is as in
/// [`include_bytes!`].
///
/// ```ignore
/// static SCENE: &[u8] = halfdome_kernel::include_blob!("scene.bvh");
/// let tree = BvhView::from_bytes(SCENE)?;
/// ```
#[macro_export]
macro_rules! include_blob {
    ($path:expr $(,)?) => {{
        const BLOB: &$crate::bvh::Aligned<[u8]> = &$crate::bvh::Aligned(*::core::include_bytes!($path));
        &BLOB.0
    }};
}

impl<'a> BvhView<'a> {
    /// Borrows the tree in a blob, which begins at a multiple of [`BLOB_ALIGNMENT`] bytes. Takes one pass over it, and
    /// no memory.
    ///
    /// # Errors
    /// - [`Error::NotABlob`], [`Error::WrongEndianness`], [`Error::UnsupportedVersion`]: the first bytes do not match.
    /// - [`Error::Truncated`], [`Error::TrailingBytes`]: `bytes` are fewer or more than one blob.
    /// - [`Error::Misaligned`]: its address is not aligned; with `alloc`, `Bvh::from_bytes` copies it.
    /// - [`Error::Damaged`]: the checksum does not match.
    /// - [`Error::BadHeader`], [`Error::InvalidTree`]: the bytes were not written by halfdome.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, Error> {
        let header = Header::read(bytes)?;
        let offset = bytes.as_ptr().align_offset(BLOB_ALIGNMENT);
        if offset != 0 {
            return Err(Error::Misaligned { alignment: BLOB_ALIGNMENT });
        }
        header.check_sum(bytes)?;
        let (nodes, blocks) = header.sections(bytes);
        let misaligned = |_| Error::Misaligned { alignment: BLOB_ALIGNMENT };
        let nodes: &[Node] = bytemuck::try_cast_slice(nodes).map_err(misaligned)?;
        let blocks: &[TriangleBlock] = bytemuck::try_cast_slice(blocks).map_err(misaligned)?;
        header.check_tree(nodes, blocks)?;
        Ok(Self::trusted(nodes, blocks))
    }
}

impl BlobHeader for Header {
    const MAGIC: [u8; 8] = *b"\x89HDBVH\r\n";
    const VERSION: u32 = BLOB_VERSION;
    const NOT_THIS: Error = Error::NotABlob;

    fn byte_order(&self) -> u32 {
        self.byte_order
    }

    fn version(&self) -> u32 {
        self.version
    }

    fn checksum(&self) -> u32 {
        self.checksum
    }

    fn blob_len(&self) -> u64 {
        let size = |count: u32, each: usize| u64::from(count) * each as u64;
        HEADER as u64 + size(self.nodes, size_of::<Node>()) + size(self.blocks, size_of::<TriangleBlock>())
    }
}

impl Header {
    /// The bytes of the nodes, and those of the blocks.
    fn sections<'a>(&self, bytes: &'a [u8]) -> (&'a [u8], &'a [u8]) {
        bytes[HEADER..].split_at(self.nodes as usize * size_of::<Node>())
    }

    /// Whether the tree can be traced, and is the one that the header describes.
    fn check_tree(&self, nodes: &[Node], blocks: &[TriangleBlock]) -> Result<(), Error> {
        if self.width != WIDTH as u32 {
            return Err(Error::BadHeader { field: "number of children a node" });
        }
        let stack = validate::validate(nodes, blocks)?;
        let bounds = stored_bounds(nodes.first().ok_or(InvalidTree::NoRoot)?);
        if self.stack != stack {
            Err(Error::BadHeader { field: "height of the stack" })
        } else if [self.min, self.max].map(|corner| corner.map(f32::to_bits))
            != bounds.map(|corner| corner.map(f32::to_bits))
        {
            Err(Error::BadHeader { field: "bounds" })
        } else if !(0.0..=f32::MAX).contains(&self.cost) {
            Err(Error::BadHeader { field: "cost" })
        } else {
            Ok(())
        }
    }
}

/// The corners of the scene's box as a header has them: zeros without a sign, as machines differ in whether 0 or -0 is
/// the lesser, and equal trees must have equal blobs.
fn stored_bounds(root: &Node) -> [[f32; 3]; 2] {
    let Aabb { min, max } = root.bounds();
    [min + 0.0, max + 0.0].map(|corner| corner.to_array())
}

#[cfg(any(feature = "alloc", test))]
pub use owned::Blob;

#[cfg(any(feature = "alloc", test))]
mod owned {
    use alloc::vec;
    use alloc::vec::Vec;
    use core::ops::{Deref, DerefMut};

    use super::*;
    use crate::bvh::blob_header::{BYTE_ORDER, checksum};
    use crate::bvh::{Bvh, pages};

    /// The bytes of a blob in memory of their own, where they can be traced in place.
    #[derive(Clone, Debug, PartialEq, Eq)]
    pub struct Blob(Vec<Line>);

    #[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
    #[repr(C, align(64))]
    struct Line([u8; BLOB_ALIGNMENT]);

    impl Blob {
        /// The given number of zeros, a multiple of [`BLOB_ALIGNMENT`].
        pub(crate) fn zeroed(len: usize) -> Self {
            Self(vec![Line::zeroed(); len / BLOB_ALIGNMENT])
        }

        /// A copy of bytes, and behind them zeros up to a multiple of [`BLOB_ALIGNMENT`].
        pub(crate) fn of(bytes: &[u8]) -> Self {
            let mut blob = Self::zeroed(bytes.len().next_multiple_of(BLOB_ALIGNMENT));
            blob[..bytes.len()].copy_from_slice(bytes);
            blob
        }
    }

    impl Deref for Blob {
        type Target = [u8];

        fn deref(&self) -> &[u8] {
            bytemuck::cast_slice(&self.0)
        }
    }

    impl DerefMut for Blob {
        fn deref_mut(&mut self) -> &mut [u8] {
            bytemuck::cast_slice_mut(&mut self.0)
        }
    }

    impl Bvh {
        /// The tree as bytes: equal for equal trees, and readable on machines of the same byte order.
        pub fn to_bytes(&self) -> Blob {
            let (nodes, blocks) = (self.view().nodes(), self.view().blocks());
            let [min, max] = stored_bounds(&nodes[0]);
            let mut header = Header {
                magic: Header::MAGIC,
                byte_order: BYTE_ORDER,
                version: BLOB_VERSION,
                width: WIDTH as u32,
                stack: self.stack,
                nodes: nodes.len() as u32,
                blocks: blocks.len() as u32,
                min,
                max,
                cost: self.cost,
                checksum: 0,
            };
            let mut blob = Blob::zeroed(header.blob_len() as usize);
            let (head, sections) = blob.split_at_mut(HEADER);
            head.copy_from_slice(bytemuck::bytes_of(&header));
            let (node_bytes, block_bytes) = sections.split_at_mut(size_of_val(nodes));
            node_bytes.copy_from_slice(bytemuck::cast_slice(nodes));
            block_bytes.copy_from_slice(bytemuck::cast_slice(blocks));
            header.checksum = checksum(&blob);
            blob[..HEADER].copy_from_slice(bytemuck::bytes_of(&header));
            blob
        }

        /// A copy of the tree in a blob, which may begin at any address.
        ///
        /// # Errors
        /// The errors of [`BvhView::from_bytes`], but for [`Error::Misaligned`].
        pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
            let header = Header::read(bytes)?;
            header.check_sum(bytes)?;
            let (node_bytes, block_bytes) = header.sections(bytes);
            let mut nodes = pages::filled(Node::EMPTY, header.nodes as usize);
            let mut blocks = pages::filled(TriangleBlock::EMPTY, header.blocks as usize);
            bytemuck::cast_slice_mut(&mut nodes).copy_from_slice(node_bytes);
            bytemuck::cast_slice_mut(&mut blocks).copy_from_slice(block_bytes);
            header.check_tree(&nodes, &blocks)?;
            let bounds = nodes[0].bounds();
            Ok(Self { nodes, blocks, bounds, cost: header.cost, built_cost: header.cost, stack: header.stack })
        }
    }
}

#[cfg(test)]
mod tests;
