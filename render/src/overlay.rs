//! Draws the records of an irradiance cache over a picture.

use glam::Vec2;
use halfdome_kernel::Ray;

use crate::cache::{Cache, Record};
use crate::world::World;

/// How far a record may be behind what the camera sees, as a part of its distance.
const BEHIND: f32 = 1e-3;

/// The records that the camera sees from the side that they light, each with the point of the film at which it is seen,
/// in pixels from the top left corner of a picture of `width` by `height`, which may be beyond its border; once for
/// each eye of a picture for two. What a file of rays sees is not known.
pub fn visible_records<'c>(world: &World, cache: &'c Cache, width: u32, height: u32) -> Vec<(&'c Record, Vec2)> {
    let camera = world.camera_on(width, height);
    let seen = |record: &'c Record| {
        let sights = (0..camera.views()).filter_map(|view| camera.sight(record.position, view));
        let visible = sights.filter(|sight| is_visible(world, record, &sight.ray));
        visible.map(|sight| (record, sight.film)).collect::<Vec<_>>()
    };
    cache.records().iter().flat_map(seen).collect()
}

fn is_visible(world: &World, record: &Record, sight: &Ray) -> bool {
    let ray = Ray { t_max: 1.0 - BEHIND, ..*sight };
    ray.direction.dot(record.normal) < 0.0 && !world.occluded(&ray)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::cornell_box;
    use crate::settings::CachedOptions;
    use glam::Vec3;

    #[test]
    fn records_are_seen_where_they_are_unless_something_hides_them() {
        let world = World::new(cornell_box()).unwrap();
        let record = |key, position, normal| Record {
            key,
            position,
            normal,
            irradiance: Vec3::ONE,
            standard_error: 0.0,
            rotational: [Vec3::ZERO; 3],
            translational: [Vec3::ZERO; 3],
            mean_distance: 0.1,
            min_distance: 0.1,
            radii: [0.1; 2],
            axis: normal.any_orthonormal_vector(),
            occluders: [f32::INFINITY; crate::cache::SECTORS],
            clearance: f32::INFINITY,
        };
        // The back wall above the blocks, which the camera at z = -0.8 looks at along z; the same from behind; and the
        // floor behind the tall block.
        let wall = Vec3::new(0.278, 0.473, 0.5592);
        let records =
            vec![record(1, wall, Vec3::NEG_Z), record(2, wall, Vec3::Z), record(3, Vec3::new(0.37, 0.0, 0.5), Vec3::Y)];
        let cache = Cache::of(CachedOptions::default(), world.surroundings_hash(), records);
        let visible = visible_records(&world, &cache, 200, 100);
        let [(record, point)] = visible[..] else { panic!("{visible:?}") };
        assert_eq!(record.key, 1);
        let height = (wall.y - world.camera.eye.y) / (wall.z - world.camera.eye.z);
        let half = (world.camera.vfov.to_radians() / 2.0).tan();
        assert!((point - Vec2::new(100.0, 50.0 - 50.0 * height / half)).length() < 1e-3, "{point}");
    }
}
