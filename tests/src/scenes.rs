//! Scenes of instances of a tree, and rays for them: made from rays at the tree, alone and in bundles.

use glam::{Affine3A, Quat, Vec3, vec3};
use halfdome_kernel::{BuildOptions, BvhView, Item, Ray, Scene, SceneRay, SceneView};

/// Rays of a bundle: those of the widest packet that is traced as one.
const BUNDLE: usize = 16;
/// So many rays after one another have one time.
const ALIKE: usize = 24;
/// Scenes that [`with_scene`] makes.
pub const KINDS: usize = 3;

/// Gives `visit` a scene of a tree, at its own place and at others: of instances, of scenes in a scene, two deep, or
/// one with motion. `kind` chooses, modulo [`KINDS`].
pub fn with_scene<T>(tree: &BvhView, kind: usize, visit: impl FnOnce(&SceneView) -> T) -> T {
    let bounds = tree.bounds();
    let (center, extent) =
        if bounds.is_empty() { (Vec3::ZERO, Vec3::ZERO) } else { (bounds.center(), bounds.max - bounds.min) };
    let at = |angle: f32, scale: Vec3, shift: Vec3| {
        let turn = Quat::from_axis_angle(vec3(0.6, 0.0, 0.8), angle);
        let around = Affine3A::from_scale_rotation_translation(scale, turn, center + shift * extent);
        around * Affine3A::from_translation(-center)
    };
    let places = [
        at(0.7, vec3(1.0, 0.8, 1.1), Vec3::ZERO),
        at(0.0, vec3(-1.0, 1.0, 1.0), vec3(0.0, 0.25, 0.0)),
        at(-2.0, Vec3::splat(0.5), vec3(0.3, 0.0, -0.2)),
    ];
    let mesh = || Item::new(*tree);
    let field = scene(vec![
        mesh(),
        placed(mesh(), &places[0]),
        placed(mesh(), &places[1]).with_mask(1),
        placed(mesh(), &places[2]),
    ]);
    let field = field.view();
    match kind % KINDS {
        0 => visit(&field),
        1 => {
            let nested = scene(vec![Item::new(&field), placed(Item::new(&field), &places[2]).with_mask(6), mesh()]);
            let nested = nested.view();
            visit(&scene(vec![placed(Item::new(&nested), &places[1]), Item::new(&field)]).view())
        }
        _ => {
            let keys = [places[0], at(0.9, vec3(1.0, 0.8, 1.1), vec3(0.0, 0.0, 0.2))];
            let items =
                vec![mesh(), mesh().moving(&keys).expect("it turns a little"), placed(Item::new(&field), &places[2])];
            visit(&scene(items).view())
        }
    }
}

fn placed<'a>(item: Item<'a>, place: &Affine3A) -> Item<'a> {
    item.placed(place).expect("it has an inverse")
}

fn scene(items: Vec<Item>) -> Scene {
    Scene::build(items, &BuildOptions::default()).expect("there are few items, and they are hardly distorted").0
}

/// Rays in a scene: one after the other those of bundles around the first few rays, then all rays. The times take
/// turns, so that some packets have one and some have two; the masks differ.
pub fn scene_rays(rays: &[Ray], bundles: usize, times: [f32; 2]) -> Vec<SceneRay> {
    let bundled = rays.iter().take(bundles).flat_map(|ray| (0..BUNDLE).map(|i| beside(ray, i)));
    let in_scene = |(i, ray)| SceneRay { ray, time: times[i / ALIKE % 2], mask: [u32::MAX, 1, 6][i % 3] };
    bundled.chain(rays.iter().copied()).enumerate().map(in_scene).collect()
}

/// A ray from the same origin, in nearly the same direction.
fn beside(ray: &Ray, i: usize) -> Ray {
    let aside = vec3((i % 4) as f32, (i / 4) as f32, (i % 3) as f32) * 0.002;
    Ray { direction: ray.direction * (1.0 + aside), ..*ray }
}
