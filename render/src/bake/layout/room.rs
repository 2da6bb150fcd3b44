//! A lower bound of the space that new charts need, before they are made and packed, which may take minutes.

use std::collections::HashMap;

use crate::bake::options::BakeOptions;
use crate::scene::{Key, Scene, UnionFind, count, key};
use crate::settings::Invalid;

/// The most texels of all pages together.
pub(super) const MAX_TEXELS: u64 = 1 << 28;
/// The most pages for which charts are packed.
const MAX_PAGES: u64 = 1024;

/// The progress of an atlas's layout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LayoutStep {
    /// New charts are about to be made of so many triangles, ...
    Begin {
        /// The triangles of meshes that need charts.
        triangles: usize,
        /// At least so many charts: there are as many connected pieces between creases.
        charts: usize,
        /// At least so many pages, if each chart has no more than one texel and its gutter.
        pages: u64,
    },
    /// ... this part of them is unwrapped, from 0 to 1, ...
    Unwrap(f32),
    /// ... and all charts are packed again: the number of attempts is not known beforehand.
    Pack,
}

/// Hears how far a layout is; called from any thread, but never from two at once.
pub type LayoutWatch<'a> = &'a (dyn Fn(LayoutStep) + Sync);

/// The connected pieces of a mesh's faces, whose sides count as connected unless `cuts` has them: it has no fewer
/// charts.
pub(super) fn pieces(
    scene: &Scene,
    mesh: usize,
    has_chart: impl Fn(usize) -> bool,
    cuts: Option<&[[bool; 3]]>,
) -> usize {
    let mesh = &scene.meshes[mesh];
    let mut sets = UnionFind::new(mesh.triangles.len());
    let mut first_faces: HashMap<[Key; 2], u32> = HashMap::new();
    let mut pieces = 0;
    for (face, triangle) in mesh.triangles.iter().enumerate().filter(|(face, _)| has_chart(*face)) {
        pieces += 1;
        let keys = triangle.map(|vertex| key(mesh.positions[vertex as usize]));
        for side in (0..3).filter(|&side| cuts.is_none_or(|cuts| !cuts[face][side])) {
            let mut ends = [keys[side], keys[(side + 1) % 3]];
            ends.sort_unstable();
            let other = *first_faces.entry(ends).or_insert(face as u32);
            pieces -= usize::from(sets.join(face as u32, other));
        }
    }
    pieces
}

/// Texels a side that a chart takes at least, with its gutter.
fn least_side(options: &BakeOptions) -> u64 {
    1 + 2 * u64::from(options.padding())
}

/// The pages that so many charts take at least.
///
/// # Errors
/// If these are too many.
pub(super) fn least_pages(charts: usize, options: &BakeOptions) -> Result<u64, Invalid> {
    let (side, size) = (least_side(options), u64::from(options.size));
    let (texels, of_page) = (charts as u64 * side * side, size * size);
    let pages = texels.div_ceil(of_page);
    if pages <= MAX_PAGES && texels <= MAX_TEXELS {
        return Ok(pages);
    }
    let most = MAX_PAGES.min(MAX_TEXELS / of_page);
    // The next power of two that would do.
    let larger = (0..).map(|bit| 1u64 << bit).find(|larger| larger * larger * MAX_PAGES >= texels).unwrap_or(size);
    let larger = if larger > size && larger <= u64::from(BakeOptions::MAX_SIZE) && texels <= MAX_TEXELS {
        format!("give --size {larger} or more, ")
    } else {
        "give ".to_owned()
    };
    Err(Invalid::new(
        format!(
            "the surfaces have at least {charts} charts, each of which takes {side}x{side} texels or more with its gutter: that \
             is {texels} texels, or {pages} pages of {size}x{size}, and a bake has at most {most} of these"
        ),
        format!(
            "{larger}a smaller --gutter, or a model with fewer loose pieces: leave leaf cards and grass out, or join \
             triangles that belong together"
        ),
    ))
}

/// The warning about more than one page.
pub(super) fn many_pages(pages: usize, charts: usize, options: &BakeOptions) -> Option<String> {
    let (side, size) = (least_side(options), options.size);
    (pages > 1 && options.density.is_none()).then(|| {
        format!(
            "the new layout has {pages} pages of {size}x{size} texels, as its {} fit on one at no density: each takes at least \
             {side}x{side} texels with its gutter; a larger --size, a smaller --gutter or a model with fewer loose pieces \
             needs fewer pages",
            count(charts, "chart", "charts")
        )
    })
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, vec3};

    use super::*;
    use crate::scene::Mesh;

    fn scene(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Scene {
        Scene { meshes: vec![Mesh { positions, triangles, ..Mesh::default() }], ..Scene::default() }
    }

    #[test]
    fn pieces_end_at_open_edges_and_at_cuts() {
        let corners = [Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 0.0), Vec3::Y].to_vec();
        let quad = scene(corners.clone(), vec![[0, 1, 2], [0, 2, 3]]);
        assert_eq!(pieces(&quad, 0, |_| true, None), 1);
        assert_eq!(pieces(&quad, 0, |face| face == 0, None), 1);
        let diagonal = [[false, false, true], [false; 3]];
        assert_eq!(pieces(&quad, 0, |_| true, Some(&diagonal)), 2);
        // With vertices of its own each triangle still hangs together with the other.
        let split = [0, 1, 2, 0, 2, 3].map(|corner| corners[corner]).to_vec();
        assert_eq!(pieces(&scene(split, vec![[0, 1, 2], [3, 4, 5]]), 0, |_| true, None), 1);
        let apart = corners.iter().chain(&corners).enumerate().map(|(i, corner)| *corner + i as f32 * Vec3::Z);
        assert_eq!(pieces(&scene(apart.collect(), vec![[0, 1, 2], [4, 5, 6]]), 0, |_| true, None), 2);
    }

    #[test]
    fn too_many_charts_are_refused_with_what_would_help() {
        let options = BakeOptions { size: 16, gutter: Some(2), ..BakeOptions::default() };
        // 9 texels each, 256 a page.
        assert_eq!(least_pages(28, &options).unwrap(), 1);
        assert_eq!(least_pages(29, &options).unwrap(), 2);
        assert_eq!(least_pages(29_127, &options).unwrap(), 1024);
        let refused = least_pages(290_000, &options).unwrap_err();
        for part in ["290000 charts", "3x3 texels", "2610000 texels", "10196 pages of 16x16", "at most 1024"] {
            assert!(refused.problem.contains(part), "{} lacks {part}", refused.problem);
        }
        assert!(refused.remedy.starts_with("give --size 64 or more, "), "{}", refused.remedy);
        assert!(least_pages(290_000, &BakeOptions { size: 64, ..options.clone() }).is_ok());
        // No page is large enough.
        let wide = BakeOptions { size: 16_384, gutter: Some(64), ..options };
        let refused = least_pages(290_000, &wide).unwrap_err();
        assert!(refused.problem.contains("65x65") && refused.remedy.starts_with("give a smaller"), "{refused:?}");
    }
}
