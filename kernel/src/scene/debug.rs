//! How objects, items and scenes print for debugging: their kinds and sizes, not the contents of trees.

use core::fmt;

use super::object::Target;
use super::{Item, Object, SceneView};

impl fmt::Debug for Object<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.target() {
            Target::Nothing => f.write_str("Nothing"),
            Target::Mesh(tree) => f.debug_struct("Mesh").field("bounds", &tree.bounds()).finish_non_exhaustive(),
            Target::Moving(tree) => f
                .debug_struct("Moving")
                .field("keys", &tree.keys())
                .field("bounds", &tree.bounds())
                .finish_non_exhaustive(),
            Target::Round(tree) => f.debug_struct("Round").field("bounds", &tree.bounds()).finish_non_exhaustive(),
            Target::Shape(shape) => f.debug_struct("Shape").field("count", &shape.count()).finish_non_exhaustive(),
            Target::Scene(scene) => scene.fmt(f),
        }
    }
}

impl fmt::Debug for Item<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Item")
            .field("object", &self.object)
            .field("to_scene", &self.to_scene(0.0))
            .field("mask", &self.mask)
            .finish_non_exhaustive()
    }
}

impl fmt::Debug for SceneView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SceneView")
            .field("items", &self.items().len())
            .field("levels", &self.levels())
            .field("bounds", &self.bounds())
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use alloc::format;

    use glam::Vec3;

    use crate::{BuildOptions, Bvh, Item, Scene};

    #[test]
    fn kinds_and_sizes_are_printed() {
        let (mesh, _) = Bvh::build(&[[Vec3::ZERO, Vec3::X, Vec3::Y]], &BuildOptions::default()).unwrap();
        let item = Item::new(mesh.view()).with_mask(6);
        let printed = format!("{item:?}");
        assert!(
            printed.starts_with("Item { object: Mesh { bounds: Aabb {") && printed.contains("mask: 6"),
            "{printed}"
        );
        let (scene, _) = Scene::build(alloc::vec![item], &BuildOptions::default()).unwrap();
        let view = scene.view();
        assert!(format!("{:?}", Item::new(&view)).contains("object: SceneView { items: 1, levels: 0"));
        assert!(format!("{:?}", Item::nothing()).contains("object: Nothing"));
    }
}
