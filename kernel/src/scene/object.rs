//! The object of an item: triangles, points, curves, custom geometry, another scene. Borrowed, or with `alloc` shared
//! by [`Arc`].

#[cfg(any(feature = "alloc", test))]
use alloc::sync::Arc;

use super::SceneView;
use super::shape::Shape;
#[cfg(any(feature = "alloc", test))]
use crate::bvh::{Bvh, MovingBvh, RoundBvh};
use crate::bvh::{BvhView, MovingBvhView, RoundBvhView};

/// The object of an item. Many items may share an object in memory.
///
/// Shared objects keep their memory alive, so an `Item<'static>` and a `Scene<'static>` are possible.
#[derive(Clone)]
#[non_exhaustive]
pub enum Object<'a> {
    /// No object: a free place.
    Nothing,
    /// Triangles.
    Mesh(BvhView<'a>),
    /// Triangles that move between keys.
    Moving(MovingBvhView<'a>),
    /// Points or curves.
    Round(RoundBvhView<'a>),
    /// Custom geometry.
    Shape(&'a dyn Shape),
    /// A scene.
    Scene(&'a SceneView<'a>),
    /// Triangles, shared.
    #[cfg(any(feature = "alloc", test))]
    SharedMesh(Arc<Bvh>),
    /// Triangles that move between keys, shared.
    #[cfg(any(feature = "alloc", test))]
    SharedMoving(Arc<MovingBvh>),
    /// Points or curves, shared.
    #[cfg(any(feature = "alloc", test))]
    SharedRound(Arc<RoundBvh>),
    /// Custom geometry, shared.
    #[cfg(any(feature = "alloc", test))]
    SharedShape(Arc<dyn Shape + Send + 'a>),
    /// A scene as of its last commit, shared.
    #[cfg(any(feature = "alloc", test))]
    SharedScene(Arc<super::Scene<'a>>),
}

/// A borrowed object.
#[derive(Clone, Copy)]
pub(super) enum Target<'a> {
    Nothing,
    Mesh(BvhView<'a>),
    Moving(MovingBvhView<'a>),
    Round(RoundBvhView<'a>),
    Shape(&'a dyn Shape),
    Scene(SceneView<'a>),
}

impl Object<'_> {
    #[inline(always)]
    pub(super) fn target(&self) -> Target<'_> {
        match self {
            Self::Nothing => Target::Nothing,
            Self::Mesh(tree) => Target::Mesh(*tree),
            Self::Moving(tree) => Target::Moving(*tree),
            Self::Round(tree) => Target::Round(*tree),
            Self::Shape(shape) => Target::Shape(*shape),
            Self::Scene(scene) => Target::Scene(**scene),
            #[cfg(any(feature = "alloc", test))]
            Self::SharedMesh(tree) => Target::Mesh(tree.view()),
            #[cfg(any(feature = "alloc", test))]
            Self::SharedMoving(tree) => Target::Moving(tree.view()),
            #[cfg(any(feature = "alloc", test))]
            Self::SharedRound(tree) => Target::Round(tree.view()),
            #[cfg(any(feature = "alloc", test))]
            Self::SharedShape(shape) => Target::Shape(&**shape),
            #[cfg(any(feature = "alloc", test))]
            Self::SharedScene(scene) => Target::Scene(scene.view()),
        }
    }
}

impl<'a> From<BvhView<'a>> for Object<'a> {
    fn from(tree: BvhView<'a>) -> Self {
        Self::Mesh(tree)
    }
}

impl<'a> From<MovingBvhView<'a>> for Object<'a> {
    fn from(tree: MovingBvhView<'a>) -> Self {
        Self::Moving(tree)
    }
}

impl<'a> From<RoundBvhView<'a>> for Object<'a> {
    fn from(tree: RoundBvhView<'a>) -> Self {
        Self::Round(tree)
    }
}

impl<'a, S: Shape> From<&'a S> for Object<'a> {
    fn from(shape: &'a S) -> Self {
        Self::Shape(shape)
    }
}

impl<'a> From<&'a SceneView<'a>> for Object<'a> {
    fn from(scene: &'a SceneView<'a>) -> Self {
        Self::Scene(scene)
    }
}

#[cfg(any(feature = "alloc", test))]
impl From<Arc<Bvh>> for Object<'_> {
    fn from(tree: Arc<Bvh>) -> Self {
        Self::SharedMesh(tree)
    }
}

#[cfg(any(feature = "alloc", test))]
impl From<Arc<MovingBvh>> for Object<'_> {
    fn from(tree: Arc<MovingBvh>) -> Self {
        Self::SharedMoving(tree)
    }
}

#[cfg(any(feature = "alloc", test))]
impl From<Arc<RoundBvh>> for Object<'_> {
    fn from(tree: Arc<RoundBvh>) -> Self {
        Self::SharedRound(tree)
    }
}

#[cfg(any(feature = "alloc", test))]
impl<'a> From<Arc<dyn Shape + Send + 'a>> for Object<'a> {
    fn from(shape: Arc<dyn Shape + Send + 'a>) -> Self {
        Self::SharedShape(shape)
    }
}

#[cfg(any(feature = "alloc", test))]
impl<'a> From<Arc<super::Scene<'a>>> for Object<'a> {
    fn from(scene: Arc<super::Scene<'a>>) -> Self {
        Self::SharedScene(scene)
    }
}
