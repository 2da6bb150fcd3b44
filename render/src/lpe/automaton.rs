//! All expressions of a picture as one deterministic automaton.
//!
//! Expressions become one nondeterministic automaton by Thompson's construction, and the sets of its places that a path
//! may be in the states of a deterministic one. Its alphabet are the events that can happen in a scene; labels that no
//! expression names are equivalent, so it is small for every scene.

use std::collections::BTreeMap;

use super::event::{Event, Kind, Pattern, Scattering};
use super::{Expression, Node};

/// The most states, and the most places of the nondeterministic automaton.
const MAX_STATES: usize = 20_000;
const MAX_PLACES: usize = 20_000;

/// The label that represents all labels that no expression names.
const OTHER: &str = "";

/// Expressions whose automaton would be too large.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TooComplex;

/// Follows paths through all expressions.
#[derive(Clone, Debug)]
pub(crate) struct Automaton {
    /// The state of a path that has left the camera.
    start: u32,
    /// The next state, by state and event.
    next: Vec<u32>,
    /// The number of events.
    events: usize,
    /// The expressions that each state accepts.
    accepts: Vec<Vec<u32>>,
}

/// The nondeterministic automaton.
#[derive(Default)]
struct Places<'a> {
    /// Where one is without an event, too.
    free: Vec<Vec<u32>>,
    /// The next state after an event.
    on: Vec<Option<(&'a Pattern, u32)>>,
}

/// The events that can happen in a scene, each once, by their indices.
#[derive(Debug)]
pub(crate) struct Alphabet {
    /// The labels that are distinguished; `None` for all.
    named: Option<Vec<String>>,
    numbers: BTreeMap<Event, u32>,
}

impl Alphabet {
    /// An alphabet for these expressions, without events.
    pub(crate) fn new(expressions: &[Expression]) -> Self {
        let mut named = Vec::new();
        for expression in expressions {
            expression.node.patterns(&mut |pattern| pattern.named(&mut |label| named.push(label.clone())));
        }
        named.sort_unstable();
        named.dedup();
        Self { named: Some(named), numbers: BTreeMap::new() }
    }

    /// An alphabet that distinguishes all labels, without events.
    pub(crate) fn of_all_labels() -> Self {
        Self { named: None, numbers: BTreeMap::new() }
    }

    /// Its events in the order of their indices.
    pub(crate) fn into_events(self) -> Vec<Event> {
        let mut events: Vec<(u32, Event)> = self.numbers.into_iter().map(|(event, number)| (number, event)).collect();
        events.sort_unstable_by_key(|&(number, _)| number);
        events.into_iter().map(|(_, event)| event).collect()
    }

    /// The index of an event; events that no expression distinguishes share one.
    pub(crate) fn number(&mut self, kind: Kind, scattering: Scattering, labels: [&str; 2]) -> u32 {
        let is_known = |label: &str| self.named.as_ref().is_none_or(|named| named.iter().any(|it| it == label));
        let known = |label: &str| if is_known(label) { label } else { OTHER }.to_owned();
        let event = Event { kind, scattering, labels: labels.map(known).into() };
        let next = self.numbers.len() as u32;
        *self.numbers.entry(event).or_insert(next)
    }
}

impl Automaton {
    /// The automaton for these expressions, in a scene with these events.
    pub(crate) fn new(expressions: &[Expression], alphabet: &Alphabet) -> Result<Self, TooComplex> {
        let mut places = Places::default();
        let first = places.add()?;
        let mut ends = BTreeMap::new();
        for (number, expression) in (0_u32..).zip(expressions) {
            let begin = places.add()?;
            places.free[first as usize].push(begin);
            ends.insert(places.follow(&expression.node, begin)?, number);
        }
        let camera = Event { kind: Kind::CAMERA, scattering: Scattering::NONE, labels: Vec::new() };
        let mut events: Vec<(&Event, u32)> = alphabet.numbers.iter().map(|(event, &number)| (event, number)).collect();
        events.sort_unstable_by_key(|&(_, number)| number);
        let mut sets = Sets { places: &places, numbers: BTreeMap::new(), sets: Vec::new() };
        let at_first = places.closure(vec![first]);
        let start = sets.number(places.after(&at_first, &camera));
        let mut next = Vec::new();
        let mut state = 0;
        while let Some(set) = sets.sets.get(state).cloned() {
            if state > MAX_STATES {
                return Err(TooComplex);
            }
            for (event, _) in &events {
                let after = places.after(&set, event);
                next.push(sets.number(after));
            }
            state += 1;
        }
        let accepts = |set: &Vec<u32>| {
            let mut accepts: Vec<u32> = set.iter().filter_map(|place| ends.get(place).copied()).collect();
            accepts.sort_unstable();
            accepts
        };
        Ok(Self { start, next, events: events.len(), accepts: sets.sets.iter().map(accepts).collect() })
    }

    /// The state of a path that has left the camera.
    pub(crate) fn start(&self) -> u32 {
        self.start
    }

    /// The state after an event.
    #[inline]
    pub(crate) fn next(&self, state: u32, event: u32) -> u32 {
        self.next[state as usize * self.events + event as usize]
    }

    /// The expressions that a path fulfils which ends in this state.
    #[inline]
    pub(crate) fn accepts(&self, state: u32) -> &[u32] {
        &self.accepts[state as usize]
    }
}

/// States by the sets of places that they are.
struct Sets<'a> {
    places: &'a Places<'a>,
    numbers: BTreeMap<Vec<u32>, u32>,
    sets: Vec<Vec<u32>>,
}

impl Sets<'_> {
    fn number(&mut self, set: Vec<u32>) -> u32 {
        debug_assert!(set.iter().all(|&place| (place as usize) < self.places.free.len()));
        *self.numbers.entry(set).or_insert_with_key(|set| {
            self.sets.push(set.clone());
            self.sets.len() as u32 - 1
        })
    }
}

impl<'a> Places<'a> {
    fn add(&mut self) -> Result<u32, TooComplex> {
        if self.free.len() == MAX_PLACES {
            return Err(TooComplex);
        }
        self.free.push(Vec::new());
        self.on.push(None);
        Ok(self.free.len() as u32 - 1)
    }

    /// Where one is behind `node`, if one begins at `from`.
    fn follow(&mut self, node: &'a Node, from: u32) -> Result<u32, TooComplex> {
        match node {
            Node::Event(pattern) => {
                let (before, behind) = (self.add()?, self.add()?);
                self.free[from as usize].push(before);
                self.on[before as usize] = Some((pattern, behind));
                Ok(behind)
            }
            Node::Sequence(nodes) => {
                // A place of its own, so that nothing leads back to what is before.
                let begin = self.add()?;
                self.free[from as usize].push(begin);
                nodes.iter().try_fold(begin, |from, node| self.follow(node, from))
            }
            Node::Either(nodes) => {
                let end = self.add()?;
                for node in nodes {
                    let behind = self.follow(node, from)?;
                    self.free[behind as usize].push(end);
                }
                Ok(end)
            }
            Node::Repeat(node, least, most) => {
                let mut at = from;
                for _ in 0..*least {
                    at = self.follow(node, at)?;
                }
                let end = self.add()?;
                match most {
                    None => {
                        let round = self.add()?;
                        self.free[at as usize].push(round);
                        let behind = self.follow(node, round)?;
                        self.free[behind as usize].push(round);
                        self.free[round as usize].push(end);
                    }
                    Some(most) => {
                        for _ in *least..*most {
                            self.free[at as usize].push(end);
                            at = self.follow(node, at)?;
                        }
                        self.free[at as usize].push(end);
                    }
                }
                Ok(end)
            }
        }
    }

    /// All places where one is with these, sorted.
    fn closure(&self, mut open: Vec<u32>) -> Vec<u32> {
        let mut is_in = vec![false; self.free.len()];
        let mut set = Vec::new();
        while let Some(place) = open.pop() {
            if !std::mem::replace(&mut is_in[place as usize], true) {
                set.push(place);
                open.extend(&self.free[place as usize]);
            }
        }
        set.sort_unstable();
        set
    }

    /// The next places after an event.
    fn after(&self, set: &[u32], event: &Event) -> Vec<u32> {
        let leads = |&place: &u32| match self.on[place as usize] {
            Some((pattern, behind)) if pattern.contains(event) => Some(behind),
            _ => None,
        };
        self.closure(set.iter().filter_map(leads).collect())
    }
}
