//! Sensors on three walls of the Cornell box: 96 x 96 on the back wall, on the red one and on the green one.

use glam::Vec3;

use super::Reference;
use crate::cache::Cache;
use crate::irradiance::{Irradiance, Part, Request, Sensor, by_cache};
use crate::scene::{Mesh, cornell_box};
use crate::settings::CachedOptions;
use crate::validate::scenes::world as prepared;
use crate::validate::{Interrupted, Outcome, Runner, worst};
use crate::watch::Watch;
use crate::world::World;

/// The sensors, wall by wall, and what some of them read by path tracing.
pub struct Walls {
    sensors: Vec<Sensor>,
    references: Vec<Reference>,
}

/// Sensors along a side of a wall.
const SIDE: u32 = 96;
/// One in so many along a side has a reference.
const STEP: u32 = 6;
/// Samples of direct light at a sensor, and rays and error of records.
const SETTINGS: (u32, u32, f32) = (256, 3072, 0.5);

impl Walls {
    /// With references of twice `spp` paths.
    pub fn new(world: &World, spp: u32, seed: u64, watch: &dyn Watch) -> Self {
        let scene = cornell_box();
        let walls = scene.meshes.iter().filter(|mesh| mesh.name.ends_with(" wall"));
        let sensors: Vec<Sensor> = walls.flat_map(|wall| (0..SIDE * SIDE).map(|i| sensor(wall, i))).collect();
        let walls = sensors.chunks_exact((SIDE * SIDE) as usize);
        let references = walls.map(|wall| {
            let some: Vec<Sensor> = referenced().map(|i| wall[i]).collect();
            Reference::by_paths(world, &some, Part::Total, spp, seed, watch)
        });
        Self { references: references.collect(), sensors }
    }

    /// All sensors: a wall's rows one after the other.
    pub fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }

    /// The relative error of each wall's reference.
    pub fn reference_errors(&self) -> Vec<f64> {
        self.references.iter().map(Reference::error).collect()
    }

    /// The relative error on each wall of readings of all sensors.
    pub fn errors(&self, values: &[Vec3]) -> Vec<f64> {
        let walls = values.chunks_exact((SIDE * SIDE) as usize).zip(&self.references);
        walls.map(|(wall, reference)| reference.error_of(referenced().map(|i| wall[i])).of_all).collect()
    }

    /// What a cache reads with so many samples of direct light, rays of a record and this error.
    pub fn by_cache(
        &self,
        world: &World,
        (spp, rays, error): (u32, u32, f32),
        seed: u64,
        watch: &dyn Watch,
    ) -> Irradiance {
        let options = CachedOptions { rays, error, ..CachedOptions::default() };
        let cache = Cache::new(options, world.surroundings_hash());
        by_cache(world, &self.sensors, cache, &Request { spp, seed, part: Part::Total }, watch)
    }
}

/// The numbers of a wall's sensors that have a reference.
fn referenced() -> impl Iterator<Item = usize> {
    (STEP / 2..SIDE)
        .step_by(STEP as usize)
        .flat_map(|row| (STEP / 2..SIDE).step_by(STEP as usize).map(move |column| (row * SIDE + column) as usize))
}

/// Sensor `i` of the quadrilateral wall of this name, in the middle of its part of the wall.
fn sensor(wall: &Mesh, i: u32) -> Sensor {
    let [u, v] = [i % SIDE, i / SIDE].map(|place| (place as f32 + 0.5) / SIDE as f32);
    let [a, b, c, d] = [0, 1, 2, 3].map(|corner| wall.positions[corner]);
    // The triangle that the place is on: the red wall's two are not in one plane.
    let (along, across) = if v <= u { (b - a, c - b) } else { (c - d, d - a) };
    Sensor { position: a + u * along + v * across, normal: along.cross(across).normalize() }
}

pub(super) fn experiment(runner: &Runner) -> Result<Outcome, Interrupted> {
    let world = prepared(cornell_box());
    let walls = Walls::new(&world, runner.share(65_536), !runner.seed(), runner.watch());
    let found = walls.by_cache(&world, SETTINGS, runner.seed(), runner.watch());
    if runner.watch().stop() {
        return Err(Interrupted);
    }
    let errors = walls.errors(&found.values);
    let quantity = format!("relative error; of its reference {:.1e}", worst(walls.reference_errors()));
    Ok(Outcome { quantity, measured: worst(errors), expected: 0.0, tolerance: 0.01, figure: None })
}
