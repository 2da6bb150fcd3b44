//! Renders without the command line, and the statistics of what they give.

use glam::DVec3;
use halfdome::driver::{self, Watch};
use halfdome::film::Picture;
use halfdome::scene::Scene;
use halfdome::settings::Settings;
use halfdome::world::World;

/// Lets every render run to its end.
struct Patience;

impl Watch for Patience {
    fn advance(&self, _: u64, _: u64) {}
    fn stop(&self) -> bool {
        false
    }
}

/// The picture of `scene`, which has a camera.
pub fn render(scene: &Scene, settings: &Settings) -> Picture {
    let world = World::new(scene.clone()).expect("the scene has a camera and few triangles");
    let render = driver::render(&world, settings, &Patience);
    assert!(render.finished);
    render.picture
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
