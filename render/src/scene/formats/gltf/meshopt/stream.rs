//! The bytes of a stream, read in order.

/// The reader of a stream.
pub(super) struct Reader<'a> {
    pub(super) rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// The stream after its first byte, which must be `header`.
    pub(super) fn new(data: &'a [u8], header: u8) -> Result<Self, String> {
        match data.split_first() {
            Some((&first, rest)) if first == header => Ok(Self { rest }),
            Some((first, _)) => Err(format!("its stream begins with {first:#x} instead of {header:#x}")),
            None => Err(CUT.to_owned()),
        }
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(CUT)?;
        self.rest = rest;
        Ok(taken)
    }

    pub(super) fn byte(&mut self) -> Result<u8, String> {
        self.take(1).map(|bytes| bytes[0])
    }

    /// A number of seven bits a byte, the lowest first.
    pub(super) fn varint(&mut self) -> Result<u32, String> {
        let mut number = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f).wrapping_shl(shift);
            if byte < 0x80 {
                break;
            }
        }
        Ok(number)
    }
}

pub(super) const CUT: &str = "its stream is cut short";

/// A difference whose lowest bit is its sign.
pub(super) fn unzigzag(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}
