//! The statements of OBJ and MTL: a line with a keyword and words after it.
//!
//! A backslash at the end of a line continues it; a comment starts with `#` and is never continued, since comments hold
//! Windows paths. Numbers end at a word that starts with `#`, names do not ("Material #25" is a common one). Names need
//! not be UTF-8: invalid bytes become U+FFFD.

use std::borrow::Cow;
use std::path::Path;

use super::blocks::Block;
use super::decimal;
use crate::scene::{Place, SceneError};

/// A line, continuation lines included.
pub(super) struct Statement<'a> {
    file: &'a Path,
    line: usize,
    text: Cow<'a, [u8]>,
    /// The length of the keyword.
    keyword: usize,
}

/// The statements of a block in order, without blank lines and comments. A line that is not text is an error; `format`
/// names the format there ("an OBJ file").
pub(super) fn statements<'a>(
    file: &'a Path,
    block: Block<'a>,
    format: &'static str,
) -> impl Iterator<Item = Result<Statement<'a>, SceneError>> {
    let mut lines = block.bytes.split(|&byte| byte == b'\n').zip(block.line..);
    // Looked up all at once, in vectors; comments may have them.
    let has_binary = block.bytes.iter().fold(false, |found, &byte| found | is_binary(byte));
    core::iter::from_fn(move || {
        loop {
            let (first, line) = lines.next()?;
            let mut text = Cow::Borrowed(first.trim_ascii());
            if text.starts_with(b"#") {
                continue;
            }
            while text.ends_with(b"\\") {
                let joined = text.to_mut();
                joined.pop();
                joined.push(b' ');
                let Some((next, _)) = lines.next() else { break };
                joined.extend_from_slice(next.trim_ascii());
            }
            if text.trim_ascii().is_empty() {
                continue;
            }
            let keyword = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
            let statement = Statement { file, line, text, keyword };
            return Some(if has_binary && statement.text.iter().copied().any(is_binary) {
                Err(statement.error(
                    format!("this is not {format}: the line holds binary data"),
                    "name a text file, saved as UTF-8 or ASCII",
                ))
            } else {
                Ok(statement)
            });
        }
    })
}

/// Whether `byte` occurs in no kind of text: a control character other than blanks and the DOS end-of-file mark.
fn is_binary(byte: u8) -> bool {
    matches!(byte, 0..=8 | 0xe..=0x19 | 0x1b..=0x1f | 0x7f)
}

impl Statement<'_> {
    /// The first word.
    pub(super) fn keyword(&self) -> &[u8] {
        &self.text[..self.keyword]
    }

    /// All after the keyword, as text.
    pub(crate) fn name(&self) -> String {
        String::from_utf8_lossy(self.text[self.keyword..].trim_ascii()).into_owned()
    }

    /// The words after the keyword, up to a comment.
    pub(super) fn words(&self) -> impl Iterator<Item = &[u8]> {
        let words = self.text[self.keyword..].split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        words.take_while(|word| !word.starts_with(b"#"))
    }

    /// `word` as a finite number.
    pub(crate) fn number(&self, word: &[u8]) -> Result<f32, SceneError> {
        match decimal::parse(word) {
            Some(number) if number.is_finite() => Ok(number),
            Some(_) => Err(self.error(
                format!("`{}` is not a finite number", shown(word)),
                "every number must be finite and in the range of single precision",
            )),
            None => Err(self.error(
                format!("`{}` is not a number", shown(word)),
                "write numbers like 2, -0.5 or 1e-3, with spaces between them",
            )),
        }
    }

    /// The first `N` words as finite numbers; further words do not matter.
    pub(crate) fn numbers<const N: usize>(&self) -> Result<[f32; N], SceneError> {
        if let Some(numbers) = self.quick_numbers() {
            return Ok(numbers);
        }
        let mut numbers = [0.0; N];
        let mut words = self.words();
        for (found, number) in numbers.iter_mut().enumerate() {
            let word = words.next().ok_or_else(|| self.too_few(found, N))?;
            *number = self.number(word)?;
        }
        Ok(numbers)
    }

    /// The same where all is as most programs write it.
    pub(super) fn quick_numbers<const N: usize>(&self) -> Option<[f32; N]> {
        let mut numbers = [0.0; N];
        let mut rest = &self.text[self.keyword..];
        for number in &mut numbers {
            rest = rest.trim_ascii_start();
            let (found, length) = decimal::prefix(rest)?;
            *number = found;
            rest = &rest[length..];
            if rest.first().is_some_and(|next| !next.is_ascii_whitespace()) {
                return None;
            }
        }
        Some(numbers)
    }

    fn too_few(&self, found: usize, needed: usize) -> SceneError {
        let keyword = shown(self.keyword());
        let numbers = if needed == 1 { "one number" } else { &format!("{needed} numbers") };
        self.error(
            format!("`{keyword}` needs {numbers}, but {found} follow{}", if found == 1 { "s" } else { "" }),
            format!("write `{keyword}` and {numbers}"),
        )
    }

    /// An error at this line.
    pub(crate) fn error(&self, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(self.file, Place::Line(self.line), problem, remedy)
    }

    /// The number of the line that it begins on.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// A warning about this line.
    pub(super) fn warning(&self, text: impl std::fmt::Display) -> String {
        format!("{}:{}: {text}", self.file.display(), self.line)
    }
}

/// `word` as text for a message, cut if it is long.
pub(super) fn shown(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(word);
    if text.chars().count() <= LONGEST {
        return text.into_owned();
    }
    text.chars().take(LONGEST).chain(['…']).collect()
}
