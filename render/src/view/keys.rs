//! Keys and mouse: their commands and help texts.

use super::session::{Command, Page};

/// Radians: sixteen taps for a right angle, quick when they repeat.
const TURN: f64 = 0.1;
const STEP: f64 = 0.05;
/// The part of the distance to the target that a tap of + or a step of the wheel leaves.
pub const ZOOM_STEP: f64 = 0.9;
const STOPS: f32 = 0.5;
/// Lines of a page of text.
const PAGE: isize = 20;

/// Keys and mouse actions, with their effects.
pub const HELP: [(&str, &str); 19] = [
    ("drag", "orbit"),
    ("right drag, shift drag", "move across the view"),
    ("wheel, +, -", "closer, farther away"),
    ("arrows", "orbit; with shift move"),
    ("click", "pick: object, light paths"),
    ("f", "look at the picked point"),
    ("0, Home", "the first camera"),
    ("s", "save the camera"),
    ("a, A", "next, previous AOV"),
    ("], [", "half a stop brighter, darker"),
    ("t", "next tone curve"),
    ("r", "initial exposure and tone"),
    ("m", "twice as many samples"),
    ("o", "the scene's tree"),
    ("h, ?", "this help"),
    ("wheel on the text", "scroll"),
    ("PageUp, PageDown", "scroll by pages"),
    ("Tab", "text on and off"),
    ("q, Escape", "quit"),
];

/// The command of a key: a character, or a name as in the `key` of a browser's events. `shift` is held or not.
pub fn command(key: &str, shift: bool) -> Option<Command> {
    let turn = |right: f64, up: f64| match shift {
        true => Command::Pan(STEP * right, STEP * up),
        false => Command::Orbit(TURN * right, TURN * up),
    };
    Some(match key {
        "ArrowLeft" => turn(-1.0, 0.0),
        "ArrowRight" => turn(1.0, 0.0),
        "ArrowUp" => turn(0.0, 1.0),
        "ArrowDown" => turn(0.0, -1.0),
        "+" | "=" => Command::Zoom(ZOOM_STEP),
        "-" => Command::Zoom(1.0 / ZOOM_STEP),
        "0" | "Home" => Command::Home,
        "f" => Command::LookAtPicked,
        "s" => Command::Save,
        "a" => Command::Layer(1),
        "A" => Command::Layer(-1),
        "]" => Command::Expose(STOPS),
        "[" => Command::Expose(-STOPS),
        "t" => Command::NextCurve,
        "r" => Command::ResetTone,
        "m" => Command::MoreSamples,
        "o" => Command::Show(Page::Scene),
        "h" | "?" => Command::Show(Page::Help),
        "PageUp" => Command::Scroll(-PAGE),
        "PageDown" => Command::Scroll(PAGE),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_key_of_the_help_does_something() {
        // These are the window's own.
        let of_window = ["Tab", "q", "Escape"];
        let names = HELP.iter().flat_map(|(keys, _)| keys.split(", "));
        let keys = names.filter(|name| !name.contains("drag") && !name.contains("wheel") && *name != "click");
        for key in keys.filter(|key| !of_window.contains(key)) {
            let key = if key == "arrows" { "ArrowLeft" } else { key };
            assert!(command(key, false).is_some(), "{key}");
        }
        assert_eq!(command("x", false), None);
        assert_eq!(command("ArrowLeft", true), Some(Command::Pan(-STEP, 0.0)));
    }
}
