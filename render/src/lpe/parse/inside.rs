//! The contents of `<…>`: a kind, scattering and labels, each a symbol or a list of them.

use super::{LpeError, Parser, Symbol};
use crate::lpe::event::{Choice, Letter, Pattern};

impl Parser<'_> {
    /// The contents of `<…>`.
    pub(super) fn event(&mut self) -> Result<Pattern, LpeError> {
        let mut pattern = Pattern::default();
        let mut place = 0;
        while !matches!(self.peek(), None | Some('>')) {
            match place {
                0 => pattern.kind = self.part(&kind_of)?,
                1 => pattern.scattering = self.part(&scattering_of)?,
                _ => {
                    let label = self.part(&label_of)?;
                    pattern.labels.push(label);
                }
            }
            place += 1;
            if let Some(repeat @ ('*' | '+' | '?' | '{')) = self.peek() {
                let problem = format!("`{repeat}` stands inside of <>");
                return self.fail(self.at, problem, "write it behind `>`: an event is repeated as a whole");
            }
        }
        Ok(pattern)
    }

    /// One place in `<…>`, whose symbols `read` gives; it names the valid symbols.
    fn part<T>(&mut self, read: &dyn Fn(Symbol) -> Result<Choice<T>, &'static str>) -> Result<Choice<T>, LpeError> {
        if self.peek() == Some('[') {
            let open = self.open()?;
            let excludes = self.takes('^');
            let mut choices = Vec::new();
            while !matches!(self.peek(), None | Some(']')) {
                let at = self.at;
                let choice = self.part(read)?;
                if excludes && !matches!(choice, Choice::Is(_)) {
                    return self.fail(
                        at,
                        "only symbols can be excluded",
                        "name the excluded symbols, for example [^DG]",
                    );
                }
                choices.push(choice);
            }
            self.close(open, ']')?;
            if choices.is_empty() {
                return self.fail(open, "this list is empty", "name what may be there, or write `.`");
            }
            let symbols = |choice| if let Choice::Is(symbol) = choice { Some(symbol) } else { None };
            return Ok(match excludes {
                true => Choice::Not(choices.into_iter().filter_map(symbols).collect()),
                false => Choice::AnyOf(choices),
            });
        }
        if let Some(bracket @ ('(' | '<' | '|')) = self.peek() {
            let problem = format!("`{bracket}` stands inside of <>");
            return self.fail(self.at, problem, "write alternatives as a list, for example <[RT]D>");
        }
        let at = self.at;
        let symbol = self.symbol()?;
        read(symbol).or_else(|remedy| {
            self.fail(at, "this symbol cannot stand here: <> has kind, scattering, labels, in this order", remedy)
        })
    }
}

fn kind_of(symbol: Symbol) -> Result<Choice<u8>, &'static str> {
    match symbol {
        Symbol::Any => Ok(Choice::Any),
        Symbol::Letter(Letter::Kind(kind)) => Ok(Choice::Is(kind)),
        Symbol::Letter(Letter::Scattering(_)) => Err("write a kind before it, one of C L O B R T V, or `.` for any"),
        Symbol::Label(_) => Err("write a kind and scattering before it, for example <L.'key'> or <RD'floor'>"),
    }
}

fn scattering_of(symbol: Symbol) -> Result<Choice<u8>, &'static str> {
    match symbol {
        Symbol::Any => Ok(Choice::Any),
        Symbol::Letter(Letter::Scattering(scattering)) => Ok(Choice::Is(scattering)),
        Symbol::Letter(Letter::Kind(_)) => {
            Err("write one of D G S s x or `.`; several kinds are a list, for example <[RT]D>")
        }
        Symbol::Label(_) => Err("write scattering before it, or `.` for any, for example <L.'key'>"),
    }
}

fn label_of(symbol: Symbol) -> Result<Choice<String>, &'static str> {
    match symbol {
        Symbol::Any => Ok(Choice::Any),
        Symbol::Label(label) => Ok(Choice::Is(label)),
        Symbol::Letter(_) => Err(
            "write a 'label' in quotes, or close the event with `>`; several letters are a list, for example <R[DG]>",
        ),
    }
}
