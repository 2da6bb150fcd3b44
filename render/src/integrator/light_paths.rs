//! Light paths of a world, and their assignment to AOVs.
//!
//! A path carries the state of an [`Automaton`] for each colour channel. Where a closure has several lobes for one
//! direction, light samples are split among them. A path continues by one lobe; for each channel the lobe is chosen in
//! proportion to its part of the closure in that channel. So in expectation each lobe gets the light that it scatters,
//! and the lobes of a path sum to it exactly.

use glam::Vec3;

use super::path_tree::PathTree;
use crate::light::Light;
use crate::lpe::{Alphabet, Automaton, Event, Expression, Kind, Scattering};
use crate::settings::{Aov, Invalid, Settings};
use crate::world::World;

/// What `--light-groups` puts before the names of groups.
const GROUP_PREFIX: &str = "Light_";

/// What a picture's AOVs make of paths in a world, or a list of the paths themselves.
pub(crate) struct LightPaths {
    follow: Follow,
    /// The number of AOVs.
    count: usize,
    /// The events at each mesh's surface, by side and lobe.
    surfaces: Vec<[[u32; 3]; 2]>,
    /// The event of each mesh's light.
    emitters: Vec<u32>,
    /// The event of each punctual light, in the scene's order.
    punctual: Vec<u32>,
    sky: u32,
}

/// The automaton or tree that follows paths.
enum Follow {
    /// The AOVs' expressions.
    Expressions(Automaton),
    /// All that happens to them.
    All(PathTree),
}

/// The numbers of all events that can happen in a world.
struct Events {
    surfaces: Vec<[[u32; 3]; 2]>,
    emitters: Vec<u32>,
    punctual: Vec<u32>,
    sky: u32,
}

/// The lobe by which a path continues.
#[derive(Clone, Copy)]
pub(super) enum Lobe {
    Wide,
    Glossy,
    Delta,
}

/// The AOVs that settings ask for in a world: those with expressions, then the light groups, by their names.
pub(crate) fn aovs(world: &World, settings: &Settings) -> Vec<Aov> {
    let mut aovs = settings.aovs.clone();
    if settings.light_groups {
        let (sky, groups) = world.light_groups();
        let sky = sky.map(|label| (label, Expression::sky()));
        let lamps = groups.into_iter().map(|label| (label.clone(), Expression::light_group(&label)));
        for (group, expression) in sky.into_iter().chain(lamps) {
            let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
            let base: String = GROUP_PREFIX.chars().chain(group.chars().map(plain)).collect();
            let is_taken = |name: &str| aovs.iter().any(|aov| aov.name == name);
            let numbered = (2..).map(|number| format!("{base}_{number}"));
            let name = std::iter::once(base.clone()).chain(numbered).find(|name| !is_taken(name));
            aovs.push(Aov { name: name.unwrap_or(base), expression });
        }
    }
    aovs
}

impl LightPaths {
    /// Light paths for these AOVs; `None` if there are none.
    ///
    /// # Errors
    /// If the expressions are too complex together.
    pub(crate) fn new(world: &World, aovs: &[Aov]) -> Result<Option<Self>, Invalid> {
        if aovs.is_empty() {
            return Ok(None);
        }
        let expressions: Vec<Expression> = aovs.iter().map(|aov| aov.expression.clone()).collect();
        let mut alphabet = Alphabet::new(&expressions);
        let Events { surfaces, emitters, punctual, sky } = Events::new(world, &mut alphabet);
        let automaton = Automaton::new(&expressions, &alphabet).map_err(|_| {
            let problem = "the light path expressions are too complex: following them takes too many states";
            Invalid::new(problem, "write simpler ones, with smaller ranges, or render them in several runs")
        })?;
        Ok(Some(Self { follow: Follow::Expressions(automaton), count: aovs.len(), surfaces, emitters, punctual, sky }))
    }

    /// Light paths that are listed, for no AOV.
    pub(crate) fn listing(world: &World) -> Self {
        let mut alphabet = Alphabet::of_all_labels();
        let Events { surfaces, emitters, punctual, sky } = Events::new(world, &mut alphabet);
        let tree = PathTree::new(alphabet.into_events());
        Self { follow: Follow::All(tree), count: 0, surfaces, emitters, punctual, sky }
    }

    /// The paths that have found light since they were last taken, if they are listed, with what they found: what happened at
    /// each surface, and the light.
    pub(crate) fn take_paths(&self) -> Vec<(Vec<Event>, Vec3)> {
        match &self.follow {
            Follow::Expressions(_) => Vec::new(),
            Follow::All(tree) => tree.take(),
        }
    }

    /// The number of AOVs.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The states of a path that has left the camera.
    pub(super) fn start(&self) -> [u32; 3] {
        match &self.follow {
            Follow::Expressions(automaton) => [automaton.start(); 3],
            Follow::All(_) => [PathTree::START; 3],
        }
    }

    /// The states after an event.
    pub(super) fn after(&self, states: [u32; 3], event: u32) -> [u32; 3] {
        match &self.follow {
            Follow::Expressions(automaton) => states.map(|state| automaton.next(state, event)),
            Follow::All(tree) => states.map(|state| tree.next(state, event)),
        }
    }

    /// The event of going on from a mesh's surface, to the other side or not.
    pub(super) fn surface(&self, mesh: usize, transmits: bool, lobe: Lobe) -> u32 {
        self.surfaces[mesh][usize::from(transmits)][lobe as usize]
    }

    /// The event of finding what a mesh emits.
    pub(super) fn emitter(&self, mesh: usize) -> u32 {
        self.emitters[mesh]
    }

    /// The event of finding the sky.
    pub(super) fn sky(&self) -> u32 {
        self.sky
    }

    /// The event of finding the light of this index among the world's lights.
    pub(super) fn light(&self, world: &World, number: u32) -> u32 {
        match &world.lights.lights()[number as usize] {
            Light::Triangle(part) => self.emitter(world.mesh_number(part.prim_id)),
            Light::Punctual(_) => self.punctual[world.lights.punctual_number(number)],
            Light::Sky => self.sky,
        }
    }

    /// Adds light to those of one ray's AOVs that paths fulfil which have come to these states, one for each channel.
    pub(super) fn add(&self, states: [u32; 3], light: Vec3, aovs: &mut [Vec3]) {
        let automaton = match &self.follow {
            Follow::Expressions(automaton) => automaton,
            Follow::All(tree) => return tree.add(states, light),
        };
        for (c, (state, light)) in states.into_iter().zip(light.to_array()).enumerate() {
            for &aov in automaton.accepts(state) {
                aovs[aov as usize][c] += light;
            }
        }
    }
}

impl Events {
    fn new(world: &World, alphabet: &mut Alphabet) -> Self {
        let lobes = [Scattering::DIFFUSE, Scattering::GLOSSY, Scattering::SINGULAR];
        let mut surface = |labels: [&str; 2]| {
            [Kind::REFLECTION, Kind::TRANSMISSION].map(|side| lobes.map(|lobe| alphabet.number(side, lobe, labels)))
        };
        let surfaces = world.surface_labels().map(|labels| surface(labels.each_ref().map(String::as_str))).collect();
        let mut light = |kind: Kind, labels: [String; 2]| {
            alphabet.number(kind, Scattering::NONE, labels.each_ref().map(String::as_str))
        };
        let emitters = world
            .emitter_labels()
            .map(|(is_lamp, labels)| light(if is_lamp { Kind::LIGHT } else { Kind::LIGHT.and(Kind::OBJECT) }, labels));
        let emitters = emitters.collect();
        let punctual = world.punctual_labels().map(|labels| light(Kind::LIGHT, labels)).collect();
        let sky = light(Kind::BACKGROUND, World::sky_labels());
        Self { surfaces, emitters, punctual, sky }
    }
}

/// A light path's labels, hashed: pictures with equal settings and scenes may differ in them.
pub(crate) fn labels_hash(world: &World) -> u64 {
    let mut text = String::new();
    let mut push = |labels: [String; 2]| text += &format!("{labels:?}\n");
    world.surface_labels().for_each(&mut push);
    world.emitter_labels().for_each(|(_, labels)| push(labels));
    world.punctual_labels().for_each(&mut push);
    xxhash_rust::xxh3::xxh3_64(text.as_bytes())
}
