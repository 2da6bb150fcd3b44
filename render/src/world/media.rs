//! Transparent solids and their absorption.

use glam::Vec3;
use halfdome_kernel::Ray;

use super::{Hit, World};
use crate::scene::{Input, Material};

/// The absorption of solids, by material.
#[derive(Debug, Default)]
pub(super) struct Solids {
    /// The absorption coefficients inside of solids; `None` for what has no inside. Empty if nothing absorbs.
    absorption: Vec<Option<Vec3>>,
}

/// The surface of what may be a solid, as a ray sees it that arrives there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boundary {
    pub(crate) material: u32,
    /// The geometric normal, on the side that the ray comes from.
    pub(crate) normal: Vec3,
    /// Whether the ray comes from inside.
    pub(crate) is_back: bool,
}

impl Solids {
    pub(super) fn new(materials: &[Material]) -> Self {
        let absorption: Vec<_> = materials.iter().map(absorption).collect();
        let absorbs = absorption.iter().flatten().any(|coefficient| *coefficient != Vec3::ZERO);
        Self { absorption: if absorbs { absorption } else { Vec::new() } }
    }
}

/// The absorption inside a material, if it transmits light into a solid.
fn absorption(material: &Material) -> Option<Vec3> {
    let inputs = &material.inputs;
    let is_mapped = material.maps.iter().flat_map(|map| &map.targets).any(|it| it.input == Input::TransmissionWeight);
    let has_light = inputs.transmission_weight > 0.0 || is_mapped || inputs.absorption != Vec3::ZERO;
    (has_light && !inputs.thin_walled).then_some(inputs.absorption)
}

impl World {
    /// Whether any solid absorbs light.
    #[inline(always)]
    pub(crate) fn has_absorption(&self) -> bool {
        !self.solids.absorption.is_empty()
    }

    /// What a material absorbs inside, in one by the scene's unit of length; `None` if it is not that of a solid which
    /// light passes through, or nothing absorbs.
    pub(crate) fn absorption(&self, material: u32) -> Option<Vec3> {
        self.solids.absorption.get(material as usize).copied().flatten()
    }

    /// The boundary that a ray has hit.
    pub(crate) fn boundary(&self, ray: &Ray, hit: &Hit) -> Boundary {
        let front = self.placed_record(hit).normal;
        let is_back = front.dot(ray.direction) > 0.0;
        let material = self.triangle_records[hit.prim_id as usize].material;
        Boundary { material, normal: if is_back { -front } else { front }, is_back }
    }
}
