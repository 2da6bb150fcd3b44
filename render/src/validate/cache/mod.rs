//! What the irradiance cache is worth: its error against path tracing, for the rays and the records that it takes.
//!
//! Unlike other experiments these have no closed form. Their references are long runs of path tracing, whose own error
//! the figures' titles say and which does not count.

mod curves;
mod study;
mod walls;

use super::room::furnished_room;
use super::scenes::world;
use super::{Experiment, Family, Interrupted, Lab, Outcome};
use crate::scene::{Scene, cornell_box};
use crate::settings::{CachedOptions, Gradients, Metric};
use crate::world::World;
use curves::{error_of, records_for};

pub use curves::{Curves, KINDS, Kind, Plan};
pub use study::{Reference, Run, Study};
pub use walls::Walls;

pub(super) const FAMILY: Family = Family {
    name: "cache",
    about: "What the irradiance cache is worth, against path tracing",
    experiments: &[
        Experiment {
            name: "cache-cornell",
            about: "Records with gradients, relative to those without for the same error, in the Cornell box",
            run: |lab| gradients(lab, "cache-cornell", "Cornell box", cornell_box()),
        },
        Experiment {
            name: "cache-room",
            about: "Records with gradients, relative to those without for the same error, in a furnished room",
            run: |lab| gradients(lab, "cache-room", "Furnished room", furnished_room()),
        },
        Experiment {
            name: "cache-hessian",
            about: "Error of 1700 records by the Hessian, relative to that by the bounded split-sphere",
            run: hessian,
        },
        Experiment {
            name: "cache-walls",
            about: "Greatest relative error of 96 x 96 sensors on a wall of the Cornell box, by cache",
            run: walls::experiment,
        },
    ],
};

/// Records that both metrics have when they are compared, as Schwarzhaupt et al. (2012) did.
const RECORDS: f64 = 1700.0;

/// A study of a scene with the lab's random numbers.
fn study<'a>(lab: &'a Lab, world: &'a World) -> Result<Study<'a>, Interrupted> {
    let study = Study::new(world, lab.share(128).clamp(8, 16), lab.share(32_768), lab.seed(), lab.watch());
    if lab.watch().stop() { Err(Interrupted) } else { Ok(study) }
}

fn gradients(lab: &Lab, name: &'static str, title: &str, scene: Scene) -> Result<Outcome, Interrupted> {
    let world = world(scene);
    let study = study(lab, &world)?;
    let plan = Plan { paths: &[16, 64, 256, 1024], errors: &[0.8, 0.57, 0.4, 0.28], rays: lab.share(4096) };
    let curves = Curves::measure(&study, &plan, |_, _, _| !lab.watch().stop()).ok_or(Interrupted)?;
    // Where the records with gradients are most, those without would have to be more than were made: the law goes on.
    let (off, both) = (curves.of(KINDS[0].label), curves.of(KINDS[2].label));
    let finest = both[both.len() - 1];
    let measured = finest.records as f64 / records_for(off, finest.error);
    let reference = format!("reference: {:.1}%", 100.0 * study.reference_error());
    let figure = curves.figure(name, &format!("{title}: indirect light ({reference})"));
    let quantity = "records for the same error".to_owned();
    Ok(Outcome { quantity, measured, expected: 0.0, tolerance: 0.5, figure: Some(figure) })
}

fn hessian(lab: &Lab) -> Result<Outcome, Interrupted> {
    let world = world(cornell_box());
    let study = study(lab, &world)?;
    let error = |metric, errors: [f32; 2]| {
        let runs = errors.map(|error| {
            let options = CachedOptions { metric, error, rays: 4096, ..CachedOptions::default() };
            study.cache(options, &[Gradients::Both])[0]
        });
        if lab.watch().stop() { Err(Interrupted) } else { Ok(error_of(&runs, RECORDS)) }
    };
    let (bounded, hessian) = (error(Metric::Bounded, [0.4, 0.28])?, error(Metric::Hessian, [0.5, 0.35])?);
    let quantity = format!("error, relative to {:.1}%", 100.0 * bounded);
    Ok(Outcome { quantity, measured: hessian / bounded, expected: 0.0, tolerance: 1.0 / 3.0, figure: None })
}
