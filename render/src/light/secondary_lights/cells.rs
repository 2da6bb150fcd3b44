//! Cells of triangles: a triangle divided by lines parallel to its edges into `side²` congruent ones.
//!
//! Row `j` lies between the lines where the barycentric coordinate `v` is `j/side` and `(j + 1)/side`. It has
//! `2 (side - j) - 1` cells, every other one upside down.

use glam::Vec2;

/// A triangle's division into cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Division {
    /// Cells along each edge, at least 1.
    pub side: u32,
}

impl Division {
    /// The number of cells.
    pub(crate) fn count(self) -> u32 {
        self.side * self.side
    }

    /// The cell of a point with the barycentric coordinates `(u, v)`.
    #[inline(always)]
    pub(crate) fn cell_at(self, place: Vec2) -> u32 {
        let scaled = (place * self.side as f32).max(Vec2::ZERO);
        let row = (scaled.y as u32).min(self.side - 1);
        let column = (scaled.x as u32).min(self.side - 1 - row);
        let rest = scaled - Vec2::new(column as f32, row as f32);
        let is_upper = rest.element_sum() > 1.0 && column + row + 1 < self.side;
        row * (2 * self.side - row) + 2 * column + u32::from(is_upper)
    }

    /// The barycentric coordinates of each cell's corners, in the cells' order.
    pub(crate) fn corners(self) -> impl Iterator<Item = [Vec2; 3]> {
        let step = (self.side as f32).recip();
        let point = move |column: u32, row: u32| Vec2::new(column as f32, row as f32) * step;
        (0..self.side).flat_map(move |row| {
            (0..2 * (self.side - row) - 1).map(move |place| {
                let column = place / 2;
                match place % 2 {
                    0 => [point(column, row), point(column + 1, row), point(column, row + 1)],
                    _ => [point(column + 1, row + 1), point(column, row + 1), point(column + 1, row)],
                }
            })
        })
    }
}

/// The point of a cell with these corners that has these coordinates there.
#[inline(always)]
pub(crate) fn place_in(corners: &[Vec2; 3], coordinates: Vec2) -> Vec2 {
    let [a, b, c] = *corners;
    a + (b - a) * coordinates.x + (c - a) * coordinates.y
}

#[cfg(test)]
mod tests {
    use halfdome_kernel::sampling::Stream;

    use super::*;

    /// Whether a point is in the triangle with these corners, but for rounding.
    fn is_in([a, b, c]: [Vec2; 3], place: Vec2) -> bool {
        [(a, b), (b, c), (c, a)].iter().all(|(from, to)| (to - from).perp_dot(place - from) > -1e-6)
    }

    #[test]
    fn cells_cover_the_triangle_and_know_their_points() {
        for side in [1, 2, 3, 7, 64] {
            let division = Division { side };
            let cells: Vec<_> = division.corners().collect();
            assert_eq!(cells.len() as u32, division.count());
            let area = |[a, b, c]: [Vec2; 3]| 0.5 * (b - a).perp_dot(c - a);
            for (number, &cell) in (0..).zip(&cells) {
                assert!((area(cell) * (side * side) as f32 - 0.5).abs() < 1e-3, "of one size and one orientation");
                assert_eq!(division.cell_at(place_in(&cell, Vec2::splat(1.0 / 3.0))), number);
            }
            for i in 0..1000 {
                let [x, y] = Stream::new(side.into(), i, 0).uniform2(0).to_array();
                let place = if x + y > 1.0 { Vec2::new(1.0 - x, 1.0 - y) } else { Vec2::new(x, y) };
                assert!(is_in(cells[division.cell_at(place) as usize], place), "{place}");
            }
        }
    }

    #[test]
    fn borders_belong_to_a_cell() {
        let division = Division { side: 5 };
        for place in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::splat(0.5), Vec2::new(0.6, 0.4), Vec2::new(-1e-9, 1.0)] {
            assert!(division.cell_at(place) < division.count(), "{place}");
        }
    }
}
