//! Errors of pictures, and limits on their size.

/// The most pixels across or down; a picture with more is refused before memory is asked for.
const MAX_SIDE: u32 = 1 << 16;

/// The most bytes that one picture may take while it is decoded.
pub(super) const MAX_BYTES: u64 = 4 << 30;

/// The problem and the remedy, as in an error of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TextureError {
    pub(crate) problem: String,
    pub(crate) remedy: &'static str,
    /// Whether the file is of a kind that is not read at all, instead of damaged.
    pub(crate) is_unknown_kind: bool,
}

impl TextureError {
    /// The error of a picture of a known kind.
    pub(super) fn wrong(problem: String, remedy: &'static str) -> Self {
        Self { problem, remedy, is_unknown_kind: false }
    }

    /// Refuses a picture without pixels, and one that takes more `bytes` than may be.
    pub(super) fn check_size(width: u32, height: u32, bytes: u64) -> Result<(), Self> {
        if width == 0 || height == 0 {
            return Err(Self::wrong(format!("it has {width} x {height} pixels"), "give it one pixel at least"));
        }
        if width > MAX_SIDE || height > MAX_SIDE || bytes > MAX_BYTES {
            let gigabytes = bytes as f64 / f64::from(1 << 30);
            let problem = format!("its {width} x {height} pixels take {gigabytes:.1} GiB");
            return Err(Self::wrong(problem, "make it smaller: 65536 pixels across and 4 GiB at most"));
        }
        Ok(())
    }
}
