//! Charts: the connected pieces of parts. Triangles are connected where they share an edge in space and on the page.

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::atlas::{Chart, NO_CHART, Page, Part};
use super::left_out::LeftOut;
use super::raster::Polygon;
use crate::scene::{Scene, UnionFind};

/// A triangle of less than this many square texels is no part of a chart.
const NO_AREA: f64 = 1e-9;

/// A corner, in space and on the page, bit for bit.
type Corner = [u32; 5];

/// Finds the charts of what is not left out, and writes into parts which triangle belongs to which.
pub(crate) fn islands(scene: &Scene, pages: &[Page], parts: &mut [Part], left_out: &LeftOut) -> Vec<Chart> {
    let mut charts = Vec::new();
    for (number, part) in parts.iter_mut().enumerate() {
        let page = pages[part.page];
        let on_page = |triangle: usize| Polygon::triangle(part.corners(triangle, page)).area().abs();
        let is_left_out = |triangle: usize| left_out.has(part.mesh, part.faces[triangle] as usize);
        let has_area: Vec<bool> = (0..part.triangles.len()).map(|i| on_page(i) > NO_AREA && !is_left_out(i)).collect();
        let roots = connect(scene, part, &has_area);
        part.charts.fill(NO_CHART);
        let mut chart_of_root = vec![NO_CHART; roots.len()];
        for triangle in (0..roots.len()).filter(|&triangle| has_area[triangle]) {
            let root = roots[triangle] as usize;
            let mut chart = chart_of_root[root];
            if chart == NO_CHART {
                chart = charts.len() as u32;
                chart_of_root[root] = chart;
                let (min, max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
                charts.push(Chart { part: number, triangles: Vec::new(), min, max, area: 0.0, texels: 0.0 });
            }
            let corners = part.triangles[triangle].map(|vertex| part.vertices[vertex as usize].uv);
            part.charts[triangle] = chart;
            let chart = &mut charts[chart as usize];
            chart.triangles.push(triangle as u32);
            chart.area += area(scene.meshes[part.mesh].corners(part.faces[triangle] as usize)) as f32;
            chart.texels += Polygon::triangle(part.corners(triangle, page)).area().abs() as f32;
            for uv in corners {
                (chart.min, chart.max) = (chart.min.min(uv), chart.max.max(uv));
            }
        }
    }
    charts
}

/// The area of a triangle in space.
pub(crate) fn area(corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}

/// The least index among the triangles connected with each one.
fn connect(scene: &Scene, part: &Part, has_area: &[bool]) -> Vec<u32> {
    let mesh = &scene.meshes[part.mesh];
    let corner = |triangle: usize, corner: usize| -> Corner {
        let vertex = part.vertices[part.triangles[triangle][corner] as usize];
        let [x, y, z] = mesh.positions[vertex.source as usize].to_array();
        // Both zeros are one.
        [x, y, z, vertex.uv.x, vertex.uv.y].map(|value| (value + 0.0).to_bits())
    };
    let mut sides: Vec<([Corner; 2], u32)> = Vec::with_capacity(3 * part.triangles.len());
    for triangle in (0..part.triangles.len()).filter(|&triangle| has_area[triangle]) {
        for side in 0..3 {
            let mut ends = [corner(triangle, side), corner(triangle, (side + 1) % 3)];
            ends.sort_unstable();
            sides.push((ends, triangle as u32));
        }
    }
    sides.sort_unstable();
    let mut sets = UnionFind::new(part.triangles.len());
    for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        sets.join(pair[0].1, pair[1].1);
    }
    sets.roots()
}

/// Steps in space for a texel's steps on the page along u and v; not finite for a triangle without area there.
pub(crate) fn texel_steps(corners: [Vec3; 3], on_page: [DVec2; 3]) -> [DVec3; 2] {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let (e, f) = (on_page[1] - on_page[0], on_page[2] - on_page[0]);
    let twice_area = e.perp_dot(f);
    [((b - a) * f.y - (c - a) * e.y) / twice_area, ((c - a) * e.x - (b - a) * f.x) / twice_area]
}

/// How a triangle is stretched: the greatest and the least length in space of a texel's step on the page, in units.
pub(crate) fn stretch(corners: [Vec3; 3], on_page: [DVec2; 3]) -> [f64; 2] {
    let [x, y] = texel_steps(corners, on_page);
    // Singular values by those of the metric tensor.
    let (xx, xy, yy) = (x.dot(x), x.dot(y), y.dot(y));
    let (middle, difference) = (0.5 * (xx + yy), (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt());
    [(middle + difference).sqrt(), (middle - difference).max(0.0).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{dvec2, vec3};

    #[test]
    fn stretch_is_the_singular_values() {
        let corners = [Vec3::ZERO, vec3(3.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0)];
        let [greatest, least] = stretch(corners, [DVec2::ZERO, DVec2::X, DVec2::Y]);
        assert!((greatest - 3.0).abs() < 1e-12 && (least - 1.0).abs() < 1e-12);
        let (sin, cos) = 0.7f64.sin_cos();
        let turned = [DVec2::ZERO, dvec2(cos, sin), dvec2(-2.0 * sin, 2.0 * cos)];
        let [greatest, least] = stretch(corners, turned);
        assert!((greatest - 3.0).abs() < 1e-12 && (least - 0.5).abs() < 1e-12);
        assert!(!stretch(corners, [DVec2::ZERO; 3])[0].is_finite());
    }
}
