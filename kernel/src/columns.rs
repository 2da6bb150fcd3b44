//! Transposes rows into columns and back: a row is one record in memory, such as a ray or a triangle with its data, and
//! a column is one field of many records, side by side in lanes.
//!
//! The compiler vectorises plain loops over columns, but writing columns word by word takes a store for each word. Here
//! eight rows at a time are loaded, transposed in registers, and stored as eight parts of columns. Only bits are moved:
//! rows may hold integers as well as floats.

use crate::simd::{Isa, Lanes, Simd, Work, dispatch};

/// A row of eight words.
pub type Row = [f32; 8];

/// The first words of `LANES` rows, then their second words, and so on.
pub type Columns<const LANES: usize> = [[f32; LANES]; 8];

/// Rows that are transposed together.
const EIGHT: usize = 8;

/// Writes the rows of `table` of `indices` to the columns' lanes, in order; each row has `PARTS` times
/// eight words. Indices beyond the table give zeros, `indices` beyond the lanes are ignored, and the lanes after the
/// last row are unspecified.
pub fn load<const PARTS: usize, const LANES: usize>(
    isa: Isa,
    table: &[[Row; PARTS]],
    indices: &[u32],
    columns: &mut [Columns<LANES>; PARTS],
) {
    dispatch(isa, Load { table, indices, columns });
}

/// Writes the rows of those lanes for which `keeps` is not 0 to the start of `rows`, in order. `keeps` has an element
/// for each of the first lanes of `columns`. Returns the number of rows; the rows after them, up to the number of
/// lanes, are unspecified. Rows beyond the end of `rows` are dropped.
pub fn compress<const WIDTH: usize, const LANES: usize>(
    isa: Isa,
    columns: &[[f32; LANES]; WIDTH],
    keeps: &[u32],
    rows: &mut [[f32; WIDTH]],
) -> usize {
    dispatch(isa, Compress { columns, keeps, rows })
}

struct Load<'a, const PARTS: usize, const LANES: usize> {
    table: &'a [[Row; PARTS]],
    indices: &'a [u32],
    columns: &'a mut [Columns<LANES>; PARTS],
}

impl<const PARTS: usize, const LANES: usize> Work for Load<'_, PARTS, LANES> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { table, indices, columns } = self;
        const { assert!(LANES.is_multiple_of(EIGHT)) }
        let (eights, rest) = indices.as_chunks::<EIGHT>();
        for (group, eight) in eights.iter().enumerate() {
            load_eight::<S, PARTS, LANES>(table, eight, group, columns);
        }
        if !rest.is_empty() {
            let mut eight = [u32::MAX; EIGHT];
            for (index, &last) in eight.iter_mut().zip(rest) {
                *index = last;
            }
            load_eight::<S, PARTS, LANES>(table, &eight, eights.len(), columns);
        }
    }
}

/// Writes eight rows to the lanes from `8 * group` on.
#[inline(always)]
fn load_eight<S: Simd, const PARTS: usize, const LANES: usize>(
    table: &[[Row; PARTS]],
    indices: &[u32; EIGHT],
    group: usize,
    columns: &mut [Columns<LANES>; PARTS],
) {
    for (part, columns) in columns.iter_mut().enumerate() {
        let mut rows = [S::F8::splat(0.0); EIGHT];
        for (row, &index) in rows.iter_mut().zip(indices) {
            if let Some(found) = table.get(index as usize) {
                *row = S::F8::load(&found[part]);
            }
        }
        for (column, lanes) in columns.iter_mut().zip(S::transpose(rows)) {
            if let Some(place) = column.as_chunks_mut().0.get_mut(group) {
                *place = lanes.store();
            }
        }
    }
}

struct Compress<'a, const WIDTH: usize, const LANES: usize> {
    columns: &'a [[f32; LANES]; WIDTH],
    keeps: &'a [u32],
    rows: &'a mut [[f32; WIDTH]],
}

impl<const WIDTH: usize, const LANES: usize> Work for Compress<'_, WIDTH, LANES> {
    type Output = usize;
    #[inline(always)]
    fn run<S: Simd>(self) -> usize {
        const { assert!(WIDTH <= EIGHT && LANES.is_multiple_of(EIGHT)) }
        let mut kept = 0;
        for (group, keeps) in self.keeps.chunks(EIGHT).enumerate().take(LANES / EIGHT) {
            let mut columns = [S::F8::splat(0.0); EIGHT];
            for (lanes, column) in columns.iter_mut().zip(self.columns) {
                if let Some(eight) = column.as_chunks().0.get(group) {
                    *lanes = S::F8::load(eight);
                }
            }
            let rows = S::transpose(columns);
            if let Ok(keeps) = <&[u32; EIGHT]>::try_from(keeps) {
                kept = compress_rows::<S, WIDTH>(&rows, keeps, self.rows, kept);
            } else {
                kept = compress_rows::<S, WIDTH>(&rows[..keeps.len()], keeps, self.rows, kept);
            }
        }
        kept.min(self.rows.len())
    }
}

/// Writes those of up to eight rows that are kept behind the first `kept` of `places`; gives how many there are then.
#[inline(always)]
fn compress_rows<S: Simd, const WIDTH: usize>(
    rows: &[S::F8],
    keeps: &[u32],
    places: &mut [[f32; WIDTH]],
    mut kept: usize,
) -> usize {
    for (row, &keep) in rows.iter().zip(keeps) {
        // Written in any case, and kept or written over: it is unpredictable which.
        if let Some(place) = places.get_mut(kept)
            && let Some(numbers) = row.store().first_chunk()
        {
            *place = *numbers;
        }
        kept += usize::from(keep != 0);
    }
    kept
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::sampling::Stream;
    use crate::simd::isas;

    const LANES: usize = 24;

    /// Any bits: NaN of both kinds are among them.
    fn row(number: u32) -> Row {
        let [a, b] = [0, 1].map(|set| Stream::new(1, number, 0).bits4(set).map(f32::from_bits));
        [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]]
    }

    fn bits<const N: usize>(numbers: [f32; N]) -> [u32; N] {
        numbers.map(f32::to_bits)
    }

    #[test]
    fn columns_have_the_bits_of_the_rows() {
        let table: Vec<[Row; 2]> = (0..100).map(|i| [row(2 * i), row(2 * i + 1)]).collect();
        for isa in isas() {
            for count in 0..=LANES + 3 {
                let indices: Vec<u32> = (0..count as u32).map(|i| i * 37 % 103).collect();
                let mut columns = [[[7.0; LANES]; 8]; 2];
                load(isa, &table, &indices, &mut columns);
                for (lane, &index) in indices.iter().enumerate().take(LANES) {
                    let expected = table.get(index as usize).copied().unwrap_or([[0.0; 8]; 2]);
                    let found = columns.map(|part| part.map(|column| column[lane]));
                    assert_eq!(found.map(bits), expected.map(bits), "{isa:?}, lane {lane} of {count}");
                }
            }
        }
    }

    #[test]
    fn rows_that_are_kept_come_back_in_order() {
        let all: Vec<Row> = (0..LANES as u32).map(row).collect();
        let columns: Columns<LANES> = core::array::from_fn(|c| core::array::from_fn(|lane| all[lane][c]));
        let narrow: [[f32; LANES]; 3] = core::array::from_fn(|c| columns[c + 2]);
        for isa in isas() {
            for count in 0..=LANES {
                // 0, 1 or another number.
                let keeps: Vec<u32> = (0..count).map(|i| Stream::new(2, i as u32, 0).bits4(0)[0] % 3).collect();
                let kept = all.iter().zip(&keeps).filter(|(_, keep)| **keep > 0);
                let expected: Vec<&Row> = kept.map(|(row, _)| row).collect();
                let mut rows = [[0.0; 8]; LANES + 1];
                assert_eq!(compress(isa, &columns, &keeps, &mut rows), expected.len());
                let mut narrow_rows = [[0.0; 3]; LANES];
                assert_eq!(compress(isa, &narrow, &keeps, &mut narrow_rows), expected.len());
                for ((found, narrow), expected) in rows.iter().zip(&narrow_rows).zip(&expected) {
                    assert_eq!(bits(*found), bits(**expected), "{isa:?}, of {count}");
                    assert_eq!(bits(*narrow), bits([expected[2], expected[3], expected[4]]));
                }
                // Beyond the lanes nothing is written.
                assert!(rows[count..].iter().all(|row| *row == [0.0; 8]), "{isa:?}, {count}");
            }
        }
    }

    #[test]
    fn rows_without_a_place_are_left_out() {
        let columns: Columns<LANES> = core::array::from_fn(|c| [c as f32; LANES]);
        let mut rows = [[0.0; 8]; 5];
        assert_eq!(compress(Isa::detect(), &columns, &[1; LANES], &mut rows), 5);
        assert_eq!(rows, [[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]; 5]);
    }
}
