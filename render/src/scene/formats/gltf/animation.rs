//! Animations: channels, each of which gives a property of a node at any time (glTF 2.0, section 3.11 and appendix C).
//!
//! Between the keys k and k + 1, at `t` = 0 to 1 and `d` seconds apart, a property is the value at k (`STEP`), a mean
//! of both, of rotations along the shorter arc (`LINEAR`), or a cubic (`CUBICSPLINE`) of values v, out-tangents b and
//! in-tangents a: `(2t³ - 3t² + 1) v_k + d (t³ - 2t² + t) b_k + (3t² - 2t³) v_(k+1) + d (t³ - t²) a_(k+1)`. Before the
//! first key and after the last one it has their values.
//!
//! Blender writes an animation for each action, in `frame / fps` seconds: those of several objects play together, but
//! only one of an object's actions (walk, run) can play. So animations play together unless they move the same property
//! of a node; then the first of the file does.
//!
//! Deviations: keys of equal times are allowed, and step. `KHR_animation_pointer` is not read.

mod sample;

use std::borrow::Cow;

use ::gltf::json::accessor::ComponentType::{self, F32, I8, I16, U8, U16};
use ::gltf::json::scene::Node;
use ::gltf::json::{Index, deserialize};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::{Document, accessor};
use crate::scene::SceneError;
use crate::scene::formats::notes::Notes;
use crate::scene::nearest::suggestion;

/// An animation as the file lists it. The types of the crate `gltf` refuse channels without a node, which are allowed.
#[derive(Deserialize)]
pub(super) struct Listed {
    name: Option<String>,
    #[serde(default)]
    channels: Vec<ListedChannel>,
    #[serde(default)]
    samplers: Vec<Sampler>,
}

#[derive(Deserialize)]
struct ListedChannel {
    sampler: usize,
    target: Target,
}

#[derive(Deserialize)]
struct Target {
    node: Option<u32>,
    path: String,
}

#[derive(Deserialize)]
struct Sampler {
    input: u32,
    output: u32,
    interpolation: Option<String>,
}

/// The animations that `raw`, a part of `text`, lists, and `text` with an empty list instead, as long and with as many
/// lines.
pub(super) fn cut<'a>(
    text: &'a [u8],
    raw: Option<&RawValue>,
) -> Result<(Vec<Listed>, Cow<'a, [u8]>), ::gltf::json::Error> {
    let Some(raw) = raw.map(RawValue::get) else { return Ok((Vec::new(), Cow::Borrowed(text))) };
    let listed = deserialize::from_str(raw)?;
    let start = raw.as_ptr() as usize - text.as_ptr() as usize;
    let mut rest = text.to_vec();
    let hole = &mut rest[start..start + raw.len()];
    hole.iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = b' ');
    (hole[0], hole[raw.len() - 1]) = (b'[', b']');
    Ok((listed, Cow::Owned(rest)))
}

/// A property of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Property {
    Translation,
    Rotation,
    Scale,
    /// The weights of morph targets.
    Weights,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// A property over time.
pub(super) struct Channel {
    pub(super) node: usize,
    pub(super) property: Property,
    interpolation: Interpolation,
    /// Seconds, ascending; at least one.
    times: Vec<f32>,
    /// `width` numbers for each time; of cubics an in-tangent, a value and an out-tangent.
    values: Vec<f32>,
    width: usize,
}

/// An animation.
pub(super) struct Animation {
    pub(super) name: String,
    pub(super) channels: Vec<Channel>,
}

/// All animations of the file.
pub(super) fn read(document: &Document, notes: &mut Notes) -> Result<Vec<Animation>, SceneError> {
    let mut animations = Vec::new();
    for (number, listed) in document.animations.iter().enumerate() {
        let (place, name) = match &listed.name {
            Some(name) => (format!("animation {number} ({name:?})"), name.clone()),
            None => (format!("animation {number}"), number.to_string()),
        };
        let mut channels: Vec<Channel> = Vec::new();
        for (number, listed_channel) in listed.channels.iter().enumerate() {
            let place = format!("{place}, channel {number}");
            let Some(channel) = channel(document, listed, listed_channel, &place, notes)? else { continue };
            if channels.iter().any(|other| other.moves_what(&channel)) {
                notes.add("a channel that moves what an earlier one of its animation moves is left out", place);
            } else {
                channels.push(channel);
            }
        }
        animations.push(Animation { name, channels });
    }
    Ok(animations)
}

/// A channel; `None` of one that moves nothing here, which is noted if the file has a use for it.
fn channel(
    document: &Document,
    animation: &Listed,
    ListedChannel { sampler, target }: &ListedChannel,
    place: &str,
    notes: &mut Notes,
) -> Result<Option<Channel>, SceneError> {
    let Some(Sampler { input, output, interpolation }) = animation.samplers.get(*sampler) else {
        let problem = format!("it refers to sampler {sampler}, which does not exist");
        return Err(document.error(place, problem, "refer to one that the animation has, counted from 0"));
    };
    let property = match target.path.as_str() {
        "translation" => Property::Translation,
        "rotation" => Property::Rotation,
        "scale" => Property::Scale,
        "weights" => Property::Weights,
        "pointer" => {
            notes.add("KHR_animation_pointer is not read", place);
            return Ok(None);
        }
        path => {
            let problem = format!("its path {path:?} is unknown");
            return Err(document.error(place, problem, "use translation, rotation, scale or weights"));
        }
    };
    // The specification says to ignore such channels.
    let Some(node) = target.node else { return Ok(None) };
    let width = match (property, document.object(Index::<Node>::new(node), "node", place)?.mesh) {
        (Property::Translation | Property::Scale, _) => 3,
        (Property::Rotation, _) => 4,
        (Property::Weights, None) => 0,
        (Property::Weights, Some(mesh)) => {
            let primitives = &document.object(mesh, "mesh", place)?.primitives;
            primitives.iter().filter_map(|it| it.targets.as_ref()).map(Vec::len).max().unwrap_or(0)
        }
    };
    if width == 0 {
        notes.add("weights of a node without morph targets are animated, which changes nothing", place);
        return Ok(None);
    }
    let interpolation = match interpolation.as_deref() {
        Some("STEP") => Interpolation::Step,
        Some("LINEAR") | None => Interpolation::Linear,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        Some(other) => {
            let problem = format!("its interpolation {other:?} is unknown");
            return Err(document.error(place, problem, "use STEP, LINEAR or CUBICSPLINE"));
        }
    };
    let times = times(document, *input, place)?;
    let values = values(document, *output, property, place)?;
    let in_key = width * if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    if values.len() != times.len() * in_key {
        let (keys, found) = (times.len(), values.len());
        let problem = format!("its {keys} keys need {} numbers, and accessor {output} has {found}", keys * in_key);
        return Err(document.error(place, problem, "give each key a value, and those of CUBICSPLINE two tangents"));
    }
    if times.is_empty() {
        notes.add("a channel without keys changes nothing", place);
        return Ok(None);
    }
    let channel = Channel { node: node as usize, property, interpolation, times, values, width };
    let is_zero = |key: &usize| channel.value(*key).iter().all(|&number| number == 0.0);
    if let Some(key) = (0..channel.times.len()).find(is_zero).filter(|_| property == Property::Rotation) {
        return Err(document.error(place, format!("its rotation at key {key} is zero"), "write unit quaternions"));
    }
    Ok(Some(channel))
}

fn times(document: &Document, input: u32, place: &str) -> Result<Vec<f32>, SceneError> {
    let times = accessor::read::<1>(document, Index::new(input), place, "times", &[F32])?;
    let times: Vec<f32> = times.into_iter().map(|[time]| time.raw()).collect();
    if let Some(key) = times.iter().position(|time| !time.is_finite()) {
        let problem = format!("the time of key {key} is not finite");
        return Err(document.error(place, problem, "write seconds"));
    }
    if let Some(key) = times.windows(2).position(|pair| pair[1] < pair[0]) {
        let problem = format!("its keys are out of order: {} s comes before {} s", times[key], times[key + 1]);
        return Err(document.error(place, problem, "sort the keys by their times"));
    }
    Ok(times)
}

/// All numbers of the accessor; integers are normalised.
fn values(document: &Document, output: u32, property: Property, place: &str) -> Result<Vec<f32>, SceneError> {
    const INTEGERS: [ComponentType; 5] = [F32, I8, U8, I16, U16];
    fn flat<const N: usize>(read: Vec<[accessor::Component; N]>) -> Vec<f32> {
        read.into_iter().flatten().map(accessor::Component::normalised).collect()
    }
    let index = Index::new(output);
    let values = match property {
        Property::Translation => flat(accessor::read::<3>(document, index, place, "translations", &[F32])?),
        Property::Scale => flat(accessor::read::<3>(document, index, place, "scales", &[F32])?),
        Property::Rotation => flat(accessor::read::<4>(document, index, place, "rotations", &INTEGERS)?),
        Property::Weights => flat(accessor::read::<1>(document, index, place, "weights", &INTEGERS)?),
    };
    if values.iter().any(|number| !number.is_finite()) {
        let problem = format!("a number of accessor {output} is not finite");
        return Err(document.error(place, problem, "export the model again"));
    }
    Ok(values)
}

impl Channel {
    /// Whether both move the same property.
    fn moves_what(&self, other: &Self) -> bool {
        (self.node, self.property) == (other.node, other.property)
    }
}

impl Animation {
    /// When its first and last keys are, in seconds; 0 without keys.
    pub(super) fn span(&self) -> (f32, f32) {
        let ends = self.channels.iter().map(|channel| (channel.times[0], channel.times[channel.times.len() - 1]));
        ends.reduce(|(from, to), (first, last)| (from.min(first), to.max(last))).unwrap_or_default()
    }
}

/// The `animations` with these `names`, or all, without those that animate the same property as an earlier one.
pub(super) fn playing<'a>(
    document: &Document,
    animations: &'a [Animation],
    names: &[String],
    notes: &mut Notes,
) -> Result<Vec<&'a Animation>, SceneError> {
    let known: Vec<&str> = animations.iter().map(|animation| animation.name.as_str()).collect();
    if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
        let remedy = match known.is_empty() {
            true => "it has none: leave the option out".to_owned(),
            false => suggestion(name, &known),
        };
        return Err(SceneError::new(
            document.path,
            crate::scene::Place::File,
            format!("the model has no animation {name:?}"),
            remedy,
        ));
    }
    let mut candidates: Vec<&Animation> = animations.iter().collect();
    if !names.is_empty() {
        candidates.retain(|animation| names.contains(&animation.name));
    }
    let mut playing: Vec<&Animation> = Vec::new();
    for candidate in candidates {
        let clashes = |other: &&Animation| {
            candidate.channels.iter().any(|channel| other.channels.iter().any(|moved| moved.moves_what(channel)))
        };
        match playing.iter().find(|other| clashes(other)) {
            Some(other) => notes.add(
                format!("animations that move what {:?} moves are not played (--animation chooses)", other.name),
                format!("{:?}", candidate.name),
            ),
            None => playing.push(candidate),
        }
    }
    Ok(playing)
}
