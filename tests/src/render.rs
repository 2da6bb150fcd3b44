//! Renders without the command line, and statistics of their results.

use glam::{DVec3, Vec3};
use halfdome::driver::{self, Watch};
use halfdome::film::Picture;
use halfdome::scene::{CameraPose, Material, Mesh, Scene};
use halfdome::settings::Settings;
use halfdome::world::World;

/// Lets every render run to its end.
pub struct NeverStops;

impl Watch for NeverStops {
    fn advance(&self, _: u64, _: u64) {}
    fn stop(&self) -> bool {
        false
    }
}

/// The picture of `scene`, which has a camera.
pub fn render(scene: &Scene, settings: &Settings) -> Picture {
    picture(&world(scene), settings)
}

/// The pixels of so many renders, whose seeds count from that of `settings`. The world is made once, which may take
/// longer than a small picture.
pub fn seeds(scene: &Scene, settings: &Settings, count: u64) -> Vec<Vec<DVec3>> {
    let world = world(scene);
    let seeds = (0..count).map(|number| settings.seed + number);
    seeds.map(|seed| pixels(&picture(&world, &Settings { seed, ..settings.clone() }))).collect()
}

fn world(scene: &Scene) -> World {
    World::new(scene.clone()).expect("the scene has a camera and few triangles")
}

fn picture(world: &World, settings: &Settings) -> Picture {
    let render = driver::render(world, settings, &NeverStops);
    assert!(render.finished);
    render.picture
}

/// The mean of all pixels.
pub fn mean(pixels: &[DVec3]) -> DVec3 {
    pixels.iter().sum::<DVec3>() / pixels.len() as f64
}

/// Red, green and blue of every pixel, row by row.
pub fn pixels(picture: &Picture) -> Vec<DVec3> {
    let [r, g, b] = ["R", "G", "B"].map(|name| &picture.channel(name).expect("every picture has colours").values);
    let pixel = |i: usize| DVec3::new(r[i].into(), g[i].into(), b[i].into());
    (0..r.len()).map(pixel).collect()
}

/// A mean, per channel, and how far it may be off.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// The mean of independent values.
    pub mean: DVec3,
    /// Its standard error.
    pub error: DVec3,
}

impl Estimate {
    /// The mean of two or more independent values, and the standard error that their scatter gives.
    pub fn of(values: &[DVec3]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<DVec3>() / count;
        let squares: DVec3 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let variance = squares / (count - 1.0);
        Self { mean, error: DVec3::from_array((variance / count).to_array().map(f64::sqrt)) }
    }

    /// The mean over renders of the means of their pixels.
    pub fn of_means(renders: &[Vec<DVec3>]) -> Self {
        Self::of(&renders.iter().map(|pixels| mean(pixels)).collect::<Vec<_>>())
    }

    /// The difference of two estimates in units of their common standard error, per channel. Differences of less than
    /// `rounding` times the mean count as none: 32-bit sums have errors that do not shrink with the scatter.
    pub fn z(&self, other: &Self, rounding: f64) -> DVec3 {
        let error = (self.error * self.error + other.error * other.error).to_array().map(f64::sqrt);
        let difference = (self.mean - other.mean).abs() - rounding * other.mean.abs();
        difference.max(DVec3::ZERO) / (DVec3::from_array(error) + 1e-300)
    }
}

impl From<DVec3> for Estimate {
    /// An exact value.
    fn from(mean: DVec3) -> Self {
        Self { mean, error: DVec3::ZERO }
    }
}

/// A mesh of single triangles without normals.
pub fn mesh(triangles: &[[Vec3; 3]], material: usize) -> Mesh {
    let corners = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    Mesh { positions: triangles.concat(), triangles: corners.collect(), material, ..Mesh::default() }
}

/// Two triangles of a quadrilateral.
pub fn quad([a, b, c, d]: [Vec3; 4]) -> [[Vec3; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// A material of this reflectance and emission.
pub fn material(diffuse: Vec3, emission: Vec3) -> Material {
    Material { emission, ..Material::matte(diffuse) }
}

/// Unit direction through the film's point `(x, y)`, in pixels from the top left corner, of a pinhole camera.
pub fn view(pose: &CameraPose, size: (u32, u32), x: f64, y: f64) -> DVec3 {
    let forward = (pose.target - pose.eye).as_dvec3().normalize();
    let right = forward.cross(pose.up.as_dvec3()).normalize();
    let up = right.cross(forward);
    let (width, height) = (f64::from(size.0), f64::from(size.1));
    // Both sides of the film in units of half its height.
    let (x, y) = ((2.0 * x - width) / height, 1.0 - 2.0 * y / height);
    let scale = (f64::from(pose.vfov).to_radians() / 2.0).tan();
    (forward + scale * (x * right + y * up)).normalize()
}
