//! The Cryptomatte layers of a picture.

/// The names that a Cryptomatte distinguishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatteKind {
    /// Objects, by their names in the model.
    Object,
    /// Materials, by their names.
    Material,
}

impl MatteKind {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Object, Self::Material];

    /// Its name in options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Material => "material",
        }
    }

    /// The name of its layer in a picture.
    pub fn layer(self) -> &'static str {
        match self {
            Self::Object => "CryptoObject",
            Self::Material => "CryptoMaterial",
        }
    }
}

/// The Cryptomatte layers of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cryptomatte {
    /// The kinds of names, each once.
    pub kinds: Vec<MatteKind>,
    /// The most names of a pixel of the picture, by coverage. A film has all.
    pub levels: u32,
}

impl Cryptomatte {
    /// The most levels.
    pub const MAX_LEVELS: u32 = 64;
}

impl Default for Cryptomatte {
    fn default() -> Self {
        Self { kinds: Vec::new(), levels: 6 }
    }
}
