//! The share of light samples that each light gets, to explain noise in pictures.

use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler, unit_double};

use crate::light::{Light, SkyPart, area};
use crate::world::World;

/// Points of the scene's surfaces that are asked.
const POINTS: u32 = 8192;
/// Lights that are chosen at each.
const CHOICES: u32 = 8;

/// The part of light samples that lights get, estimated at points spread evenly over the scene's surfaces, seen from
/// their fronts. The sum is 1 unless no point receives light.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LightShares {
    /// The share of all emissive triangles of each material.
    pub materials: Vec<f64>,
    /// Of each punctual light, in the scene's order.
    pub punctual: Vec<f64>,
    pub sky: f64,
    /// Bytes of the light trees.
    pub tree_bytes: usize,
}

impl World {
    /// The lights' parts of the light samples.
    pub(crate) fn light_shares(&self) -> LightShares {
        let mut shares = LightShares {
            materials: vec![0.0; self.materials.len()],
            punctual: vec![0.0; self.lights.lights().len()],
            sky: 0.0,
            tree_bytes: self.lights.tree_bytes(),
        };
        let mut ends = Vec::with_capacity(self.placed);
        let mut sum = 0.0;
        for record in self.placed_records() {
            sum += f64::from(area(&record.corners));
            ends.push(sum);
        }
        let mut chosen = 0.0;
        for i in 0..POINTS {
            let sampler = Sampler::new(Pattern::Sobol, 0, 0, i);
            let [x, y, u, v] = sampler.uniform4(0);
            let prim_id = ends.partition_point(|&end| end <= (f64::from(i) + 0.5) / f64::from(POINTS) * sum);
            if prim_id >= ends.len() {
                break;
            }
            let point = TriangleWarp.map(glam::Vec2::new(x, y));
            let receiver = self.surface(prim_id as u32, point.x, point.y).receiver();
            let weights = self.lights.weigh(&receiver, SkyPart::All);
            for k in 0..CHOICES {
                let u = (unit_double(glam::Vec2::new(u, v)) + f64::from(k)) / f64::from(CHOICES);
                let Some(choice) = self.lights.choose(&receiver, &weights, u) else { continue };
                chosen += 1.0;
                match &self.lights.lights()[choice.index as usize] {
                    Light::Triangle(part) => {
                        shares.materials[self.triangle_records[part.prim_id as usize].material as usize] += 1.0;
                    }
                    Light::Punctual(_) => shares.punctual[self.lights.punctual_number(choice.index)] += 1.0,
                    Light::Sky => shares.sky += 1.0,
                }
            }
        }
        let scale = |share: &mut f64| *share /= f64::max(chosen, 1.0);
        shares.materials.iter_mut().chain(&mut shares.punctual).chain([&mut shares.sky]).for_each(scale);
        shares
    }
}
