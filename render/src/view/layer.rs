//! The layer that is shown, and the mapping of its values to colours.
//!
//! Radiance is shown as in PNG files, by the same code. Vectors are shown as `(n + 1) / 2`, positions relative to the
//! scene's box, motion vectors `v` with the longest `m` as `(v / m + 1) / 2`, counts and depths by false colours up to
//! their 99th percentile, and ids by distinct colours.

use glam::Vec3;
use rayon::prelude::*;

use crate::film::Picture;
use crate::integrator;
use crate::output::ToneMapping;
use crate::output::false_color;
use crate::settings::Settings;
use crate::world::World;

/// The depth from which on nothing was hit; no measured depth is as large.
const NOTHING: f32 = 1e9;
/// sRGB codes of what has no value.
const EMPTY: [u8; 3] = [24; 3];

/// A layer: channels that are shown together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// The name.
    pub name: String,
    /// Its channels: three, or one; and alpha with the picture itself.
    pub channels: Vec<String>,
    kind: Kind,
    /// Whether it needs [`Settings::aov`].
    pub needs_aov: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Linear light: exposure and tone curve.
    Light,
    /// Linear numbers from 0 to 1: neither.
    Color,
    /// Unit vectors.
    Vector,
    /// Points of the scene.
    Point,
    /// Vectors of any length.
    Motion,
    /// Two coordinates of pictures.
    Texcoord,
    /// More is lighter.
    Count,
    /// Less is lighter.
    Depth,
    /// Whole numbers that are names.
    Id,
}

impl Layer {
    fn new(name: &str, kind: Kind, channels: &[&str], needs_aov: bool) -> Self {
        let channels = channels.iter().map(|&channel| channel.to_owned()).collect();
        Self { name: name.to_owned(), channels, kind, needs_aov }
    }

    fn of_light(name: &str, needs_aov: bool) -> Self {
        let channels = ["R", "G", "B"].map(|color| format!("{name}.{color}"));
        Self { name: name.to_owned(), channels: channels.into(), kind: Kind::Light, needs_aov }
    }

    /// The layers that pictures of a world can have with these settings: the picture itself, AOVs by light path
    /// expressions, and those of `--aov`.
    pub fn all(world: &World, settings: &Settings) -> Vec<Self> {
        let picture = match settings.integrator.name() {
            "heat" => Self::new("cost", Kind::Count, &["R"], false),
            _ => Self::new("light", Kind::Light, &["R", "G", "B", "A"], false),
        };
        let light = integrator::aovs(world, settings).into_iter().map(|aov| Self::of_light(&aov.name, false));
        let mut layers: Vec<Self> = std::iter::once(picture).chain(light).collect();
        layers.extend([
            Self::new("Albedo", Kind::Color, &["Albedo.R", "Albedo.G", "Albedo.B"], true),
            Self::new("N", Kind::Vector, &["N.X", "N.Y", "N.Z"], true),
            Self::new("Ns", Kind::Vector, &["Ns.X", "Ns.Y", "Ns.Z"], true),
            Self::new("P", Kind::Point, &["P.X", "P.Y", "P.Z"], true),
            Self::new("UV", Kind::Texcoord, &["UV.U", "UV.V"], true),
            Self::new("Depth", Kind::Depth, &["Depth.Z"], true),
            Self::new("Id.Object", Kind::Id, &["Id.Object"], true),
            Self::new("Id.Instance", Kind::Id, &["Id.Instance"], true),
            Self::new("Id.Material", Kind::Id, &["Id.Material"], true),
            Self::new("Id.Triangle", Kind::Id, &["Id.Triangle"], true),
            Self::new("forward", Kind::Motion, &["forward.u", "forward.v"], true),
            Self::of_light("Variance", true),
            Self::new("Samples", Kind::Count, &["Samples.Y"], true),
        ]);
        layers.extend(["HalfA", "HalfB"].map(|half| Self::of_light(half, true)));
        layers
    }

    /// Whether exposure and tone curve change how it looks.
    pub fn is_toned(&self) -> bool {
        self.kind == Kind::Light
    }

    /// The sRGB codes of a picture's pixels, row by row from the top; `bounds` are the scene's. Channels that are
    /// missing count as 0.
    pub fn codes(&self, picture: &Picture, tone: &ToneMapping, bounds: (Vec3, Vec3)) -> Vec<[u8; 3]> {
        let count = picture.width as usize * picture.height as usize;
        let plane = |number: usize| {
            let channel = self.channels.get(number).and_then(|name| picture.channel(name));
            channel.map(|channel| channel.values.as_slice())
        };
        let planes = [0, 1, 2, 3].map(plane);
        let values = |pixel: usize| planes.map(|plane| plane.map_or(0.0, |values| values[pixel]));
        let linear = ToneMapping::default();
        let scale = match self.kind {
            Kind::Count => false_color::scale(planes[0].unwrap_or_default()) as f32,
            Kind::Depth => percentile(planes[0].unwrap_or_default()),
            Kind::Motion => longest(planes[0].unwrap_or_default()).max(longest(planes[1].unwrap_or_default())),
            _ => 1.0,
        };
        let code = |pixel: usize| {
            let [r, g, b, a] = values(pixel);
            match self.kind {
                Kind::Light => match planes[3] {
                    None => tone.to_srgb8([r, g, b]),
                    // Colours are multiplied by alpha.
                    Some(_) if a > 0.0 => mix(tone.to_srgb8([r, g, b].map(|value| value / a)), a),
                    Some(_) => EMPTY,
                },
                Kind::Color => linear.to_srgb8([r, g, b]),
                // Codes, not light: so they are shown everywhere.
                Kind::Vector => [r, g, b].map(|value| unit_code(0.5 * value + 0.5)),
                Kind::Motion => [r / scale, g / scale, 0.0].map(|value| unit_code(0.5 * value + 0.5)),
                Kind::Point => {
                    let extent = (bounds.1 - bounds.0).max(Vec3::splat(f32::MIN_POSITIVE));
                    ((Vec3::new(r, g, b) - bounds.0) / extent).to_array().map(unit_code)
                }
                Kind::Texcoord => [r, g, 0.0].map(|value| unit_code(value - value.floor())),
                Kind::Count => false_color::color(r / scale),
                Kind::Depth if r >= NOTHING => EMPTY,
                Kind::Depth => false_color::color(1.0 - r / scale),
                Kind::Id => id_color(r),
            }
        };
        (0..count).into_par_iter().map(code).collect()
    }
}

/// A colour that covers a part of what is empty.
fn mix(color: [u8; 3], part: f32) -> [u8; 3] {
    std::array::from_fn(|c| (f32::from(color[c]) * part + f32::from(EMPTY[c]) * (1.0 - part)).round() as u8)
}

/// The code of a number from 0 to 1.
fn unit_code(value: f32) -> u8 {
    (255.0 * value.clamp(0.0, 1.0)).round() as u8
}

/// A number that nearly all depths are below, more than 0.
fn percentile(values: &[f32]) -> f32 {
    let mut sorted: Vec<f32> = values.iter().copied().filter(|&value| value < NOTHING).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let value = sorted.get(sorted.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(1.0);
    if value > 0.0 { value } else { 1.0 }
}

/// The greatest magnitude, more than 0.
fn longest(values: &[f32]) -> f32 {
    values.iter().fold(f32::MIN_POSITIVE, |longest, value| longest.max(value.abs()))
}

/// A colour for each id, not dark; what has none is empty.
fn id_color(id: f32) -> [u8; 3] {
    if id <= 0.0 {
        return EMPTY;
    }
    let hash = xxhash_rust::xxh3::xxh3_64(&(id as u32).to_le_bytes()).to_le_bytes();
    [hash[0], hash[1], hash[2]].map(|byte| 64 + byte / 4 * 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Channel, Metadata};
    use crate::output::ToneCurve;
    use crate::scene::cornell_box;

    const UNIT: (Vec3, Vec3) = (Vec3::ZERO, Vec3::ONE);

    fn layers() -> Vec<Layer> {
        let settings = Settings { light_groups: true, ..Settings::default() };
        Layer::all(&World::new(cornell_box()).unwrap(), &settings)
    }

    fn picture(channels: &[(&str, [f32; 2])]) -> Picture {
        let channel = |&(name, values): &(&str, [f32; 2])| Channel { name: name.to_owned(), values: values.into() };
        let channels = channels.iter().map(channel).collect();
        Picture { width: 2, height: 1, channels, metadata: Metadata::default() }
    }

    fn codes(name: &str, channels: &[(&str, [f32; 2])]) -> Vec<[u8; 3]> {
        let layer = layers().into_iter().find(|layer| layer.name == name).unwrap();
        layer.codes(&picture(channels), &ToneMapping::default(), UNIT)
    }

    #[test]
    fn light_is_shown_as_png_shows_it() {
        let tone = ToneMapping { exposure: 1.5, curve: ToneCurve::Neutral };
        let picture = picture(&[("R", [0.1, 4.0]), ("G", [0.2, f32::NAN]), ("B", [0.3, 0.0])]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        crate::output::write(&path, &picture, &tone).unwrap();
        let png = std::fs::read(&path).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&png)).read_info().unwrap();
        let mut expected = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut expected).unwrap();
        assert_eq!(layers()[0].codes(&picture, &tone, UNIT).as_flattened(), expected);
    }

    #[test]
    fn what_is_no_light_has_its_own_colours() {
        assert_eq!(codes("N", &[("N.X", [0.0, -1.0]), ("N.Y", [1.0, 0.0]), ("N.Z", [0.0; 2])])[0], [128, 255, 128]);
        assert_eq!(codes("P", &[("P.X", [0.0, 1.0]), ("P.Y", [0.5, 2.0]), ("P.Z", [1.0, -1.0])])[1], [255, 255, 0]);
        assert_eq!(codes("UV", &[("UV.U", [1.25, 0.0]), ("UV.V", [-0.25, 0.0])])[0], [64, 191, 0]);
        let depths = codes("Depth", &[("Depth.Z", [2.0, 1e10])]);
        assert_eq!(depths, [false_color::color(0.0), EMPTY]);
        let ids = codes("Id.Object", &[("Id.Object", [0.0, 1.0])]);
        assert!(ids[0] == EMPTY && ids[1] != EMPTY);
        let half = codes("light", &[("R", [0.5, 0.0]), ("G", [0.5, 0.0]), ("B", [0.5, 0.0]), ("A", [0.5, 0.0])]);
        assert_eq!(half, [[140; 3], EMPTY], "white over half of what is empty");
    }

    #[test]
    fn there_is_a_layer_for_each_channel_of_a_picture() {
        struct Unwatched;
        impl crate::watch::Watch for Unwatched {
            fn advance(&self, _: u64, _: u64) {}
            fn stop(&self) -> bool {
                false
            }
        }
        let settings = Settings {
            width: 4,
            height: 4,
            spp: 1,
            aov: true,
            halves: true,
            light_groups: true,
            ..Settings::default()
        };
        let world = World::new(cornell_box()).unwrap();
        let picture = crate::driver::render(&world, &settings, &Unwatched).picture;
        let shown: Vec<String> = layers().into_iter().flat_map(|layer| layer.channels).collect();
        // Texture coordinates have two names.
        let is_shown = |name: &String| shown.contains(name) || name == "u" || name == "v";
        let missing: Vec<_> = picture.channels.iter().map(|channel| &channel.name).filter(|it| !is_shown(it)).collect();
        assert!(missing.is_empty(), "{missing:?}");
        assert!(layers().iter().any(|layer| layer.name == "Light_light" && layer.is_toned()));
    }
}
