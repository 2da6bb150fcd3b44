//! The words of pbrt's text: bare words and numbers, strings in quotes, brackets, each with its line.
//!
//! A `#` outside of strings starts a comment. Strings end on their line; `\"` and `\\` stand for a quote and a
//! backslash.

use std::path::Path;
use std::rc::Rc;

use crate::scene::{Place, SceneError};

/// A place in a file.
#[derive(Clone, Debug)]
pub(super) struct At {
    pub(super) path: Rc<Path>,
    pub(super) line: usize,
}

impl At {
    pub(super) fn error(&self, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(&self.path, Place::Line(self.line), problem, remedy)
    }
}

/// The kind of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A directive, a number, `true` or `false`.
    Word,
    /// What stood in quotes, which are left out.
    String,
    Open,
    Close,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'a> {
    pub(super) kind: Kind,
    text: &'a [u8],
    pub(super) line: usize,
}

impl<'a> Token<'a> {
    /// The text of the file; empty if it is not UTF-8.
    pub(super) fn raw(&self) -> &'a str {
        str::from_utf8(self.text).unwrap_or_default()
    }

    /// The text, with escapes resolved.
    pub(super) fn text(&self) -> String {
        let mut text = String::from_utf8_lossy(self.text).into_owned();
        if self.kind == Kind::String && text.contains('\\') {
            text = text.replace("\\\"", "\"").replace("\\\\", "\\");
        }
        text
    }

    /// As messages show it.
    pub(super) fn shown(&self) -> String {
        let text = crate::scene::formats::statement::shown(self.text);
        if self.kind == Kind::String { format!("{text:?}") } else { format!("`{text}`") }
    }
}

/// The tokens of a file.
pub(super) struct Tokens<'a> {
    path: Rc<Path>,
    bytes: &'a [u8],
    next: usize,
    line: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(path: Rc<Path>, bytes: &'a [u8]) -> Self {
        Self { path, bytes, next: 0, line: 1 }
    }

    pub(super) fn at(&self, line: usize) -> At {
        At { path: self.path.clone(), line }
    }

    /// The next token, which stays the next one; `None` at the end.
    pub(super) fn peek(&mut self) -> Result<Option<Token<'a>>, SceneError> {
        let (next, line) = (self.next, self.line);
        let token = self.next()?;
        (self.next, self.line) = (next, line);
        Ok(token)
    }

    /// The next token; `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<Token<'a>>, SceneError> {
        self.skip_blanks();
        let (start, line) = (self.next, self.line);
        let Some(&first) = self.bytes.get(start) else { return Ok(None) };
        let (kind, text) = match first {
            b'[' | b']' => {
                self.next += 1;
                (if first == b'[' { Kind::Open } else { Kind::Close }, &self.bytes[start..start + 1])
            }
            b'"' => (Kind::String, self.string(line)?),
            _ => {
                let is_end = |byte: &u8| byte.is_ascii_whitespace() || b"\"[]#".contains(byte);
                let length = self.bytes[start..].iter().position(is_end).unwrap_or(self.bytes.len() - start);
                self.next += length;
                (Kind::Word, &self.bytes[start..self.next])
            }
        };
        if kind == Kind::Word && text.iter().any(|&byte| byte < b' ' || byte == 0x7f) {
            let remedy = "name a text file, saved as UTF-8 or ASCII";
            return Err(self.at(line).error("this is not a pbrt scene: the line holds binary data", remedy));
        }
        Ok(Some(Token { kind, text, line }))
    }

    fn string(&mut self, line: usize) -> Result<&'a [u8], SceneError> {
        let start = self.next + 1;
        let mut end = start;
        loop {
            match self.bytes.get(end) {
                Some(b'"') => break,
                Some(b'\\') => end += 2,
                Some(b'\n') | None => {
                    let begin = crate::scene::formats::statement::shown(
                        self.bytes[start..end.min(self.bytes.len())].trim_ascii(),
                    );
                    let problem = format!("the string \"{begin} does not end on its line");
                    return Err(self.at(line).error(problem, "close it with a quote (\")"));
                }
                Some(_) => end += 1,
            }
        }
        self.next = end + 1;
        Ok(&self.bytes[start..end])
    }

    fn skip_blanks(&mut self) {
        while let Some(&byte) = self.bytes.get(self.next) {
            match byte {
                b'\n' => self.line += 1,
                b'#' => {
                    let rest = &self.bytes[self.next..];
                    self.next += rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
                    continue;
                }
                byte if byte.is_ascii_whitespace() => {}
                _ => return,
            }
            self.next += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Result<Vec<(String, usize)>, SceneError> {
        let mut tokens = Tokens::new(Path::new("a.pbrt").into(), text.as_bytes());
        let mut list = Vec::new();
        while let Some(token) = tokens.next()? {
            list.push((token.text(), token.line));
        }
        Ok(list)
    }

    #[test]
    fn words_strings_and_brackets_with_their_lines() {
        let found = tokens("Shape \"a # b\" # \"c\n[1 -2]\r\n\"x \\\" y\"").unwrap();
        let expected = [("Shape", 1), ("a # b", 1), ("[", 2), ("1", 2), ("-2", 2), ("]", 2), ("x \" y", 3)];
        assert_eq!(found, expected.map(|(text, line)| (text.to_owned(), line)));
    }

    #[test]
    fn strings_end_on_their_line() {
        for text in ["a\n\"open", "a\n\"open\n\"", "a\n\"open\\"] {
            let error = tokens(text).unwrap_err();
            assert_eq!(error.place, Place::Line(2));
            assert!(error.problem.starts_with("the string \"open"), "{error}");
        }
    }
}
