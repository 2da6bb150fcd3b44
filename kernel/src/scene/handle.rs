//! Handles of items that stay valid while other items are inserted and removed.

use alloc::vec::Vec;

use crate::error::InvalidScene;

/// The greatest index, `u32::MAX`, stands for no item in [`SceneHit::MISS`](super::SceneHit::MISS).
const MAX_ITEMS: usize = u32::MAX as usize;

/// The handle of an item in a scene, valid until the item is removed; indices are reused, with another generation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Handle {
    pub(super) index: u32,
    pub(super) generation: u32,
}

impl Handle {
    /// The item's index: the `item` of its hits.
    pub fn index(self) -> u32 {
        self.index
    }

    /// How many items had this index before.
    pub fn generation(self) -> u32 {
        self.generation
    }
}

/// Which places are taken.
#[derive(Clone, Debug, Default)]
pub(super) struct Places {
    places: Vec<Place>,
    /// Places to be used again.
    vacant: Vec<u32>,
    /// Places whose items were removed since the last commit, and are still visible.
    leaving: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    generation: u32,
    is_taken: bool,
}

impl Places {
    /// The first `count` places are taken.
    ///
    /// # Errors
    /// [`InvalidScene::TooManyItems`].
    pub(super) fn taken(count: usize) -> Result<Self, InvalidScene> {
        if count > MAX_ITEMS {
            return Err(InvalidScene::TooManyItems { limit: MAX_ITEMS });
        }
        let mut places = Vec::new();
        places.resize(count, Place { generation: 0, is_taken: true });
        Ok(Self { places, ..Self::default() })
    }

    /// Takes a place.
    ///
    /// # Errors
    /// [`InvalidScene::TooManyItems`] if there are no more.
    pub(super) fn take(&mut self) -> Result<Handle, InvalidScene> {
        let index = match self.vacant.pop() {
            Some(index) => index,
            None if self.places.len() == MAX_ITEMS => return Err(InvalidScene::TooManyItems { limit: MAX_ITEMS }),
            None => {
                self.places.push(Place { generation: 0, is_taken: false });
                self.places.len() as u32 - 1
            }
        };
        let place = &mut self.places[index as usize];
        place.is_taken = true;
        Ok(Handle { index, generation: place.generation })
    }

    /// Frees the place of a valid handle, to be taken after the next commit.
    pub(super) fn free(&mut self, handle: Handle) {
        let place = &mut self.places[handle.index as usize];
        place.is_taken = false;
        // One whose generations are used up is not taken again.
        if let Some(generation) = place.generation.checked_add(1) {
            place.generation = generation;
            self.leaving.push(handle.index);
        }
    }

    /// The removed items are no longer visible.
    pub(super) fn commit(&mut self) {
        self.vacant.append(&mut self.leaving);
    }

    pub(super) fn contains(&self, handle: Handle) -> bool {
        self.handle(handle.index) == Some(handle)
    }

    /// The handle of the item at an index, if there is one.
    pub(super) fn handle(&self, index: u32) -> Option<Handle> {
        let place = self.places.get(index as usize).filter(|place| place.is_taken)?;
        Some(Handle { index, generation: place.generation })
    }

    /// The handles of all items.
    pub(super) fn handles(&self) -> impl Iterator<Item = Handle> {
        (0..self.places.len() as u32).filter_map(|index| self.handle(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_used_again_under_other_names() {
        let mut places = Places::default();
        let first = places.take().unwrap();
        let second = places.take().unwrap();
        assert!(places.contains(first) && places.contains(second) && first != second);
        places.free(first);
        assert!(!places.contains(first) && places.handle(0).is_none());
        // Not before the commit: rays may still see it.
        assert_eq!(places.take().unwrap().index(), 2);
        places.commit();
        let third = places.take().unwrap();
        assert_eq!((third.index(), third.generation()), (0, 1));
        assert!(!places.contains(first) && places.contains(third));
        assert_eq!(places.handles().count(), 3);
    }

    #[cfg(target_pointer_width = "64")]
    #[test]
    fn there_are_no_more_places_than_indices() {
        let error = Places::taken(MAX_ITEMS + 1).unwrap_err();
        assert_eq!(error, InvalidScene::TooManyItems { limit: MAX_ITEMS });
        assert_eq!(alloc::format!("{error}"), "a scene holds 4294967295 items at most");
    }

    #[test]
    fn a_place_whose_names_are_used_up_stays_vacant() {
        let mut places = Places::default();
        places.take().unwrap();
        places.places[0].generation = u32::MAX;
        places.free(Handle { index: 0, generation: u32::MAX });
        places.commit();
        assert_eq!(places.take().unwrap().index(), 1);
        assert!(places.handle(0).is_none());
    }
}
