//! Probes of a grid as Bevy's irradiance volume: a texture of ambient cubes (Mitchell, McTaggart and Green 2006,
//! "Shading in Valve's Source Engine"), which hold the light for normals along the six axes.
//!
//! For a grid of `(rx, ry, rz)` the texture has `(rx, 2 ry, 3 rz)` texels. The texel of probe `(x, y, z)` for a normal
//! along an axis is at `(x, y + ry if the normal is negative, z + rz times 0, 1 or 2 for x, y or z)`. (So reads the
//! shader of Bevy 0.18 to 0.20, `irradiance_volume.wgsl`, which looks half of the texture further down where a normal
//! is negative; the text of its documentation has the two halves the other way around.)
//!
//! A texel is irradiance over π, as Bevy multiplies what it reads by the surface's colour alone. The shader weighs the
//! three sides that a normal sees by its squared components. The volume's transform stretches a cube of side 1 over the
//! grid, whose probes are in the middles of its cells.

use std::f32::consts::PI;

use glam::Vec3;

use super::{Probe, ProbeGrid};

/// A texture of three dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Texels along x, y and z.
    pub extent: [u32; 3],
    /// Irradiance over π: slice by slice, row by row.
    pub texels: Vec<Vec3>,
}

/// The volume of a grid's probes, in the grid's order.
pub fn volume(grid: &ProbeGrid, probes: &[Probe]) -> Volume {
    let [rx, ry, rz] = grid.count;
    let extent = [rx, 2 * ry, 3 * rz];
    let mut texels = vec![Vec3::ZERO; extent.map(|side| side as usize).iter().product()];
    for (index, probe) in probes.iter().enumerate() {
        let [x, y, z] = grid.place(index);
        for (side, irradiance) in (0..).zip(probe.light.axes) {
            let (axis, is_negative) = (side / 2, side % 2);
            let [y, z] = [y + ry * is_negative, z + rz * axis];
            let texel = ((z as usize * extent[1] as usize) + y as usize) * extent[0] as usize + x as usize;
            texels[texel] = irradiance / PI;
        }
    }
    Volume { extent, texels }
}

#[cfg(test)]
mod tests {
    use super::super::{ProbeLight, State};
    use super::*;

    /// What Bevy's shader reads at the middle of a probe's cell, nearest texel.
    fn read(volume: &Volume, count: [u32; 3], place: [u32; 3], normal: Vec3) -> Vec3 {
        let squares = normal * normal;
        let side = |axis: u32| {
            let y = place[1] + if normal[axis as usize] < 0.0 { volume.extent[1] / 2 } else { 0 };
            let z = place[2] + axis * count[2];
            volume.texels[((z * volume.extent[1] + y) * volume.extent[0] + place[0]) as usize]
        };
        side(0) * squares.x + side(1) * squares.y + side(2) * squares.z
    }

    #[test]
    fn the_shader_finds_each_side_of_each_probe() {
        let grid = ProbeGrid { min: Vec3::ZERO, max: Vec3::ONE, count: [2, 3, 4] };
        let probe = |index: usize| {
            let axes = [0, 1, 2, 3, 4, 5].map(|side| Vec3::splat(PI * (10 * index + side) as f32));
            Probe {
                position: Vec3::ZERO,
                state: State::Free,
                backs: 0.0,
                light: ProbeLight { axes, ..ProbeLight::default() },
            }
        };
        let probes: Vec<Probe> = (0..24).map(probe).collect();
        let volume = volume(&grid, &probes);
        assert_eq!(volume.extent, [2, 6, 12]);
        assert_eq!(volume.texels.len(), 6 * 24);
        let normals = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        for index in 0..24 {
            for (side, normal) in normals.into_iter().enumerate() {
                let found = read(&volume, grid.count, grid.place(index), normal).x;
                assert!((found - (10 * index + side) as f32).abs() < 1e-3, "{index} {normal}: {found}");
            }
        }
        // Even light is even for every normal.
        let even = ProbeLight { axes: [Vec3::splat(PI); 6], ..ProbeLight::default() };
        let even: Vec<Probe> = probes.iter().map(|probe| Probe { light: even, ..*probe }).collect();
        let found = read(&super::volume(&grid, &even), grid.count, [1, 2, 3], Vec3::new(0.6, -0.64, 0.48));
        assert!((found - Vec3::ONE).abs().max_element() < 1e-6);
    }
}
