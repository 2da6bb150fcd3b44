//! Depth of field: points out of focus have the size of a thin lens's blur, and the same light.

use halfdome::scene::{Lens, Optics, Projection};
use halfdome::settings::{Integrator, Settings};
use halfdome_tests::render::{pixels, render};

use super::{disc, glowing};
use glam::Vec3;

const SIDE: u32 = 128;
const LENS: Lens = Lens { radius: 1.0, focus: 2.0, blades: 0, rotation: 0.0, ratio: 1.0 };
/// The radius of the disc that is seen over its distance: it is small beside its blur.
const RADIUS: f32 = 0.06;

fn settings(spp: u32) -> Settings {
    let integrator = Integrator::named("path").expect("a name of an integrator");
    Settings { width: SIDE, height: SIDE, spp, integrator, ..Settings::default() }
}

/// Of the picture of a disc at a depth: its sum, and half the width and half the height of an ellipse with its second
/// moments, in pixels, without those of the disc itself.
fn seen(lens: Option<Lens>, depth: f32, projection: Projection) -> (f64, [f64; 2]) {
    let scale =
        if projection == Projection::Perspective { SIDE as f64 / 2.0 / f64::from(depth) } else { SIDE as f64 / 2.0 };
    let optics = Optics { lens, projection, ..Optics::default() };
    let scene = glowing(&disc(Vec3::new(0.0, 0.0, -depth), RADIUS * depth, 256), optics);
    let picture = pixels(&render(&scene, &settings(512)));
    let sum: f64 = picture.iter().map(|pixel| pixel.x).sum();
    let moment = |axis: fn(usize) -> usize| {
        let squares = picture.iter().enumerate().map(|(i, pixel)| {
            let place = axis(i) as f64 + 0.5 - SIDE as f64 / 2.0;
            pixel.x * place * place
        });
        // A pixel is as wide as 1, and the disc has a second moment of its own.
        let own = (f64::from(RADIUS * depth) * scale).powi(2) / 4.0 + 1.0 / 12.0;
        2.0 * (squares.sum::<f64>() / sum - own).max(0.0).sqrt()
    };
    (sum, [moment(|i| i % SIDE as usize), moment(|i| i / SIDE as usize)])
}

/// `c = A f / s · |z - s| / z`, and half the picture's height is the focal length at 90 degrees.
#[test]
fn the_blur_of_a_small_disc_is_that_of_a_thin_lens() {
    for depth in [1.0, 1.3, 4.0, 10.0] {
        let blur = |z: f64| 0.5 * f64::from(SIDE) * 1.0 / 2.0 * (z - 2.0).abs() / z;
        let (_, [width, height]) = seen(Some(LENS), depth, Projection::Perspective);
        for radius in [width, height] {
            assert!((radius / blur(f64::from(depth)) - 1.0).abs() < 0.01, "{depth}: {radius} {}", blur(depth.into()));
        }
    }
    let parallel = Projection::Orthographic { height: 2.0 };
    let (_, [width, height]) = seen(Some(LENS), 3.0, parallel);
    // A |z - s| / s of the two units that are 128 pixels high.
    let expected = 1.0 * 1.0 / 2.0 * 64.0;
    assert!((width / expected - 1.0).abs() < 0.01 && (height / expected - 1.0).abs() < 0.01, "{width} {height}");
}

#[test]
fn an_anamorphic_lens_makes_ovals() {
    let (_, [width, height]) = seen(Some(Lens { ratio: 2.0, ..LENS }), 4.0, Projection::Perspective);
    let expected = 64.0 * 1.0 / 2.0 * 0.5;
    assert!((height / expected - 1.0).abs() < 0.01 && (2.0 * width / expected - 1.0).abs() < 0.01, "{width} {height}");
}

/// A lens spreads light, and loses none; so does one with blades.
#[test]
fn what_is_out_of_focus_sends_as_much_light() {
    let (sharp, _) = seen(None, 4.0, Projection::Perspective);
    for lens in [LENS, Lens { blades: 5, rotation: 20.0, ..LENS }, Lens { ratio: 1.5, ..LENS }] {
        let (blurred, _) = seen(Some(lens), 4.0, Projection::Perspective);
        assert!((blurred / sharp - 1.0).abs() < 0.01, "{blurred} {sharp}");
    }
    let disc = std::f64::consts::PI * (f64::from(RADIUS) * 64.0).powi(2);
    assert!((sharp / disc - 1.0).abs() < 0.01, "{sharp} {disc}");
}

/// The picture of a point behind the sharp plane is the aperture itself, and before it the aperture upside down.
#[test]
fn blades_are_seen_as_they_stand() {
    for (depth, turned) in [(8.0, 1.0), (1.0, -1.0)] {
        let lens = Lens { blades: 3, rotation: 90.0, ..LENS };
        let optics = Optics { lens: Some(lens), ..Optics::default() };
        let scene = glowing(&disc(Vec3::new(0.0, 0.0, -depth), 0.02 * depth, 32), optics);
        let picture = pixels(&render(&scene, &settings(512)));
        let lit = |upper: bool| {
            let rows = picture.chunks(SIDE as usize).enumerate();
            let half = rows.filter(|(row, _)| (*row < SIDE as usize / 2) == upper);
            // The widest row in this half: the triangle has its base below if its corner is up.
            half.map(|(_, row)| row.iter().filter(|pixel| pixel.x > 0.0).count()).max().unwrap_or(0) as f32
        };
        // A regular triangle is R √3 wide at its base, and two thirds of that at the height of its centre.
        let (upper, lower) = (lit(true), lit(false));
        assert!(turned * (lower - upper) > 8.0, "{depth}: {upper} above, {lower} below");
    }
}
