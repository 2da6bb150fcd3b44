//! The emissive triangles of a scene as lights: as wholes, or as parts where a texture makes some brighter than others, such
//! as the lit windows of a wall at night.

use glam::Vec3;
use halfdome_kernel::{Triangle, triangle_normal};

use super::cells::{Division, PartTable, TrianglePart};
use super::tree::leaf::TriangleLight;
use super::{area, luminance_weight};
use crate::scene::Material;

/// The parts of a triangle that emit, and their mean radiances, as luminance.
pub(crate) struct EmissiveParts {
    /// How the triangle is divided into the smallest of them.
    pub division: Division,
    pub parts: Vec<(TrianglePart, f32)>,
}

/// The lights that triangles are.
pub(super) struct Emitters {
    pub parts: Vec<TrianglePart>,
    /// Each part as a light.
    pub lights: Vec<TriangleLight>,
    pub table: PartTable,
}

impl Emitters {
    /// See [`LightSampler::new`](super::LightSampler::new).
    pub(super) fn new<'m>(
        triangles: &[Triangle],
        material: impl Fn(usize) -> &'m Material,
        front: impl Fn(usize) -> Option<Vec3>,
        emissive_parts: impl Fn(usize) -> Option<EmissiveParts>,
    ) -> Self {
        let (mut parts, mut lights, mut sides) = (Vec::new(), Vec::new(), Vec::new());
        for (prim, triangle) in triangles.iter().enumerate() {
            let (prim_id, material) = (prim as u32, material(prim));
            if material.emission == Vec3::ZERO || area(triangle) == 0.0 {
                continue;
            }
            let front = front(prim);
            let normal = front.unwrap_or_else(|| triangle_normal(triangle));
            let both_sides = material.emits_both_sides || front.is_none();
            let mut push = |part: TrianglePart, radiance: f32| {
                let corners = part.corners(triangle);
                let area = area(&corners);
                if radiance > 0.0 && area > 0.0 {
                    parts.push(part);
                    lights.push(TriangleLight { corners, normal, radiance, area, both_sides });
                }
            };
            match emissive_parts(prim) {
                None => push(TrianglePart::whole(prim_id), luminance_weight(material.emission)),
                Some(EmissiveParts { division, parts }) => {
                    sides.push((prim_id, division));
                    parts.into_iter().for_each(|(part, radiance)| push(part, radiance));
                }
            }
        }
        let division_of = |prim_id: u32| {
            let known = sides.binary_search_by_key(&prim_id, |(prim_id, _)| *prim_id);
            known.map_or(Division::WHOLE, |place| sides[place].1)
        };
        let table = PartTable::new(parts.iter(), division_of, triangles.len());
        Self { parts, lights, table }
    }
}
