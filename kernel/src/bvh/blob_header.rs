//! The common part of the headers of trees' and scenes' blobs: one cache line, which begins with a magic number, the
//! byte order and the version, and ends with a checksum.

use bytemuck::AnyBitPattern;

use crate::error::Error;

/// The marker of the byte order.
pub(crate) const BYTE_ORDER: u32 = 0x0102_0304;

/// Bytes of a header: one cache line.
pub(crate) const HEADER: usize = 64;

/// The header of a kind of blob, of [`HEADER`] bytes.
pub(crate) trait BlobHeader: AnyBitPattern {
    /// The first bytes.
    const MAGIC: [u8; 8];
    /// The only version that is read.
    const VERSION: u32;
    /// The error for bytes with another magic number.
    const NOT_THIS: Error;

    fn byte_order(&self) -> u32;
    fn version(&self) -> u32;
    fn checksum(&self) -> u32;

    /// The length of the blob in bytes.
    fn blob_len(&self) -> u64;

    /// The header of a blob of the right length.
    ///
    /// # Errors
    /// [`NOT_THIS`](Self::NOT_THIS), [`Error::Truncated`], [`Error::WrongEndianness`], [`Error::BadHeader`],
    /// [`Error::UnsupportedVersion`] and [`Error::TrailingBytes`].
    fn read(bytes: &[u8]) -> Result<Self, Error> {
        let start = bytes.get(..Self::MAGIC.len()).unwrap_or(bytes);
        if !Self::MAGIC.starts_with(start) {
            return Err(Self::NOT_THIS);
        }
        let found = bytes.len() as u64;
        let Some(header) = bytes.get(..HEADER) else {
            return Err(Error::Truncated { needed: HEADER as u64, found });
        };
        let header: Self = bytemuck::pod_read_unaligned(header);
        match header.byte_order() {
            BYTE_ORDER => {}
            order if order == BYTE_ORDER.swap_bytes() => return Err(Error::WrongEndianness),
            _ => return Err(Error::BadHeader { field: "byte order" }),
        }
        if header.version() != Self::VERSION {
            return Err(Error::UnsupportedVersion { found: header.version(), readable: Self::VERSION });
        }
        let needed = header.blob_len();
        match found {
            _ if found < needed => Err(Error::Truncated { needed, found }),
            _ if found > needed => Err(Error::TrailingBytes { needed, found }),
            _ => Ok(header),
        }
    }

    /// # Errors
    /// [`Error::Damaged`].
    fn check_sum(&self, bytes: &[u8]) -> Result<(), Error> {
        let (stored, computed) = (self.checksum(), checksum(bytes));
        if computed == stored { Ok(()) } else { Err(Error::Damaged { stored, computed }) }
    }
}

/// The checksum of a blob, or of what will be one when the checksum is in its place: the last word of its header.
pub(crate) fn checksum(bytes: &[u8]) -> u32 {
    let mut crc = crc32fast::Hasher::new();
    crc.update(&bytes[..HEADER - 4]);
    crc.update(&bytes[HEADER..]);
    crc.finalize()
}
