//! Texels on surfaces: their positions and sizes.
//!
//! A texel belongs to the chart that covers most of it. Its sample point is its centre if the chart covers that, else
//! the centroid of the largest piece of the chart in it, which is inside of a triangle and never on an edge, where a
//! ray could slip behind the neighbouring wall.

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use super::atlas::{Atlas, NO_CHART, Page};
use super::islands::texel_steps;
use super::raster::{Polygon, rasterize};
use crate::scene::Scene;

/// A texel on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Texel {
    /// Index of the page.
    pub(crate) page: u32,
    /// Its place there, row by row.
    pub(crate) index: u32,
    pub(crate) chart: u32,
    /// The sample point of the texel.
    pub(crate) point: Point,
    /// How wide it is there, in units.
    pub(crate) spacing: f32,
    /// Vectors in space along u and v.
    pub(crate) tangents: [Vec3; 2],
    /// The part of it that its chart covers, up to 1.
    pub(crate) coverage: f32,
    /// Whether something covers its middle, so that its point is elsewhere.
    pub(crate) is_moved: bool,
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// The index of the triangle among all of the scene.
    pub(crate) prim_id: u32,
    /// The weights of its second and third corner.
    pub(crate) barycentric: [f32; 2],
}

/// How far inside of a triangle a centre must be at the border of a chart, in texels.
const MARGIN: f64 = 0.01;
/// A texel that its chart covers up to this part is not at the border.
const COVERED: f64 = 0.999;

/// A texel of which its chart covers less than this is left to the gutter: a point so close to the border could lie
/// behind the next wall by rounding.
pub(super) const MIN_COVERAGE: f32 = 0.02;

/// A piece of a triangle in a texel.
struct Piece {
    texel: u32,
    chart: u32,
    part: u32,
    triangle: u32,
    polygon: Polygon,
}

/// The surfaces behind the pages.
pub(crate) struct Surfaces<'a> {
    scene: &'a Scene,
    atlas: &'a Atlas,
    /// See [`first_prims`].
    first_prims: Vec<u32>,
    /// For each triangle of the scene its part, and its index there; none for those that are in no part.
    faces: Vec<Option<(u32, u32)>>,
}

/// A place on a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) page: usize,
    /// The texel, row by row.
    pub(crate) texel: u32,
    pub(crate) chart: u32,
}

/// For each mesh the index of its first triangle among all of the scene, and behind them the number of all.
pub(crate) fn first_prims(scene: &Scene) -> Vec<u32> {
    let counts = scene.meshes.iter().map(|mesh| mesh.triangles.len() as u32);
    let ends = counts.scan(0, |sum, count| {
        *sum += count;
        Some(*sum)
    });
    std::iter::once(0).chain(ends).collect()
}

impl<'a> Surfaces<'a> {
    pub(crate) fn new(scene: &'a Scene, atlas: &'a Atlas) -> Self {
        let first_prims = first_prims(scene);
        let mut faces = vec![None; first_prims[scene.meshes.len()] as usize];
        for (number, part) in (0..).zip(&atlas.parts) {
            for (triangle, face) in (0..).zip(&part.faces) {
                faces[(first_prims[part.mesh] + face) as usize] = Some((number, triangle));
            }
        }
        Self { scene, atlas, first_prims, faces }
    }

    /// The sizes of all pages.
    pub(crate) fn pages(&self) -> &[Page] {
        &self.atlas.pages
    }

    /// Where a point of a triangle of the scene lies; `None` if it is on no page.
    pub(crate) fn place(&self, prim_id: u32, [u, v]: [f32; 2]) -> Option<Place> {
        let (part, triangle) = self.faces[prim_id as usize]?;
        let part = &self.atlas.parts[part as usize];
        let chart = part.charts[triangle as usize];
        let size = self.atlas.pages[part.page];
        let [a, b, c] = part.triangles[triangle as usize].map(|vertex| part.vertices[vertex as usize].uv);
        let [x, y] = size.to_texels(a + (b - a) * u + (c - a) * v).to_array();
        let column = |x: f64, side: u32| (x as u32).min(side - 1);
        let texel = column(y, size.height) * size.width + column(x, size.width);
        (chart != NO_CHART).then_some(Place { page: part.page, texel, chart })
    }

    /// All texels on surfaces, page by page and row by row.
    pub(crate) fn texels(&self) -> Vec<Texel> {
        let pages: Vec<Vec<Texel>> =
            (0..self.atlas.pages.len()).into_par_iter().map(|page| self.texels_of(page)).collect();
        pages.concat()
    }

    fn texels_of(&self, page: usize) -> Vec<Texel> {
        let mut pieces = self.pieces(page);
        pieces.sort_by_key(|piece| piece.texel);
        let mut texels: Vec<Texel> =
            pieces.chunk_by(|a, b| a.texel == b.texel).filter_map(|pieces| self.texel(page, pieces)).collect();
        // A chart that covers no texel well keeps what it has.
        let mut most = vec![0.0f32; self.atlas.charts.len()];
        texels.iter().for_each(|texel| most[texel.chart as usize] = most[texel.chart as usize].max(texel.coverage));
        texels.retain(|texel| texel.coverage >= MIN_COVERAGE.min(0.5 * most[texel.chart as usize]));
        texels
    }

    /// The texel of which these are all pieces.
    fn texel(&self, page: usize, pieces: &[Piece]) -> Option<Texel> {
        let size = self.atlas.pages[page];
        let index = pieces[0].texel;
        let chart = largest_chart(pieces);
        let own = || pieces.iter().filter(|piece| piece.chart == chart);
        let coverage = own().map(|piece| piece.polygon.area().abs()).sum::<f64>().min(1.0);
        let centre = DVec2::new((index % size.width).into(), (index / size.width).into()) + 0.5;
        let margin = if coverage > COVERED { 0.0 } else { MARGIN };
        let at_centre = own().find_map(|piece| Some((piece, self.locate(piece.part, piece.triangle, centre, margin)?)));
        let (piece, point) = at_centre.or_else(|| {
            // The first of equal ones.
            let piece = own().reduce(|a, b| if b.polygon.area().abs() > a.polygon.area().abs() { b } else { a })?;
            Some((piece, self.clamped(piece.part, piece.triangle, piece.polygon.centroid())))
        })?;
        let part = &self.atlas.parts[piece.part as usize];
        let corners = self.scene.meshes[part.mesh].corners(part.faces[piece.triangle as usize] as usize);
        let steps = texel_steps(corners, part.corners(piece.triangle as usize, size));
        Some(Texel {
            page: page as u32,
            index,
            chart,
            point,
            spacing: steps[0].cross(steps[1]).length().sqrt() as f32,
            tangents: steps.map(|step| step.as_vec3()),
            coverage: coverage as f32,
            is_moved: false,
        })
    }

    /// All pieces of a page's triangles.
    fn pieces(&self, page: usize) -> Vec<Piece> {
        let size = self.atlas.pages[page];
        let mut pieces = Vec::new();
        for (number, part) in (0..).zip(&self.atlas.parts).filter(|(_, part)| part.page == page) {
            for (triangle, &chart) in part.charts.iter().enumerate().filter(|(_, chart)| **chart != NO_CHART) {
                rasterize(part.corners(triangle, size), size.width, size.height, |x, y, polygon| {
                    let texel = y * size.width + x;
                    pieces.push(Piece { texel, chart, part: number, triangle: triangle as u32, polygon: *polygon });
                });
            }
        }
        pieces
    }

    /// The points of a texel's chart that lie on a grid of `side` by `side` in it, those near its centre first.
    pub(crate) fn points_within(&self, texel: &Texel, side: u32) -> Vec<Point> {
        let size = self.atlas.pages[texel.page as usize];
        let (x, y) = (texel.index % size.width, texel.index / size.width);
        let chart = &self.atlas.charts[texel.chart as usize];
        let part = &self.atlas.parts[chart.part];
        let touches = |&&triangle: &&u32| {
            let corners = part.corners(triangle as usize, size);
            Polygon::triangle(corners).in_texel(x, y).area() != 0.0
        };
        let triangles: Vec<u32> = chart.triangles.iter().filter(touches).copied().collect();
        let place = |i: u32| (DVec2::new((i % side).into(), (i / side).into()) + 0.5) / f64::from(side);
        let mut places: Vec<DVec2> = (0..side * side).map(place).collect();
        places.sort_by(|a, b| (*a - 0.5).length_squared().total_cmp(&(*b - 0.5).length_squared()));
        let low = DVec2::new(x.into(), y.into());
        let locate = |place: DVec2| {
            triangles.iter().find_map(|&triangle| self.locate(chart.part as u32, triangle, low + place, MARGIN))
        };
        places.into_iter().filter_map(locate).collect()
    }

    /// The points of a texel's own triangle that lie on a grid of `side` by `side` in it.
    pub(crate) fn spread(&self, texel: &Texel, side: u32) -> Vec<Point> {
        let Some((part, triangle)) = self.faces[texel.point.prim_id as usize] else { return Vec::new() };
        let width = self.atlas.pages[texel.page as usize].width;
        let low = DVec2::new((texel.index % width).into(), (texel.index / width).into());
        let places = (0..side * side).map(|i| DVec2::new((i % side).into(), (i / side).into()) + 0.5);
        places.filter_map(|place| self.locate(part, triangle, low + place / f64::from(side), MARGIN)).collect()
    }

    /// The point of a triangle at a place on its page that is at least `margin` texels inside.
    fn locate(&self, part: u32, triangle: u32, place: DVec2, margin: f64) -> Option<Point> {
        let (weights, heights) = self.weights(part, triangle, place);
        let inside = weights.iter().zip(heights).all(|(weight, height)| weight * height >= margin);
        inside.then(|| self.point(part, triangle, weights))
    }

    /// The point of a triangle at a place that is in it but for rounding.
    fn clamped(&self, part: u32, triangle: u32, place: DVec2) -> Point {
        let weights = self.weights(part, triangle, place).0.map(|weight| weight.clamp(0.0, 1.0));
        let sum: f64 = weights.iter().sum();
        self.point(part, triangle, weights.map(|weight| weight / sum))
    }

    fn point(&self, part: u32, triangle: u32, [_, u, v]: [f64; 3]) -> Point {
        let part = &self.atlas.parts[part as usize];
        let prim_id = self.first_prims[part.mesh] + part.faces[triangle as usize];
        Point { prim_id, barycentric: [u as f32, v as f32] }
    }

    /// The weights of a triangle's corners at a place on its page, and how far in texels each corner is from the side
    /// across.
    fn weights(&self, part: u32, triangle: u32, place: DVec2) -> ([f64; 3], [f64; 3]) {
        let part = &self.atlas.parts[part as usize];
        let [a, b, c] = part.corners(triangle as usize, self.atlas.pages[part.page]);
        let area = (b - a).perp_dot(c - a);
        let second = (place - a).perp_dot(c - a) / area;
        let third = (b - a).perp_dot(place - a) / area;
        let heights = [c - b, a - c, b - a].map(|side| area.abs() / side.length());
        ([1.0 - second - third, second, third], heights)
    }
}

/// The chart that covers most of a texel; of equal ones the first.
fn largest_chart(pieces: &[Piece]) -> u32 {
    let area = |chart: u32| -> f64 {
        pieces.iter().filter(|piece| piece.chart == chart).map(|piece| piece.polygon.area().abs()).sum()
    };
    let first = (pieces[0].chart, area(pieces[0].chart));
    let best = pieces[1..].iter().fold(first, |best, piece| {
        let area = if piece.chart == best.0 { best.1 } else { area(piece.chart) };
        if area > best.1 || (area == best.1 && piece.chart < best.0) { (piece.chart, area) } else { best }
    });
    best.0
}
