//! Arguments between a directive and its parameters: strings and numbers.

use super::tokens::{At, Kind, Token, Tokens};
use crate::scene::SceneError;

/// The string that a directive needs.
pub(super) fn string(name: &str, at: &At, tokens: &mut Tokens) -> Result<String, SceneError> {
    let found = tokens.next()?;
    let (at, problem) = match found {
        Some(token) if token.kind == Kind::String => return Ok(token.text()),
        Some(token) => (tokens.at(token.line), format!("{} follows `{name}`, not a string", token.shown())),
        None => (at.clone(), format!("the file ends after `{name}`")),
    };
    Err(at.error(problem, format!("write `{name} \"...\"`")))
}

/// The numbers that a directive needs, in brackets or not.
pub(super) fn numbers<const N: usize>(name: &str, at: &At, tokens: &mut Tokens) -> Result<[f64; N], SceneError> {
    let is_list = tokens.peek()?.is_some_and(|token| token.kind == Kind::Open);
    if is_list {
        tokens.next()?;
    }
    let too_few = |found: usize| {
        at.error(format!("`{name}` needs {N} numbers, but has {found}"), format!("write `{name}` and {N} numbers"))
    };
    let mut numbers = [0.0; N];
    for (found, number) in numbers.iter_mut().enumerate() {
        let token: Option<Token> = tokens.next()?;
        let value = token.filter(|token| token.kind == Kind::Word).and_then(|token| token.raw().parse::<f64>().ok());
        *number = value.filter(|number| number.is_finite()).ok_or_else(|| too_few(found))?;
    }
    if is_list && tokens.next()?.is_none_or(|token| token.kind != Kind::Close) {
        let problem = format!("the brackets of `{name}` hold more than {N} numbers");
        return Err(at.error(problem, format!("write {N} numbers in them")));
    }
    Ok(numbers)
}

/// Passes over all up to the next directive.
pub(super) fn skip(tokens: &mut Tokens) -> Result<(), SceneError> {
    let is_value = |token: &Token| {
        let is_name = token.raw().starts_with(|first: char| first.is_ascii_alphabetic());
        token.kind != Kind::Word || !is_name || ["true", "false"].contains(&token.raw())
    };
    while tokens.peek()?.is_some_and(|token| is_value(&token)) {
        tokens.next()?;
    }
    Ok(())
}
