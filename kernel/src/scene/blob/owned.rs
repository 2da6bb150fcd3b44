//! Writing blobs of scenes, and loading them into memory of their own.

use alloc::collections::BTreeMap;
use alloc::sync::Arc;
use alloc::vec::Vec;

use bytemuck::bytes_of;

use super::layout::{NOTHING, block_parts};
use super::*;
use crate::bvh::blob_header::{BYTE_ORDER, checksum};
use crate::bvh::{Blob, BuildOptions, Bvh, MovingBvh, Quality, RoundBvh, Serial};
use crate::error::InvalidTree;
use crate::scene::Scene;
use crate::scene::item::ItemSummary;
use crate::scene::object::Target;
use crate::scene::top_level::TopLevel;
use crate::scene::transform::Placement;

impl Scene<'_> {
    /// The scene, as of its last commit, as bytes: equal for scenes of equal items and options, whatever their history.
    /// Objects shared by several items are written once.
    ///
    /// # Errors
    /// [`InvalidScene::NotSerializable`] if an item is a shape of the caller's, and [`InvalidTree::TooLarge`].
    pub fn to_bytes(&self) -> Result<Blob, Error> {
        self.view().to_bytes(&self.options())
    }
}

impl Scene<'static> {
    /// A copy of the scene in a blob, which may begin at any address, with its contents. Its items have the handles of
    /// a newly built scene: their indices, and generation 0.
    ///
    /// # Errors
    /// The errors of [`SceneView::from_bytes`], but for [`Error::Misaligned`]; scenes may lie in others.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let copy;
        let aligned = match bytes.as_ptr().align_offset(BLOB_ALIGNMENT) {
            0 => bytes,
            _ => {
                Header::read(bytes)?;
                copy = Blob::of(bytes);
                &copy[..bytes.len()]
            }
        };
        SceneBlob::open(aligned)?.scene(|object| match object {
            Object::Mesh(tree) => Arc::new(Bvh::copy_of(&tree)).into(),
            Object::Moving(tree) => Arc::new(MovingBvh::copy_of(&tree)).into(),
            Object::Round(tree) => Arc::new(RoundBvh::copy_of(&tree)).into(),
            _ => Object::Nothing,
        })
    }
}

impl<'a> Scene<'a> {
    /// The scene in a blob, as by [`from_bytes`](Self::from_bytes), whose meshes, points and curves are used in place:
    /// only its items and the trees over them take memory. The blob begins at a multiple of [`BLOB_ALIGNMENT`] bytes.
    ///
    /// # Errors
    /// The errors of [`SceneView::from_bytes`]; scenes may lie in others.
    pub fn over_bytes(bytes: &'a [u8]) -> Result<Self, Error> {
        SceneBlob::open(bytes)?.scene(|object| object)
    }
}

impl<'a> SceneBlob<'a> {
    /// A scene of what `own` makes of the meshes.
    fn scene<'b>(&self, own: impl Fn(Object<'a>) -> Object<'b>) -> Result<Scene<'b>, Error> {
        let options = Quality::ALL.get(usize::from(self.quality)).copied().unwrap_or_default().into();
        let meshes: Vec<Object<'b>> = (0..self.meshes.len() as u32).map(|index| own(self.mesh(index))).collect();
        let mut scenes: Vec<Arc<Scene<'b>>> = Vec::with_capacity(self.scenes.len());
        for record in self.scenes {
            let object = |item: &ItemRecord| match item.kind {
                MESH => meshes.get(item.object as usize).cloned(),
                SCENE => scenes.get(item.object as usize).cloned().map(Object::from),
                _ => None,
            };
            let item = |record: &ItemRecord| {
                let item = Item::new(object(record).unwrap_or(Object::Nothing)).with_mask(record.mask);
                match self.transforms_of(record) {
                    [] => Ok(item),
                    keys => item.moving_shared(keys.into()),
                }
            };
            let mut items = self.records_of(record).iter().map(item).collect::<Result<Vec<_>, Error>>()?;
            // A blob that cannot be traced in place is not to be loaded either.
            let (parts, nodes, indices) = self.tree_of(record);
            let bounds = SceneView::new(&mut items, parts, nodes, indices)?.bounds();
            let (mut scene, _) = Scene::build(items, &options)?;
            // Scenes around it are checked with the box that it has in place, which a forged tree may make too large.
            scene.widen(&bounds);
            scenes.push(Arc::new(scene));
        }
        // Nothing is in the last but what is before it, and it is in nothing.
        let scene = scenes.pop().ok_or(Error::BadHeader { field: "number of scenes" })?;
        Ok(Arc::try_unwrap(scene).unwrap_or_else(|shared| (*shared).clone()))
    }
}

impl SceneView<'_> {
    /// The scene as bytes, as by `Scene::to_bytes`; its own tree, and those of the scenes in it, are built with
    /// `options`.
    ///
    /// # Errors
    /// The errors of `Scene::to_bytes`.
    pub fn to_bytes(&self, options: &BuildOptions) -> Result<Blob, Error> {
        let mut writer = Writer { options: *options, ..Writer::default() };
        writer.scene(self, 0)?;
        writer.finish()
    }
}

/// The address of an object, which identifies it.
type Place = (usize, usize, usize);

/// The sections of a blob under way.
#[derive(Default)]
struct Writer {
    options: BuildOptions,
    nodes: Vec<Node>,
    blocks: Vec<TriangleBlock>,
    scene_nodes: Vec<Node>,
    block_parts: Vec<BlockPart>,
    transforms: Vec<[f32; 16]>,
    meshes: Vec<MeshRecord>,
    scenes: Vec<SceneRecord>,
    items: Vec<ItemRecord>,
    parts: Vec<Part>,
    indices: Vec<u32>,
    known_meshes: BTreeMap<Place, u32>,
    known_scenes: BTreeMap<Place, u32>,
}

impl Writer {
    /// Writes a scene that is `depth` scenes deep, and before it all that is in it; gives its index.
    fn scene(&mut self, scene: &SceneView, depth: usize) -> Result<u32, Error> {
        let items = scene.items();
        let place = (items.as_ptr().addr(), items.len(), scene.tree().nodes(0).as_ptr().addr());
        if let Some(&known) = self.known_scenes.get(&place) {
            return Ok(known);
        }
        let mut objects = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            objects.push(match item.object.target() {
                Target::Nothing => (NOTHING, 0),
                Target::Mesh(tree) => (MESH, self.mesh(&[tree.nodes()], &[tree.blocks()], 0)?),
                Target::Moving(tree) => {
                    let keys = 0..tree.keys();
                    let nodes: Vec<&[Node]> = keys.clone().map(|key| tree.nodes(key)).collect();
                    let blocks: Vec<&[TriangleBlock]> = keys.map(|key| tree.blocks(key)).collect();
                    (MESH, self.mesh(&nodes, &blocks, to_u32(tree.keys())?)?)
                }
                Target::Round(tree) => (MESH, self.round(&tree)?),
                Target::Scene(inner) => (SCENE, self.scene(&inner, depth + 1)?),
                Target::Shape(_) => return Err(InvalidScene::NotSerializable { item: index, depth }.into()),
            });
        }
        let summaries: Vec<ItemSummary> = items.iter().map(Item::summary).collect();
        let (top, _) = TopLevel::build(&Serial, (items, &summaries), scene.summary(), &self.options)?;
        let tree = top.tree.view();
        let mut record = SceneRecord {
            first_item: to_u32(self.items.len())?,
            items: to_u32(items.len())?,
            first_part: to_u32(self.parts.len())?,
            parts: to_u32(top.parts.len())?,
            first_index: to_u32(self.indices.len())?,
            indices: to_u32(tree.items().len())?,
            first_node: to_u32(self.scene_nodes.len())?,
            nodes: 0,
        };
        (0..tree.keys()).for_each(|key| self.scene_nodes.extend_from_slice(tree.nodes(key)));
        record.nodes = to_u32(self.scene_nodes.len())? - record.first_node;
        self.parts.extend_from_slice(&top.parts);
        self.indices.extend_from_slice(tree.items());
        for (item, (kind, object)) in items.iter().zip(objects) {
            let first_transform = to_u32(self.transforms.len())?;
            self.place(&item.placement);
            let transforms = to_u32(self.transforms.len())? - first_transform;
            self.items.push(ItemRecord { kind, object, mask: item.mask, first_transform, transforms });
        }
        let index = to_u32(self.scenes.len())?;
        self.scenes.push(record);
        self.known_scenes.insert(place, index);
        Ok(index)
    }

    /// Writes the nodes and blocks of a mesh at its keys, unless that was done before; gives its index.
    fn mesh(&mut self, nodes: &[&[Node]], blocks: &[&[TriangleBlock]], keys: u32) -> Result<u32, Error> {
        let first = nodes.first().copied().unwrap_or(&[]);
        let place = (first.as_ptr().addr(), first.len(), keys as usize);
        if let Some(&known) = self.known_meshes.get(&place) {
            return Ok(known);
        }
        let (first_node, first_block) = (to_u32(self.nodes.len())?, to_u32(self.blocks.len())?);
        nodes.iter().for_each(|nodes| self.nodes.extend_from_slice(nodes));
        blocks.iter().for_each(|blocks| self.blocks.extend_from_slice(blocks));
        let (nodes, blocks) = (to_u32(self.nodes.len())? - first_node, to_u32(self.blocks.len())? - first_block);
        self.add_mesh(place, MeshRecord { first_node, nodes, first_block, blocks, keys, kind: TRIANGLES })
    }

    /// The same of points or curves.
    fn round(&mut self, tree: &RoundBvhView) -> Result<u32, Error> {
        let place = (tree.nodes().as_ptr().addr(), tree.nodes().len(), 0);
        if let Some(&known) = self.known_meshes.get(&place) {
            return Ok(known);
        }
        let (first_node, first_block) = (to_u32(self.nodes.len())?, to_u32(self.block_parts.len())?);
        let (kind, parts) = block_parts(tree.blocks());
        self.nodes.extend_from_slice(tree.nodes());
        self.block_parts.extend_from_slice(parts);
        let (nodes, blocks) = (to_u32(tree.nodes().len())?, to_u32(parts.len())?);
        self.add_mesh(place, MeshRecord { first_node, nodes, first_block, blocks, keys: 0, kind })
    }

    /// Adds a mesh, which lies there; gives its index.
    fn add_mesh(&mut self, place: Place, record: MeshRecord) -> Result<u32, Error> {
        let index = to_u32(self.meshes.len())?;
        self.meshes.push(record);
        self.known_meshes.insert(place, index);
        Ok(index)
    }

    /// Writes the transforms of a placement.
    fn place(&mut self, placement: &Placement) {
        let columns = |transform: &Affine3A| {
            let mut numbers = [0.0; 16];
            for (column, three) in transform.to_cols_array().as_chunks::<3>().0.iter().enumerate() {
                numbers[4 * column..][..3].copy_from_slice(three);
            }
            numbers
        };
        match placement {
            Placement::AsItIs => {}
            Placement::Moving { keys, .. } => self.transforms.extend(keys.iter().map(columns)),
            Placement::Flat { .. } | Placement::Still { .. } => {
                self.transforms.extend(placement.to_scene(0.0).iter().map(columns));
            }
        }
    }

    fn finish(self) -> Result<Blob, Error> {
        let quality = Quality::ALL.iter().position(|&quality| quality == self.options.quality).unwrap_or_default();
        let mut header = Header {
            magic: Header::MAGIC,
            byte_order: BYTE_ORDER,
            version: SCENE_BLOB_VERSION,
            nodes: to_u32(self.nodes.len())?,
            blocks: to_u32(self.blocks.len())?,
            scene_nodes: to_u32(self.scene_nodes.len())?,
            transforms: to_u32(self.transforms.len())?,
            meshes: to_u32(self.meshes.len())?,
            scenes: to_u32(self.scenes.len())?,
            items: to_u32(self.items.len())?,
            parts: to_u32(self.parts.len())?,
            indices: to_u32(self.indices.len())?,
            width: WIDTH as u16,
            quality: quality as u16,
            block_parts: to_u32(self.block_parts.len())?,
            checksum: 0,
        };
        let mut blob = Blob::zeroed(header.blob_len() as usize);
        let sections: [&[u8]; 11] = [
            bytes_of(&header),
            bytemuck::cast_slice(&self.nodes),
            bytemuck::cast_slice(&self.blocks),
            bytemuck::cast_slice(&self.scene_nodes),
            bytemuck::cast_slice(&self.block_parts),
            bytemuck::cast_slice(&self.transforms),
            bytemuck::cast_slice(&self.meshes),
            bytemuck::cast_slice(&self.scenes),
            bytemuck::cast_slice(&self.items),
            bytemuck::cast_slice(&self.parts),
            bytemuck::cast_slice(&self.indices),
        ];
        let mut rest = &mut blob[..];
        for section in sections {
            let (place, after) = rest.split_at_mut(section.len());
            place.copy_from_slice(section);
            rest = after;
        }
        header.checksum = checksum(&blob);
        blob[..HEADER].copy_from_slice(bytes_of(&header));
        Ok(blob)
    }
}

/// A count as a blob has it.
fn to_u32(count: usize) -> Result<u32, Error> {
    u32::try_from(count).map_err(|_| InvalidTree::TooLarge { limit: u32::MAX }.into())
}
