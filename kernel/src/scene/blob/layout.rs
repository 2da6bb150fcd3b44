//! The header and the records of a scene's blob, with their layout in memory; the [module above](super) lists them.

use bytemuck::{Pod, Zeroable};
use glam::Affine3A;

use super::SCENE_BLOB_VERSION;
use crate::bvh::blob_header::{BlobHeader, HEADER};
use crate::bvh::{BLOB_ALIGNMENT, Node, RoundBlocks, TriangleBlock};
use crate::error::Error;
use crate::scene::Part;

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Header {
    pub(super) magic: [u8; 8],
    pub(super) byte_order: u32,
    pub(super) version: u32,
    pub(super) nodes: u32,
    pub(super) blocks: u32,
    pub(super) scene_nodes: u32,
    pub(super) transforms: u32,
    pub(super) meshes: u32,
    pub(super) scenes: u32,
    pub(super) items: u32,
    pub(super) parts: u32,
    pub(super) indices: u32,
    pub(super) width: u16,
    pub(super) quality: u16,
    pub(super) block_parts: u32,
    pub(super) checksum: u32,
}

const _: () = assert!(size_of::<Header>() == HEADER && size_of::<Affine3A>() == 64);

/// The qualities that a header may name.
pub(super) const QUALITIES: u16 = 3;

#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct MeshRecord {
    pub(super) first_node: u32,
    pub(super) nodes: u32,
    pub(super) first_block: u32,
    pub(super) blocks: u32,
    pub(super) keys: u32,
    pub(super) kind: u32,
}

/// The `kind` of a mesh of triangles.
pub(super) const TRIANGLES: u32 = 0;

/// What every block of points or curves is a multiple of.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(super) struct BlockPart([u32; 8]);

/// The blocks that these parts form; `None` if there is no such kind, or the number of blocks is not whole.
pub(super) fn round_blocks(kind: u32, parts: &[BlockPart]) -> Option<RoundBlocks<'_>> {
    match kind {
        1 => bytemuck::try_cast_slice(parts).ok().map(RoundBlocks::Spheres),
        2 => bytemuck::try_cast_slice(parts).ok().map(RoundBlocks::Discs),
        3 => bytemuck::try_cast_slice(parts).ok().map(RoundBlocks::LinearCurves),
        4 => bytemuck::try_cast_slice(parts).ok().map(RoundBlocks::CubicCurves),
        _ => None,
    }
}

/// The kind of blocks, and their parts.
#[cfg(any(feature = "alloc", test))]
pub(super) fn block_parts(blocks: RoundBlocks<'_>) -> (u32, &[BlockPart]) {
    match blocks {
        RoundBlocks::Spheres(blocks) => (1, bytemuck::cast_slice(blocks)),
        RoundBlocks::Discs(blocks) => (2, bytemuck::cast_slice(blocks)),
        RoundBlocks::LinearCurves(blocks) => (3, bytemuck::cast_slice(blocks)),
        RoundBlocks::CubicCurves(blocks) => (4, bytemuck::cast_slice(blocks)),
    }
}

#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct SceneRecord {
    pub(super) first_item: u32,
    pub(super) items: u32,
    pub(super) first_part: u32,
    pub(super) parts: u32,
    pub(super) first_index: u32,
    pub(super) indices: u32,
    pub(super) first_node: u32,
    pub(super) nodes: u32,
}

#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ItemRecord {
    pub(super) kind: u32,
    pub(super) object: u32,
    pub(super) mask: u32,
    pub(super) first_transform: u32,
    pub(super) transforms: u32,
}

pub(super) const NOTHING: u32 = 0;
pub(super) const MESH: u32 = 1;
pub(super) const SCENE: u32 = 2;

impl BlobHeader for Header {
    const MAGIC: [u8; 8] = *b"\x89HDSCN\r\n";
    const VERSION: u32 = SCENE_BLOB_VERSION;
    const NOT_THIS: Error = Error::NotAScene;

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
        let sizes = [
            (self.nodes, size_of::<Node>()),
            (self.blocks, size_of::<TriangleBlock>()),
            (self.scene_nodes, size_of::<Node>()),
            (self.block_parts, size_of::<BlockPart>()),
            (self.transforms, size_of::<Affine3A>()),
            (self.meshes, size_of::<MeshRecord>()),
            (self.scenes, size_of::<SceneRecord>()),
            (self.items, size_of::<ItemRecord>()),
            (self.parts, size_of::<Part>()),
            (self.indices, size_of::<u32>()),
        ];
        let len = sizes.iter().map(|&(count, each)| u64::from(count) * each as u64).sum::<u64>();
        (HEADER as u64 + len).next_multiple_of(BLOB_ALIGNMENT as u64)
    }
}
