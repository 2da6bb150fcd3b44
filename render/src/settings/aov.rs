//! AOVs by light path expressions.

use super::Invalid;
use crate::lpe::Expression;

/// Light of some paths, in channels of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Aov {
    /// Its channels are called `name.R`, `name.G` and `name.B`.
    pub name: String,
    /// The expression of the paths.
    pub expression: Expression,
}

/// Names that pictures have for other channels, and the beginnings of such.
const TAKEN: [&str; 18] = [
    "R", "G", "B", "A", "P", "N", "Ns", "u", "v", "Albedo", "Variance", "HalfA", "HalfB", "Noisy", "UV", "Depth", "Id",
    "Samples",
];
const BEGINNINGS: [&str; 2] = ["Crypto", "Light_"];
const LONGEST: usize = 64;

impl Aov {
    /// An AOV of this name by this expression.
    ///
    /// # Errors
    /// If channels cannot be called so, or the text is no expression.
    pub fn new(name: &str, text: &str) -> Result<Self, Invalid> {
        let is_plain = |character: char| character.is_ascii_alphanumeric() || "_-".contains(character);
        if name.is_empty() || name.len() > LONGEST || !name.chars().all(is_plain) {
            return Err(Invalid::new(
                format!("{name:?} is no name of an AOV"),
                format!("write 1 to {LONGEST} of A-Z, a-z, 0-9, _ and -"),
            ));
        }
        if TAKEN.contains(&name) || BEGINNINGS.iter().any(|beginning| name.starts_with(beginning)) {
            let problem = format!("{name:?} is the name of other channels");
            return Err(Invalid::new(problem, "choose another name, for example diffuse"));
        }
        let expression = Expression::parse(text).map_err(|error| {
            let (problem, remedy) = error.parts();
            Invalid::new(problem, remedy)
        })?;
        Ok(Self { name: name.to_owned(), expression })
    }

    /// `NAME=EXPRESSION`.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new), and if it has no `=`.
    pub fn parse(text: &str) -> Result<Self, Invalid> {
        let Some((name, expression)) = text.split_once('=') else {
            return Err(Invalid::new(
                format!("{text:?} has no name"),
                "write NAME=EXPRESSION, for example diffuse='C<RD>.*L'",
            ));
        };
        Self::new(name.trim(), expression.trim())
    }
}
