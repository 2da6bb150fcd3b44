//! Messages about layouts, and input that is refused before them.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use super::*;
use crate::settings::Invalid;

fn mesh(positions: Vec<Vec3>) -> Mesh {
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh { name: "leaves".to_owned(), positions, triangles, ..Mesh::default() }
}

/// So many triangles that do not touch.
fn loose(count: u32) -> Mesh {
    let step = |i: u32| vec3(2.0 * (i % 50) as f32, 2.0 * (i / 50) as f32, 0.0);
    mesh((0..count).flat_map(|i| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| step(i) + corner)).collect())
}

fn laid_out(mesh: Mesh, options: &BakeOptions, watch: LayoutWatch) -> Result<Atlas, Invalid> {
    let scene = Scene { meshes: vec![mesh], materials: vec![Material::default()], ..Scene::default() };
    Atlas::watched(&scene, &LeftOut::default(), options, watch)
}

#[test]
fn a_watcher_hears_of_charts_their_unwrapping_and_their_packing() {
    let steps = Mutex::new(Vec::new());
    let options = BakeOptions { size: 64, ..BakeOptions::default() };
    laid_out(loose(12), &options, &|step| steps.lock().unwrap().push(step)).unwrap();
    let steps = steps.into_inner().unwrap();
    assert_eq!(steps[0], LayoutStep::Begin { triangles: 12, charts: 12, pages: 1 });
    assert!(steps.contains(&LayoutStep::Unwrap(1.0)) && steps.contains(&LayoutStep::Pack), "{steps:?}");
}

#[test]
fn many_pages_are_told_and_too_many_refused_before_they_are_packed() {
    let options = BakeOptions { size: 64, gutter: Some(20), ..BakeOptions::default() };
    let few = laid_out(loose(4), &options, &|_| {}).unwrap();
    assert_eq!((few.pages.len(), few.warnings.len()), (1, 0));
    let many = laid_out(loose(40), &options, &|_| {}).unwrap();
    let pages = many.pages.len();
    let [warning] = &many.warnings[..] else { panic!("{:?}", many.warnings) };
    assert!(pages > 4 && warning.contains(&format!("{pages} pages of 64x64 texels")), "{warning}");
    assert!(warning.contains("40 charts") && warning.contains("21x21"), "{warning}");
    // Who gives a density knows that there may be many.
    let asked = BakeOptions { density: Some(1.0), ..options.clone() };
    assert!(laid_out(loose(40), &asked, &|_| {}).unwrap().warnings.is_empty());
    let packs = AtomicBool::new(false);
    let watch = |step| packs.store(step == LayoutStep::Pack, Ordering::Relaxed);
    let options = BakeOptions { size: 16, gutter: Some(10), ..options };
    let refused = laid_out(loose(2200), &options, &watch).unwrap_err();
    assert!(refused.problem.contains("2200 charts") && refused.problem.contains("1040 pages"), "{refused}");
    assert!(!packs.into_inner());
}
