//! White furnace: what reflects or lets through all light is invisible under a sky that is the same everywhere.

use glam::{Vec3, vec3};

use super::scenes::{Corners, cube, grey, scene, sphere, turned, view, world};
use super::statistics::Sample;
use super::{Experiment, Family, Interrupted, Outcome, Runner};
use crate::scene::{Material, Sky, Specular};
use crate::settings::{Integrator, LightSampling, PathOptions, Settings, Stop};

pub(super) const FAMILY: Family = Family {
    name: "materials",
    about: "White furnaces: under a constant sky, what loses no light is invisible",
    experiments: &[
        Experiment {
            name: "materials-diffuse",
            about: "Radiance of a white diffuse sphere under a sky of radiance one",
            run: |runner| furnace(runner, &sphere(3, 1.0), &grey(1.0, 0.0)),
        },
        Experiment {
            name: "materials-bowl",
            about: "Radiance of a white diffuse box without a lid, which light leaves after many bounces",
            run: |runner| furnace(runner, &turned(&cube()[2..]), &grey(1.0, 0.0)),
        },
        Experiment {
            name: "materials-mirror",
            about: "Radiance of a perfect mirror ball under a sky of radiance one",
            run: |runner| furnace(runner, &sphere(3, 1.0), &specular(0.0, Specular::Mirror { reflectance: Vec3::ONE })),
        },
        Experiment {
            name: "materials-polish",
            about: "Radiance of a ball that reflects a part diffusely and the rest like a mirror",
            run: |runner| {
                let reflectance = Vec3::splat(0.3);
                furnace(runner, &sphere(3, 1.0), &specular(0.7, Specular::Mirror { reflectance }))
            },
        },
        Experiment {
            name: "materials-glass",
            about: "Radiance of a clear glass ball, which reflects and refracts",
            run: |runner| furnace(runner, &sphere(3, 1.0), &glass(1.5)),
        },
        Experiment {
            name: "materials-water",
            about: "Radiance of a box of water, out of which total reflection lets little at a time",
            run: |runner| furnace(runner, &cube(), &glass(1.33)),
        },
    ],
};

/// A surface that is smooth in part.
fn specular(diffuse: f32, specular: Specular) -> Material {
    Material { specular, ..grey(diffuse, 0.0) }
}

/// Clear glass of this index of refraction.
fn glass(ior: f32) -> Material {
    specular(0.0, Specular::Glass { ior, transmittance: Vec3::ONE })
}

/// The mean over pictures by each way to find light. No path is ended by chance: facets of glass hold some light for
/// hundreds of reflections, and roulette with a survival of less than one has a variance without bounds there.
fn furnace(runner: &Runner, solid: &[Corners], material: &Material) -> Result<Outcome, Interrupted> {
    let mut furnace = scene([(solid, material.clone())], view(vec3(0.9, 1.6, 1.2), Vec3::ZERO));
    furnace.sky = Sky::constant(Vec3::ONE);
    let world = world(furnace);
    let mut values = Vec::new();
    for lights in [LightSampling::Mis, LightSampling::Direct, LightSampling::Naive] {
        let integrator = Integrator::Path(PathOptions { lights, stop: Stop::Depth, ..PathOptions::default() });
        let settings = Settings { width: 48, height: 48, spp: runner.share(64), integrator, ..Settings::default() };
        values.extend(runner.render(&world, settings)?.values);
    }
    Ok(Outcome::mean("radiance", &Sample::of(&values), 1.0, 1e-6))
}
