//! The denoisers of the library.

use halfdome::denoise::{DenoiseError, Method, Oidn};
use halfdome::driver;
use halfdome::film::Picture;
use halfdome::scene::cornell_box;
use halfdome::settings::Settings;
use halfdome::world::World;

use super::{COLORS, Unwatched, error, picture, values};

fn nlm(picture: &Picture) -> Picture {
    Method::Nlm.denoise(picture.clone(), &Unwatched).unwrap().0
}

/// The Cornell box with all that denoisers need.
fn cornell(spp: u32, seed: u64) -> Picture {
    let world = World::new(cornell_box()).unwrap();
    let settings = Settings {
        width: 72,
        height: 64,
        spp,
        seed,
        aov: true,
        aov_through: true,
        halves: true,
        ..Settings::default()
    };
    driver::render(&world, &settings, &Unwatched).picture
}

fn stays(before: &Picture, tolerance: f32) {
    let after = nlm(before);
    for name in COLORS {
        for (i, (a, b)) in values(&after, name).iter().zip(values(before, name)).enumerate() {
            assert!((a - b).abs() <= tolerance * b.abs().max(1e-3), "{name}, pixel {i}: {b} became {a}");
        }
        assert_eq!(values(&after, &format!("Noisy.{name}")), values(before, name));
    }
}

#[test]
fn pictures_without_noise_stay() {
    stays(&picture(40, 30, |_, _| [0.25, 0.5, 4.0]), 1e-5);
    stays(&picture(40, 30, |_, _| [0.0; 3]), 0.0);
    // A texture, an edge and a lamp.
    let textured = |x: u32, y: u32| match (x, y) {
        (10..13, 10..13) => [40.0; 3],
        (20.., _) => [0.1 + 0.02 * (x % 5) as f32, 0.3, 0.1 + 0.01 * (y % 7) as f32],
        _ => [0.8, 0.4 + 0.3 * ((x / 3 + y / 3) % 2) as f32, 0.2],
    };
    stays(&picture(41, 33, textured), 1e-4);
}

#[test]
fn small_pictures_have_no_neighbours() {
    for (width, height) in [(1, 1), (3, 2), (1, 40), (70, 1)] {
        stays(&picture(width, height, |x, y| [0.5, x as f32, y as f32]), 1e-4);
    }
}

#[test]
fn the_picture_does_not_depend_on_threads() {
    let noisy = cornell(8, 3);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| nlm(&noisy))
    };
    assert!(on(1) == on(3));
}

/// Against a render of other random numbers. With fewer than 5 samples one half is empty.
#[test]
fn the_error_is_never_higher_and_soon_much_lower() {
    let reference = cornell(4096, 77);
    for (spp, least) in [(8, 3.0), (16, 3.0), (64, 1.0)] {
        let denoised = nlm(&cornell(spp, 1));
        let (raw, found) = (error(&denoised, "Noisy", &reference), error(&denoised, "", &reference));
        println!("{spp} samples: {raw} became {found}");
        assert!(found * least < raw, "{spp} samples: {raw} became {found}");
    }
}

/// A wall and a darker one, which get most of their light in one pixel of 16 to 40; a lamp that has no noise; a black
/// edge.
#[test]
fn rare_bright_samples_keep_their_light() {
    rare_bright_samples(1.0);
    rare_bright_samples(1e9);
}

fn rare_bright_samples(exposure: f32) {
    let (width, height) = (192, 96);
    let wall =
        |x: u32| if x < 96 { (0.1 * exposure, 3.0 * exposure, 16) } else { (0.02 * exposure, 0.6 * exposure, 40) };
    let is_lamp = |x: u32, y: u32| (40..60).contains(&x) && y < 20;
    let is_black = |x: u32| x >= 188;
    let mut noisy = picture(width, height, |x, y| match (is_lamp(x, y), is_black(x)) {
        (true, _) => [20.0 * exposure; 3],
        (_, true) => [0.0; 3],
        _ => [wall(x).0; 3],
    });
    let mut word = 1_u32;
    for i in 0..(width * height) as usize {
        let (x, y) = (i as u32 % width, i as u32 / width);
        let (_, bright, rarity) = wall(x);
        word = word.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        if !(word >> 16).is_multiple_of(rarity) || is_lamp(x, y) || is_black(x) {
            continue;
        }
        let half = if word >> 31 == 0 { "HalfA" } else { "HalfB" };
        for channel in &mut noisy.channels {
            let name = &channel.name;
            if COLORS.contains(&&**name) {
                channel.values[i] += bright;
            } else if name.starts_with(half) {
                channel.values[i] += 2.0 * bright;
            } else if name.starts_with("Variance") {
                channel.values[i] += bright * bright;
            }
        }
    }
    let denoised = nlm(&noisy);
    // The mean of a square.
    let area = |picture: &Picture, name: &str, left: u32, top: u32, side: u32| {
        let values = values(picture, name);
        let pixels = (top..top + side).flat_map(|y| (left..left + side).map(move |x| (y * width + x) as usize));
        pixels.map(|i| values[i]).sum::<f32>() / (side * side) as f32
    };
    for name in COLORS {
        for left in [0, 120] {
            let (found, expected) = (area(&denoised, name, left, 30, 66), area(&noisy, name, left, 30, 66));
            assert!((found / expected - 1.0).abs() < 0.12, "{name}: {found} of {expected}");
            // Bright samples that fell close together by chance are no light of the wall there.
            let parts = (32..80).step_by(8).flat_map(|y| (left..left + 56).step_by(8).map(move |x| (x, y)));
            let deviations = parts.map(|(x, y)| (area(&denoised, name, x, y, 8) / found - 1.0).powi(2));
            let deviation = (deviations.sum::<f32>() / 42.0).sqrt();
            assert!(deviation < 0.08, "{name} from {left}: areas differ by {deviation}");
        }
        let lamp = area(&denoised, name, 42, 2, 16);
        assert!((lamp / (20.0 * exposure) - 1.0).abs() < 0.05, "{name}: {lamp}");
        let edge = area(&denoised, name, 188, 0, 4);
        assert!(edge.abs() < 0.05 * exposure, "{name}: {edge}");
    }
}

#[test]
fn what_is_not_a_number_is_black_and_counted() {
    let mut noisy = picture(20, 10, |_, _| [0.5; 3]);
    for channel in noisy.channels.iter_mut().filter(|channel| channel.name == "G" || channel.name == "HalfA.G") {
        channel.values[7] = f32::NAN;
        channel.values[55] = f32::INFINITY;
    }
    let (denoised, replaced) = Method::Nlm.denoise(noisy, &Unwatched).unwrap();
    assert_eq!(replaced, 2);
    assert!(COLORS.iter().all(|name| values(&denoised, name).iter().all(|value| value.is_finite())));
}

#[test]
fn missing_channels_and_empty_halves_are_named() {
    let whole = picture(4, 4, |_, _| [0.5; 3]);
    let problem = |picture: &Picture| Method::Nlm.denoise(picture.clone(), &Unwatched).unwrap_err();
    let mut plain = whole.clone();
    plain.channels.retain(|channel| channel.name != "HalfB.G" && !channel.name.starts_with("Ns"));
    let text = problem(&plain).to_string();
    assert!(text.starts_with("lacks the channels HalfB.G\n  help: render with --aov"), "{text}");
    let mut empty = whole.clone();
    empty.channels.iter_mut().filter(|c| c.name.starts_with("HalfB")).for_each(|c| c.values.fill(0.0));
    assert!(matches!(problem(&empty), DenoiseError::EmptyHalf(_)));
    let mut single = whole.clone();
    single.metadata.samples_per_pixel = 1;
    assert!(problem(&single).to_string().contains("at least 5 samples"), "{}", problem(&single));
    let warnings = Method::Nlm.check(&whole).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
}

/// Open Image Denoise, or a word that it is not there.
fn oidn() -> Option<Method> {
    Oidn::find().map(Method::Oidn).map_err(|error| eprintln!("skipped: {error}")).ok()
}

#[test]
fn open_image_denoise_lowers_the_error() {
    let Some(method) = oidn() else { return };
    let (noisy, reference) = (cornell(16, 1), cornell(2048, 77));
    let denoised = method.denoise(noisy.clone(), &Unwatched).unwrap().0;
    let (raw, found) = (error(&denoised, "Noisy", &reference), error(&denoised, "", &reference));
    assert!(found * 4.0 < raw, "{raw} became {found}");
    // Colours alone are enough, with a warning.
    let mut plain = noisy;
    plain.channels.truncate(3);
    let warnings = method.check(&plain).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("Albedo and Ns"), "{warnings:?}");
    let denoised = method.denoise(plain, &Unwatched).unwrap().0;
    assert!(error(&denoised, "", &reference) < raw);
}
