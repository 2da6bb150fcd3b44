//! Streams of attributes.

use super::stream::{CUT, Reader, unzigzag};

/// Bytes in blocks of vertices; in a block, byte by byte of the stride, as differences to the vertex before.
pub(super) fn attributes(data: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    const GROUP: usize = 16;
    let mut reader = Reader::new(data, 0xa0)?;
    // The stream ends with the vertex before the first, padded at its start to 32 bytes.
    let tail = reader.rest.len().checked_sub(stride.max(32)).ok_or(CUT)?;
    let mut last = reader.rest[reader.rest.len() - stride..].to_vec();
    reader.rest = &reader.rest[..tail];
    let block_size = (8192 / stride / GROUP * GROUP).min(256);
    let mut bytes = Vec::new();
    while bytes.len() < count * stride {
        let start = bytes.len();
        let vertices = (count - start / stride).min(block_size);
        let groups = vertices.div_ceil(GROUP);
        bytes.resize(start + vertices * stride, 0);
        for (slot, previous) in last.iter_mut().enumerate() {
            let header = reader.take(groups.div_ceil(4))?;
            for group in 0..groups {
                let differences = group_of(&mut reader, (header[group / 4] >> (2 * (group % 4))) & 3)?;
                for (place, difference) in differences.into_iter().enumerate() {
                    let vertex = group * GROUP + place;
                    if vertex < vertices {
                        *previous = previous.wrapping_add(unzigzag(difference.into()) as u8);
                        bytes[start + vertex * stride + slot] = *previous;
                    }
                }
            }
        }
    }
    Ok(bytes)
}

/// Sixteen differences of 0, 2, 4 or 8 bits; the greatest of 2 or 4 bits stands for a byte that follows.
fn group_of(reader: &mut Reader, kind: u8) -> Result<[u8; 16], String> {
    let bits = match kind {
        0 => return Ok([0; 16]),
        3 => return Ok(reader.take(16)?.try_into().expect("sixteen bytes")),
        kind => 2 * usize::from(kind),
    };
    let packed = reader.take(2 * bits)?;
    let (per_byte, escape) = (8 / bits, (1 << bits) - 1);
    let mut group = [0; 16];
    for (place, number) in group.iter_mut().enumerate() {
        let shift = 8 - bits * (place % per_byte + 1);
        *number = (packed[place / per_byte] >> shift) & escape;
        if *number == escape {
            *number = reader.byte()?;
        }
    }
    Ok(group)
}
