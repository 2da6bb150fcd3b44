//! Denoising of pictures: exact results, no worse pictures, and messages.

mod command;
mod pictures;

use halfdome::driver::Watch;
use halfdome::film::{Channel, Metadata, Picture};

/// Hears of nothing and stops nothing.
struct Unwatched;

impl Watch for Unwatched {
    fn advance(&self, _samples: u64, _rays: u64) {}
    fn stop(&self) -> bool {
        false
    }
}

/// The names of a group's channels.
fn names(group: &str, ends: [&str; 3]) -> [String; 3] {
    ends.map(|end| if group.is_empty() { end.to_owned() } else { format!("{group}.{end}") })
}

const COLORS: [&str; 3] = ["R", "G", "B"];
const AXES: [&str; 3] = ["X", "Y", "Z"];

/// A picture without noise with the channels that denoisers read: colours by a function, albedos equal to them, one
/// normal.
fn picture(width: u32, height: u32, color: impl Fn(u32, u32) -> [f32; 3]) -> Picture {
    let mut channels = Vec::new();
    let mut add = |group: &str, ends: [&str; 3], value: &dyn Fn(u32, u32) -> [f32; 3]| {
        for (c, name) in names(group, ends).into_iter().enumerate() {
            let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            channels.push(Channel { name, values: pixels.map(|(x, y)| value(x, y)[c]).collect() });
        }
    };
    for group in ["", "HalfA", "HalfB", "Albedo"] {
        add(group, COLORS, &color);
    }
    add("Variance", COLORS, &|_, _| [0.0; 3]);
    add("Ns", AXES, &|_, _| [0.0, 0.0, 1.0]);
    add("P", AXES, &|x, y| [x as f32, y as f32, 0.0]);
    let metadata = Metadata { samples_per_pixel: 16, ..Metadata::default() };
    Picture { width, height, channels, metadata }
}

/// The values of a channel.
fn values<'a>(picture: &'a Picture, name: &str) -> &'a [f32] {
    &picture.channel(name).unwrap_or_else(|| panic!("there is no {name}")).values
}

/// The mean of `(a - b)² / (b² + 0.01)` over colours.
fn error(a: &Picture, group: &str, reference: &Picture) -> f64 {
    let mut sum = 0.0;
    for (name, of_reference) in names(group, COLORS).iter().zip(COLORS) {
        let (found, expected) = (values(a, name), values(reference, of_reference));
        let errors =
            found.iter().zip(expected).map(|(&a, &b)| f64::from(a - b).powi(2) / (f64::from(b).powi(2) + 0.01));
        sum += errors.sum::<f64>() / found.len() as f64;
    }
    sum / 3.0
}
