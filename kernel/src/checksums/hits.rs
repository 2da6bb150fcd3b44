//! Hits by every method of tracing, with every instruction set, through the tree of each quality.

use super::scenes::Scene;
use super::{Checksum, compare};
use crate::simd::isas;
use crate::traverse::reference::intersect_all;
use crate::traverse::{PacketWidth, Width};
use crate::{Bvh, BvhView, Hit, HitPacket, Quality, Ray, RayPacket};

#[test]
fn hits_are_those_that_are_kept() {
    let mut lines = vec!["# scene, what, hits of rays (or nodes and blocks), FNV-1a of the bits".to_owned()];
    for Scene { name, triangles, rays } in Scene::all() {
        let hits: Vec<Hit> = rays.iter().map(|ray| intersect_all(&triangles, ray).unwrap_or(Hit::MISS)).collect();
        let expected = [closest(&hits), any(hits.iter().map(Hit::is_hit))];
        let count = hits.iter().filter(|hit| hit.is_hit()).count();
        lines.push(format!("{name} closest {count}/{} {}", rays.len(), expected[0]));
        lines.push(format!("{name} any {count}/{} {}", rays.len(), expected[1]));
        for quality in Quality::ALL {
            let (bvh, _) = Bvh::build(&triangles, &quality.into()).unwrap();
            let tree = bvh.view();
            lines.push(format!(
                "{name} tree-{quality} {}+{} {}",
                tree.nodes().len(),
                tree.blocks().len(),
                memory(&tree)
            ));
            let visits = rays.iter().flat_map(|ray| [tree.intersect_visits(ray), tree.occluded_visits(ray)]);
            let visits = Checksum::of(visits.flat_map(|visits| [visits.nodes, visits.blocks]));
            lines.push(format!("{name} visits-{quality} {visits}"));
            for isa in isas() {
                for (method, found) in by_methods(&tree.with_isa(isa), &rays) {
                    assert_eq!(found, expected, "{name}, {quality}, {}, {method}", isa.level());
                }
            }
        }
    }
    compare("hits", include_str!("../../../tests/checksums/hits.txt"), &lines);
}

/// The checksums of closest and of any hits by each method of tracing.
fn by_methods(tree: &BvhView, rays: &[Ray]) -> [(&'static str, [Checksum; 2]); 6] {
    let one: Vec<Hit> = rays.iter().map(|ray| tree.intersect(ray).unwrap_or(Hit::MISS)).collect();
    let (mut many, mut occluded) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
    tree.intersect_many(rays, &mut many);
    tree.occluded_many(rays, &mut occluded);
    let (mut gathered, mut gathered_any) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
    tree.intersect_gather(rays, &mut gathered);
    tree.occluded_gather(rays, &mut gathered_any);
    [
        ("one by one", [closest(&one), any(rays.iter().map(|ray| tree.occluded(ray)))]),
        ("many", [closest(&many), any(occluded)]),
        ("packets of 4", packets::<4>(tree, rays)),
        ("packets of 8", packets::<8>(tree, rays)),
        ("packets of 16", packets::<16>(tree, rays)),
        ("gathers", [closest(&gathered), any(gathered_any)]),
    ]
}

fn packets<const N: usize>(tree: &BvhView, rays: &[Ray]) -> [Checksum; 2]
where
    Width<N>: PacketWidth<N>,
{
    let (mut hits, mut occluded) = (Vec::new(), Vec::new());
    for rays in rays.chunks(N) {
        let packet = RayPacket::<N>::from_rays(rays);
        let mut found = HitPacket::MISS;
        tree.intersect_packet(&packet, &mut found);
        hits.extend((0..rays.len()).map(|lane| found.hit(lane)));
        let bits = tree.occluded_packet(&packet);
        occluded.extend((0..rays.len()).map(|lane| bits >> lane & 1 == 1));
    }
    [closest(&hits), any(occluded)]
}

fn closest(hits: &[Hit]) -> Checksum {
    Checksum::of(hits.iter().flat_map(|hit| [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.prim_id]))
}

fn any(occluded: impl IntoIterator<Item = bool>) -> Checksum {
    Checksum::of(occluded.into_iter().map(u32::from))
}

/// Of the tree as it lies in memory.
fn memory(tree: &BvhView) -> Checksum {
    let (nodes, blocks) = (bytemuck::cast_slice(tree.nodes()), bytemuck::cast_slice(tree.blocks()));
    // Unused lanes hold NaN, of which targets may have several.
    let words =
        nodes.iter().chain(blocks).map(|&word: &u32| if f32::from_bits(word).is_nan() { u32::MAX } else { word });
    Checksum::of(words)
}
