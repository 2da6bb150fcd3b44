//! Expressions against a matcher without automata, on all short paths.

use super::event::{Event, Kind, Scattering};
use super::{Alphabet, Automaton, Expression, Node};

/// The places at which a match of `node` can end that begins at `from`.
fn ends(node: &Node, events: &[Event], from: usize) -> Vec<usize> {
    let mut ends = match node {
        Node::Event(pattern) => {
            events.get(from).filter(|event| pattern.contains(event)).map(|_| from + 1).into_iter().collect()
        }
        Node::Sequence(nodes) => nodes.iter().fold(vec![from], |starts, node| all_ends(node, events, &starts)),
        Node::Either(nodes) => nodes.iter().flat_map(|node| ends(node, events, from)).collect(),
        Node::Repeat(node, least, most) => {
            let mut starts = vec![from];
            let mut found = Vec::new();
            // More rounds than there are events add nothing.
            for round in 0..=most.unwrap_or(*least + events.len() as u32) {
                if round >= *least {
                    found.extend(&starts);
                }
                starts = all_ends(node, events, &starts);
            }
            found
        }
    };
    ends.sort_unstable();
    ends.dedup();
    ends
}

fn all_ends(node: &Node, events: &[Event], starts: &[usize]) -> Vec<usize> {
    let mut all: Vec<usize> = starts.iter().flat_map(|&start| ends(node, events, start)).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn matches(expression: &Expression, path: &[Event]) -> bool {
    ends(&expression.node, path, 0).contains(&path.len())
}

fn event(kind: Kind, scattering: Scattering, labels: [&str; 2]) -> Event {
    Event { kind, scattering, labels: labels.map(str::to_owned).into() }
}

fn camera() -> Event {
    Event { kind: Kind::CAMERA, scattering: Scattering::NONE, labels: Vec::new() }
}

/// What can happen at a surface.
fn surfaces() -> Vec<Event> {
    let mut events = Vec::new();
    for kind in [Kind::REFLECTION, Kind::TRANSMISSION] {
        for scattering in [Scattering::DIFFUSE, Scattering::GLOSSY, Scattering::SINGULAR] {
            events.push(event(kind, scattering, ["floor", "wood"]));
            events.push(event(kind, scattering, ["wall", "paint"]));
        }
    }
    events
}

fn lights() -> Vec<Event> {
    let of = |kind, labels| event(kind, Scattering::NONE, labels);
    vec![
        of(Kind::LIGHT, ["key", "left"]),
        of(Kind::LIGHT, ["fill", "fill"]),
        of(Kind::LIGHT.and(Kind::OBJECT), ["lamp", "shade"]),
        of(Kind::BACKGROUND, ["sky", "sky"]),
    ]
}

/// All paths with at most so many surfaces.
fn paths(most: usize) -> Vec<Vec<Event>> {
    let mut beginnings = vec![vec![camera()]];
    let mut all = Vec::new();
    for _ in 0..=most {
        for beginning in &beginnings {
            all.extend(lights().into_iter().map(|light| [beginning.as_slice(), &[light]].concat()));
        }
        let longer = |beginning: Vec<Event>| {
            surfaces().into_iter().map(move |surface| [beginning.as_slice(), &[surface]].concat())
        };
        beginnings = beginnings.into_iter().flat_map(longer).collect();
    }
    all
}

const EXPRESSIONS: [&str; 34] = [
    "C.*",
    "CL",
    "C.*L",
    "C.*[LOB]",
    "C<RD>L",
    "C<RD>.*L",
    "C<RG>L",
    "CD+L",
    "C<.D><.G>?L",
    "C[DG]{2}L",
    "C[DG]{1,2}B",
    "CS{1,}L",
    "CS*DL",
    "C(DS|G)L",
    "CD|S|GL",
    "C(D(G|S)*)+[LB]",
    "C<[RT][DG]>.*O",
    "C<[^R]>L",
    "C[^D]*L",
    "C<R[^DG]>B",
    "C.*<L.'key'>",
    "C.*<L.[^'key']>",
    "C.*<..'key'>",
    "C'floor'*L",
    "C[^'floor']*<L..'left'>",
    "C<RD.'wood'>.*",
    "C<RD'floor''wood'>L",
    "C<.D['floor''wall']>{2}L",
    "C[<RD>L<TS>B]*",
    "C<R><T>L",
    "CVL",
    "C<>L",
    "C.*<Lx>",
    "C ( <T S> | <R S> ) * D <L . \"fill\">",
];

#[test]
fn the_automaton_is_the_expression_on_all_short_paths() {
    let expressions: Vec<Expression> = EXPRESSIONS.iter().map(|text| Expression::parse(text).unwrap()).collect();
    let mut alphabet = Alphabet::new(&expressions);
    let mut number =
        |event: &Event| alphabet.number(event.kind, event.scattering, [0, 1].map(|label| event.labels[label].as_str()));
    let paths = paths(3);
    let numbered: Vec<Vec<u32>> = paths.iter().map(|path| path[1..].iter().map(&mut number).collect()).collect();
    let automaton = Automaton::new(&expressions, &alphabet).unwrap();
    let mut found = vec![0; expressions.len()];
    for (path, numbers) in paths.iter().zip(&numbered) {
        let state = numbers.iter().fold(automaton.start(), |state, &event| automaton.next(state, event));
        for (number, expression) in (0_u32..).zip(&expressions) {
            let expected = matches(expression, path);
            assert_eq!(automaton.accepts(state).contains(&number), expected, "{}: {path:?}", expression.text());
            found[number as usize] += usize::from(expected);
        }
    }
    let never: Vec<&str> =
        found.iter().zip(EXPRESSIONS).filter(|(found, _)| **found == 0).map(|(_, text)| text).collect();
    assert_eq!(never, ["CVL"], "there are no volumes");
    assert_eq!(found[0], paths.len());
}

#[test]
fn expressions_mean_what_is_written_about_them() {
    let floor = |kind, scattering| event(kind, scattering, ["floor", "wood"]);
    let diffuse = floor(Kind::REFLECTION, Scattering::DIFFUSE);
    let mirror = floor(Kind::REFLECTION, Scattering::SINGULAR);
    let glass = floor(Kind::TRANSMISSION, Scattering::SINGULAR);
    let [key, _, lamp, sky] = [0, 1, 2, 3].map(|number| lights()[number].clone());
    let is = |text: &str, events: &[&Event]| {
        let path: Vec<Event> = std::iter::once(camera()).chain(events.iter().map(|&event| event.clone())).collect();
        matches(&Expression::parse(text).unwrap(), &path)
    };
    assert!(is("C<RD>L", &[&diffuse, &key]) && is("C<RD>L", &[&diffuse, &lamp]) && !is("C<RD>L", &[&diffuse, &sky]));
    assert!(is("C<RD>[LB]", &[&diffuse, &sky]) && !is("C<RD>L", &[&diffuse, &diffuse, &key]));
    // Caustics.
    assert!(is("CDS+L", &[&diffuse, &glass, &glass, &key]) && !is("CDS+L", &[&diffuse, &key]));
    assert!(is("C<RS>D", &[&mirror, &diffuse]) && !is("C<RS>D", &[&glass, &diffuse]));
    // `|` joins what is right before and behind it.
    assert!(is("CD|SL", &[&diffuse, &key]) && is("CD|SL", &[&mirror, &key]) && !is("CD|SL", &[&diffuse, &mirror]));
    // Emitters of the model are lights as well.
    assert!(is("CO", &[&lamp]) && is("CL", &[&lamp]) && !is("CO", &[&key]) && !is("C[^O]", &[&lamp]));
    // The first label of lights is their group.
    assert!(is("C<L.'key'>", &[&key]) && is("C'key'", &[&key]) && is("C<L..'left'>", &[&key]));
    assert!(!is("C<L.'left'>", &[&key]) && is("C<L.[^'fill']>", &[&key]) && !is("C<L.[^'key']>", &[&key]));
    assert!(is("C<RD'floor'>L", &[&diffuse, &key]) && is("C<RD.'wood'>L", &[&diffuse, &key]));
}

#[test]
fn light_groups_are_first_labels_of_lights() {
    let (key, of_sky, sky) = (Expression::light_group("key"), Expression::light_group("sky"), Expression::sky());
    let is = |group: &Expression, light: Event| matches(group, &[camera(), surfaces()[0].clone(), light]);
    let all = |group: &Expression| [0, 1, 2, 3].map(|light| is(group, lights()[light].clone()));
    assert_eq!((all(&key), all(&sky)), ([true, false, false, false], [false, false, false, true]));
    // A lamp of the sky's name is not the sky.
    let lamp = Event { kind: Kind::LIGHT, scattering: Scattering::NONE, labels: vec!["sky".to_owned(); 2] };
    assert_eq!(all(&of_sky), [false; 4]);
    assert!(is(&of_sky, lamp.clone()) && !is(&sky, lamp));
    assert!(!matches(&of_sky, &[camera(), event(Kind::REFLECTION, Scattering::DIFFUSE, ["sky", "sky"])]));
}

#[test]
fn errors_point_at_their_place() {
    let place = |text: &str| {
        let message = Expression::parse(text).unwrap_err().to_string();
        let mark = message.lines().find(|line| line.trim() == "^").unwrap_or_else(|| panic!("{text}: {message}"));
        mark.len() - 5
    };
    for (text, at) in [
        ("C<RD", 1),
        ("C(D|S", 1),
        ("C[LO", 1),
        ("CD)L", 2),
        ("C<RD>>", 5),
        ("*C", 0),
        ("CQL", 1),
        ("C|", 1),
        ("|C", 0),
        ("C'ab", 1),
        ("C{2}{3,1}L", 4),
        ("C{a}", 1),
        ("C{1000}", 1),
        ("C<DR>", 2),
        ("C<R'a'>", 3),
        ("C<RDD>", 4),
        ("C<RD*>L", 4),
        ("C<(RD)>", 2),
        ("C<R<D>>", 3),
        ("C[]", 1),
        ("C[^]", 2),
        ("C[^RD]", 2),
        ("C[^.]", 3),
        ("C<R[]>", 3),
        ("C<R[^.]>", 5),
        ("Ä", 0),
        ("C'ä'Q", 4),
    ] {
        assert_eq!(place(text), at, "{text}");
    }
    for empty in ["", "  "] {
        assert_eq!(Expression::parse(empty).unwrap_err().to_string().lines().next(), Some("there is no expression"));
    }
    let deep = "(".repeat(1000);
    assert!(Expression::parse(&deep).unwrap_err().to_string().contains("nested too deep"));
    let long = format!("CD{}L", "*".repeat(100_000));
    assert!(Expression::parse(&long).unwrap_err().to_string().contains("too many repetitions"));
    assert_eq!(
        Expression::parse("C<RD.*L").unwrap_err().to_string(),
        "`*` stands inside of <>\n    C<RD.*L\n         ^\n  help: write it behind `>`: an event is repeated as a whole"
    );
}

#[test]
fn automata_that_are_too_large_are_refused() {
    // Whether there was an R so many events before the end takes two states to the power of so many.
    let expressions = [Expression::parse("C.*R.{40}L").unwrap()];
    let mut alphabet = Alphabet::new(&expressions);
    for event in surfaces().iter().chain(&lights()) {
        alphabet.number(event.kind, event.scattering, ["", ""]);
    }
    assert!(Automaton::new(&expressions, &alphabet).is_err());
}
