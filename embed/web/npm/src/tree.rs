//! The trees over meshes.

use std::sync::Arc;

use halfdome_kernel::{Bvh, Hit};
#[cfg(feature = "scene")]
use halfdome_kernel::{RoundBvh, bvh::MovingBvh, scene::Object};

/// The tree over a mesh, which a scene shares.
pub(crate) enum Tree {
    Still(Arc<Bvh>),
    /// The tree of a mesh that deforms between keys; only rays in scenes have a time.
    #[cfg(feature = "scene")]
    Moving(Arc<MovingBvh>),
    /// Of points or curves, and how many of them can be hit.
    #[cfg(feature = "scene")]
    Round(Arc<RoundBvh>, usize),
}

impl Tree {
    pub(crate) fn still(&self) -> Option<&Bvh> {
        match self {
            Self::Still(bvh) => Some(bvh),
            #[cfg(feature = "scene")]
            Self::Moving(_) | Self::Round(..) => None,
        }
    }

    pub(crate) fn still_mut(&mut self) -> Option<&mut Arc<Bvh>> {
        match self {
            Self::Still(bvh) => Some(bvh),
            #[cfg(feature = "scene")]
            Self::Moving(_) | Self::Round(..) => None,
        }
    }

    /// What a scene has of it.
    #[cfg(feature = "scene")]
    pub(crate) fn object(&self) -> Object<'static> {
        match self {
            Self::Still(bvh) => bvh.clone().into(),
            Self::Moving(bvh) => bvh.clone().into(),
            Self::Round(bvh, _) => bvh.clone().into(),
        }
    }

    /// How many triangles, points or curves it has that can be hit.
    pub(crate) fn triangles(&self) -> usize {
        let blocks = match self {
            Self::Still(bvh) => bvh.view().blocks(),
            #[cfg(feature = "scene")]
            Self::Moving(bvh) => bvh.view().blocks(0),
            #[cfg(feature = "scene")]
            Self::Round(_, count) => return *count,
        };
        blocks.iter().flat_map(|block| block.prim_id).filter(|&prim_id| prim_id != Hit::NO_PRIM).count()
    }

    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Still(bvh) => bvh.statistics().memory_bytes,
            #[cfg(feature = "scene")]
            Self::Moving(bvh) => bvh.memory_bytes(),
            #[cfg(feature = "scene")]
            Self::Round(bvh, _) => bvh.memory_bytes(),
        }
    }
}
