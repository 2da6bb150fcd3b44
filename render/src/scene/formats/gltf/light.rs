//! `KHR_lights_punctual`: lights shine along their node's -Z axis. Scale does not change them.
//!
//! The extension has no sizes. In a light's `extras`, which Blender writes from custom properties, `radius` is the
//! radius of a point or spot (metres), and `angle` the angle that the disc of a directional light subtends (radians).
//!
//! A spot of Blender's fades by a smoothstep in the cosine, over the part `blend` of the way from the edge of its cone
//! to the axis, and Blender writes `(1 - blend)` times the outer angle for the inner one. In its files this edge is
//! used instead of the square of a ramp between the two angles, which the extension recommends. (A spot in Blender
//! 5.0's Cycles has the same profile within 0.003.)

use core::f32::consts::FRAC_PI_2;

use ::gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use ::gltf::json::validation::Checked;
use glam::{DVec3, Vec3};
use serde_json::Value;

use super::Document;
use super::hierarchy::Placed;
use crate::scene::formats::light_units::Strength;
use crate::scene::{LightUnits, PunctualLight, SceneError, SpotEdge};

/// Light `index` of the file at a node.
pub(super) fn read(
    document: &Document,
    light: &Light,
    index: usize,
    placed: &Placed,
) -> Result<PunctualLight, SceneError> {
    let place = format!("light {index}");
    let strength = Vec3::from(light.color) * light.intensity;
    if !strength.is_finite() || strength.min_element() < 0.0 || light.intensity < 0.0 {
        return Err(document.error(
            place,
            "its colour or intensity is negative or not finite",
            "write numbers that are 0 or more",
        ));
    }
    let position = placed.origin();
    let radius = extra(document, light, &place, "radius", PunctualLight::MAX_RADIUS)?;
    let half_angle = 0.5 * extra(document, light, &place, "angle", MAX_ANGLE)?;
    match light.type_ {
        Checked::Valid(Type::Point) => Ok(PunctualLight::Point { position, intensity: strength, radius }),
        Checked::Valid(Type::Directional) => Ok(PunctualLight::Directional {
            direction: placed.direction(DVec3::NEG_Z).as_vec3(),
            irradiance: strength,
            half_angle,
        }),
        Checked::Valid(Type::Spot) => {
            let Some(spot) = &light.spot else {
                return Err(document.error(place, "it is a spot light without `spot`", "give it the object `spot`"));
            };
            let (inner, outer) = (spot.inner_cone_angle, spot.outer_cone_angle);
            // Equal angles are a hard edge: Blender writes a spot without blend so.
            if !(0.0 <= inner && inner <= outer && outer <= FRAC_PI_2 + 1e-5) {
                return Err(document.error(
                    place,
                    format!("its cone goes from {inner} to {outer}"),
                    "write angles in radians: 0 <= innerConeAngle <= outerConeAngle <= pi/2",
                ));
            }
            let (edge, cosines) = if document.is_from_blender() {
                let blend = if outer > 0.0 { 1.0 - inner / outer } else { 0.0 };
                (SpotEdge::Smooth, SpotEdge::blended(outer, blend))
            } else {
                (SpotEdge::Square, (inner.cos(), outer.cos()))
            };
            let (cos_inner, cos_outer) = SpotEdge::apart(cosines.0, cosines.1);
            Ok(PunctualLight::Spot {
                position,
                direction: placed.direction(DVec3::NEG_Z).as_vec3(),
                intensity: strength,
                radius,
                cos_inner,
                cos_outer,
                edge,
            })
        }
        Checked::Invalid => Err(document.error(place, "its type is unknown", "use directional, point or spot")),
    }
}

/// The units of the file's lights. Only Blender writes some that are not those of its emission.
pub(super) fn units(document: &Document) -> LightUnits {
    if !document.is_from_blender() {
        return LightUnits::Radiometric;
    }
    let extensions = document.root.extensions.as_ref();
    let listed = extensions.and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    let strengths = listed.iter().flat_map(|listed| &listed.lights).map(|light| match light.type_ {
        Checked::Valid(Type::Directional) => Strength::Irradiance(light.intensity),
        _ => Strength::Intensity(light.intensity),
    });
    LightUnits::guess_of_blender(&strengths.collect::<Vec<_>>())
}

/// Whether a light is a spot at a node whose axes are not equally long, by a hundredth, or not at right angles.
pub(super) fn is_stretched_spot(light: &Light, placed: &Placed) -> bool {
    let linear = placed.linear();
    let axes = [linear.x_axis, linear.y_axis, linear.z_axis];
    let lengths = DVec3::from_array(axes.map(|axis| axis.length()));
    let [x, y, z] = axes.map(DVec3::normalize_or_zero);
    let is_sheared = DVec3::new(x.dot(y), y.dot(z), z.dot(x)).abs().max_element() > 0.01;
    let is_spot = matches!(light.type_, Checked::Valid(Type::Spot));
    is_spot && (is_sheared || lengths.max_element() > 1.01 * lengths.min_element())
}

/// The largest sun, in radians.
const MAX_ANGLE: f32 = 3.125;

/// A number of a light's extras that is at most `most`, 0 if it is not there.
fn extra(document: &Document, light: &Light, place: &str, name: &str, most: f32) -> Result<f32, SceneError> {
    let extras = light.extras.as_ref().and_then(|extras| serde_json::from_str::<Value>(extras.get()).ok());
    let Some(value) = extras.as_ref().and_then(|extras| extras.get(name)) else { return Ok(0.0) };
    match value.as_f64() {
        Some(number) if (0.0..=f64::from(most)).contains(&number) => Ok(number as f32),
        _ => {
            let problem = format!("extras.{name} is {value}");
            // Without an exponent where that is short.
            let most = if most < 1e6 { most.to_string() } else { format!("{most:e}") };
            Err(document.error(place.to_owned(), problem, format!("write a number from 0 to {most}")))
        }
    }
}
