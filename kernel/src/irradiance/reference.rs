//! The sums of a gather as the formulas read, in `f64`, without tables or lanes: what [`Layout::accumulate`] is tested
//! against.
//!
//! Nothing is shared with the code in lanes; of a hemicube even the neighbours are found another way, by looking across
//! the middle of each edge.
//!
//! [`Layout::accumulate`]: super::Layout::accumulate

use core::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3, dvec3};

use super::Gather;
use crate::sampling::Strata;

/// The gather of a stratified hemisphere (Ward and Heckbert 1992, with the exact cell weights for ∇_r). The slices have
/// [`Strata::cells`] elements; panics if they are shorter.
pub fn stratified(strata: &Strata, radiance: &[Vec3], distance: &[f32]) -> Gather {
    let (m, n) = (strata.rings() as usize, strata.sectors() as usize);
    let (phi, delta_phi) = (|k: f64| TAU * k / n as f64, TAU / n as f64);
    let theta = |j: usize| libm::asin(libm::sqrt(j as f64 / m as f64));
    let (sin, cos) = (|j| libm::sin(theta(j)), |j| libm::cos(theta(j)));
    let mut sums = Sums::default();
    for j in 0..m {
        for k in 0..n {
            let (cell, previous) = (j * n + k, j * n + (k + n - 1) % n);
            let zone = |j: usize| 0.5 * (theta(j) - sin(j) * cos(j));
            let turn = tangent(phi(k as f64 + 0.5)) * 2.0 * libm::sin(PI / n as f64) * (zone(j + 1) - zone(j));
            sums.add_cell(radiance[cell], distance[cell], PI / (m * n) as f64, turn);
            let mut add_wall = |a: usize, b: usize, direction: DVec3, integral: f64| {
                sums.add_wall([radiance[a], radiance[b]], [distance[a], distance[b]], direction * integral);
            };
            if j >= 1 {
                let length = sin(j) * delta_phi;
                add_wall(cell - n, cell, radial(phi(k as f64 + 0.5)) * cos(j), length * cos(j));
            }
            add_wall(previous, cell, tangent(phi(k as f64)), sin(j + 1) - sin(j));
            sums.add_difference([radiance[previous], radiance[cell]], PI / (m * n) as f64);
        }
    }
    sums.gather()
}

fn radial(phi: f64) -> DVec3 {
    dvec3(libm::cos(phi), libm::sin(phi), 0.0)
}

fn tangent(phi: f64) -> DVec3 {
    dvec3(-libm::sin(phi), libm::cos(phi), 0.0)
}

/// The gather of a hemicube with `n` texels a side, in the order of [`Hemicube`](super::Hemicube). The slices have 3n²
/// elements; panics if they are shorter.
pub fn hemicube(n: u32, radiance: &[Vec3], distance: &[f32]) -> Gather {
    let n = n as usize;
    let mut sums = Sums::default();
    for cell in 0..3 * n * n {
        let (centre, corners) = texel(n, cell);
        let edges = [0, 1, 2, 3].map(|i| [corners[i], corners[(i + 1) % 4]]);
        let mut vector = DVec3::ZERO;
        for [a, b] in edges {
            let normal = outwards(a, b, centre);
            vector -= 0.5 * angle(a, b) * normal;
            // The neighbour is the cell just beyond the middle of the edge; each wall is met from both of its sides.
            let beyond = a + b + 1e-3 / n as f64 * normal;
            if beyond.z > 1e-9
                && let other = cell_of(n, beyond)
                && other > cell
            {
                let cosine_integral = 2.0 * libm::sin(0.5 * angle(a, b)) * (a + b).normalize().z;
                let (radiance, distance) = ([radiance[cell], radiance[other]], [distance[cell], distance[other]]);
                sums.add_wall(radiance, distance, normal * cosine_integral);
            }
        }
        sums.add_cell(radiance[cell], distance[cell], vector.z, DVec3::Z.cross(vector));
        let (first, columns) = if cell < n * n { (0, n) } else { (n * n, 4 * n) };
        let column = (cell - first) % columns;
        let previous = cell - column + (column + columns - 1) % columns;
        sums.add_difference([radiance[previous], radiance[cell]], vector.z);
    }
    sums.gather()
}

/// The angle between unit vectors.
fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

/// The unit normal of the plane through the origin, a and b that points away from `inside`.
fn outwards(a: DVec3, b: DVec3, inside: DVec3) -> DVec3 {
    let normal = a.cross(b).normalize();
    if normal.dot(inside) > 0.0 { -normal } else { normal }
}

/// The direction of a texel's centre, and those of its corners in order around it.
fn texel(n: usize, cell: usize) -> (DVec3, [DVec3; 4]) {
    let step = 2.0 / n as f64;
    let (middle, a, b) = if cell < n * n {
        let (x, y) = ((cell % n) as f64, (cell / n) as f64);
        (dvec3((x + 0.5) * step - 1.0, (y + 0.5) * step - 1.0, 1.0), DVec3::X, DVec3::Y)
    } else {
        let (row, column) = ((cell - n * n) / (4 * n), (cell - n * n) % (4 * n));
        let turn = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y];
        let (outwards, along) = (turn[column / n], turn[(column / n + 1) % 4]);
        let (u, z) = (((column % n) as f64 + 0.5) * step - 1.0, 1.0 - (row as f64 + 0.5) * step);
        (outwards + u * along + z * DVec3::Z, along, DVec3::Z)
    };
    let (a, b) = (0.5 * step * a, 0.5 * step * b);
    (middle.normalize(), [middle - a - b, middle + a - b, middle + a + b, middle - a + b].map(DVec3::normalize))
}

/// The texel that a direction goes through.
fn cell_of(n: usize, d: DVec3) -> usize {
    let index = |u: f64| ((0.5 * (u + 1.0) * n as f64) as usize).min(n - 1);
    if d.z >= d.x.abs().max(d.y.abs()) {
        return index(d.y / d.z) * n + index(d.x / d.z);
    }
    let (face, outwards, along) = match d.x.abs() > d.y.abs() {
        true if d.x > 0.0 => (0, d.x, d.y),
        true => (2, -d.x, -d.y),
        false if d.y > 0.0 => (1, d.y, -d.x),
        false => (3, -d.y, d.x),
    };
    let row = ((1.0 - d.z / outwards) * 0.5 * n as f64) as usize;
    n * n + row * 4 * n + face * n + index(along / outwards)
}

#[derive(Default)]
struct Sums {
    irradiance: DVec3,
    rotational: [DVec3; 3],
    translational: [DVec3; 3],
    inverse_distance: f64,
    nearness: f64,
    squares: DVec3,
}

impl Sums {
    fn add_cell(&mut self, radiance: Vec3, distance: f32, cosine: f64, turn: DVec3) {
        self.irradiance += radiance.as_dvec3() * cosine;
        for channel in 0..3 {
            self.rotational[channel] += turn * f64::from(radiance[channel]);
        }
        self.inverse_distance += cosine / f64::from(distance);
        self.nearness = self.nearness.max(1.0 / f64::from(distance));
    }

    fn add_wall(&mut self, radiance: [Vec3; 2], distance: [f32; 2], across: DVec3) {
        let [a, b] = distance.map(f64::from);
        let (near, far) = (a.min(b), a.max(b));
        if near == f64::INFINITY {
            return;
        }
        let inverse = if far / near < 1.5 { 0.5 * (1.0 / near + 1.0 / far) } else { 1.0 / near };
        let rise = radiance[1].as_dvec3() - radiance[0].as_dvec3();
        for channel in 0..3 {
            self.translational[channel] += across * (rise[channel] * inverse);
        }
    }

    /// A cell's difference from the one before in its row, which for the first is the last.
    fn add_difference(&mut self, radiance: [Vec3; 2], cosine: f64) {
        let difference = cosine * (radiance[1].as_dvec3() - radiance[0].as_dvec3());
        self.squares += difference * difference;
    }

    fn gather(&self) -> Gather {
        let flat = |v: DVec3| dvec3(v.x, v.y, 0.0).as_vec3();
        Gather {
            irradiance: self.irradiance.as_vec3(),
            rotational: self.rotational.map(flat),
            translational: self.translational.map(flat),
            harmonic_mean_distance: (PI / self.inverse_distance) as f32,
            minimum_distance: (1.0 / self.nearness) as f32,
            standard_error: libm::sqrt(0.5 * self.squares.max_element()) as f32,
        }
    }
}
