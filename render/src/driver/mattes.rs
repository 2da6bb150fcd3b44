//! The Cryptomatte ids of the surfaces that camera rays hit.

use crate::film::{NO_NAME, id};
use crate::settings::MatteKind;
use crate::world::{Hit, World};

/// The ids of one layer.
pub(super) struct MatteIds {
    kind: MatteKind,
    /// The ids of objects or materials, by index.
    ids: Vec<u32>,
}

impl MatteIds {
    pub(super) fn new(world: &World, kind: MatteKind) -> Self {
        Self { kind, ids: world.names(kind).map(|name| id(&name)).collect() }
    }

    /// The id of what a ray has hit.
    pub(super) fn of(&self, world: &World, hit: &Hit) -> u32 {
        if hit.is_hit() { self.ids[world.number_of(self.kind, hit)] } else { NO_NAME }
    }
}
