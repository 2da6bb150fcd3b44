//! Instances of one mesh, against Embree's.

use std::error::Error;
use std::time::Instant;

use halfdome_benches::instances::{self, SceneTracer};
use halfdome_benches::measure;
use halfdome_benches::rays::{RayCounts, RayKind};
use halfdome_benches::scenes;
use halfdome_benches::tracer::{Entry, Tracer};
use halfdome_kernel::{BuildOptions, Bvh, Quality};
use serde_json::json;

use crate::Options;
use crate::embree::Embree;
use crate::judge::Tally;
use crate::report::{self, Comparison};
use crate::trees::Peer;

/// Triangles along an edge of an octant of the mesh: about 100,000 in all.
const SIDE: u32 = 112;

/// Traces rays through `count` instances, and moves them.
pub(crate) fn compare(count: u32, embree: Option<&Embree>, options: &Options) -> Result<(), Box<dyn Error>> {
    let triangles = scenes::blob(SIDE);
    let (mesh, _) = Bvh::build(&triangles, &BuildOptions::default())?;
    let places = instances::places(count, 0);
    let mut scene = instances::scene(&mesh, &places, Quality::High)?;
    let peer = embree.map(|embree| embree.build(&triangles)?.instances(&places)).transpose()?;
    let name = format!("{count} instances of {} triangles", triangles.len());
    if !options.json {
        println!("{name}\n{}", report::heading());
    }
    let counts = if options.quick { RayCounts::QUICK } else { RayCounts::FULL };
    for set in instances::rays(&scene.view(), &triangles, counts) {
        let ours = |entry: Entry| -> Box<dyn Tracer + '_> { Box::new(SceneTracer(scene.view(), entry)) };
        let mut tracers: Vec<_> = Entry::ALL.map(|entry| (entry.name(), ours(entry))).into();
        tracers.extend(peer.iter().flat_map(|peer| peer.tracers(set.kind == RayKind::Primary)));
        let (names, tracers): (Vec<_>, Vec<_>) = tracers.into_iter().unzip();
        let tracers: Vec<&dyn Tracer> = tracers.iter().map(|tracer| &**tracer).collect();
        let timings = measure::interleaved(&tracers, &set, options.rounds.into());
        let timings: Vec<_> = names.into_iter().zip(timings).collect();
        let (ours, peers) = timings.split_at(Entry::ALL.len());
        if let Some((entry, _)) = ours.iter().find(|(_, timing)| timing.answers != ours[0].1.answers) {
            return Err(format!("{name}, {}: {entry} finds other hits than {}", set.kind.name(), ours[0].0).into());
        }
        let comparison = Comparison { scene: &name, kind: set.kind.name(), ours, peers, judged: Tally::default() };
        if options.json {
            println!("{}", comparison.json());
        } else {
            println!("{}", comparison.text());
        }
    }
    // All of them move, frame by frame.
    let handles: Vec<_> = scene.handles().collect();
    let (mut ours, mut embrees, mut builds) = (Vec::new(), Vec::new(), 0);
    for frame in 1..=u32::from(options.rounds) {
        let places = instances::places(count, frame);
        let start = Instant::now();
        for (&handle, place) in handles.iter().zip(&places) {
            scene.set_transform(handle, place)?;
        }
        builds += u32::from(scene.commit()?.is_rebuilt);
        ours.push(start.elapsed().as_secs_f64() * 1e3);
        if let Some(peer) = &peer {
            let start = Instant::now();
            peer.move_instances(&places);
            embrees.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied()
    };
    let (ours, embrees) = (median(&mut ours), median(&mut embrees));
    if options.json {
        println!("{}", json!({ "scene": name, "update_ms": ours, "builds": builds, "embree_update_ms": embrees }));
    } else {
        println!("moving all and committing: {ours:.2?} ms ({builds} builds), Embree {embrees:.2?} ms");
    }
    Ok(())
}
