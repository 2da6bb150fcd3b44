//! Changes of a scene's items, staged until its next commit.

use glam::Affine3A;

use super::{Scene, Staged, UNCHANGED};
use crate::error::{Error, InvalidScene};
use crate::scene::handle::Handle;
use crate::scene::item::ItemSummary;
use crate::scene::transform::Placement;
use crate::scene::{Item, Object};

impl<'a> Scene<'a> {
    /// Adds an item, from the next commit on.
    ///
    /// # Errors
    /// [`InvalidScene::TooManyItems`] if there are 2³² - 1 items.
    pub fn insert(&mut self, item: Item<'a>) -> Result<Handle, Error> {
        let handle = self.places.take()?;
        let index = handle.index as usize;
        if index == self.items.len() {
            // Nothing yet, with the paths of nothing: none.
            self.items.push(Item { first_path: self.summary.first_path(), ..Item::nothing() });
            self.summaries.push(ItemSummary::NOTHING);
            self.staged_at.push(UNCHANGED);
        }
        *self.stage(handle.index) = item;
        Ok(handle)
    }

    /// Removes an item, from the next commit on, and its handle at once.
    ///
    /// # Errors
    /// [`InvalidScene::NoSuchItem`].
    pub fn remove(&mut self, handle: Handle) -> Result<(), Error> {
        *self.item_mut(handle)? = Item::nothing();
        self.places.free(handle);
        Ok(())
    }

    /// Sets an item's transform, from the next commit on. A transform that flattens hides it.
    ///
    /// # Errors
    /// [`InvalidScene::NoSuchItem`] and those of [`Item::placed`]; the item then keeps its transform.
    pub fn set_transform(&mut self, handle: Handle, to_scene: &Affine3A) -> Result<(), Error> {
        let placement = Placement::still(to_scene)?;
        self.item_mut(handle)?.placement = placement;
        Ok(())
    }

    /// Sets an item's mask, from the next commit on; 0 hides it.
    ///
    /// # Errors
    /// [`InvalidScene::NoSuchItem`].
    pub fn set_mask(&mut self, handle: Handle, mask: u32) -> Result<(), Error> {
        self.item_mut(handle)?.mask = mask;
        Ok(())
    }

    /// Sets an item's object, from the next commit on; its transform and mask stay. A deforming mesh can use two trees,
    /// one in the scene while the other is refitted: after the commit the first is no longer shared.
    ///
    /// # Errors
    /// [`InvalidScene::NoSuchItem`].
    pub fn set_object(&mut self, handle: Handle, object: impl Into<Object<'a>>) -> Result<(), Error> {
        self.item_mut(handle)?.object = object.into();
        Ok(())
    }

    /// Replaces an item, from the next commit on; the handle stays.
    ///
    /// # Errors
    /// [`InvalidScene::NoSuchItem`].
    pub fn set_item(&mut self, handle: Handle, item: Item<'a>) -> Result<(), Error> {
        *self.item_mut(handle)? = item;
        Ok(())
    }

    /// An item with its changes since the last commit; `None` if it was removed.
    pub fn get(&self, handle: Handle) -> Option<&Item<'a>> {
        if !self.places.contains(handle) {
            return None;
        }
        match self.staged_at[handle.index as usize] {
            UNCHANGED => self.items.get(handle.index as usize),
            place => self.staged.get(place as usize).map(|staged| &staged.item),
        }
    }

    /// The handle of the item that a hit names by its `item`; `None` if it has been removed since.
    pub fn handle(&self, item: u32) -> Option<Handle> {
        self.places.handle(item)
    }

    /// The handles of all items, in the order of their indices.
    pub fn handles(&self) -> impl Iterator<Item = Handle> {
        self.places.handles()
    }

    fn item_mut(&mut self, handle: Handle) -> Result<&mut Item<'a>, InvalidScene> {
        if !self.places.contains(handle) {
            let Handle { index, generation } = handle;
            return Err(InvalidScene::NoSuchItem { index, generation });
        }
        Ok(self.stage(handle.index))
    }

    /// The item at an index, to be changed.
    fn stage(&mut self, index: u32) -> &mut Item<'a> {
        let place = &mut self.staged_at[index as usize];
        if *place == UNCHANGED {
            *place = self.staged.len() as u32;
            self.staged.push(Staged { index, item: self.items[index as usize].clone() });
        }
        &mut self.staged[*place as usize].item
    }
}
