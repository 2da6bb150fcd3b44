//! Parts of triangles that are lights of their own: cells of a triangle that is divided by lines parallel to its edges into
//! `side²` congruent ones.
//!
//! Row `j` lies between the lines where the barycentric coordinate `v` is `j/side` and `(j + 1)/side`. It has
//! `2 (side - j) - 1` cells, every other one upside down.

use glam::Vec2;
use halfdome_kernel::Triangle;

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

/// A triangle of the scene, or a cell of one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TrianglePart {
    pub prim_id: u32,
    /// The barycentric coordinates `(u, v)` of its corners in the triangle.
    pub places: [Vec2; 3],
}

impl TrianglePart {
    /// The whole triangle.
    pub(crate) fn whole(prim_id: u32) -> Self {
        Self { prim_id, places: [Vec2::ZERO, Vec2::X, Vec2::Y] }
    }

    /// The barycentric coordinates in the triangle of a point that has these in the part.
    #[inline(always)]
    pub(crate) fn place(&self, coordinates: Vec2) -> Vec2 {
        let [a, b, c] = self.places;
        a + (b - a) * coordinates.x + (c - a) * coordinates.y
    }

    /// The inverse of [`place`](Self::place).
    #[inline(always)]
    pub(crate) fn coordinates(&self, place: Vec2) -> Vec2 {
        let [a, b, c] = self.places;
        let (along, across, way) = (b - a, c - a, place - a);
        Vec2::new(way.perp_dot(across), along.perp_dot(way)) / along.perp_dot(across)
    }

    /// The four congruent parts between its corners and the middles of its edges.
    pub(crate) fn quarters(&self) -> [Self; 4] {
        let [a, b, c] = self.places;
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| 0.5 * (from + to));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]].map(|places| Self { places, ..*self })
    }

    /// The barycentric coordinates of its middle.
    pub(crate) fn middle(&self) -> Vec2 {
        self.place(Vec2::splat(1.0 / 3.0))
    }

    /// Its corners, where the triangle has these.
    pub(crate) fn corners(&self, triangle: &Triangle) -> Triangle {
        let [a, b, c] = *triangle;
        self.places.map(|place| a * (1.0 - place.x - place.y) + b * place.x + c * place.y)
    }
}

/// The value for what is no light.
const NO_LIGHT: u32 = u32::MAX;

/// Finds the part of a triangle that a point is in, by its number.
#[derive(Debug, Default)]
pub(crate) struct PartTable {
    /// For each `prim_id` its number among the triangles that have parts, or [`NO_LIGHT`]; empty if there are none.
    divided: Vec<u32>,
    /// How each of these is divided, and its first cell.
    divisions: Vec<(Division, u32)>,
    /// The number of the part that each cell belongs to, or [`NO_LIGHT`].
    cells: Vec<u32>,
}

impl PartTable {
    /// The table of these parts in a scene of `triangles` triangles. A part is a cell of its triangle, or has four times as
    /// many as each of its [quarters](TrianglePart::quarters).
    pub(crate) fn new<'p>(
        parts: impl Iterator<Item = &'p TrianglePart>,
        division_of: impl Fn(u32) -> Division,
        triangles: usize,
    ) -> Self {
        let mut table = Self::default();
        for (number, part) in (0..).zip(parts) {
            table.divided.resize(triangles, NO_LIGHT);
            let of_triangle = &mut table.divided[part.prim_id as usize];
            if *of_triangle == NO_LIGHT {
                *of_triangle = table.divisions.len() as u32;
                let division = division_of(part.prim_id);
                table.divisions.push((division, table.cells.len() as u32));
                table.cells.resize(table.cells.len() + division.count() as usize, NO_LIGHT);
            }
            let (division, first) = table.divisions[*of_triangle as usize];
            table.set(part, (division, first), number);
        }
        table
    }

    /// Lets the cells of a part have its number.
    fn set(&mut self, part: &TrianglePart, (division, first): (Division, u32), number: u32) {
        if (part.places[1].x - part.places[0].x).abs() * (division.side as f32) < 1.5 {
            self.cells[(first + division.cell_at(part.middle())) as usize] = number;
        } else {
            part.quarters().iter().for_each(|quarter| self.set(quarter, (division, first), number));
        }
    }

    /// The number of the part at a point of triangle `prim_id` with these barycentric coordinates.
    #[inline(always)]
    pub(crate) fn at(&self, prim_id: u32, place: Vec2) -> Option<u32> {
        let &number = self.divided.get(prim_id as usize).filter(|number| **number != NO_LIGHT)?;
        let (division, first) = self.divisions[number as usize];
        let part = self.cells[(first + division.cell_at(place)) as usize];
        (part != NO_LIGHT).then_some(part)
    }
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
                let part = TrianglePart { prim_id: 0, places: cell };
                assert_eq!(division.cell_at(part.middle()), number);
                let coordinates = Vec2::new(0.2, 0.7);
                assert!(part.coordinates(part.place(coordinates)).abs_diff_eq(coordinates, 1e-3));
            }
            for i in 0..1000 {
                let [x, y] = Stream::new(side.into(), i, 0).uniform2(0).to_array();
                let place = if x + y > 1.0 { Vec2::new(1.0 - x, 1.0 - y) } else { Vec2::new(x, y) };
                assert!(is_in(cells[division.cell_at(place) as usize], place), "{place}");
            }
        }
    }

    #[test]
    fn points_find_their_parts() {
        let division_of = |prim_id: u32| Division { side: if prim_id == 3 { 4 } else { 1 } };
        // A quarter, and the cells of two others.
        let [large, rest @ ..] = TrianglePart::whole(3).quarters();
        let cells = rest[1..].iter().flat_map(TrianglePart::quarters);
        let parts: Vec<_> = [TrianglePart::whole(1), large].into_iter().chain(cells).collect();
        let table = PartTable::new(parts.iter(), division_of, 5);
        for i in 0..1000 {
            let [x, y] = Stream::new(1, i, 0).uniform2(0).to_array();
            let place = if x + y > 1.0 { Vec2::new(1.0 - x, 1.0 - y) } else { Vec2::new(x, y) };
            assert_eq!([0, 1, 2, 4].map(|prim_id| table.at(prim_id, place)), [None, Some(0), None, None]);
            let of = |part: &&TrianglePart| part.prim_id == 3 && is_in(part.places, place);
            let found = table.at(3, place).map(|number| parts[number as usize].middle());
            assert_eq!(found, parts.iter().find(of).map(TrianglePart::middle), "{place}");
        }
        assert_eq!(PartTable::default().at(0, Vec2::ZERO), None);
        // Of a whole triangle coordinates are the same to the bit.
        let place = Vec2::new(0.123_456_7, 0.654_321);
        assert_eq!([parts[0].place(place), parts[0].coordinates(place)], [place; 2]);
    }

    #[test]
    fn borders_belong_to_a_cell() {
        let division = Division { side: 5 };
        for place in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::splat(0.5), Vec2::new(0.6, 0.4), Vec2::new(-1e-9, 1.0)] {
            assert!(division.cell_at(place) < division.count(), "{place}");
        }
    }
}
