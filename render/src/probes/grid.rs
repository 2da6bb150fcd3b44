//! Points in the middles of the cells of a box.

use glam::Vec3;

/// A box that is divided into cells with a probe each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeGrid {
    /// The lower corner.
    pub min: Vec3,
    /// The upper corner.
    pub max: Vec3,
    /// Cells along x, y and z, at least 1 each.
    pub count: [u32; 3],
}

impl ProbeGrid {
    /// The most probes.
    pub const MAX_PROBES: u64 = 1 << 22;

    /// The extent of a cell.
    pub fn cell(&self) -> Vec3 {
        (self.max - self.min) / Vec3::from_array(self.count.map(|count| count as f32))
    }

    /// Probes in all.
    pub fn len(&self) -> usize {
        self.count.iter().map(|&count| count as usize).product()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Column, row and slice of the probe of this index.
    pub fn place(&self, index: usize) -> [u32; 3] {
        let [rx, ry, _] = self.count.map(|count| count as usize);
        [index % rx, index / rx % ry, index / rx / ry].map(|place| place as u32)
    }

    /// The index of the probe in this column, row and slice: x changes first, z last.
    pub fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        let [rx, ry, _] = self.count.map(|count| count as usize);
        (z as usize * ry + y as usize) * rx + x as usize
    }

    /// The middles of all cells, in their order.
    pub fn positions(&self) -> impl Iterator<Item = Vec3> {
        let grid = *self;
        (0..self.len()).map(move |index| {
            let place = Vec3::from_array(grid.place(index).map(|place| place as f32 + 0.5));
            grid.min + place * grid.cell()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probes_are_in_the_middles_of_cells_with_x_first() {
        let grid = ProbeGrid { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(1.0, 3.0, 3.0), count: [2, 3, 1] };
        let positions: Vec<Vec3> = grid.positions().collect();
        assert_eq!(positions.len(), grid.len());
        assert_eq!(positions[1], Vec3::new(0.5, 0.5, 2.5));
        assert_eq!(positions[4], Vec3::new(-0.5, 2.5, 2.5));
        assert!((0..grid.len()).all(|index| grid.index(grid.place(index)) == index));
    }
}
