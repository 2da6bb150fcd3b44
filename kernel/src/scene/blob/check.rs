//! The check of a blob's records and of the trees of its meshes.

use super::layout::{MESH, NOTHING, SCENE, TRIANGLES};
use super::{Parts, SceneBlob, range};
use crate::bvh::{BvhView, MovingBvhView, RoundBvhView};
use crate::error::{Error, InvalidScene};

impl SceneBlob<'_> {
    /// Checks that records follow each other, that no scene contains itself, and all trees of meshes.
    pub(super) fn check(&self) -> Result<(), Error> {
        let (mut node, mut block, mut block_part) = (0, 0, 0);
        for (index, record) in self.meshes.iter().enumerate() {
            let bad = InvalidScene::BadRecord { record: "mesh", index };
            follow(&mut node, record.first_node, record.nodes, bad)?;
            let end = if record.kind == TRIANGLES { &mut block } else { &mut block_part };
            follow(end, record.first_block, record.blocks, bad)?;
            match self.mesh_parts(record).ok_or(bad)? {
                Parts::Still(nodes, blocks) => BvhView::new(nodes, blocks).map(|_| ())?,
                Parts::Moving(nodes, blocks, keys) => MovingBvhView::new(nodes, blocks, keys).map(|_| ())?,
                Parts::Round(nodes, blocks) => RoundBvhView::new(nodes, blocks).map(|_| ())?,
            }
        }
        let (mut item, mut part, mut leaf_index, mut scene_node) = (0, 0, 0, 0);
        let mut transform = 0;
        for (scene, record) in self.scenes.iter().enumerate() {
            let bad = InvalidScene::BadRecord { record: "scene", index: scene };
            follow(&mut item, record.first_item, record.items, bad)?;
            follow(&mut part, record.first_part, record.parts, bad)?;
            follow(&mut leaf_index, record.first_index, record.indices, bad)?;
            follow(&mut scene_node, record.first_node, record.nodes, bad)?;
            let items = self.items.get(range(record.first_item, record.items)).ok_or(bad)?;
            for (index, item) in (record.first_item as usize..).zip(items) {
                let bad = InvalidScene::BadRecord { record: "item", index };
                follow(&mut transform, item.first_transform, item.transforms, bad)?;
                let is_there = match item.kind {
                    NOTHING => item.object == 0,
                    MESH => (item.object as usize) < self.meshes.len(),
                    SCENE => (item.object as usize) < scene,
                    _ => false,
                };
                if !is_there {
                    return Err(bad.into());
                }
            }
        }
        let ends = [
            (node, self.nodes.len()),
            (block, self.blocks.len()),
            (scene_node, self.scene_nodes.len()),
            (block_part, self.block_parts.len()),
            (transform, self.transforms.len()),
            (item, self.items.len()),
            (part, self.parts.len()),
            (leaf_index, self.indices.len()),
        ];
        if ends.iter().any(|&(end, len)| end != len as u64) {
            return Err(Error::BadHeader { field: "table of counts" });
        }
        Ok(())
    }
}

/// Moves `end` from where a record's range begins, which is where that of the record before it ended, to where it ends.
fn follow(end: &mut u64, first: u32, count: u32, bad: InvalidScene) -> Result<(), InvalidScene> {
    if *end != u64::from(first) {
        return Err(bad);
    }
    *end += u64::from(count);
    Ok(())
}
