//! Scenes made from formulas, each hard on trees in its own way.

use glam::{Vec2, Vec3};
use halfdome_kernel::Triangle;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{ONE_MINUS_EPSILON, Stream, sin_cos_turns};

/// The sine of an angle in turns, from the kernel's arithmetic: the standard library's differs between platforms.
fn sine(turns: f32) -> f32 {
    sin_cos_turns((turns - turns.floor()).min(ONE_MINUS_EPSILON)).0
}

/// Hills with overhangs over a square of 20 by 20, a grid of `side` × `side` cells of two triangles: many of them, and
/// more memory than caches hold.
pub(super) fn terrain(side: u32) -> Vec<Triangle> {
    let vertex = |column: u32, row: u32| {
        let [x, z] = [column, row].map(|i| 20.0 * i as f32 / side as f32);
        let octave = |frequency: f32, height: f32| {
            height * sine(frequency * (x + 0.17 * z)) * sine(frequency * (0.83 * z - 0.11 * x) + 0.25)
        };
        let height = octave(0.19, 1.0) + octave(0.73, 0.4) + octave(4.1, 0.09) + octave(16.0, 0.03);
        // Slopes lean to and fro with the height, so that some hang over.
        Vec3::new(x + 0.35 * sine(0.6 * height), height, z)
    };
    let mut triangles = Vec::with_capacity(2 * (side as usize).pow(2));
    for column in 0..side {
        for row in 0..side {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| vertex(column + i, row + j));
            triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    triangles
}

/// `count` blades, up to 100 times as long as wide, leaning all ways over a disc: boxes that overlap however they are
/// sorted.
pub(super) fn forest(count: u32) -> Vec<Triangle> {
    let blade = |i: u32| {
        let stream = Stream::new(1, i, 0);
        let [radius, turns, base, length] = stream.uniform4(0);
        let [lean_x, lean_y, facing, width] = stream.uniform4(1);
        let (sin, cos) = sin_cos_turns(turns);
        let foot = 4.0 * radius.sqrt() * Vec3::new(cos, 0.0, sin) + 1.5 * base * base * Vec3::Y;
        let up = CosineHemisphere.map(Vec2::new(0.6 * lean_x, lean_y));
        let axis = (0.2 + 0.8 * length) * Vec3::new(up.x, up.z, up.y);
        let (sin, cos) = sin_cos_turns(facing);
        let across = (0.01 + 0.02 * width) * Vec3::new(cos, 0.0, sin);
        [foot - 0.5 * across, foot + 0.5 * across, foot + axis]
    };
    (0..count).map(blade).collect()
}

/// `side` × `side` boxes of 12 triangles: three in four stand as towers, one in four lies as a beam many cells long.
/// Every box is turned about the vertical.
pub(super) fn city(side: u32) -> Vec<Triangle> {
    let mut triangles = Vec::with_capacity(12 * (side as usize).pow(2));
    for row in 0..side {
        for column in 0..side {
            let [turns, width, length, height] = Stream::new(2, column, row).uniform4(0);
            let half_size = if (column + row) % 4 == 0 {
                Vec3::new(1.0 + 9.0 * length * length, 0.04, 0.04 + 0.08 * width)
            } else {
                Vec3::new(0.1 + 0.25 * width, 0.3 + 4.0 * height * height, 0.1 + 0.2 * length)
            };
            let level = if half_size.y < 0.1 { 3.0 * height } else { half_size.y };
            let centre = Vec3::new(column as f32, level, row as f32);
            triangles.extend(turned_box(centre, half_size, turns));
        }
    }
    triangles
}

/// A box about `centre`, turned about the vertical; its fronts look outwards.
fn turned_box(centre: Vec3, half_size: Vec3, turns: f32) -> impl Iterator<Item = Triangle> {
    let (sin, cos) = sin_cos_turns(turns);
    let corner = move |bits: usize| {
        let sign = |axis: usize| if bits >> axis & 1 == 1 { 1.0 } else { -1.0 };
        let p = half_size * Vec3::new(sign(0), sign(1), sign(2));
        centre + Vec3::new(cos * p.x + sin * p.z, p.y, cos * p.z - sin * p.x)
    };
    const FACES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    FACES.into_iter().flat_map(move |face| {
        let [a, b, c, d] = face.map(corner);
        [[a, b, c], [a, c, d]]
    })
}

/// A bumpy sphere of 8 `side`² triangles: an octahedron whose faces are cut into grids and pushed out to a radius that
/// waves with the direction. As compact as a scanned figure.
pub(super) fn blob(side: u32) -> Vec<Triangle> {
    let surface = |p: Vec3| {
        let n = p.normalize();
        let wave = |frequency: f32| sine(frequency * n.x + 0.1) * sine(frequency * n.y + 0.3) * sine(frequency * n.z);
        let ripple = sine(5.3 * n.y + sine(2.1 * n.x));
        n * (1.0 + 0.35 * wave(0.9) + 0.12 * wave(2.7) + 0.02 * ripple + 0.01 * wave(11.0))
    };
    let mut triangles = Vec::with_capacity(8 * (side as usize).pow(2));
    for octant in 0..8 {
        let sign = |axis: u32| if octant >> axis & 1 == 1 { -1.0 } else { 1.0 };
        let signs = Vec3::new(sign(0), sign(1), sign(2));
        // A mirrored octant would turn its faces inside out.
        let mirrored = signs.element_product() < 0.0;
        let vertex = |i: u32, j: u32| surface(signs * Vec3::new(i as f32, j as f32, (side - i - j) as f32));
        let mut face = |[a, b, c]: Triangle| triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
        for i in 0..side {
            for j in 0..side - i {
                face([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                if i + j + 1 < side {
                    face([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
                }
            }
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six times the volume that a closed mesh encloses; positive if its fronts look outwards (divergence theorem).
    fn volume6(triangles: &[Triangle]) -> f64 {
        let corner = |p: Vec3| p.as_dvec3();
        triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum()
    }

    /// Every edge is walked once in each direction.
    fn is_closed(triangles: &[Triangle]) -> bool {
        let key = |p: Vec3| p.to_array().map(|x| (x + 0.0).to_bits());
        let mut edges: Vec<_> = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        edges.sort_unstable_by_key(|&(a, b)| (key(a), key(b)));
        let has = |a: Vec3, b: Vec3| edges.binary_search_by_key(&(key(a), key(b)), |&(a, b)| (key(a), key(b))).is_ok();
        let distinct = edges.windows(2).all(|pair| pair[0] != pair[1]);
        distinct && edges.iter().all(|&(a, b)| has(b, a))
    }

    #[test]
    fn a_box_is_closed_and_has_its_volume() {
        let triangles: Vec<_> = turned_box(Vec3::new(3.0, -1.0, 0.5), Vec3::new(1.0, 2.0, 0.25), 0.0).collect();
        assert!(is_closed(&triangles));
        assert_eq!(volume6(&triangles), 6.0 * 2.0 * 4.0 * 0.5);
        let turned: Vec<_> = turned_box(Vec3::ZERO, Vec3::new(1.0, 2.0, 0.25), 0.1).collect();
        assert!((volume6(&turned) - 24.0).abs() < 1e-5);
    }

    #[test]
    fn the_blob_is_closed_and_about_a_sphere() {
        let blob = blob(12);
        assert!(is_closed(&blob));
        let sphere = 8.0 * std::f64::consts::PI;
        assert!((volume6(&blob) / sphere - 1.0).abs() < 0.2, "{}", volume6(&blob) / sphere);
    }

    #[test]
    fn the_terrain_faces_up_and_hangs_over() {
        let faces_up = |t: &&Triangle| (t[1] - t[0]).cross(t[2] - t[0]).y > 0.0;
        let terrain = terrain(200);
        let up = terrain.iter().filter(faces_up).count();
        assert!(up < terrain.len() && up > terrain.len() * 8 / 10, "{up}");
    }

    #[test]
    fn blades_are_thin() {
        let blades = forest(1000);
        let length = |t: &Triangle| (t[2] - 0.5 * (t[0] + t[1])).length();
        assert!(blades.iter().all(|t| length(t) > 6.0 * (t[1] - t[0]).length()));
    }
}
