//! Reads parts of large files on many threads, and returns them in order.

use rayon::prelude::*;

/// Whole lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Block<'a> {
    pub(super) bytes: &'a [u8],
    /// The number of the first line.
    pub(super) line: usize,
    /// How many there are.
    pub(super) lines: usize,
}

impl<'a> Block<'a> {
    /// All lines of a file.
    pub(super) fn whole(bytes: &'a [u8]) -> Self {
        Self { bytes, line: 1, lines: line_count(bytes) }
    }

    /// The first `lines` lines and the others; `None` if there are no others.
    pub(crate) fn split_at(self, lines: usize) -> Option<(Self, Self)> {
        let others = self.lines.checked_sub(lines).filter(|others| *others > 0)?;
        let length: usize = self.bytes.split_inclusive(|byte| *byte == b'\n').take(lines).map(<[u8]>::len).sum();
        let (first, rest) = self.bytes.split_at(length);
        let line = self.line + lines;
        Some((Self { bytes: first, lines, ..self }, Self { bytes: rest, line, lines: others }))
    }
}

/// About how many bytes a block has.
const LENGTH: usize = 1 << 20;

/// Cuts `bytes`, which begin with the line of number `line`, into blocks. No block ends with a line that a backslash
/// continues.
pub(super) fn blocks(bytes: &[u8], line: usize) -> Vec<Block<'_>> {
    blocks_of(bytes, line, LENGTH)
}

fn blocks_of(mut bytes: &[u8], mut line: usize, length: usize) -> Vec<Block<'_>> {
    let mut parts = Vec::new();
    while !bytes.is_empty() {
        let mut end = length.min(bytes.len());
        // On to the end of a line.
        loop {
            end += bytes[end..].iter().position(|byte| *byte == b'\n').map_or(bytes.len() - end, |newline| newline + 1);
            if end == bytes.len() || bytes[..end].trim_ascii_end().last() != Some(&b'\\') {
                break;
            }
        }
        let (part, rest) = bytes.split_at(end);
        parts.push(part);
        bytes = rest;
    }
    let counts: Vec<usize> = parts.par_iter().map(|part| line_count(part)).collect();
    let with_lines = parts.into_iter().zip(counts).map(|(bytes, lines)| {
        line += lines;
        Block { bytes, line: line - lines, lines }
    });
    with_lines.collect()
}

/// The number of lines; the last one may lack its end.
fn line_count(bytes: &[u8]) -> usize {
    // Few at a time, so that a byte can count them, in vectors.
    let ends = |bytes: &[u8]| usize::from(bytes.iter().map(|byte| u8::from(*byte == b'\n')).sum::<u8>());
    let ends: usize = bytes.chunks(192).map(ends).sum();
    ends + usize::from(bytes.last().is_some_and(|last| *last != b'\n'))
}

/// Reads parts in parallel, a few at a time, and takes what they give in their order. The first error in that order
/// ends it.
pub(super) fn read_in_order<P: Sync, R: Send, E: Send>(
    parts: &[P],
    read: impl Fn(&P) -> Result<R, E> + Sync,
    mut take: impl FnMut(R) -> Result<(), E>,
) -> Result<(), E> {
    for few in parts.chunks(8 * rayon::current_num_threads()) {
        let read: Vec<Result<R, E>> = few.par_iter().map(&read).collect();
        read.into_iter().try_for_each(|part| take(part?))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_whole_lines() {
        let text = b"one\ntwo\n\nfour\nfive";
        let short = blocks_of(text, 1, 1);
        let lines: Vec<_> = short.iter().map(|block| (block.bytes, block.line, block.lines)).collect();
        let expected: [(&[u8], usize, usize); 5] =
            [(b"one\n", 1, 1), (b"two\n", 2, 1), (b"\nfour\n", 3, 2), (b"five", 5, 1), (b"", 0, 0)];
        assert_eq!(lines, expected[..4]);
        assert_eq!(blocks_of(text, 7, 100), [Block { bytes: text, line: 7, lines: 5 }]);
        assert_eq!(blocks_of(b"", 1, 1), []);
        let all = Block::whole(text);
        let (first, rest) = all.split_at(2).unwrap();
        assert_eq!((first.bytes, first.line, first.lines), (b"one\ntwo\n".as_slice(), 1, 2));
        assert_eq!((rest.bytes, rest.line, rest.lines), (b"\nfour\nfive".as_slice(), 3, 3));
        assert_eq!((all.split_at(5), all.split_at(6)), (None, None));
        let many = [b"\n".as_slice(); 1000].concat();
        assert_eq!(line_count(&many), 1000);
    }

    #[test]
    fn what_a_backslash_continues_stays_together() {
        let blocks = blocks_of(b"v 1 \\\r\n2 3\nv\\ \n\n4\nf", 1, 1);
        let lines: Vec<_> = blocks.iter().map(|block| (block.bytes, block.line)).collect();
        let expected: [(&[u8], usize); 3] = [(b"v 1 \\\r\n2 3\n", 1), (b"v\\ \n\n4\n", 3), (b"f", 6)];
        assert_eq!(lines, expected);
    }

    #[test]
    fn parts_are_taken_in_their_order_up_to_the_first_error() {
        let parts: Vec<usize> = (0..1000).collect();
        let mut taken = Vec::new();
        let read = |part: &usize| if *part == 700 || *part == 701 { Err(*part) } else { Ok(*part) };
        let end = read_in_order(&parts, read, |part| {
            taken.push(part);
            Ok(())
        });
        assert_eq!((end, taken), (Err(700), parts[..700].to_vec()));
    }
}
