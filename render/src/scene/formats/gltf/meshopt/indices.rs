//! Streams of indices: of triangles, and of other primitives.

use super::stream::{CUT, Reader, unzigzag};

/// Edges and vertices that were used lately.
struct Lately<T> {
    ring: [T; 16],
    next: usize,
}

impl<T: Copy + Default> Lately<T> {
    fn new() -> Self {
        Self { ring: [T::default(); 16], next: 0 }
    }

    fn push(&mut self, item: T) {
        self.ring[self.next % 16] = item;
        self.next += 1;
    }

    /// The item that was pushed `back` ago, 1 for the latest.
    fn back(&self, back: usize) -> T {
        self.ring[(self.next + 16 - back) % 16]
    }
}

/// Corners of triangles that share edges with those before.
pub(super) fn triangles(data: &[u8], count: usize) -> Result<Vec<u32>, String> {
    let mut reader = Reader::new(data, 0xe1)?;
    let codes = reader.take(count)?;
    let (rest, table) = reader.rest.split_last_chunk::<16>().ok_or(CUT)?;
    reader.rest = rest;
    let (mut edges, mut vertices) = (Lately::<[u32; 2]>::new(), Lately::<u32>::new());
    // The number of vertices so far, and the last that was written out.
    let (mut new, mut last) = (0_u32, 0_u32);
    let next_new = |new: &mut u32| {
        *new = new.wrapping_add(1);
        new.wrapping_sub(1)
    };
    let mut corners = Vec::with_capacity(3 * count);
    for &code in codes {
        let (high, low) = (usize::from(code >> 4), usize::from(code & 15));
        if high < 15 {
            let [a, b] = edges.back(1 + high);
            let c = match low {
                0 => next_new(&mut new),
                1..=12 => vertices.back(1 + low),
                13 => last.wrapping_sub(1),
                14 => last.wrapping_add(1),
                _ => last.wrapping_add(unzigzag(reader.varint()?)),
            };
            if low == 0 || low > 12 {
                vertices.push(c);
            }
            if low > 12 {
                last = c;
            }
            corners.extend([a, b, c]);
            edges.push([c, b]);
            edges.push([a, c]);
            continue;
        }
        let (first, others) = match low {
            14 | 15 => (if low == 14 { 0 } else { 15 }, reader.byte()?),
            low => (0, table[low]),
        };
        if low >= 14 && others == 0 {
            new = 0;
        }
        let kinds = [first, usize::from(others >> 4), usize::from(others & 15)];
        // All that is new is counted before what is written out is read, and the ring stays as it is meanwhile.
        let mut triangle = kinds.map(|kind| match kind {
            0 => next_new(&mut new),
            15 => 0,
            back => vertices.back(back),
        });
        for (corner, kind) in triangle.iter_mut().zip(kinds) {
            if kind == 15 {
                last = last.wrapping_add(unzigzag(reader.varint()?));
                *corner = last;
            }
        }
        for (corner, kind) in triangle.into_iter().zip(kinds) {
            if matches!(kind, 0 | 15) {
                vertices.push(corner);
            }
        }
        let [a, b, c] = triangle;
        corners.extend(triangle);
        edges.push([b, a]);
        edges.push([c, b]);
        edges.push([a, c]);
    }
    Ok(corners)
}

/// Indices as differences to one of two that went before.
pub(super) fn indices(data: &[u8], count: usize) -> Result<Vec<u32>, String> {
    let mut reader = Reader::new(data, 0xd1)?;
    let mut last = [0_u32; 2];
    let mut indices = Vec::new();
    for _ in 0..count {
        let code = reader.varint()?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(unzigzag(code >> 1));
        indices.push(*last);
    }
    Ok(indices)
}
