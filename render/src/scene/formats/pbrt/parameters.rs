//! Parameter lists: `"type name" value` or `"type name" [ values ]`, any number of them after a directive.

use std::cell::Cell;

use glam::{Vec2, Vec3};

use super::tokens::{At, Kind, Tokens};
use crate::scene::SceneError;

/// The types, each with the values that it needs at least and of which it takes multiples.
const TYPES: [(&str, usize); 17] = [
    ("integer", 1),
    ("float", 1),
    ("point2", 2),
    ("vector2", 2),
    ("point3", 3),
    ("vector3", 3),
    ("normal3", 3),
    ("point", 3),
    ("vector", 3),
    ("normal", 3),
    ("rgb", 3),
    ("blackbody", 1),
    ("spectrum", 1),
    ("bool", 1),
    ("string", 1),
    ("texture", 1),
    ("color", 3),
];

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Numbers(Vec<f32>),
    Integers(Vec<i32>),
    Flags(Vec<bool>),
    Words(Vec<String>),
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(list) => list.len(),
            Self::Integers(list) => list.len(),
            Self::Flags(list) => list.len(),
            Self::Words(list) => list.len(),
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Parameter {
    /// One of the types, without the numbers of `point3` and its like.
    pub(super) kind: &'static str,
    pub(super) name: String,
    pub(super) values: Values,
    pub(super) at: At,
    /// Whether it was read.
    used: Cell<bool>,
}

/// The parameters of a directive.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    /// As messages call it: `Shape "sphere"`.
    pub(super) of: String,
    pub(super) at: At,
    list: Vec<Parameter>,
}

impl Parameters {
    /// The list that comes next, up to the next directive.
    pub(super) fn read(of: String, at: At, tokens: &mut Tokens) -> Result<Self, SceneError> {
        let mut list = Vec::new();
        while let Some(token) = tokens.peek()?.filter(|token| token.kind == Kind::String) {
            tokens.next()?;
            let at = tokens.at(token.line);
            let declaration = token.text();
            let mut words = declaration.split_ascii_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                let problem = format!("{} is not a type and a name", token.shown());
                return Err(at.error(problem, "write `\"float radius\" 2` or `\"rgb L\" [ 1 1 1 ]`"));
            };
            let Some(&(kind, _)) = TYPES.iter().find(|(known, _)| *known == kind) else {
                let problem = format!("`{kind}` of `{name}` is not a type of parameters");
                let remedy = crate::scene::nearest::suggestion(kind, &TYPES.map(|(kind, _)| kind));
                return Err(at.error(problem, remedy));
            };
            let values = read_values(kind, name, &at, tokens)?;
            list.push(Parameter { kind, name: name.to_owned(), values, at, used: Cell::new(false) });
        }
        Ok(Self { of, at, list })
    }

    /// Adds one that an `Attribute` directive gave, unless it is there.
    pub(super) fn add_default(&mut self, default: &Parameter) {
        if !self.has(&default.name) {
            // The parameter may not apply to this directive.
            default.used.set(true);
            self.list.push(default.clone());
        }
    }

    pub(super) fn into_list(self) -> Vec<Parameter> {
        self.list
    }

    /// The parameters that were not read.
    pub(super) fn unused(&self) -> impl Iterator<Item = &Parameter> {
        self.list.iter().filter(|parameter| !parameter.used.get())
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.list.iter().any(|parameter| parameter.name == name)
    }

    /// The parameter of this name.
    pub(super) fn get(&self, name: &str) -> Option<&Parameter> {
        let found = self.list.iter().find(|parameter| parameter.name == name)?;
        found.used.set(true);
        Some(found)
    }

    /// Says that these need no warning.
    pub(super) fn ignore(&self, names: &[&str]) {
        names.iter().for_each(|name| _ = self.get(name));
    }

    fn numbers(&self, name: &str, kinds: &[&str]) -> Result<Option<&[f32]>, SceneError> {
        let Some(found) = self.get(name) else { return Ok(None) };
        match &found.values {
            Values::Numbers(numbers) if kinds.contains(&found.kind) => Ok(Some(numbers)),
            _ => Err(self.wrong_kind(found, kinds[0])),
        }
    }

    fn wrong_kind(&self, found: &Parameter, kind: &str) -> SceneError {
        let problem = format!("`{}` of {} is of type {}, not {kind}", found.name, self.of, found.kind);
        found.at.error(problem, format!("write `\"{kind} {}\"`", found.name))
    }

    fn one<'a, T>(&self, name: &str, values: &'a [T]) -> Result<&'a T, SceneError> {
        match values {
            [one] => Ok(one),
            _ => {
                let at = self.get(name).map_or(&self.at, |found| &found.at);
                Err(at.error(format!("`{name}` of {} has {} values", self.of, values.len()), "give it one value"))
            }
        }
    }

    pub(super) fn floats(&self, name: &str) -> Result<Option<&[f32]>, SceneError> {
        self.numbers(name, &["float"])
    }

    pub(super) fn optional_float(&self, name: &str) -> Result<Option<f32>, SceneError> {
        self.floats(name)?.map(|values| self.one(name, values).copied()).transpose()
    }

    pub(super) fn float(&self, name: &str, default: f32) -> Result<f32, SceneError> {
        Ok(self.optional_float(name)?.unwrap_or(default))
    }

    /// A number of more than 0.
    pub(super) fn positive(&self, name: &str, default: f32) -> Result<f32, SceneError> {
        let number = self.float(name, default)?;
        if number > 0.0 {
            return Ok(number);
        }
        let at = self.get(name).map_or(&self.at, |found| &found.at);
        Err(at.error(format!("`{name}` of {} is {number}", self.of), "write a number of more than 0"))
    }

    pub(super) fn integers(&self, name: &str) -> Result<Option<&[i32]>, SceneError> {
        let Some(found) = self.get(name) else { return Ok(None) };
        match &found.values {
            Values::Integers(list) => Ok(Some(list)),
            _ => Err(self.wrong_kind(found, "integer")),
        }
    }

    pub(super) fn integer(&self, name: &str, default: i32) -> Result<i32, SceneError> {
        self.integers(name)?.map_or(Ok(default), |values| self.one(name, values).copied())
    }

    pub(super) fn flag(&self, name: &str, default: bool) -> Result<bool, SceneError> {
        let Some(found) = self.get(name) else { return Ok(default) };
        match &found.values {
            Values::Flags(list) => self.one(name, list).copied(),
            _ => Err(self.wrong_kind(found, "bool")),
        }
    }

    pub(super) fn texts(&self, name: &str) -> Result<Option<&[String]>, SceneError> {
        let Some(found) = self.get(name) else { return Ok(None) };
        match &found.values {
            Values::Words(list) if found.kind == "string" => Ok(Some(list)),
            _ => Err(self.wrong_kind(found, "string")),
        }
    }

    pub(super) fn text(&self, name: &str) -> Result<Option<&str>, SceneError> {
        self.texts(name)?.map(|list| self.one(name, list).map(String::as_str)).transpose()
    }

    pub(super) fn points(&self, name: &str) -> Result<Option<Vec<Vec3>>, SceneError> {
        let kinds = ["point3", "point", "vector3", "vector", "normal3", "normal"];
        let Some(numbers) = self.numbers(name, &kinds)? else { return Ok(None) };
        Ok(Some(numbers.chunks_exact(3).map(Vec3::from_slice).collect()))
    }

    pub(super) fn point(&self, name: &str, default: Vec3) -> Result<Vec3, SceneError> {
        self.points(name)?.map_or(Ok(default), |points| self.one(name, &points).copied())
    }

    pub(super) fn points2(&self, name: &str) -> Result<Option<Vec<Vec2>>, SceneError> {
        // Older files have them as floats.
        let kinds = ["point2", "vector2", "float"];
        let Some(numbers) = self.numbers(name, &kinds)? else { return Ok(None) };
        if numbers.len() % 2 == 1 {
            let at = self.get(name).map_or(&self.at, |found| &found.at);
            return Err(at.error(format!("`{name}` of {} has an odd number of values", self.of), "write two a vertex"));
        }
        Ok(Some(numbers.chunks_exact(2).map(Vec2::from_slice).collect()))
    }
}

fn read_values(kind: &str, name: &str, at: &At, tokens: &mut Tokens) -> Result<Values, SceneError> {
    let (mut numbers, mut integers, mut flags, mut words) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let is_list = tokens.peek()?.is_some_and(|token| token.kind == Kind::Open);
    if is_list {
        tokens.next()?;
    }
    let missing = || at.error(format!("`{name}` has no value"), format!("write `\"{kind} {name}\" [ values ]`"));
    loop {
        let Some(token) = tokens.next()? else {
            let remedy = "close the list of values with `]`";
            return Err(if is_list {
                at.error(format!("the values of `{name}` do not end"), remedy)
            } else {
                missing()
            });
        };
        let place = tokens.at(token.line);
        if token.kind == Kind::Close && is_list {
            break;
        }
        if matches!(token.kind, Kind::Open | Kind::Close) {
            let problem = format!("{} does not belong in the values of `{name}`", token.shown());
            return Err(place.error(problem, "write the values in one pair of brackets"));
        }
        let wrong = |what: &str| {
            place.error(format!("{} of `{name}` is not {what}", token.shown()), format!("`{name}` is of type {kind}"))
        };
        match kind {
            "string" | "texture" => match token.kind {
                Kind::String => words.push(token.text()),
                _ => return Err(wrong("a string in quotes")),
            },
            "spectrum" if token.kind == Kind::String => words.push(token.text()),
            "bool" => match token.raw() {
                "true" => flags.push(true),
                "false" => flags.push(false),
                _ => return Err(wrong("`true` or `false`")),
            },
            _ if token.kind == Kind::String => return Err(wrong("a number")),
            "integer" => match token.raw().parse() {
                Ok(number) => integers.push(number),
                Err(_) => return Err(wrong("a whole number")),
            },
            _ => match token.raw().parse::<f32>() {
                Ok(number) if number.is_finite() => numbers.push(number),
                Ok(_) => return Err(wrong("finite")),
                Err(_) => return Err(wrong("a number")),
            },
        }
        if !is_list {
            break;
        }
    }
    let values = match kind {
        "string" | "texture" => Values::Words(words),
        "spectrum" if numbers.is_empty() => Values::Words(words),
        "bool" => Values::Flags(flags),
        "integer" => Values::Integers(integers),
        _ if !words.is_empty() => {
            return Err(at.error(format!("`{name}` mixes names and numbers"), "write one of them"));
        }
        _ => Values::Numbers(numbers),
    };
    if values.len() == 0 {
        return Err(missing());
    }
    let each = TYPES.iter().find(|(known, _)| *known == kind).map_or(1, |(_, each)| *each);
    if !values.len().is_multiple_of(each) {
        let problem = format!("`{name}` has {} values, which is no multiple of {each}", values.len());
        return Err(at.error(problem, format!("write {each} numbers for each {kind}")));
    }
    Ok(values)
}
