//! Picking: the first surface on the ray through a pixel's middle, and the pixel's light paths.

use glam::Vec3;

use crate::camera::{Camera, FilmPoint};
use crate::driver::{SampleHistory, pixel_history};
use crate::scene::CameraPose;
use crate::settings::{MatteKind, Settings};
use crate::world::{Hit, World};

/// Samples whose paths are listed.
const SAMPLES: u32 = 8;

/// The contents of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Pick {
    /// Its column and its row, from the top left.
    pub pixel: (u32, u32),
    /// The surface at its middle; `None` for the sky.
    pub surface: Option<PickedSurface>,
    /// The paths of its last samples, or why they are not known.
    pub history: Result<Vec<SampleHistory>, String>,
}

/// A surface under a pixel's middle.
#[derive(Clone, Debug, PartialEq)]
pub struct PickedSurface {
    /// The object's name, or its index.
    pub object: String,
    /// Its material's.
    pub material: String,
    /// The triangle's index in its object, from 0.
    pub triangle: u32,
    /// Where, in world space.
    pub position: Vec3,
    /// Unit normal of the triangle, on the side that is seen.
    pub normal: Vec3,
    /// Unit normal by vertices and maps.
    pub shading_normal: Vec3,
    /// The distance from the ray's origin, in the scene's units.
    pub distance: f32,
}

impl Pick {
    /// Of a picture of `world` with these settings, from this pose, whose pixels have `samples` samples.
    pub fn new(world: &World, pose: &CameraPose, settings: &Settings, pixel: (u32, u32), samples: u32) -> Self {
        let surface = PickedSurface::find(world, pose, settings, pixel);
        let last = samples.saturating_sub(SAMPLES)..samples;
        let history = pixel_history(world, settings, pixel, last).map_err(|error| error.problem);
        Self { pixel, surface, history }
    }
}

impl PickedSurface {
    fn find(world: &World, pose: &CameraPose, settings: &Settings, (x, y): (u32, u32)) -> Option<Self> {
        let camera = Camera::new(pose, world.optics(), settings.width, settings.height);
        let ray = camera.central_ray(&FilmPoint::middle(x, y))?;
        let mut hits = [Hit::MISS];
        world.intersect_many(&[ray], &mut hits);
        let [hit] = hits;
        if !hit.is_hit() {
            return None;
        }
        let surface = world.surface_at(&hit).facing(ray.direction);
        let name = |kind: MatteKind| world.names(kind).nth(world.number_of(kind, &hit)).unwrap_or_default();
        Some(Self {
            object: name(MatteKind::Object),
            material: name(MatteKind::Material),
            triangle: world.triangle_number(&hit),
            position: surface.position,
            normal: surface.normal,
            shading_normal: surface.shading_normal,
            distance: hit.t * ray.direction.length(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::cornell_box;

    #[test]
    fn the_middle_of_the_box_is_its_back_wall() {
        let world = World::new(cornell_box()).unwrap();
        let settings = Settings { width: 101, height: 101, ..Settings::default() };
        let pick = |x, y, samples| Pick::new(&world, &world.camera(), &settings, (x, y), samples);
        let ceiling = pick(50, 2, 0).surface.unwrap();
        assert_eq!((ceiling.object.as_str(), ceiling.material.as_str()), ("ceiling", "white"));
        let Pick { surface, history, .. } = pick(50, 30, 10);
        let surface = surface.unwrap();
        assert_eq!((surface.object.as_str(), surface.material.as_str()), ("back wall", "white"));
        // The camera is at z = -0.8, on x = 0.278.
        assert!((surface.position.x - 0.278).abs() < 1e-4 && (surface.position.z - 0.5592).abs() < 1e-5);
        assert!((surface.normal - Vec3::NEG_Z).length() < 1e-6);
        assert!((surface.distance - world.camera().eye.distance(surface.position)).abs() < 1e-5);
        let history = history.unwrap();
        assert_eq!(history.iter().map(|it| it.sample).collect::<Vec<_>>(), (2..10).collect::<Vec<_>>());
        let first = |path: &crate::driver::LightPath| path.events[0].to_string();
        assert!(history.iter().flat_map(|it| &it.paths).all(|path| first(path) == "RD back wall"));
    }

    #[test]
    fn beside_the_box_is_nothing() {
        let world = World::new(cornell_box()).unwrap();
        let settings = Settings { width: 200, height: 50, ..Settings::default() };
        let Pick { surface, history, .. } = Pick::new(&world, &world.camera(), &settings, (0, 25), 4);
        assert_eq!(surface, None);
        assert!(history.unwrap().iter().all(|sample| sample.paths.is_empty()));
    }
}
