//! A map of irradiance that is looked up at hits: gathers use it in place of paths.
//!
//! A hit uses its texel unfiltered. Many rays end in or near a texel, so that interpolation would gain nothing; and
//! texels beyond the border of a chart are never used.

use glam::Vec3;

use crate::bake::layout::texels::{Surfaces, Texel};
use crate::integrator::IrradianceMap;
use crate::world::Hit;

/// Stands for no texel.
const NOTHING: u32 = u32::MAX;

/// Irradiance by texel.
pub(super) struct TexelIrradiance<'a> {
    surfaces: &'a Surfaces<'a>,
    texels: &'a [Texel],
    /// The index of each page's texels among all texels with light.
    numbers: Vec<Vec<u32>>,
    irradiance: Vec<Option<Vec3>>,
}

impl<'a> TexelIrradiance<'a> {
    /// `irradiance` has that of each of `texels`, where it is known.
    pub(super) fn new(surfaces: &'a Surfaces<'a>, texels: &'a [Texel], irradiance: Vec<Option<Vec3>>) -> Self {
        let mut numbers: Vec<Vec<u32>> = surfaces.pages().iter().map(|page| vec![NOTHING; page.texels()]).collect();
        for (number, texel) in (0..).zip(texels) {
            numbers[texel.page as usize][texel.index as usize] = number;
        }
        Self { surfaces, texels, numbers, irradiance }
    }
}

impl IrradianceMap for TexelIrradiance<'_> {
    fn irradiance(&self, hit: &Hit) -> Option<Vec3> {
        let place = self.surfaces.place(hit.prim_id, [hit.u, hit.v])?;
        let number = self.numbers[place.page][place.texel as usize];
        let texel = self.texels.get(number as usize)?;
        // It may belong to the chart beside.
        if texel.chart == place.chart { self.irradiance[number as usize] } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::{Atlas, BakeOptions};
    use crate::scene::cornell_box;

    #[test]
    fn each_point_finds_its_own_texel() {
        let scene = cornell_box();
        let atlas = Atlas::new(&scene, &BakeOptions { size: 64, ..BakeOptions::default() }).unwrap();
        let surfaces = Surfaces::new(&scene, &atlas);
        let texels = surfaces.texels();
        let known = |number: usize| (!number.is_multiple_of(7)).then(|| Vec3::splat(number as f32));
        let lookup = TexelIrradiance::new(&surfaces, &texels, (0..texels.len()).map(known).collect());
        assert!(texels.len() > 1000);
        for (number, texel) in texels.iter().enumerate() {
            let [u, v] = texel.point.barycentric;
            let hit = Hit { prim_id: texel.point.prim_id, u, v, ..Hit::MISS };
            assert_eq!(lookup.irradiance(&hit), known(number), "{texel:?}");
        }
        // A texel of another chart is not asked.
        let mut foreign = texels.clone();
        foreign.iter_mut().for_each(|texel| texel.chart += 1);
        let lookup = TexelIrradiance::new(&surfaces, &foreign, vec![Some(Vec3::ONE); foreign.len()]);
        let Texel { point, .. } = texels[0];
        let hit = Hit { prim_id: point.prim_id, u: point.barycentric[0], v: point.barycentric[1], ..Hit::MISS };
        assert_eq!(lookup.irradiance(&hit), None);
    }
}
