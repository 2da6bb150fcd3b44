//! Parts of triangles that are lights of their own: cells of a triangle that is divided by lines parallel to its edges into
//! `side²` congruent ones, or by lines parallel to one edge into slices.
//!
//! Row `j` of congruent cells lies between the lines where the barycentric coordinate `v` is `j/side` and `(j + 1)/side`. It
//! has `2 (side - j) - 1` cells, every other one upside down.
//!
//! Slice `i` of `n` lies between the parts `i/n` and `(i + 1)/n` of the way from the corner opposite that edge. The first is
//! a triangle, a diagonal divides each other one into two cells.

use glam::Vec2;
use halfdome_kernel::Triangle;

/// A triangle's division into cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Division {
    /// Congruent ones, so many along each edge: at least 1.
    Congruent { side: u32 },
    /// Those of slices parallel to the edge opposite a corner, at least 1.
    Slices { corner: u32, count: u32 },
}

impl Division {
    /// Into one cell.
    pub(crate) const WHOLE: Self = Self::Congruent { side: 1 };

    /// The number of cells.
    pub(crate) fn count(self) -> u32 {
        match self {
            Self::Congruent { side } => side * side,
            Self::Slices { count, .. } => 2 * count - 1,
        }
    }

    /// The cell of a point with the barycentric coordinates `(u, v)`.
    #[inline(always)]
    pub(crate) fn cell_at(self, place: Vec2) -> u32 {
        match self {
            Self::Congruent { side } => congruent_cell(side, place),
            Self::Slices { corner, count } => cell_of_slice(corner, count, place),
        }
    }

    /// The barycentric coordinates of each cell's corners, in the cells' order.
    pub(crate) fn corners(self) -> Vec<[Vec2; 3]> {
        match self {
            Self::Congruent { side } => congruent_cells(side),
            Self::Slices { corner, count } => cells_of_slices(corner, count),
        }
    }
}

#[inline(always)]
fn congruent_cell(side: u32, place: Vec2) -> u32 {
    let scaled = (place * side as f32).max(Vec2::ZERO);
    let row = (scaled.y as u32).min(side - 1);
    let column = (scaled.x as u32).min(side - 1 - row);
    let rest = scaled - Vec2::new(column as f32, row as f32);
    let is_upper = rest.element_sum() > 1.0 && column + row + 1 < side;
    row * (2 * side - row) + 2 * column + u32::from(is_upper)
}

fn congruent_cells(side: u32) -> Vec<[Vec2; 3]> {
    let step = (side as f32).recip();
    let point = move |column: u32, row: u32| Vec2::new(column as f32, row as f32) * step;
    let cell = move |row: u32, place: u32| {
        let column = place / 2;
        match place % 2 {
            0 => [point(column, row), point(column + 1, row), point(column, row + 1)],
            _ => [point(column + 1, row + 1), point(column, row + 1), point(column + 1, row)],
        }
    };
    (0..side).flat_map(|row| (0..2 * (side - row) - 1).map(move |place| cell(row, place))).collect()
}

/// The cell of a point, of which two barycentric coordinates belong to the corners after `corner`.
fn cell_of_slice(corner: u32, count: u32, place: Vec2) -> u32 {
    let [u, v] = place.to_array();
    let [x, y] = match corner {
        0 => [u, v],
        1 => [v, 1.0 - u - v],
        _ => [1.0 - u - v, u],
    }
    .map(|weight| weight.max(0.0) * count as f32);
    let slice = ((x + y) as u32).min(count - 1);
    let [near, far] = [slice, slice + 1].map(|line| line as f32);
    2 * slice - u32::from(slice > 0 && x * far + y * near > near * far)
}

fn cells_of_slices(corner: u32, count: u32) -> Vec<[Vec2; 3]> {
    let [from, along, across] = [0, 1, 2].map(|next| [Vec2::ZERO, Vec2::X, Vec2::Y][(corner as usize + next) % 3]);
    let line = |number: u32| {
        let part = number as f32 / count as f32;
        [along, across].map(|end| from + (end - from) * part)
    };
    let slice = |number: u32| {
        let ([a, b], [c, d]) = (line(number), line(number + 1));
        // Of the first slice, the second of these is a point.
        [[a, c, d], [a, d, b]]
    };
    (0..count).flat_map(|number| slice(number).into_iter().take(if number == 0 { 1 } else { 2 })).collect()
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

    /// The part of the triangle's edges that it extends over, if it is as long in all directions.
    fn extent(&self) -> f32 {
        (self.places[1].x - self.places[0].x).abs()
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
        match division {
            Division::Congruent { side } if part.extent() * side as f32 > 1.5 => {
                part.quarters().iter().for_each(|quarter| self.set(quarter, (division, first), number));
            }
            _ => self.cells[(first + division.cell_at(part.middle())) as usize] = number,
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
        let congruent = [1, 2, 3, 7, 64].map(|side| Division::Congruent { side });
        let slices = [(0, 1), (0, 5), (1, 2), (2, 16)].map(|(corner, count)| Division::Slices { corner, count });
        for division in congruent.into_iter().chain(slices) {
            let cells = division.corners();
            assert_eq!(cells.len() as u32, division.count());
            let area = |[a, b, c]: [Vec2; 3]| 0.5 * (b - a).perp_dot(c - a);
            assert!((cells.iter().copied().map(area).sum::<f32>() - 0.5).abs() < 1e-5);
            for (number, &cell) in (0..).zip(&cells) {
                match division {
                    Division::Congruent { side } => assert!((area(cell) * (side * side) as f32 - 0.5).abs() < 1e-3),
                    Division::Slices { .. } => assert!(area(cell) > 0.0, "of one orientation"),
                }
                let part = TrianglePart { prim_id: 0, places: cell };
                assert_eq!(division.cell_at(part.middle()), number);
                let coordinates = Vec2::new(0.2, 0.7);
                assert!(part.coordinates(part.place(coordinates)).abs_diff_eq(coordinates, 1e-3));
            }
            for i in 0..1000 {
                let [x, y] = Stream::new(u64::from(division.count()), i, 0).uniform2(0).to_array();
                let place = if x + y > 1.0 { Vec2::new(1.0 - x, 1.0 - y) } else { Vec2::new(x, y) };
                assert!(is_in(cells[division.cell_at(place) as usize], place), "{place}");
            }
        }
    }

    #[test]
    fn points_find_their_parts() {
        let division_of = |prim_id: u32| Division::Congruent { side: if prim_id == 3 { 4 } else { 1 } };
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
        let places = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::splat(0.5), Vec2::new(0.6, 0.4), Vec2::new(-1e-9, 1.0)];
        let slices = [0, 1, 2].map(|corner| Division::Slices { corner, count: 5 });
        for division in slices.into_iter().chain([Division::Congruent { side: 5 }]) {
            assert!(places.iter().all(|place| division.cell_at(*place) < division.count()), "{division:?}");
        }
    }
}
