//! Photometric files (`.ies`) by IES LM-63, of 1986, 1991, 1995, 2002 and 2019, with type C photometry.
//!
//! The reader takes the angles, the candela values, and their factors: the multiplier, the ballast factor and, in files
//! older than 1995, the ballast-lamp factor (reserved in later editions). `TILT=INCLUDE` says how a lamp dims when its
//! luminaire is tilted out of the measured position; it is skipped, and so are keywords, the luminaire's size, lumens
//! and watts.

use std::path::Path;

use crate::scene::description::profile::Profile;
use crate::scene::error::{Place, SceneError};

/// First lines, and their years. Files of 1986 have none.
const VERSIONS: [(&str, u32); 5] = [
    ("IESNA91", 1991),
    ("IESNA:LM-63-1991", 1991),
    ("IESNA:LM-63-1995", 1995),
    ("IESNA:LM-63-2002", 2002),
    ("IES:LM-63-2019", 2019),
];

/// More candela values than any luminaire has: a file with more is not what it says.
const MAX_VALUES: usize = 1 << 22;

/// The profile in `bytes`, which are the file at `path`.
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Profile, SceneError> {
    // Keywords may be in any encoding, and do not matter.
    let text = String::from_utf8_lossy(bytes);
    Parser::new(path, &text)?.profile()
}

/// The numbers of a file, with their lines.
struct Parser<'a> {
    path: &'a Path,
    tokens: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    /// The line of the last one.
    line: usize,
    year: u32,
    tilt: (usize, &'a str),
}

impl<'a> Parser<'a> {
    /// Reads the lines of words.
    fn new(path: &'a Path, text: &'a str) -> Result<Self, SceneError> {
        let error =
            |line, problem: String, remedy: &str| Err(SceneError::new(path, Place::Line(line), problem, remedy));
        let first = text.lines().next().unwrap_or_default().trim_start_matches('\u{feff}').trim();
        let known = VERSIONS.iter().find(|(name, _)| *name == first);
        if known.is_none() && first.starts_with("IES") {
            let names = VERSIONS.map(|(name, _)| name).join(", ");
            return error(1, format!("its version is {first:?}"), &format!("known are {names}, and none for 1986"));
        }
        let mut lines = (1..).zip(text.lines().map(str::trim));
        let Some((line, tilt)) = lines.find(|(_, line)| line.starts_with("TILT=")) else {
            return error(1, "it has no line TILT=".to_owned(), "name a photometric file by IES LM-63 (.ies)");
        };
        let tokens = lines.flat_map(|(number, line)| {
            let words = line.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
            words.map(move |word| (number, word))
        });
        let year = known.map_or(1986, |&(_, year)| year);
        Ok(Self { path, tokens: Box::new(tokens), line, year, tilt: (line, tilt["TILT=".len()..].trim()) })
    }

    fn error<T>(&self, line: usize, problem: String, remedy: &str) -> Result<T, SceneError> {
        Err(SceneError::new(self.path, Place::Line(line), problem, remedy))
    }

    fn number(&mut self, what: &str) -> Result<f64, SceneError> {
        let Some((line, word)) = self.tokens.next() else {
            let problem = format!("the file ends before {what}");
            return self.error(self.line, problem, "get the whole file");
        };
        self.line = line;
        match word.parse() {
            Ok(number) if f64::is_finite(number) => Ok(number),
            _ => self.error(line, format!("{what} is {word:?}"), "write a finite number"),
        }
    }

    fn numbers(&mut self, count: usize, what: &str) -> Result<Vec<f32>, SceneError> {
        (1..=count).map(|i| self.number(&format!("{what} {i} of {count}")).map(|number| number as f32)).collect()
    }

    fn count(&mut self, what: &str, least: usize) -> Result<usize, SceneError> {
        let number = self.number(what)?;
        if number.fract() == 0.0 && number >= least as f64 && number <= MAX_VALUES as f64 {
            return Ok(number as usize);
        }
        let remedy = match number > MAX_VALUES as f64 {
            true => format!("write a whole number from {least} to {MAX_VALUES}"),
            false => format!("write a whole number, {least} or more"),
        };
        self.error(self.line, format!("{what} is {number}"), &remedy)
    }

    fn factor(&mut self, what: &str) -> Result<f64, SceneError> {
        let number = self.number(what)?;
        if number >= 0.0 {
            return Ok(number);
        }
        self.error(self.line, format!("{what} is {number}"), "write a number of 0 or more")
    }

    /// Angles in order.
    fn angles(&mut self, count: usize, what: &str) -> Result<Vec<f32>, SceneError> {
        let mut angles: Vec<f32> = Vec::with_capacity(count);
        for i in 1..=count {
            let angle = self.number(&format!("{what} angle {i} of {count}"))? as f32;
            if let Some(&last) = angles.last().filter(|&&last| last >= angle) {
                let problem = format!("the {what} angle {angle} comes after {last}");
                return self.error(self.line, problem, "write angles in rising order");
            }
            angles.push(angle);
        }
        Ok(angles)
    }

    fn profile(mut self) -> Result<Profile, SceneError> {
        match self.tilt {
            (_, "NONE") => {}
            (_, "INCLUDE") => {
                self.number("the lamp's position in the luminaire")?;
                let pairs = self.count("the number of tilts", 0)?;
                self.numbers(pairs, "tilt")?;
                self.numbers(pairs, "the factor of tilt")?;
            }
            (line, other) => {
                let remedy = "write TILT=NONE, or TILT=INCLUDE and the numbers below it";
                return self.error(line, format!("its tilt is {other:?}, in another file"), remedy);
            }
        }
        self.number("the number of lamps")?;
        self.number("the lumens of a lamp")?;
        let mut factor = self.factor("the multiplier of candela")?;
        let vertical_count = self.count("the number of vertical angles", 2)?;
        let horizontal_count = self.count("the number of horizontal angles", 1)?;
        if vertical_count.saturating_mul(horizontal_count) > MAX_VALUES {
            let problem = format!("it has {vertical_count} times {horizontal_count} candela values");
            return self.error(self.line, problem, "name the file of a luminaire, which has fewer");
        }
        let kind = self.number("the type of photometry")?;
        if kind != 1.0 {
            let (problem, remedy) = match kind {
                2.0 => ("its photometry is of type B (2)".to_owned(), "convert it to type C (1)"),
                3.0 => ("its photometry is of type A (3)".to_owned(), "convert it to type C (1)"),
                _ => (format!("the type of photometry is {kind}"), "write 1, for type C"),
            };
            return self.error(self.line, problem, remedy);
        }
        for what in ["the unit of lengths", "the width", "the length", "the height"] {
            self.number(what)?;
        }
        factor *= self.factor("the ballast factor")?;
        let of_lamp = self.factor("the factor of ballast and lamp")?;
        factor *= if self.year < 1995 { of_lamp } else { 1.0 };
        self.number("the input watts")?;
        let vertical = self.angles(vertical_count, "vertical")?;
        self.check(&vertical, "vertical", &[[0.0, 90.0], [0.0, 180.0], [90.0, 180.0]])?;
        let horizontal = self.angles(horizontal_count, "horizontal")?;
        let whole = [[0.0, 0.0], [0.0, 90.0], [0.0, 180.0], [0.0, 360.0], [90.0, 270.0]];
        self.check(&horizontal, "horizontal", &whole)?;
        let mut rows = Vec::with_capacity(horizontal_count);
        for angle in &horizontal {
            let row = (1..=vertical_count).map(|i| {
                let what = format!("candela value {i} of {vertical_count} at {angle} degrees");
                self.factor(&what).map(|candela| (candela * factor) as f32)
            });
            rows.push(row.collect::<Result<Vec<_>, _>>()?);
        }
        if rows.iter().flatten().any(|candela| !candela.is_finite()) {
            return self.error(self.line, "its candela values are too great".to_owned(), "write a smaller multiplier");
        }
        Ok(Profile::new(vertical, horizontal, rows))
    }

    /// Angles go from one end to another.
    fn check(&self, angles: &[f32], what: &str, ranges: &[[f32; 2]]) -> Result<(), SceneError> {
        let [first, last] = [angles[0], angles[angles.len() - 1]];
        if ranges.contains(&[first, last]) {
            return Ok(());
        }
        let known: Vec<String> = ranges.iter().map(|[first, last]| format!("{first} to {last}")).collect();
        let problem = format!("the {what} angles go from {first} to {last}");
        self.error(self.line, problem, &format!("write angles in degrees, of type C: {}", known.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::description::profile::ProfileFrame;
    use glam::Vec3;

    const FRAME: ProfileFrame = ProfileFrame { axis: Vec3::NEG_Y, zero: Vec3::X };

    fn read(text: &str) -> Result<Profile, SceneError> {
        parse(Path::new("lamp.ies"), text.as_bytes())
    }

    fn down(text: &str) -> f32 {
        read(text).unwrap().candela(&FRAME, Vec3::NEG_Y)
    }

    /// Line, problem and remedy.
    fn told(text: &str) -> (usize, String, String) {
        let error = read(text).unwrap_err();
        let Place::Line(line) = error.place else { panic!("{error}") };
        assert_eq!(error.file, Path::new("lamp.ies"));
        (line, error.problem, error.remedy)
    }

    const BODY: &str = "1 1000 2 3 1 1 2 0.1 0.2 0\n0.5 0.25 60\n0 45 90\n0\n100, 50 0\n";

    #[test]
    fn all_versions_are_read_with_their_factors() {
        for (version, factor) in [("IESNA91\n", 0.25), ("IESNA:LM-63-1995\r\n", 1.0), ("IESNA:LM-63-2002\n", 1.0)] {
            let text = format!("{version}[TEST] caf\u{e9}\n[LAMP] x\nTILT=NONE\n{BODY}");
            assert_eq!(down(&text), 100.0 * 2.0 * 0.5 * factor, "{version}");
        }
        assert_eq!(down(&format!("A lamp of 1986\nTILT=NONE\n{BODY}")), 25.0);
        assert_eq!(down(&format!("IES:LM-63-2019\nTILT=INCLUDE\n1\n3\n0 30 60\n1 0.9 0.8\n{BODY}")), 100.0);
        // In any encoding, and with numbers on other lines.
        let mut bytes = format!("IESNA91\n[A] caf*\nTILT=NONE\n{}", BODY.replace(' ', "\n")).into_bytes();
        let star = bytes.iter().position(|&byte| byte == b'*').unwrap();
        bytes[star] = 0xe9;
        let profile = parse(Path::new("lamp.ies"), &bytes).unwrap();
        assert_eq!(profile.candela(&FRAME, Vec3::NEG_Y), 25.0);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let head = "IESNA91\nTILT=NONE\n";
        let (line, problem, remedy) = told("IESNA:LM-63-1985\nTILT=NONE\n");
        assert_eq!((line, problem.as_str()), (1, "its version is \"IESNA:LM-63-1985\""));
        assert!(remedy.starts_with("known are IESNA91, "));
        assert_eq!(told("a text\n").1, "it has no line TILT=");
        assert_eq!(told("").1, "it has no line TILT=");
        assert_eq!(told("IESNA91\n\nTILT=a.tlt\n").0, 3);
        for (from, to, line, problem, remedy) in [
            ("100, 50 0", "100, 50", 7, "the file ends before candela value 3 of 3 at 0 degrees", "get the whole file"),
            ("100, 50 0", "100, 5o 0", 7, "candela value 2 of 3 at 0 degrees is \"5o\"", "write a finite number"),
            ("100, 50 0", "100, nan 0", 7, "candela value 2 of 3 at 0 degrees is \"nan\"", "write a finite number"),
            ("100, 50 0", "100 -50 0", 7, "candela value 2 of 3 at 0 degrees is -50", "write a number of 0 or more"),
            ("0 45 90", "0 95 90", 5, "the vertical angle 90 comes after 95", "write angles in rising order"),
            ("3 1 1 2", "3 1 2 2", 3, "its photometry is of type B (2)", "convert it to type C (1)"),
            ("3 1 1 2", "3 1 3 2", 3, "its photometry is of type A (3)", "convert it to type C (1)"),
            ("3 1 1 2", "3 1 4 2", 3, "the type of photometry is 4", "write 1, for type C"),
            ("3 1 1 2", "1 1 1 2", 3, "the number of vertical angles is 1", "write a whole number, 2 or more"),
            ("3 1 1 2", "3 0 1 2", 3, "the number of horizontal angles is 0", "write a whole number, 1 or more"),
        ] {
            let text = format!("{head}{}", BODY.replacen(from, to, 1));
            assert_eq!(told(&text), (line, problem.to_owned(), remedy.to_owned()), "{to}");
        }
        let wide = told(&format!("{head}{}", BODY.replacen("0 45 90", "0 45 80", 1)));
        assert_eq!((wide.0, wide.1.as_str()), (5, "the vertical angles go from 0 to 80"));
        assert!(wide.2.ends_with("0 to 90, 0 to 180, 90 to 180"), "{}", wide.2);
        let many = told(&format!("{head}{}", BODY.replacen("3 1 1 2", "4000000 4000000 1 2", 1)));
        assert_eq!(many.1, "it has 4000000 times 4000000 candela values");
    }

    #[test]
    fn counts_have_a_maximum() {
        let body = |counts: &str| format!("IESNA91\nTILT=NONE\n{}", BODY.replacen("3 1 1 2", counts, 1));
        let whole = |least: usize| format!("write a whole number from {least} to 4194304");
        for (text, line, problem, remedy) in [
            (body("4194305 1 1 2"), 3, "the number of vertical angles is 4194305", whole(2)),
            (body("2 1e30 1 2"), 3, "the number of horizontal angles is 1000000000000000000000000000000", whole(1)),
            (format!("IESNA91\nTILT=INCLUDE\n1\n\n4194305\n{BODY}"), 5, "the number of tilts is 4194305", whole(0)),
            (
                body("2048 2049 1 2"),
                3,
                "it has 2048 times 2049 candela values",
                "name the file of a luminaire, which has fewer".to_owned(),
            ),
        ] {
            assert_eq!(told(&text), (line, problem.to_owned(), remedy));
        }
        // As many as there may be: only the angles are wrong.
        for counts in ["4194304 1 1 2", "2048 2048 1 2"] {
            let problem = told(&body(counts)).1;
            assert!(problem.starts_with("the vertical angle "), "{counts}: {problem}");
        }
    }
}
