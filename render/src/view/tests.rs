//! Sessions without a window.

use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use glam::Vec3;

use super::*;
use crate::film::Picture;
use crate::output::ToneMapping;
use crate::scene::{PunctualLight, Scene, cornell_box};
use crate::settings::{Integrator, Settings};
use crate::watch::Watch;
use crate::world::World;

struct Unwatched;

impl Watch for Unwatched {
    fn advance(&self, _samples: u64, _rays: u64) {}
    fn stop(&self) -> bool {
        false
    }
}

/// A session, and the notifications of its frames.
struct Viewer {
    session: Session,
    frames: Receiver<()>,
}

fn settings(integrator: &str, spp: u32) -> Settings {
    Settings { width: 70, height: 40, spp, integrator: Integrator::named(integrator).unwrap(), ..Settings::default() }
}

impl Viewer {
    fn new(scene: Scene, settings: Settings) -> Self {
        let (sender, frames) = channel();
        let outline = outline(&scene, "box");
        let start = Start {
            name: "box".to_owned(),
            settings,
            tone: ToneMapping::default(),
            camera_file: CameraFile { scene: None, optics: Vec::new(), has_optics: false },
            pool: rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap(),
            notify: Box::new(move || {
                // A test that has failed does not listen.
                let _ = sender.send(());
            }),
        };
        Self { session: Session::new(World::new(scene).unwrap(), outline, start), frames }
    }

    /// Waits until all samples are taken; gives the sides of squares that were seen on the way.
    fn finish(&mut self) -> Vec<u32> {
        let mut sides = Vec::new();
        loop {
            self.frames.recv_timeout(Duration::from_secs(300)).expect("frames come until the last");
            // A notice may be of a frame that has been taken with an earlier one: then the last picture is still there.
            let is_new = self.session.update();
            assert_eq!(self.session.message(), None);
            if let Some(frame) = self.session.frame().filter(|_| is_new) {
                sides.push(frame.side);
                if frame.finished {
                    return sides;
                }
            }
        }
    }

    fn text(&mut self) -> String {
        self.session.text(1000).into_iter().map(|line| line.text + "\n").collect()
    }
}

/// What `halfdome render` makes of a scene.
fn rendered(scene: Scene, pose: Option<crate::scene::CameraPose>, settings: &Settings) -> Picture {
    let camera = pose.or(scene.camera);
    crate::driver::render(&World::new(Scene { camera, ..scene }).unwrap(), settings, &Unwatched).picture
}

fn same(shown: &Frame, rendered: &Picture) {
    assert!(!shown.picture.channels.is_empty());
    for channel in &shown.picture.channels {
        assert_eq!(Some(channel), rendered.channel(&channel.name));
    }
}

/// A box with a sun and a sky behind its open side: what a world prepares depends on where it is looked at from.
fn sunny() -> Scene {
    let mut scene = cornell_box();
    let direction = Vec3::new(0.3, -0.5, 0.8).normalize();
    scene.lights.push(PunctualLight::Directional { direction, irradiance: Vec3::splat(3.0), half_angle: 0.0 });
    scene.sky.radiance = Vec3::new(0.2, 0.3, 0.4);
    scene
}

#[test]
fn the_picture_is_that_of_render() {
    for integrator in ["path", "ao", "cached"] {
        let settings = settings(integrator, 5);
        let mut viewer = Viewer::new(sunny(), settings.clone());
        let sides = viewer.finish();
        assert!(sides.is_sorted_by(|a, b| a >= b) && sides.ends_with(&[1]), "{sides:?}");
        let frame = viewer.session.frame().unwrap();
        assert_eq!((frame.samples.clone(), frame.side), (5..5, 1));
        let expected = rendered(sunny(), None, &settings);
        same(frame, &expected);
        // And its colours are those of a PNG.
        let tone = ToneMapping::default();
        let value = |name: &str, i: usize| expected.channel(name).unwrap().values[i];
        let codes: Vec<_> = (0..70 * 40).map(|i| tone.to_srgb8(["R", "G", "B"].map(|name| value(name, i)))).collect();
        assert_eq!(viewer.session.codes().unwrap(), codes);
    }
}

#[test]
fn after_a_move_the_picture_is_that_of_the_new_camera() {
    let settings = settings("path", 4);
    let mut viewer = Viewer::new(sunny(), settings.clone());
    viewer.finish();
    let home = viewer.session.pose();
    viewer.session.apply(Command::Orbit(2.0, 0.3));
    viewer.session.apply(Command::Zoom(0.8));
    viewer.finish();
    let pose = viewer.session.pose();
    assert_ne!(pose, home);
    let moved = rendered(sunny(), Some(pose), &settings);
    same(viewer.session.frame().unwrap(), &moved);
    assert_ne!(moved.channels, rendered(sunny(), None, &settings).channels);
    viewer.session.apply(Command::Home);
    viewer.finish();
    assert_eq!(viewer.session.pose(), home);
    same(viewer.session.frame().unwrap(), &rendered(sunny(), None, &settings));
}

#[test]
fn more_samples_go_on_with_those_that_there_are() {
    let mut viewer = Viewer::new(cornell_box(), settings("path", 3));
    viewer.finish();
    let before = viewer.session.frame().unwrap().rays;
    viewer.session.apply(Command::MoreSamples);
    let sides = viewer.finish();
    assert!(sides.iter().all(|&side| side == 1), "not from coarse to fine again: {sides:?}");
    let frame = viewer.session.frame().unwrap();
    assert_eq!(frame.samples, 6..6);
    assert!(frame.rays > 3 * before / 2 && frame.rays < 3 * before, "{} {before}", frame.rays);
    same(frame, &rendered(cornell_box(), None, &settings("path", 6)));
}

#[test]
fn layers_are_those_of_aov_and_light_paths() {
    let lpe = crate::settings::Aov::new("direct", "CD[LO]").unwrap();
    let settings = Settings { aovs: vec![lpe], ..settings("path", 2) };
    let mut viewer = Viewer::new(cornell_box(), settings.clone());
    viewer.finish();
    let whole = rendered(cornell_box(), None, &Settings { aov: true, halves: true, ..settings });
    for (name, count) in [("direct", 3), ("N", 3), ("Depth", 1), ("Id.Object", 1), ("light", 3), ("Albedo", 3)] {
        assert!(viewer.session.show(name));
        viewer.finish();
        let frame = viewer.session.frame().unwrap();
        assert_eq!(frame.picture.channels.len(), count, "{name}");
        same(frame, &whole);
        assert!(viewer.text().contains(&format!("shows     {name}")));
    }
    assert!(!viewer.session.show("nothing"));
    let before = viewer.session.layer().clone();
    viewer.session.apply(Command::Layer(1));
    viewer.session.apply(Command::Layer(-1));
    assert_eq!(viewer.session.layer(), &before);
}

#[test]
fn a_click_tells_what_is_there() {
    let mut viewer = Viewer::new(cornell_box(), settings("path", 9));
    // Before there is any picture, too.
    viewer.session.apply(Command::Pick(35, 10));
    viewer.finish();
    let pick = viewer.session.pick().unwrap().clone();
    assert_eq!((pick.pixel, pick.surface.as_ref().unwrap().object.as_str()), ((35, 10), "back wall"));
    assert_eq!(pick.history.as_ref().unwrap().last().unwrap().sample, 8, "the last samples of all");
    let text = viewer.text();
    for expected in ["Pixel 35, 10", "object    back wall, triangle", "material  white", "sample 8: ", "RD back wall"] {
        assert!(text.contains(expected), "{expected} is not in:\n{text}");
    }
    viewer.session.apply(Command::Show(Page::Scene));
    let chosen: Vec<_> = viewer.session.text(99).into_iter().filter(|line| line.style == Style::Chosen).collect();
    assert!(matches!(&chosen[..], [line] if line.text.contains("back wall: 2 triangles, white")), "{chosen:?}");
    // And one may look there.
    viewer.session.apply(Command::LookAtPicked);
    assert_eq!(viewer.session.pose().target, pick.surface.unwrap().position);
    assert_eq!(viewer.session.pick(), None);
    viewer.session.apply(Command::LookAtPicked);
    assert!(viewer.session.message().unwrap().contains("nothing is picked"));
}

#[test]
fn tone_has_ends_and_a_beginning() {
    let mut viewer = Viewer::new(cornell_box(), settings("path", 1));
    viewer.session.apply(Command::Expose(1000.0));
    assert_eq!(viewer.session.tone().exposure, 64.0);
    let first = viewer.session.tone().curve;
    viewer.session.apply(Command::NextCurve);
    assert_ne!(viewer.session.tone().curve, first);
    viewer.session.apply(Command::ResetTone);
    assert_eq!(viewer.session.tone(), ToneMapping::default());
    viewer.session.apply(Command::Save);
    let message = viewer.session.message().unwrap();
    assert!(message.contains("no file") && message.contains("--eye 0.278,0.273,-0.8 --target"), "{message}");
    let text = viewer.text();
    assert!(text.lines().all(|line| line.chars().count() <= COLUMNS), "{text}");
}
