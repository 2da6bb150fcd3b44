//! Lights. Radiance and intensity are those of the film in pbrt: `rgb` is used unchanged, every other spectrum is
//! scaled to a luminance of 1 (pbrt divides it by its luminous intensity), and `scale` multiplies both.
//!
//! `power` and `illuminance` set a light's total, as in pbrt. There each triangle or patch of a mesh is a light of its
//! own that gets the whole `power`; a mesh has that sum here, evenly spread.

use std::rc::Rc;

use glam::{DVec3, Vec3};

use super::Reader;
use super::parameters::Parameters;
use super::round::area;
use super::sky;
use super::spectrum::{LUMINANCE, Spectrum};
use crate::scene::description::unit;
use crate::scene::nearest::suggestion;
use crate::scene::{Mesh, PunctualLight, SceneError, SpotEdge, TextureMap};

/// The emission of the following shapes by an `AreaLightSource`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AreaLight {
    radiance: Vec3,
    power: Option<f32>,
    pub(super) two_sided: bool,
    pub(super) picture: Option<TextureMap>,
    /// The mean of the picture, or 1.
    mean: f32,
}

const KNOWN: [&str; 4] = ["distant", "infinite", "point", "spot"];

impl Reader<'_> {
    /// The colour of a light by its parameter; white without one.
    fn light_color(&mut self, parameters: &Parameters, name: &str) -> Result<Vec3, SceneError> {
        let Some(spectrum) = Spectrum::read(parameters, name, self.files, &self.folder)? else { return Ok(Vec3::ONE) };
        let color = spectrum.light();
        if color.is_none() {
            self.note(&parameters.at, &format!("the spectrum of `{name}` is not read; white instead"));
        }
        Ok(color.unwrap_or(Vec3::ONE))
    }

    /// `LightSource`.
    pub(super) fn light(&mut self, kind: &str, parameters: &Parameters) -> Result<(), SceneError> {
        let to_world = self.to_world();
        let place = |point: Vec3| to_world.transform_point3(point.as_dvec3()).as_vec3();
        let scale = parameters.float("scale", 1.0)?;
        match kind {
            "point" => {
                let power = parameters.optional_float("power")?.filter(|power| *power > 0.0);
                let factor = power.map_or(1.0, |power| power / (4.0 * std::f32::consts::PI));
                let intensity = self.light_color(parameters, "I")? * scale * factor;
                let position = place(parameters.point("from", Vec3::ZERO)?);
                self.scene.lights.push(PunctualLight::Point { position, intensity, radius: 0.0 });
            }
            "spot" => {
                let intensity = self.light_color(parameters, "I")? * scale;
                let from = parameters.point("from", Vec3::ZERO)?;
                let to = parameters.point("to", Vec3::Z)?;
                let outer = parameters.float("coneangle", 30.0)?;
                let inner = outer - parameters.float("conedeltaangle", 5.0)?;
                if !(outer > 0.0 && outer <= 90.0 && inner <= outer) {
                    let problem = format!("the cone of a spot goes from {inner} to {outer} degrees");
                    return Err(parameters
                        .at
                        .error(problem, "write a `coneangle` up to 90, a `conedeltaangle` from 0"));
                }
                let [cos_inner, cos_outer] = [inner.max(0.0), outer].map(|angle| angle.to_radians().cos());
                let power = parameters.optional_float("power")?.filter(|power| *power > 0.0);
                let solid_angle = SpotEdge::Smooth.solid_angle(cos_inner, cos_outer) as f32;
                let (cos_inner, cos_outer) = SpotEdge::apart(cos_inner, cos_outer);
                self.scene.lights.push(PunctualLight::Spot {
                    position: place(from),
                    direction: direction(place(from), place(to), parameters)?,
                    intensity: intensity * power.map_or(1.0, |power| power / solid_angle),
                    radius: 0.0,
                    cos_inner,
                    cos_outer,
                    edge: SpotEdge::Smooth,
                });
            }
            "distant" => {
                let illuminance = parameters.optional_float("illuminance")?.filter(|it| *it > 0.0).unwrap_or(1.0);
                let irradiance = self.light_color(parameters, "L")? * scale * illuminance;
                let [from, to] = [parameters.point("from", Vec3::ZERO)?, parameters.point("to", Vec3::Z)?];
                let direction = direction(place(from), place(to), parameters)?;
                self.scene.lights.push(PunctualLight::Directional { direction, irradiance, half_angle: 0.0 });
            }
            "infinite" => self.infinite(parameters, scale)?,
            "goniometric" | "projection" => {
                self.note(&parameters.at, &format!("a light {kind:?} is not read"));
                parameters.unused().for_each(|unused| parameters.ignore(&[&unused.name]));
            }
            _ => {
                let problem = format!("there is no light {kind:?}");
                return Err(parameters.at.error(problem, suggestion(kind, &KNOWN)));
            }
        }
        Ok(())
    }

    fn infinite(&mut self, parameters: &Parameters, scale: f32) -> Result<(), SceneError> {
        let illuminance = parameters.optional_float("illuminance")?.filter(|it| *it > 0.0);
        if parameters.get("portal").is_some() {
            self.note(&parameters.at, "the portal of an infinite light is not read: its light comes from everywhere");
        }
        if parameters.has("mapname") {
            return Err(super::of_v3(&parameters.at, "`mapname` of an infinite light"));
        }
        let Some(name) = parameters.text("filename")?.map(str::to_owned) else {
            let factor = illuminance.map_or(1.0, |it| it / std::f32::consts::PI);
            let color = self.light_color(parameters, "L")?;
            self.scene.sky.radiance += color * scale * factor;
            return Ok(());
        };
        if parameters.has("L") {
            let problem = "an infinite light has both `L` and `filename`";
            return Err(parameters.at.error(problem, "write one of them"));
        }
        let path = self.resolve(&name, &parameters.at);
        let bytes = self.read_file(&path, &parameters.at)?;
        let wrong = |problem: &str, remedy: &str| parameters.at.error(format!("{}: {problem}", path.display()), remedy);
        let picture =
            crate::scene::texture::decode(&bytes, Some(&path)).map_err(|error| wrong(&error.problem, error.remedy))?;
        let (width, height) = picture.size();
        if width != height || width > 1 << 13 {
            let remedy = "convert it by pbrt's `imgtool makeequiarea`, to 8192 x 8192 at most";
            let problem =
                format!("it has {width} x {height} pixels, and is no square of the equal-area octahedral map");
            return Err(wrong(&problem, remedy));
        }
        if self.scene.sky.picture.is_some() {
            self.note(&parameters.at, "a second picture of an infinite light is not read");
            return Ok(());
        }
        let to_light = self.to_world().matrix3.inverse();
        let factor = illuminance.map_or(1.0, |it| it / sky::illuminance(&picture) as f32);
        let factor = if factor.is_finite() { factor } else { 0.0 };
        self.scene.sky.picture = Some(sky::resample(&picture, to_light, Vec3::splat(scale * factor)));
        Ok(())
    }

    /// `AreaLightSource`.
    pub(super) fn area_light(&mut self, kind: &str, parameters: &Parameters) -> Result<Rc<AreaLight>, SceneError> {
        if kind != "diffuse" {
            let problem = format!("there is no area light {kind:?}");
            return Err(parameters.at.error(problem, "write \"diffuse\", the only kind"));
        }
        let radiance = self.light_color(parameters, "L")? * parameters.float("scale", 1.0)?;
        let texture = match parameters.text("filename")?.map(str::to_owned) {
            Some(name) => self.load_image(&name, parameters),
            None => None,
        };
        let picture = texture.map(|texture| TextureMap { texture, ..TextureMap::default() });
        let mean = texture.map_or(1.0, |texture| self.textures.list[texture].mean().truncate().dot(LUMINANCE));
        let two_sided = parameters.flag("twosided", false)?;
        let power = parameters.optional_float("power")?.filter(|power| *power > 0.0);
        Ok(Rc::new(AreaLight { radiance, power, two_sided, picture, mean }))
    }
}

impl AreaLight {
    /// The radiance that a mesh in world space emits, of as many lights.
    pub(super) fn radiance_of(&self, mesh: &Mesh, lights: usize) -> Vec3 {
        let Some(power) = self.power else { return self.radiance };
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        let emitted = std::f64::consts::PI * sides * area(mesh) * f64::from(self.mean);
        let factor = f64::from(power) * lights as f64 / emitted;
        if factor.is_finite() { self.radiance * factor as f32 } else { Vec3::ZERO }
    }
}

fn direction(from: Vec3, to: Vec3, parameters: &Parameters) -> Result<Vec3, SceneError> {
    let along: DVec3 = to.as_dvec3() - from.as_dvec3();
    unit(along.as_vec3()).ok_or_else(|| {
        let problem = format!("`from` and `to` of {} are the same point", parameters.of);
        parameters.at.error(problem, "write two points; the light goes from the first to the second")
    })
}
