//! Shadow rays of paths on their straight way through [panes](crate::integrator::panes).

use halfdome_kernel::{self as kernel, Ray};
use smallvec::SmallVec;

use super::Advance;
use crate::integrator::path_block::{LANES, PathBlock, ShadowRays};
use crate::world::time_of;

impl Advance<'_, '_> {
    /// Takes the shadow rays of a block through panes.
    #[inline(never)]
    pub(super) fn pass_shadows(&mut self, block: &PathBlock, shadows: &mut ShadowRays) {
        let Some(glass) = self.world.panes() else { return };
        shadows.start_at_surfaces();
        let mut lit = SmallVec::<[usize; LANES]>::new();
        lit.extend((0..block.len).filter(|&i| shadows.is_lit(i)));
        let rays: SmallVec<[Ray; LANES]> = lit.iter().map(|&i| shadows.ray(i)).collect();
        let mut hits = [kernel::Hit::MISS; LANES];
        glass.intersect_many(&rays, &mut hits[..rays.len()]);
        let mut before = Vec::new();
        let (mut parts, mut times) = (Vec::new(), Vec::new());
        for ((&i, ray), hit) in lit.iter().zip(&rays).zip(&hits).filter(|(_, hit)| hit.is_hit()) {
            let add = |part: Ray| {
                parts.push(part);
                times.push(time_of(self.batch.times, block.index(i)));
                before.push(i);
            };
            match glass.cross(ray, hit, add) {
                Some((rest, transmittance)) => shadows.pass(i, rest.t_min, transmittance),
                None => shadows.lose(i),
            }
        }
        let mut occluded = vec![false; parts.len()];
        self.world.occluded_many_at(&parts, &times, &mut occluded);
        self.wave.traced_at_panes += parts.len() as u64;
        before.iter().zip(occluded).filter(|(_, occluded)| *occluded).for_each(|(&i, _)| shadows.lose(i));
    }
}
