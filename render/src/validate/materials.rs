//! White furnace: a surface that scatters all light is invisible under a constant sky.

use glam::{Vec3, vec3};

use super::scenes::{Corners, cube, grey, scene, sphere, turned, view, world};
use super::statistics::Sample;
use super::{Experiment, Family, Interrupted, Outcome, Runner};
use crate::scene::{Material, Sky};
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
            run: |runner| furnace(runner, &sphere(3, 1.0), &Material::mirror(Vec3::ONE)),
        },
        Experiment {
            name: "materials-polish",
            about: "Radiance of a white diffuse ball under a smooth varnish",
            run: |runner| furnace(runner, &sphere(3, 1.0), &Material::varnished(Vec3::ONE, 1.5)),
        },
        Experiment {
            name: "materials-glass",
            about: "Radiance of a clear glass ball, which reflects and refracts",
            run: |runner| furnace(runner, &sphere(3, 1.0), &Material::glass(1.5)),
        },
        Experiment {
            name: "materials-water",
            about: "Radiance of a box of water, out of which total reflection lets little at a time",
            run: |runner| furnace(runner, &cube(), &Material::glass(1.33)),
        },
    ],
};

/// The mean over pictures by each sampling of lights. Without Russian roulette: facets of glass hold some light for
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
    // Closures of several lobes read their albedos from tables.
    let is_tabled = material.inputs.specular_weight > 0.0 && material.inputs.transmission_weight == 0.0;
    Ok(Outcome::mean("radiance", &Sample::of(&values), 1.0, if is_tabled { 5e-4 } else { 1e-6 }))
}
