//! Parses light path expressions, as Open Shading Language does:
//!
//! ```text
//! expression = { item }
//! item       = atom { "*" | "+" | "?" | "{n}" | "{n,}" | "{n,m}" } { "|" item }
//! atom       = "." | letter | 'label' | "(" expression ")" | "[" { item } "]" | "[^" { letter | label } "]" | event
//! event      = "<" [ part [ part { part } ] ] ">"          kind, scattering, labels
//! part       = "." | letter | 'label' | "[" { part } "]" | "[^" { letter | label } "]"
//! ```
//!
//! So `|` joins the items right before and behind it alone. A letter outside of `<>` is an event with that kind or
//! scattering, a label one with that first label. Labels may stand between `"` too. `?` is not in Open Shading
//! Language, and neither are errors for symbols where they can mean nothing, as in `<DR>`.

mod inside;

use std::fmt;

use super::Node;
use super::event::{Choice, Letter, Pattern, letter};

/// The most repetitions that a range may ask for.
const MAX_REPEATS: u32 = 64;
/// The deepest nesting of brackets, and the most repetitions of one item.
const MAX_NESTED: usize = 64;

/// Why a text is no light path expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LpeError {
    text: String,
    /// Bytes before the place that it is about.
    at: usize,
    problem: String,
    remedy: String,
}

impl LpeError {
    /// What is wrong, with the expression and a mark under the place; and what would be right.
    pub fn parts(&self) -> (String, &str) {
        if self.text.trim().is_empty() {
            return (self.problem.clone(), &self.remedy);
        }
        let before = self.text[..self.at].chars().count();
        (format!("{}\n    {}\n    {:before$}^", self.problem, self.text, ""), &self.remedy)
    }
}

impl fmt::Display for LpeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (problem, remedy) = self.parts();
        write!(f, "{problem}\n  help: {remedy}")
    }
}

impl std::error::Error for LpeError {}

pub(super) fn parse(text: &str) -> Result<Node, LpeError> {
    let mut parser = Parser { text, at: 0, nested: 0 };
    if text.trim().is_empty() {
        return parser.fail(0, "there is no expression", "write one, for example C<RD>.*L");
    }
    let node = parser.sequence()?;
    match parser.peek() {
        None => Ok(node),
        Some(closing) => parser.fail(
            parser.at,
            format!("`{closing}` closes nothing"),
            "leave it out, or write the bracket that it closes",
        ),
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    /// Open brackets.
    nested: usize,
}

/// The pattern of one symbol.
enum Symbol {
    Any,
    Letter(Letter),
    Label(String),
}

/// A list of symbols that are excluded: of one sort.
enum Excluded {
    Kinds(Vec<u8>),
    Scatterings(Vec<u8>),
    Labels(Vec<String>),
}

const LETTERS: &str = "write one of C L O B R T V (kinds), D G S s x (scattering), `.`, or a 'label'";

impl Parser<'_> {
    fn fail<T>(&self, at: usize, problem: impl Into<String>, remedy: impl Into<String>) -> Result<T, LpeError> {
        Err(LpeError { text: self.text.to_owned(), at, problem: problem.into(), remedy: remedy.into() })
    }

    /// The next character that is not a blank.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    /// Whether this character is next, which is then taken.
    fn takes(&mut self, character: char) -> bool {
        let is_next = self.peek() == Some(character);
        self.at += if is_next { character.len_utf8() } else { 0 };
        is_next
    }

    fn close(&mut self, open: usize, end: char) -> Result<(), LpeError> {
        self.nested -= 1;
        if self.takes(end) {
            return Ok(());
        }
        let opening = &self.text[open..=open];
        self.fail(open, format!("this `{opening}` is not closed"), format!("write `{end}` where it ends"))
    }

    fn open(&mut self) -> Result<usize, LpeError> {
        self.nested += 1;
        if self.nested > MAX_NESTED {
            return self.fail(self.at, "brackets are nested too deep", format!("nest at most {MAX_NESTED}"));
        }
        self.at += 1;
        Ok(self.at - 1)
    }

    /// Items up to the end or a closing bracket.
    fn sequence(&mut self) -> Result<Node, LpeError> {
        let mut items = Vec::new();
        while let Some(next) = self.peek() {
            match next {
                ')' | ']' | '>' | '}' => break,
                '|' => return self.fail(self.at, "there is nothing before this `|`", "write an item on both sides"),
                _ => items.push(self.item()?),
            }
        }
        Ok(Node::Sequence(items))
    }

    /// An item, with those that `|` joins to it.
    fn item(&mut self) -> Result<Node, LpeError> {
        let mut items = vec![self.repeated()?];
        while self.takes('|') {
            if matches!(self.peek(), None | Some(')' | ']' | '>' | '}' | '|')) {
                return self.fail(self.at - 1, "there is nothing behind this `|`", "write an item on both sides");
            }
            items.push(self.repeated()?);
        }
        Ok(if items.len() == 1 { items.remove(0) } else { Node::Either(items) })
    }

    fn repeated(&mut self) -> Result<Node, LpeError> {
        let mut node = self.atom()?;
        for _ in 0..MAX_NESTED {
            let (least, most) = match self.peek() {
                Some('*') => (0, None),
                Some('+') => (1, None),
                Some('?') => (0, Some(1)),
                Some('{') => {
                    let (least, most) = self.range()?;
                    node = Node::Repeat(Box::new(node), least, most);
                    continue;
                }
                _ => return Ok(node),
            };
            self.at += 1;
            node = Node::Repeat(Box::new(node), least, most);
        }
        self.fail(self.at, "too many repetitions follow one another", format!("write fewer than {MAX_NESTED}"))
    }

    /// `{n}`, `{n,}` or `{n,m}`.
    fn range(&mut self) -> Result<(u32, Option<u32>), LpeError> {
        let open = self.at;
        self.at += 1;
        let least = self.number();
        let most = if self.takes(',') { self.number() } else { least };
        let is_bounded = least == most || most.is_some();
        let fits = |number: Option<u32>| number.is_none_or(|number| number <= MAX_REPEATS);
        match least {
            Some(number) if self.takes('}') && fits(least) && fits(most) && most.is_none_or(|most| most >= number) => {
                Ok((number, if is_bounded { most } else { None }))
            }
            _ => self.fail(
                open,
                "this is no range",
                format!("write {{n}}, {{n,}} or {{n,m}} with n at most m, and both at most {MAX_REPEATS}"),
            ),
        }
    }

    fn number(&mut self) -> Option<u32> {
        self.peek();
        let digits = self.text[self.at..].bytes().take_while(u8::is_ascii_digit).count();
        let number = &self.text[self.at..][..digits];
        self.at += digits;
        number.parse().ok().or((digits > 0).then_some(u32::MAX))
    }

    fn atom(&mut self) -> Result<Node, LpeError> {
        match self.peek() {
            Some('(') => {
                let open = self.open()?;
                let node = self.sequence()?;
                self.close(open, ')')?;
                Ok(node)
            }
            Some('[') => {
                let open = self.open()?;
                if self.takes('^') {
                    let excluded = self.excluded()?;
                    self.close(open, ']')?;
                    return Ok(Node::Event(match excluded {
                        Excluded::Kinds(kinds) => Pattern { kind: Choice::Not(kinds), ..Pattern::default() },
                        Excluded::Scatterings(not) => Pattern { scattering: Choice::Not(not), ..Pattern::default() },
                        Excluded::Labels(labels) => Pattern { labels: vec![Choice::Not(labels)], ..Pattern::default() },
                    }));
                }
                let Node::Sequence(items) = self.sequence()? else { unreachable!("a sequence is one") };
                self.close(open, ']')?;
                if items.is_empty() {
                    return self.fail(open, "this list is empty", "write what may be there, for example [LO]");
                }
                Ok(Node::Either(items))
            }
            Some('<') => {
                let open = self.open()?;
                let pattern = self.event()?;
                self.close(open, '>')?;
                Ok(Node::Event(pattern))
            }
            _ => Ok(Node::Event(match self.symbol()? {
                Symbol::Any => Pattern::default(),
                Symbol::Letter(Letter::Kind(kind)) => Pattern { kind: Choice::Is(kind), ..Pattern::default() },
                Symbol::Letter(Letter::Scattering(it)) => Pattern { scattering: Choice::Is(it), ..Pattern::default() },
                Symbol::Label(label) => Pattern { labels: vec![Choice::Is(label)], ..Pattern::default() },
            })),
        }
    }

    fn symbol(&mut self) -> Result<Symbol, LpeError> {
        let start = self.at;
        match self.peek() {
            None => self.fail(self.at, "the expression ends here", LETTERS),
            Some('.') => {
                self.at += 1;
                Ok(Symbol::Any)
            }
            Some(quote @ ('\'' | '"')) => {
                let start = self.at;
                let Some(length) = self.text[start + 1..].find(quote) else {
                    return self.fail(start, "this label has no end", format!("write {quote} behind it"));
                };
                self.at = start + length + 2;
                Ok(Symbol::Label(self.text[start + 1..][..length].to_owned()))
            }
            Some(character) => match letter(character) {
                Some(letter) => {
                    self.at += 1;
                    Ok(Symbol::Letter(letter))
                }
                None if "*+?{".contains(character) => self.fail(
                    self.at,
                    format!("`{character}` has nothing before it to repeat"),
                    "write it behind an event; repetitions stand outside of <>",
                ),
                None => self.fail(self.at.max(start), format!("`{character}` is no symbol"), LETTERS),
            },
        }
    }

    /// The symbols of `[^…]`, all of one sort.
    fn excluded(&mut self) -> Result<Excluded, LpeError> {
        let (mut kinds, mut scatterings, mut labels) = (Vec::new(), Vec::new(), Vec::new());
        let start = self.at;
        while !matches!(self.peek(), None | Some(']')) {
            let at = self.at;
            match self.symbol()? {
                Symbol::Any => return self.fail(at, "`.` excludes all", "name the excluded symbols, for example [^L]"),
                Symbol::Letter(Letter::Kind(kind)) => kinds.push(kind),
                Symbol::Letter(Letter::Scattering(scattering)) => scatterings.push(scattering),
                Symbol::Label(label) => labels.push(label),
            }
        }
        match (kinds.is_empty(), scatterings.is_empty(), labels.is_empty()) {
            (false, true, true) => Ok(Excluded::Kinds(kinds)),
            (true, false, true) => Ok(Excluded::Scatterings(scatterings)),
            (true, true, false) => Ok(Excluded::Labels(labels)),
            (true, true, true) => self.fail(
                start - 1,
                "this list excludes nothing",
                "name the excluded symbols, for example [^L], or write `.`",
            ),
            _ => self.fail(
                start - 1,
                "this list mixes kinds, scattering and labels",
                "exclude each at its place, for example <[^T][^S]'floor'>",
            ),
        }
    }
}
