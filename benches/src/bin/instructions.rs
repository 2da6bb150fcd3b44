//! Counts the instructions of the kernel's hot paths in Valgrind, and fails where they exceed a limit: a slowdown that
//! shows on a busy machine too. `benches/instructions.sh` installs Valgrind and runs it.
//!
//! `instructions` runs itself in Callgrind once for each path, as `instructions NAME`; what [`counted`] calls is
//! counted. Valgrind supports AVX2 but not AVX-512. Compilers differ by less than the allowed 5%. A faster path gets a
//! lower limit; there are a thousand rays.

#![forbid(unsafe_code)]

use std::hint::black_box;
use std::process::{Command, ExitCode};

use glam::Vec3;
use halfdome_benches::rays::{self, RayCounts, RayKind};
use halfdome_benches::scenes;
use halfdome_benches::tracer::Entry;
use halfdome_kernel::irradiance::{Layout, Stratified};
use halfdome_kernel::sampling::{Strata, Stream};
use halfdome_kernel::{BuildOptions, Bvh, Hit, Ray, Triangle};

/// A path: its name, the instructions that were counted when it was last changed, and what prepares it.
struct Case {
    name: &'static str,
    instructions: u64,
    prepare: fn() -> Box<dyn FnMut()>,
}

const CASES: [Case; 13] = [
    Case {
        name: "nearest, room, single",
        instructions: 762_676,
        prepare: || nearest(Entry::Single, "cornell", RayKind::Diffuse),
    },
    Case {
        name: "nearest, room, batch",
        instructions: 502_822,
        prepare: || nearest(Entry::Batch, "cornell", RayKind::Diffuse),
    },
    Case {
        name: "nearest, room, gather",
        instructions: 524_279,
        prepare: || nearest(Entry::Gather, "cornell", RayKind::Gather),
    },
    Case {
        name: "nearest, hills, packets",
        instructions: 1_467_403,
        prepare: || nearest(Entry::Packet16, HILLS, RayKind::Primary),
    },
    Case {
        name: "nearest, hills, single",
        instructions: 757_324,
        prepare: || nearest(Entry::Single, HILLS, RayKind::Diffuse),
    },
    Case {
        name: "nearest, hills, batch",
        instructions: 825_090,
        prepare: || nearest(Entry::Batch, HILLS, RayKind::Diffuse),
    },
    Case {
        name: "nearest, hills, gather",
        instructions: 1_201_564,
        prepare: || nearest(Entry::Gather, HILLS, RayKind::Gather),
    },
    Case { name: "any, room, batch", instructions: 336_908, prepare: || any(Entry::Batch, "cornell", RayKind::Shadow) },
    Case {
        name: "any, hills, packets",
        instructions: 985_826,
        prepare: || any(Entry::Packet16, HILLS, RayKind::Shadow),
    },
    Case { name: "any, hills, batch", instructions: 584_082, prepare: || any(Entry::Batch, HILLS, RayKind::Shadow) },
    Case { name: "build, hills", instructions: 147_685_772, prepare: build },
    Case { name: "gradients, strata", instructions: 35_491, prepare: gradients },
    Case { name: "hessian, strata", instructions: 79_917, prepare: hessian },
];

const HILLS: &str = "terrain:80";

fn main() -> ExitCode {
    if let Some(name) = std::env::args().nth(1) {
        let Some(case) = CASES.iter().find(|case| case.name == name) else {
            eprintln!("error: there is no path {name:?}");
            return ExitCode::FAILURE;
        };
        let mut path = (case.prepare)();
        counted(&mut *path);
        return ExitCode::SUCCESS;
    }
    println!("{:<26}{:>14}{:>14}{:>9}", "path", "instructions", "before", "ratio");
    let mut slower = 0;
    for case in &CASES {
        let counted = match count(case.name) {
            Ok(counted) => counted,
            Err(problem) => {
                eprintln!("error: {}: {problem}", case.name);
                return ExitCode::FAILURE;
            }
        };
        let over = counted > case.instructions + case.instructions / 20;
        slower += usize::from(over);
        let ratio = counted as f64 / case.instructions as f64;
        let remark = if over { "  more than 5% over" } else { "" };
        println!("{:<26}{counted:>14}{:>14}{ratio:>9.3}{remark}", case.name, case.instructions);
    }
    if slower > 0 {
        eprintln!("error: {slower} of {} paths take more instructions than they did", CASES.len());
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// Runs a path in Callgrind.
fn count(name: &str) -> Result<u64, String> {
    let this = std::env::current_exe().map_err(|problem| problem.to_string())?;
    let output = Command::new("valgrind")
        .args([
            "--tool=callgrind",
            "--callgrind-out-file=/dev/null",
            "--collect-atstart=no",
            "--toggle-collect=*counted*",
        ])
        .arg(this)
        .arg(name)
        .output()
        .map_err(|problem| format!("valgrind: {problem}"))?;
    let log = String::from_utf8_lossy(&output.stderr);
    let collected = log.lines().find_map(|line| line.split_once("Collected :")?.1.trim().parse().ok());
    match collected {
        Some(instructions) if output.status.success() && instructions > 0 => Ok(instructions),
        _ => Err(format!("valgrind counted nothing:\n{log}")),
    }
}

/// What Callgrind counts.
#[inline(never)]
fn counted(path: &mut dyn FnMut()) {
    path();
}

/// A thousand rays of one kind in a scene.
fn rays(scene: &str, kind: RayKind) -> (Bvh, Vec<Ray>) {
    let scene = scenes::by_name(scene).expect("a scene that is made");
    let (bvh, _) = Bvh::build(&scene.triangles, &BuildOptions::default()).expect("a scene that can be built");
    let mut sets = rays::generate(&scene, &bvh.view(), RayCounts::TINY).into_iter();
    let rays = sets.find(|set| set.kind == kind).expect("rays of all kinds").rays;
    (bvh, rays)
}

fn nearest(entry: Entry, scene: &str, kind: RayKind) -> Box<dyn FnMut()> {
    let (bvh, rays) = rays(scene, kind);
    let mut hits = vec![Hit::MISS; rays.len()];
    Box::new(move || {
        entry.tracer(bvh.view()).intersect(black_box(&rays), &mut hits);
        black_box(&hits);
    })
}

fn any(entry: Entry, scene: &str, kind: RayKind) -> Box<dyn FnMut()> {
    let (bvh, rays) = rays(scene, kind);
    let mut occluded = vec![false; rays.len()];
    Box::new(move || {
        entry.tracer(bvh.view()).occluded(black_box(&rays), &mut occluded);
        black_box(&occluded);
    })
}

fn build() -> Box<dyn FnMut()> {
    let triangles: Vec<Triangle> = scenes::by_name(HILLS).expect("a scene that is made").triangles;
    Box::new(move || {
        black_box(Bvh::build(black_box(&triangles), &BuildOptions::default()).expect("a scene that can be built"));
    })
}

/// What the rays of a gather found.
struct Found {
    layout: Stratified<Vec<f32>>,
    directions: Vec<Vec3>,
    radiance: Vec<Vec3>,
    distance: Vec<f32>,
}

impl Found {
    fn new() -> Self {
        let strata = Strata::new(18, 57).expect("rings and sectors");
        let layout = Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)]).expect("its own table");
        let random = |cell: usize, set: u32| Stream::new(1, cell as u32, set).uniform2(0);
        let mut directions = vec![Vec3::ZERO; layout.cells()];
        layout.directions(&mut |cell| random(cell, 0), &mut directions).expect("a direction for each cell");
        let radiance = (0..layout.cells()).map(|cell| random(cell, 1).extend(0.5)).collect();
        let distance = (0..layout.cells()).map(|cell| 0.1 + random(cell, 2).x).collect();
        Self { layout, directions, radiance, distance }
    }
}

fn gradients() -> Box<dyn FnMut()> {
    let found = Found::new();
    Box::new(move || {
        let _ = black_box(found.layout.accumulate(black_box(&found.radiance), &found.distance));
    })
}

fn hessian() -> Box<dyn FnMut()> {
    let found = Found::new();
    Box::new(move || {
        let _ = black_box(found.layout.hessian(&found.directions, black_box(&found.radiance), &found.distance));
    })
}
