//! Distinct colours of lights in a picture: a hue for each emissive mesh, each punctual light and the sky.

use glam::{Vec3, Vec4};

use super::names::SKY;
use crate::light::Light;
use crate::settings::MatteKind;
use crate::world::World;

/// The golden ratio's fractional part: hues in steps of it lie as far apart as they can, however many there are.
const HUE_STEP: f32 = 0.618_034;

impl World {
    /// The colour of a light by its index among all, in linear sRGB.
    pub(crate) fn light_color(&self, light: u32) -> Vec3 {
        match &self.lights.lights()[light as usize] {
            Light::Triangle(part) => self.mesh_light_color(self.mesh_number(part.prim_id)),
            Light::Punctual(_) => color(1 + self.lights.punctual_number(light)),
            Light::Sky => color(0),
        }
    }

    /// The names of all lights, with the colours, in linear sRGB, of the integrator `heat-lights`: the sky, punctual
    /// lights, meshes that emit. Without a name of its own a light is called by its index.
    pub fn light_colors(&self) -> Vec<(String, Vec3)> {
        let sky = (self.lights.sky.mean() != Vec3::ZERO).then(|| (SKY.to_owned(), color(0)));
        let punctual = self.light_labels.iter().enumerate().map(|(number, label)| {
            let name = if label.name.is_empty() { format!("light {number}") } else { label.name.clone() };
            (name, color(1 + number))
        });
        let objects = self.names(MatteKind::Object).zip(&self.meshes).enumerate();
        let emissive = objects.filter(|(_, (_, mesh))| self.emits(mesh));
        let emissive = emissive.map(|(number, (name, _))| (name, self.mesh_light_color(number)));
        sky.into_iter().chain(punctual).chain(emissive).collect()
    }

    fn mesh_light_color(&self, mesh: usize) -> Vec3 {
        color(1 + self.light_labels.len() + mesh)
    }
}

/// The colour of this index: bright, of any hue.
fn color(number: usize) -> Vec3 {
    let hue = (number as f32 * HUE_STEP).fract();
    // Hue to RGB (Smith 1978), as tents about 0, 1/3 and 2/3, with a floor so that no colour is dark.
    let distance = (Vec4::splat(hue) - Vec4::new(0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0)).abs() * 6.0;
    let tents = Vec3::new(distance.x.min(distance.w), distance.y, distance.z);
    (2.0 - tents).clamp(Vec3::splat(0.02), Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{PunctualLight, Sky, cornell_box};

    #[test]
    fn hues_are_those_of_the_circle() {
        assert_eq!(color(0), Vec3::new(1.0, 0.02, 0.02), "red");
        let close = |a: usize, b: usize| color(a).distance(color(b));
        for number in 1..12 {
            assert!((0..number).all(|other| close(number, other) > 0.1), "{number} looks like another");
        }
    }

    #[test]
    fn every_light_has_a_name_and_the_colour_by_which_it_is_drawn() {
        let mut scene = cornell_box();
        scene.lights.push(PunctualLight::Point { position: Vec3::splat(0.2), intensity: Vec3::ONE, radius: 0.0 });
        scene.light_labels.push(Default::default());
        scene.sky = Sky::constant(Vec3::ONE);
        let world = World::new(scene).unwrap();
        let colors = world.light_colors();
        let names: Vec<&str> = colors.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names.len(), 3, "{names:?}");
        assert_eq!(names[..2], ["sky", "light 0"]);
        let drawn: Vec<Vec3> = (0..world.lights.lights().len()).map(|light| world.light_color(light as u32)).collect();
        assert!(drawn.iter().all(|color| colors.iter().any(|(_, known)| known == color)), "{drawn:?} {colors:?}");
        assert!(colors.iter().all(|(_, color)| drawn.contains(color)), "{drawn:?} {colors:?}");
    }
}
