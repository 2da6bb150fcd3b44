//! Scenes as bytes: items, where they are, the trees of their meshes, points and curves, and the scenes in them, in one
//! blob that is traced in place or loaded.
//!
//! A blob is a header of 64 bytes and then, without gaps, these sections, with the counts in the header:
//!
//! | bytes each | |
//! | --- | --- |
//! | 256 | nodes of meshes, key by key where these move |
//! | 320 | their blocks of triangles |
//! | 256 | nodes of the scenes' own trees, key by key |
//! | 32 | parts of the blocks of points and curves: 5 for one of spheres, 8 of discs, 9 of linear and 17 of cubic curves |
//! | 64 | transforms: four columns of three numbers and a zero |
//! | 24 | meshes: which nodes and blocks, or parts of blocks; how many keys, 0 of one that cannot move; what of: 0 triangles, 1 spheres, 2 discs, 3 linear curves, 4 cubic curves |
//! | 32 | scenes: which items, parts, indices in leaves and nodes; the last scene is the outermost |
//! | 20 | items: what kind (0 nothing, 1 a mesh, 2 a scene), which, mask, which transforms |
//! | 8 | parts ([`Part`]) |
//! | 4 | indices of parts in the leaves of the scenes' trees |
//!
//! and zeros up to a multiple of 64. A scene's items are meshes or earlier scenes, so no scene contains itself. The
//! header:
//!
//! | offset | bytes | |
//! | --- | --- | --- |
//! | 0 | 8 | `89 48 44 53 43 4e 0d 0a` |
//! | 8 | 4 | the number 0x01020304: in which order bytes are |
//! | 12 | 4 | version |
//! | 16 | 36 | how many of each of the above, in that order |
//! | 52 | 2 | children a node |
//! | 54 | 2 | how the scene's tree was built: 0 fast, 1 medium, 2 high |
//! | 56 | 4 | how many parts of blocks of points and curves |
//! | 60 | 4 | CRC-32 of all bytes but these four, as in [`bvh::blob`](crate::bvh::blob) |
//!
//! As with blobs of trees, other byte orders and versions are refused, and an accepted blob is safe to trace, whoever
//! wrote it. Every tree is checked once, however many items share it.
//!
//! # In place
//! An [`Item`] is larger than its record in a blob, so the caller provides memory for items: one slice for each scene.
//! Without nested scenes that is all:
//!
//! ```
//! # #[cfg(feature = "alloc")] {
//! # use glam::{Affine3A, Vec3};
//! # use halfdome_kernel::{BuildOptions, Bvh, Item, Ray, Scene, SceneView};
//! # let (bvh, _) = Bvh::build(&[[Vec3::ZERO, Vec3::X, Vec3::Y]], &BuildOptions::default())?;
//! # let right = Affine3A::from_translation(Vec3::X * 5.0);
//! let items = vec![Item::new(bvh.view()), Item::new(bvh.view()).placed(&right)?];
//! let bytes = Scene::build(items, &BuildOptions::default())?.0.to_bytes()?;
//! // Elsewhere, without an allocator:
//! let mut items = [const { Item::nothing() }; 2];
//! let scene = SceneView::from_bytes(&bytes, &mut items)?;
//! let hit = scene.intersect(&Ray::new(Vec3::new(5.25, 0.25, 1.0), Vec3::NEG_Z).into()).unwrap();
//! assert_eq!((hit.item, hit.hit.t), (1, 1.0));
//! # }
//! # Ok::<(), halfdome_kernel::Error>(())
//! ```
//!
//! With nested scenes, [`SceneBlob`] opens one after the other.

mod check;
mod layout;
#[cfg(any(feature = "alloc", test))]
mod owned;
#[cfg(test)]
mod tests;

use core::ops::Range;

use bytemuck::AnyBitPattern;
use glam::Affine3A;

use layout::{BlockPart, Header, ItemRecord, MESH, MeshRecord, QUALITIES, SCENE, SceneRecord, TRIANGLES, round_blocks};

use super::{Item, Object, Part, SceneView};
use crate::bvh::blob_header::{BlobHeader, HEADER};
use crate::bvh::{BLOB_ALIGNMENT, BvhView, MovingBvhView, Node, RoundBlocks, RoundBvhView, TriangleBlock, WIDTH};
use crate::error::{Error, InvalidScene};

/// The version of the blobs of scenes that this crate writes, and the only one that it reads.
pub const SCENE_BLOB_VERSION: u32 = 2;

/// A scene as bytes, checked.
///
/// Nested scenes have lower indices than the scenes that contain them: they are opened in order, each with memory for
/// its items and with the views of the earlier ones.
///
/// ```
/// # #[cfg(feature = "alloc")] {
/// # use glam::Vec3;
/// # use halfdome_kernel::scene::SceneBlob;
/// # use halfdome_kernel::{BuildOptions, Bvh, Item, Scene};
/// # let options = BuildOptions::default();
/// # let (bvh, _) = Bvh::build(&[[Vec3::ZERO, Vec3::X, Vec3::Y]], &options)?;
/// # let (inside, _) = Scene::build(vec![Item::new(bvh.view())], &options)?;
/// # let inside = inside.view();
/// # let bytes = Scene::build(vec![Item::new(&inside), Item::new(&inside)], &options)?.0.to_bytes()?;
/// let blob = SceneBlob::open(&bytes)?;
/// assert_eq!((blob.scene_count(), blob.item_count(0), blob.item_count(1)), (2, Some(1), Some(2)));
/// let mut items = [const { Item::nothing() }; 1];
/// let inner = [blob.view(0, &mut items, &[])?];
/// let mut items = [const { Item::nothing() }; 2];
/// let scene = blob.view(1, &mut items, &inner)?;
/// assert_eq!(scene.levels(), 1);
/// # }
/// # Ok::<(), halfdome_kernel::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SceneBlob<'a> {
    nodes: &'a [Node],
    blocks: &'a [TriangleBlock],
    scene_nodes: &'a [Node],
    block_parts: &'a [BlockPart],
    transforms: &'a [Affine3A],
    meshes: &'a [MeshRecord],
    scenes: &'a [SceneRecord],
    items: &'a [ItemRecord],
    parts: &'a [Part],
    indices: &'a [u32],
    #[cfg(any(feature = "alloc", test))]
    quality: u16,
}

impl<'a> SceneView<'a> {
    /// Borrows the scene in a blob without nested scenes, at a multiple of [`BLOB_ALIGNMENT`] bytes. `items` are
    /// overwritten; there may be more of them than needed.
    ///
    /// # Errors
    /// The errors of [`SceneBlob::open`] and [`SceneBlob::view`].
    pub fn from_bytes<'b: 'a>(bytes: &'b [u8], items: &'a mut [Item<'b>]) -> Result<Self, Error> {
        let blob = SceneBlob::open(bytes)?;
        blob.view(blob.scene_count() - 1, items, &[])
    }
}

impl<'a> SceneBlob<'a> {
    /// Checks a blob, which begins at a multiple of [`BLOB_ALIGNMENT`] bytes. Takes one pass over it, and no memory.
    ///
    /// # Errors
    /// - [`Error::NotAScene`], [`Error::WrongEndianness`], [`Error::UnsupportedVersion`]: the first bytes do not match.
    /// - [`Error::Truncated`], [`Error::TrailingBytes`]: `bytes` are fewer or more than one blob.
    /// - [`Error::Misaligned`]: its address is not aligned; with `alloc`, `Scene::from_bytes` copies it.
    /// - [`Error::Damaged`]: the checksum does not match.
    /// - [`Error::BadHeader`], [`Error::InvalidTree`], [`InvalidScene::BadRecord`]: the bytes were not written by
    ///   halfdome.
    pub fn open(bytes: &'a [u8]) -> Result<Self, Error> {
        let header = Header::read(bytes)?;
        if bytes.as_ptr().align_offset(BLOB_ALIGNMENT) != 0 {
            return Err(Error::Misaligned { alignment: BLOB_ALIGNMENT });
        }
        header.check_sum(bytes)?;
        if usize::from(header.width) != WIDTH {
            return Err(Error::BadHeader { field: "number of children a node" });
        }
        if header.quality >= QUALITIES {
            return Err(Error::BadHeader { field: "quality" });
        }
        if header.scenes == 0 {
            return Err(Error::BadHeader { field: "number of scenes" });
        }
        let mut rest = &bytes[HEADER..];
        let nodes = section(&mut rest, header.nodes)?;
        let blocks = section(&mut rest, header.blocks)?;
        let scene_nodes = section(&mut rest, header.scene_nodes)?;
        let block_parts = section(&mut rest, header.block_parts)?;
        // A transform whose padding is not zero is invalid.
        let words: &[[u32; 16]] = bytemuck::cast_slice(&rest[..header.transforms as usize * size_of::<Affine3A>()]);
        let transforms = section(&mut rest, header.transforms)?;
        let blob = Self {
            nodes,
            blocks,
            scene_nodes,
            block_parts,
            transforms,
            meshes: section(&mut rest, header.meshes)?,
            scenes: section(&mut rest, header.scenes)?,
            items: section(&mut rest, header.items)?,
            parts: section(&mut rest, header.parts)?,
            indices: section(&mut rest, header.indices)?,
            #[cfg(any(feature = "alloc", test))]
            quality: header.quality,
        };
        let are_zero = words.iter().all(|words| [3, 7, 11, 15].iter().all(|&place| words[place] == 0));
        if !are_zero || rest.iter().any(|&byte| byte != 0) {
            return Err(Error::BadHeader { field: "padding" });
        }
        blob.check()?;
        Ok(blob)
    }

    /// The number of scenes: nested ones first, the outermost last.
    pub fn scene_count(&self) -> usize {
        self.scenes.len()
    }

    /// The number of a scene's items; `None` if there is no such scene.
    pub fn item_count(&self, scene: usize) -> Option<usize> {
        self.scenes.get(scene).map(|record| record.items as usize)
    }

    /// Borrows a scene. `items` are overwritten by its own, of which there are [`item_count`](Self::item_count);
    /// `inner` are the views of the earlier scenes, at least of those that it contains.
    ///
    /// # Errors
    /// [`InvalidScene::BufferTooSmall`] if there are fewer items or scenes than needed; and, for bytes that were not
    /// written by halfdome, the errors of [`Item::placed`], [`Item::moving`] and [`SceneView::new`].
    pub fn view<'s, 'i: 's>(
        &self,
        scene: usize,
        items: &'s mut [Item<'i>],
        inner: &'i [SceneView<'i>],
    ) -> Result<SceneView<'s>, Error>
    where
        'a: 'i,
    {
        let too_few = |what, needed, given| InvalidScene::BufferTooSmall { what, needed, given };
        let record = self.scenes.get(scene).ok_or(too_few("scenes", scene + 1, self.scenes.len()))?;
        let (needed, given) = (record.items as usize, items.len());
        let items = items.get_mut(..needed).ok_or(too_few("items", needed, given))?;
        for (place, record) in items.iter_mut().zip(self.records_of(record)) {
            let object = match record.kind {
                SCENE => {
                    let scene = record.object as usize;
                    Object::Scene(inner.get(scene).ok_or(too_few("scenes", scene + 1, inner.len()))?)
                }
                MESH => self.mesh(record.object),
                _ => Object::Nothing,
            };
            let item = Item::new(object).with_mask(record.mask);
            *place = match self.transforms_of(record) {
                [] => item,
                keys => item.moving(keys)?,
            };
        }
        let (parts, nodes, indices) = self.tree_of(record);
        SceneView::new(items, parts, nodes, indices)
    }

    /// The items of a scene.
    fn records_of(&self, scene: &SceneRecord) -> &'a [ItemRecord] {
        self.items.get(range(scene.first_item, scene.items)).unwrap_or(&[])
    }

    /// The transforms of an item at its keys; none for an item without a transform.
    fn transforms_of(&self, item: &ItemRecord) -> &'a [Affine3A] {
        self.transforms.get(range(item.first_transform, item.transforms)).unwrap_or(&[])
    }

    /// The parts, nodes and indices of a scene.
    fn tree_of(&self, scene: &SceneRecord) -> (&'a [Part], &'a [Node], &'a [u32]) {
        (
            self.parts.get(range(scene.first_part, scene.parts)).unwrap_or(&[]),
            self.scene_nodes.get(range(scene.first_node, scene.nodes)).unwrap_or(&[]),
            self.indices.get(range(scene.first_index, scene.indices)).unwrap_or(&[]),
        )
    }

    /// A mesh, which was checked.
    fn mesh(&self, index: u32) -> Object<'a> {
        match self.meshes.get(index as usize).and_then(|record| self.mesh_parts(record)) {
            Some(Parts::Still(nodes, blocks)) => Object::Mesh(BvhView::trusted(nodes, blocks)),
            Some(Parts::Moving(nodes, blocks, keys)) => Object::Moving(MovingBvhView::trusted(nodes, blocks, keys)),
            Some(Parts::Round(nodes, blocks)) => Object::Round(RoundBvhView::trusted(nodes, blocks)),
            None => Object::Nothing,
        }
    }

    /// The parts of a mesh; `None` if its record refers to parts that do not exist.
    fn mesh_parts(&self, record: &MeshRecord) -> Option<Parts<'a>> {
        let nodes = self.nodes.get(range(record.first_node, record.nodes))?;
        let blocks = range(record.first_block, record.blocks);
        match (record.kind, record.keys) {
            (TRIANGLES, 0) => Some(Parts::Still(nodes, self.blocks.get(blocks)?)),
            (TRIANGLES, keys) => Some(Parts::Moving(nodes, self.blocks.get(blocks)?, keys as usize)),
            (kind, 0) => Some(Parts::Round(nodes, round_blocks(kind, self.block_parts.get(blocks)?)?)),
            _ => None,
        }
    }
}

/// The parts of a mesh.
enum Parts<'a> {
    Still(&'a [Node], &'a [TriangleBlock]),
    /// The nodes, with the number of keys.
    Moving(&'a [Node], &'a [TriangleBlock], usize),
    Round(&'a [Node], RoundBlocks<'a>),
}

/// The next elements of the rest.
fn section<'a, T: AnyBitPattern>(rest: &mut &'a [u8], count: u32) -> Result<&'a [T], Error> {
    let misaligned = Error::Misaligned { alignment: BLOB_ALIGNMENT };
    let (section, after) = rest.split_at_checked(count as usize * size_of::<T>()).ok_or(misaligned)?;
    *rest = after;
    bytemuck::try_cast_slice(section).map_err(|_| misaligned)
}

fn range(first: u32, count: u32) -> Range<usize> {
    first as usize..(first as usize).saturating_add(count as usize)
}
