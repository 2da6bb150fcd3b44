//! Fixtures for the scenes of several modules' tests.

use std::f32::consts::{PI, TAU};

use glam::{Vec3, vec3};

use crate::material::Inputs;
use crate::scene::{Mesh, PunctualLight};

/// The index of refraction of [`glass`].
pub(crate) const IOR: f32 = 1.5;

/// Clear, smooth, solid glass.
pub(crate) fn glass() -> Inputs {
    Inputs {
        specular_weight: 1.0,
        specular_roughness: 0.0,
        specular_ior: IOR,
        transmission_weight: 1.0,
        transmission_color: Vec3::ONE,
        ..Inputs::default()
    }
}

/// Fresnel's reflectance of a face between air and [`glass`], for the cosine in air.
pub(crate) fn reflectance(cos: f64) -> f64 {
    let n = f64::from(IOR);
    let inside = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
    let [s, p] = [(cos - n * inside) / (cos + n * inside), (n * cos - inside) / (n * cos + inside)];
    0.5 * (s * s + p * p)
}

/// A sun of a point's size.
pub(crate) fn sun(to_sun: Vec3) -> PunctualLight {
    PunctualLight::Directional { direction: -to_sun, irradiance: Vec3::ONE, half_angle: 0.0 }
}

/// A square of the width 18 at this height, its front up or down.
pub(crate) fn square(z: f32, is_up: bool, material: usize) -> Mesh {
    sloping_square(z, is_up, 0.0, 9.0, material)
}

/// A square that is twice `half` wide and rises by `slope` along x.
pub(crate) fn sloping_square(z: f32, is_up: bool, slope: f32, half: f32, material: usize) -> Mesh {
    let corner = |(x, y): (f32, f32)| half * vec3(x, y, slope * x) + Vec3::Z * z;
    let positions = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner).to_vec();
    let triangles = if is_up { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 2, 1], [0, 3, 2]] };
    Mesh { positions, triangles, material, ..Mesh::default() }
}

/// A ball about the origin with the radius 1 and vertex normals: `rows` from pole to pole along z, of `columns` quads
/// each.
pub(crate) fn ball([rows, columns]: [u32; 2]) -> Mesh {
    let normal = |(row, column): (u32, u32)| {
        let (down, around) = (PI * row as f32 / rows as f32, TAU * column as f32 / columns as f32);
        vec3(down.sin() * around.cos(), down.sin() * around.sin(), down.cos())
    };
    let normals: Vec<_> =
        (0..=rows).flat_map(|row| (0..columns).map(move |column| (row, column))).map(normal).collect();
    let at = |row: u32, column: u32| row * columns + column % columns;
    let triangles = (0..rows)
        .flat_map(|row| (0..columns).map(move |column| (row, column)))
        .flat_map(|(row, column)| {
            let [a, b, c, d] = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    Mesh { positions: normals.clone(), normals, triangles, ..Mesh::default() }
}
