//! White furnace: what reflects or lets through all light is invisible under a sky that is the same everywhere.

use glam::{Vec3, vec3};

use super::scenes::{Corners, cube, grey, scene, sphere, turned, view};
use super::statistics::Sample;
use super::{Experiment, Family, Interrupted, Lab, Outcome};
use crate::scene::{Material, Sky};
use crate::settings::{Integrator, LightSampling, PathOptions, Settings};

pub(super) const FAMILY: Family = Family {
    name: "materials",
    about: "White furnaces: under a constant sky, what loses no light is invisible",
    experiments: &[
        Experiment {
            name: "materials-diffuse",
            about: "Radiance of a white diffuse sphere under a sky of radiance one",
            run: |lab| furnace(lab, &sphere(3, 1.0), &grey(1.0, 0.0)),
        },
        Experiment {
            name: "materials-bowl",
            about: "Radiance of a white diffuse box without a lid, which light leaves after many bounces",
            run: |lab| furnace(lab, &turned(&cube()[2..]), &grey(1.0, 0.0)),
        },
    ],
};

/// The mean over pictures by each way to find light.
fn furnace(lab: &Lab, solid: &[Corners], material: &Material) -> Result<Outcome, Interrupted> {
    let mut values = Vec::new();
    for lights in [LightSampling::Mis, LightSampling::Direct, LightSampling::Naive] {
        let mut scene = scene([(solid, material.clone())], view(vec3(0.9, 1.6, 1.2), Vec3::ZERO));
        scene.sky = Sky { radiance: Vec3::ONE };
        let integrator = Integrator::Path(PathOptions { lights, ..PathOptions::default() });
        let settings = Settings { width: 48, height: 48, spp: lab.share(64), integrator, ..Settings::default() };
        values.extend(lab.render(scene, settings)?.values);
    }
    Ok(Outcome::mean("radiance", &Sample::of(&values), 1.0, 1e-6))
}
