//! A grid over the places of receivers: what is known of each cell.

use glam::Vec3;
use halfdome_kernel::Aabb;

/// The cells along the longest side of the box.
const CELLS: f32 = 16.0;

/// Cells of equal size, as cubes, with a value each.
#[derive(Clone, Debug)]
pub(crate) struct Grid<T> {
    first: Vec3,
    per_length: f32,
    size: [usize; 3],
    cells: Vec<T>,
}

impl<T: Clone> Grid<T> {
    /// A grid over a box.
    pub(crate) fn new(bounds: Aabb, value: T) -> Self {
        let extent = (bounds.max - bounds.min).max(Vec3::ZERO);
        let per_length = CELLS / extent.max_element().max(f32::MIN_POSITIVE);
        let size = (extent * per_length).to_array().map(|cells| cells as usize + 1);
        Self { first: bounds.min, per_length, size, cells: vec![value; size.iter().product()] }
    }

    /// How many cells there are.
    pub(crate) fn len(&self) -> usize {
        self.cells.len()
    }

    /// The number of the cell that a place is in; outside of the box, of one at its border.
    #[inline(always)]
    pub(crate) fn cell(&self, place: Vec3) -> usize {
        let place = (place - self.first) * self.per_length;
        // Negative numbers and NaN become 0.
        let [x, y, z] = [place.x as usize, place.y as usize, place.z as usize];
        let [width, height, depth] = self.size;
        (z.min(depth - 1) * height + y.min(height - 1)) * width + x.min(width - 1)
    }

    /// The value at a place.
    #[inline(always)]
    pub(crate) fn at(&self, place: Vec3) -> &T {
        &self.cells[self.cell(place)]
    }

    /// The value of a cell.
    pub(crate) fn cell_mut(&mut self, cell: usize) -> &mut T {
        &mut self.cells[cell]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_in_cells_and_what_is_outside_is_in_the_next_one() {
        let bounds = Aabb { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(3.0, 1.0, 2.0) };
        let mut grid = Grid::new(bounds, 0);
        assert_eq!(grid.len(), 17 * 5);
        for cell in 0..grid.len() {
            *grid.cell_mut(cell) = cell;
        }
        let at = |x, y| *grid.at(Vec3::new(x, y, 2.0));
        assert_eq!([at(-0.99, 0.01), at(-0.7, 0.01), at(-0.99, 0.3), at(3.0, 1.0)], [0, 1, 17, 84]);
        assert_eq!([at(-9.0, -9.0), at(9.0, 9.0), at(f32::NAN, f32::NAN), at(f32::INFINITY, 0.0)], [0, 84, 0, 16]);
        let flat = Grid::new(Aabb { min: Vec3::ONE, max: Vec3::ONE }, 7);
        assert_eq!((flat.len(), *flat.at(Vec3::ZERO), *flat.at(Vec3::splat(5.0))), (1, 7, 7));
    }
}
