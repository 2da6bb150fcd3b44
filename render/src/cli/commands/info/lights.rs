//! The lights of a scene: kind, power, and the share of light samples that each gets.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use serde::Serialize;

use super::spaced;
use crate::cli::memory;
use crate::scene::{LightUnits, PunctualLight, Scene};
use crate::world::World;

/// As many lights as the table shows; the JSON has all.
const ROWS: usize = 16;

#[derive(Debug, Default, PartialEq, Serialize)]
pub(super) struct Lights {
    emissive_triangles: usize,
    /// Counted once, even if both sides emit.
    emissive_area: f64,
    /// Watts in red, green and blue if a unit is a metre.
    emissive_power: [f64; 3],
    point: usize,
    spot: usize,
    directional: usize,
    /// Lights with a photometric profile.
    profile: usize,
    /// The units of the file's lights.
    units: Option<&'static str>,
    sky_radiance: [f32; 3],
    /// Bytes of the light trees.
    tree_bytes: usize,
    list: Vec<Light>,
}

/// All emissive triangles of a material, or another light.
#[derive(Debug, PartialEq, Serialize)]
struct Light {
    kind: &'static str,
    /// The material's or its own, or else the number among the lights of its kind.
    name: String,
    /// In red, green and blue.
    power: [f64; 3],
    unit: &'static str,
    /// The part of the light samples that it gets, all over the scene's surfaces.
    share: f64,
    /// A light by its index in the scene.
    #[serde(skip)]
    key: Key,
}

/// The light's index in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Key {
    Material(usize),
    Punctual(usize),
    Sky,
}

impl Lights {
    /// All but the shares.
    pub(super) fn of(scene: &Scene) -> Self {
        let sky = scene.sky.mean();
        let units = scene.light_units.map(LightUnits::name);
        let mut lights = Self { units, sky_radiance: sky.to_array(), ..Self::default() };
        let mut powers = vec![DVec3::ZERO; scene.materials.len()];
        for mesh in &scene.meshes {
            let material = scene.materials[mesh.material].without_maps(&scene.textures);
            if material.emission == Vec3::ZERO {
                continue;
            }
            lights.emissive_triangles += mesh.triangles.len();
            let area: f64 = mesh
                .triangles
                .iter()
                .map(|triangle| {
                    let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
                    0.5 * (b - a).cross(c - a).length()
                })
                .sum();
            lights.emissive_area += area;
            // A Lambertian side of area A and radiance L emits pi A L.
            let sides = if material.emits_both_sides { 2.0 } else { 1.0 };
            powers[mesh.material] += PI * sides * area * material.emission.as_dvec3();
        }
        lights.emissive_power = powers.iter().sum::<DVec3>().to_array();
        for (number, power) in powers.into_iter().enumerate().filter(|(_, power)| *power != DVec3::ZERO) {
            let material = &scene.materials[number];
            lights.push("area", material.name.clone(), power, "W", Key::Material(number));
        }
        for (number, light) in scene.lights.iter().enumerate() {
            let key = Key::Punctual(number);
            let (kind, count, unit) = match light {
                PunctualLight::Point { .. } => ("point", &mut lights.point, "W"),
                PunctualLight::Spot { .. } => ("spot", &mut lights.spot, "W"),
                PunctualLight::Profiled { .. } => ("profile", &mut lights.profile, "W"),
                PunctualLight::Directional { .. } => ("directional", &mut lights.directional, "W/m²"),
            };
            // The name that heat maps and light groups show.
            let named = scene.light_labels.get(number).map(|label| &label.name).filter(|name| !name.is_empty());
            let name = named.cloned().unwrap_or_else(|| count.to_string());
            *count += 1;
            let (color, extent) = light.power();
            lights.push(kind, name, extent * color.as_dvec3(), unit, key);
        }
        if sky != Vec3::ZERO {
            let kind = if scene.sky.picture.is_some() { "sky picture" } else { "sky" };
            lights.push(kind, String::new(), sky.as_dvec3(), "W/(m² sr)", Key::Sky);
        }
        lights
    }

    fn push(&mut self, kind: &'static str, name: String, power: DVec3, unit: &'static str, key: Key) {
        self.list.push(Light { kind, name, power: power.to_array(), unit, share: 0.0, key });
    }

    /// Adds the shares in the world made of the scene.
    pub(super) fn share(&mut self, world: &World) {
        let shares = world.light_shares();
        self.tree_bytes = shares.tree_bytes;
        for light in &mut self.list {
            light.share = match light.key {
                Key::Material(number) => shares.materials[number],
                Key::Punctual(number) => shares.punctual[number],
                Key::Sky => shares.sky,
            };
        }
    }

    /// Rows of the table: the greatest shares first.
    pub(super) fn rows(&self, row: &mut impl FnMut(&str, String)) {
        row("emissive triangles", format!("{}, area {:.6}", self.emissive_triangles, self.emissive_area));
        row("emitted power", format!("{} W (red, green, blue)", spaced(self.emissive_power)));
        let profiles = if self.profile > 0 { format!(", {} with a profile", self.profile) } else { String::new() };
        let counts = format!("{} point, {} spot, {} directional", self.point, self.spot, self.directional);
        row("other lights", counts + &profiles);
        if let Some(units) = self.units {
            row("light units", format!("{units} in the file"));
        }
        row("sky radiance", format!("{} W/(m² sr)", spaced(self.sky_radiance.map(f64::from))));
        if self.tree_bytes > 0 {
            row("light tree memory", memory::size(self.tree_bytes as u64));
        }
        let mut list: Vec<&Light> = self.list.iter().collect();
        list.sort_by(|a, b| b.share.total_cmp(&a.share));
        for Light { kind, name, power, unit, share, .. } in list.iter().take(ROWS) {
            let name = format!("{kind} {name}");
            let name = name.trim_end();
            row("light", format!("{:5.1}% of samples  {name}: {} {unit}", 100.0 * share, spaced(*power)));
        }
        if list.len() > ROWS {
            row("light", format!("and {} more; --json lists all", list.len() - ROWS));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{LightLabel, Sky, SpotEdge, cornell_box};

    #[test]
    fn the_cornell_light_has_the_power_of_its_area() {
        let lights = Lights::of(&cornell_box());
        assert_eq!(lights.emissive_triangles, 2);
        let area = 0.130 * 0.105;
        assert!((lights.emissive_area - area).abs() < 1e-8);
        for (power, radiance) in lights.emissive_power.into_iter().zip([18.4, 15.6, 8.0]) {
            assert!((power - PI * area * radiance).abs() < 1e-6 * radiance, "{power}");
        }
        let mut both = cornell_box();
        both.materials[3].emits_both_sides = true;
        assert_eq!(Lights::of(&both).emissive_power, lights.emissive_power.map(|power| 2.0 * power));
    }

    #[test]
    fn spots_have_the_power_of_their_cone() {
        let mut scene = cornell_box();
        for edge in [SpotEdge::Square, SpotEdge::Smooth] {
            let (position, direction, intensity) = (Vec3::ZERO, Vec3::X, Vec3::new(1.0, 2.0, 3.0));
            let (radius, cos_inner, cos_outer) = (0.0, 0.75, 0.25);
            let spot = PunctualLight::Spot { position, direction, intensity, radius, cos_inner, cos_outer, edge };
            scene.lights.push(spot);
        }
        let lights = Lights::of(&scene);
        // 2π times the length in cosines: 1/4 that is full, and a third or a half of the ramp's 1/2.
        for (light, ramp) in lights.list[1..].iter().zip([1.0 / 3.0, 0.5]) {
            assert!((light.power[1] - 4.0 * PI * (0.25 + 0.5 * ramp)).abs() < 1e-9, "{light:?}");
        }
    }

    /// 683 cd down and none up, linear in the angle between: ∫ (1 - θ/π) sin θ dθ = 1 over the hemispheres.
    #[test]
    fn profiles_have_the_power_of_their_integral() {
        let text = "IESNA91\nTILT=NONE\n1 1 1 2 1 1 2 0 0 0\n1 1 1\n0 180\n0\n683 0\n";
        let profile = crate::scene::formats::ies::parse(std::path::Path::new("lamp.ies"), text.as_bytes()).unwrap();
        let frame = crate::scene::ProfileFrame::new(Vec3::NEG_Y, 0.0);
        let (position, intensity) = (Vec3::ZERO, Vec3::splat(1.0 / 683.0));
        let mut scene = cornell_box();
        scene.lights.push(PunctualLight::Profiled { position, frame, intensity, radius: 0.0, profile: profile.into() });
        let lights = Lights::of(&scene);
        assert!((lights.list[1].power[0] / (2.0 * PI) - 1.0).abs() < 1e-6, "{:?}", lights.list[1]);
        assert_eq!((lights.list[1].kind, lights.profile), ("profile", 1));
    }

    #[test]
    fn shares_add_up_to_1_and_follow_what_arrives() {
        let mut scene = cornell_box();
        let position = Vec3::new(0.278, 0.4, 0.28);
        // Alike, but for their strength.
        for (strength, name) in [(0.01, ""), (0.03, "window")] {
            let intensity = Vec3::splat(strength);
            scene.lights.push(PunctualLight::Point { position, intensity, radius: 0.0 });
            scene.light_labels.push(LightLabel { name: name.to_owned(), ..LightLabel::default() });
        }
        scene.sky = Sky::constant(Vec3::splat(0.1));
        let mut lights = Lights::of(&scene);
        lights.share(&World::new(scene).unwrap());
        let sum: f64 = lights.list.iter().map(|light| light.share).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        assert_eq!(lights.list.iter().map(|light| light.kind).collect::<Vec<_>>(), ["area", "point", "point", "sky"]);
        let share = |i: usize| lights.list[i].share;
        assert!((share(2) / share(1) - 3.0).abs() < 0.1 && share(0) > 0.1 && share(3) > 0.01, "{lights:?}");
        let mut rows = Vec::new();
        lights.rows(&mut |name, value| rows.push(format!("{name}: {value}")));
        for name in ["area light", "point 0", "point window"] {
            assert!(rows.iter().any(|row| row.contains(&format!("% of samples  {name}: "))), "{rows:?} lack {name}");
        }
    }
}
