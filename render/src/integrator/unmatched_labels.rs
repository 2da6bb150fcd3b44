//! Warnings about light path expressions that name what a scene does not have.

use crate::lpe::{Event, Kind, Scattering};
use crate::scene::{listed, nearest};
use crate::settings::Aov;
use crate::world::World;

/// What a label is the name of: of surfaces and of lights, by its place.
const SURFACES: [&str; 2] = ["an object", "a material"];
const LIGHTS: [&str; 2] = ["a light group", "a light"];

/// A warning for each label that an AOV's expression names and that nothing in the world has where it is named, so that
/// the AOV lacks light or is black.
pub(crate) fn unmatched_labels(world: &World, aovs: &[Aov]) -> Vec<String> {
    if aovs.is_empty() {
        return Vec::new();
    }
    let events = events(world);
    let of_aov = |aov: &Aov| -> Vec<String> {
        let unmatched = aov.expression.unmatched_labels(&events);
        unmatched.iter().map(|&(label, place)| warning(&events, &aov.name, label, place)).collect()
    };
    aovs.iter().flat_map(of_aov).collect()
}

/// All that can happen in a world, but for how surfaces scatter. Of meshes only those that emit are lights.
fn events(world: &World) -> Vec<Event> {
    let event = |kind: Kind, labels: [String; 2]| Event { kind, scattering: Scattering::NONE, labels: labels.into() };
    let surfaces = world.surface_labels().map(|labels| event(Kind::REFLECTION.and(Kind::TRANSMISSION), labels));
    let emitters = world
        .lit_labels()
        .map(|(is_lamp, labels)| event(if is_lamp { Kind::LIGHT } else { Kind::LIGHT.and(Kind::OBJECT) }, labels));
    let punctual = world.punctual_labels().map(|labels| event(Kind::LIGHT, labels));
    let sky = std::iter::once(event(Kind::BACKGROUND, World::sky_labels()));
    surfaces.chain(emitters).chain(punctual).chain(sky).collect()
}

fn warning(events: &[Event], aov: &str, label: &str, place: usize) -> String {
    let begin = format!("--lpe {aov}: nothing is called '{label}'");
    if let Some((event, other)) = events.iter().find_map(|event| Some((event, place_of(event, label)?))) {
        let is_surface = event.kind == Kind::REFLECTION.and(Kind::TRANSMISSION);
        let (names, example) = if is_surface { (SURFACES, "R") } else { (LIGHTS, "L") };
        let written = if other == 0 { format!("<{example}.'{label}'>") } else { format!("<{example}..'{label}'>") };
        return format!("{begin} where the expression says so: it is the name of {}, {written}", names[other]);
    }
    let mut names: Vec<&str> = events.iter().filter_map(|event| event.labels.get(place)).map(String::as_str).collect();
    names.sort_unstable();
    names.dedup();
    let hint = match nearest(label, &names) {
        Some(name) => format!("did you mean '{name}'?"),
        None => format!("known are {}", listed(&names.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>())),
    };
    format!("{begin}, so the label matches nothing; {hint}")
}

/// The place of a label in an event.
fn place_of(event: &Event, label: &str) -> Option<usize> {
    event.labels.iter().position(|it| it == label)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::cornell_box;

    #[test]
    fn labels_that_nothing_has_are_named_with_the_nearest() {
        let mut scene = cornell_box();
        for (mesh, name) in scene.meshes.iter_mut().zip(["floor", "left wall"]) {
            mesh.name = name.to_owned();
        }
        let light = scene.meshes.iter_mut().find(|mesh| scene.materials[mesh.material].emission != glam::Vec3::ZERO);
        light.unwrap().name = "lamp".to_owned();
        let material = scene.materials[0].name.clone();
        let world = World::new(scene).unwrap();
        let warnings = |text: &str| unmatched_labels(&world, &[Aov::new("test", text).unwrap()]);
        for fine in ["C.*", "C<RD'floor'>L", "C.*<L.'lamp'>", "C<T.'left wall'>.*<B.'sky'>", "C'lamp'.*"] {
            assert_eq!(warnings(fine), [""; 0], "{fine}");
        }
        let [far] = &warnings("C<RD'no such label'>L")[..] else { panic!() };
        assert!(
            far.starts_with("--lpe test: nothing is called 'no such label', so") && far.contains("'floor'"),
            "{far}"
        );
        let [near] = &warnings("C<RD'flor'>+<L.[^'flor']>")[..] else { panic!() };
        assert!(near.ends_with("did you mean 'floor'?"), "{near}");
        // A surface that does not emit is no light.
        let [dark] = &warnings("C.*<L.'floor'>")[..] else { panic!() };
        assert!(dark.ends_with("where the expression says so: it is the name of an object, <R.'floor'>"), "{dark}");
        let [second] = &warnings(&format!("C<RD'{material}'>L"))[..] else { panic!() };
        assert!(second.ends_with(&format!("it is the name of a material, <R..'{material}'>")), "{second}");
    }
}
