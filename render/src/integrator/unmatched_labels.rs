//! Warnings about light path expressions that name what a scene does not have.

use crate::lpe::{Event, Kind, Scattering, Unmatched};
use crate::scene::{listed, nearest};
use crate::settings::Aov;
use crate::world::World;

/// What surfaces and lights have names for, by the place of the label.
const SURFACE: [&str; 2] = ["object", "material"];
const LIGHT: [&str; 2] = ["light group", "light"];

/// The kind of a surface's events.
const SCATTERING: Kind = Kind::REFLECTION.and(Kind::TRANSMISSION);

/// A warning for each label that an AOV's expression names and that nothing in the world has where it is named, so that
/// the AOV lacks light or is black.
pub(crate) fn unmatched_labels(world: &World, aovs: &[Aov]) -> Vec<String> {
    if aovs.is_empty() {
        return Vec::new();
    }
    let events = events(world);
    let of_aov = |aov: &Aov| -> Vec<String> {
        let unmatched = aov.expression.unmatched_labels(&events);
        unmatched.iter().map(|it| warning(&events, &aov.name, it)).collect()
    };
    aovs.iter().flat_map(of_aov).collect()
}

/// All that can happen in a world, but for how surfaces scatter. Of meshes only those that emit are lights.
fn events(world: &World) -> Vec<Event> {
    let event = |kind: Kind, labels: [String; 2]| Event { kind, scattering: Scattering::NONE, labels: labels.into() };
    let surfaces = world.surface_labels().map(|labels| event(SCATTERING, labels));
    let emitters = world
        .lit_labels()
        .map(|(is_lamp, labels)| event(if is_lamp { Kind::LIGHT } else { Kind::LIGHT.and(Kind::OBJECT) }, labels));
    let punctual = world.punctual_labels().map(|labels| event(Kind::LIGHT, labels));
    let sky = std::iter::once(event(Kind::BACKGROUND, World::sky_labels()));
    surfaces.chain(emitters).chain(punctual).chain(sky).collect()
}

fn warning(events: &[Event], aov: &str, unmatched: &Unmatched) -> String {
    let Unmatched { label, place, .. } = *unmatched;
    let begin = format!("AOV {aov}: no {} is called '{label}'", sought(events, unmatched));
    if let Some((event, other)) = events.iter().find_map(|event| Some((event, place_of(event, label)?))) {
        if event.kind == Kind::BACKGROUND {
            return format!("{begin}: it is the name of the sky, B");
        }
        let (names, letter) = if event.kind == SCATTERING { (SURFACE, 'R') } else { (LIGHT, 'L') };
        let (article, name) = (if names[other] == "object" { "an" } else { "a" }, names[other]);
        return format!("{begin}: it is the name of {article} {name}, <{letter}{}'{label}'>", ".".repeat(other + 1));
    }
    let possible = events.iter().filter(|event| unmatched.is_for(event)).filter_map(|event| event.labels.get(place));
    let mut names: Vec<&str> = possible.map(String::as_str).collect();
    names.sort_unstable();
    names.dedup();
    let hint = match nearest(label, &names) {
        Some(name) => format!("; did you mean '{name}'?"),
        None if names.is_empty() => String::new(),
        None => format!("; known are {}", listed(&names.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>())),
    };
    format!("{begin}, so the label matches nothing{hint}")
}

/// What the label should be the name of.
fn sought(events: &[Event], unmatched: &Unmatched) -> &'static str {
    let (surfaces, lights): (Vec<&Event>, _) = events.iter().partition(|event| event.kind == SCATTERING);
    let [is_surface, is_light] = [surfaces, lights].map(|of| of.iter().any(|event| unmatched.is_for(event)));
    let names = match (is_surface, is_light) {
        (true, false) => SURFACE,
        (false, true) => LIGHT,
        _ => ["surface or light"; 2],
    };
    names.get(unmatched.place).copied().unwrap_or("surface or light")
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
            far.starts_with("AOV test: no object is called 'no such label', so") && far.contains("'floor'"),
            "{far}"
        );
        // Each with names of its kind.
        let [surface, light] = &warnings("C<RD'Flor'>+<L.[^'Flor']>")[..] else { panic!() };
        assert!(surface.ends_with("did you mean 'floor'?"), "{surface}");
        assert_eq!(light, "AOV test: no light group is called 'Flor', so the label matches nothing; known are 'lamp'");
        let [lamp] = &warnings("C<RD'lam'>.*<L.'lam'>")[1..] else { panic!() };
        assert!(lamp.ends_with("did you mean 'lamp'?"), "{lamp}");
        // A surface that does not emit is no light.
        let [dark] = &warnings("C.*<L.'floor'>")[..] else { panic!() };
        assert_eq!(dark, "AOV test: no light group is called 'floor': it is the name of an object, <R.'floor'>");
        let [second] = &warnings(&format!("C<RD'{material}'>L"))[..] else { panic!() };
        assert!(second.ends_with(&format!("it is the name of a material, <R..'{material}'>")), "{second}");
        let [sky] = &warnings("C.*<L.'sky'>")[..] else { panic!() };
        assert_eq!(sky, "AOV test: no light group is called 'sky': it is the name of the sky, B");
        assert_eq!(warnings("C.*B"), [""; 0]);
    }
}
