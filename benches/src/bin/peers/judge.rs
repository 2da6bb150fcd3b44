//! Checks rays where the kernel and Embree differ: a loop over all triangles in double precision.
//!
//! A triangle is crossed where the ray's direction and each pair of its corners span volumes of one sign. From `f32`
//! coordinates these are exact in `f64` to some units of the last place; where one is less than that the ray passes an
//! edge, and either answer will do.

use glam::DVec3;
use halfdome_benches::measure::{Answers, TOLERANCE};
use halfdome_benches::rays::RaySet;
use halfdome_kernel::{Hit, Ray, Triangle};

/// Rays that are judged at most: each is a loop over the scene.
const MAX_RAYS: usize = 256;
/// Volumes smaller than this times their factors' lengths have no certain sign.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The number of rays with different answers, by the tracer that is right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    /// The kernel alone is right.
    pub(crate) ours: usize,
    /// Embree alone is right.
    pub(crate) embree: usize,
    /// Neither is.
    pub(crate) neither: usize,
    /// The ray passes an edge, or both are right.
    pub(crate) edge: usize,
}

/// Judges the rays to which `ours` and `embree` have different answers, at most [`MAX_RAYS`] of them.
pub(crate) fn tally(triangles: &[Triangle], set: &RaySet, ours: &Answers, embree: &Answers) -> Tally {
    let mut tally = Tally::default();
    for number in ours.differing(embree).take(MAX_RAYS) {
        let truth = Truth::new(triangles, &set.rays[number]);
        let [ours, embree] = [ours, embree].map(|answers| match answers {
            Answers::Nearest(hits) => truth.allows(&hits[number]),
            Answers::Any(occluded) => truth.allows_any(occluded[number]),
        });
        *match (ours, embree) {
            (true, true) => &mut tally.edge,
            (true, false) => &mut tally.ours,
            (false, true) => &mut tally.embree,
            (false, false) => &mut tally.neither,
        } += 1;
    }
    tally
}

/// Where a ray hits something.
struct Truth {
    /// The nearest certain hit.
    nearest: Option<f64>,
    /// Hits at edges that are nearer.
    doubtful: Vec<f64>,
}

impl Truth {
    fn new(triangles: &[Triangle], ray: &Ray) -> Self {
        let (mut nearest, mut doubtful) = (f64::INFINITY, Vec::new());
        for triangle in triangles {
            match cross(triangle, ray) {
                Some((t, true)) => nearest = nearest.min(t),
                Some((t, false)) => doubtful.push(t),
                None => {}
            }
        }
        doubtful.retain(|&t| t < nearest);
        Self { nearest: Some(nearest).filter(|t| t.is_finite()), doubtful }
    }

    /// Whether `hit` is the nearest one, or an edge that may be.
    fn allows(&self, hit: &Hit) -> bool {
        let near = |&t: &f64| (f64::from(hit.t) - t).abs() <= f64::from(TOLERANCE) * t;
        match hit.is_hit() {
            true => self.nearest.iter().chain(&self.doubtful).any(near),
            false => self.nearest.is_none(),
        }
    }

    fn allows_any(&self, occluded: bool) -> bool {
        match occluded {
            true => self.nearest.is_some() || !self.doubtful.is_empty(),
            false => self.nearest.is_none(),
        }
    }
}

/// Where the ray crosses the triangle within its interval, and whether that is certain.
fn cross(triangle: &Triangle, ray: &Ray) -> Option<(f64, bool)> {
    let direction = ray.direction.as_dvec3();
    let [a, b, c] = triangle.map(|corner| corner.as_dvec3() - ray.origin.as_dvec3());
    let volumes = [volume(direction, c, b), volume(direction, a, c), volume(direction, b, a)];
    let all = |test: &dyn Fn(f64, f64) -> bool| volumes.iter().all(|&(volume, error)| test(volume, error));
    let may_be_inside = all(&|volume, error| volume >= -error) || all(&|volume, error| volume <= error);
    let sum: f64 = volumes.iter().map(|(volume, _)| volume).sum();
    if !may_be_inside || sum == 0.0 {
        return None;
    }
    let point = (volumes[0].0 * a + volumes[1].0 * b + volumes[2].0 * c) / sum;
    let t = point.dot(direction) / direction.length_squared();
    let is_certain = all(&|volume, error| volume > error) || all(&|volume, error| volume < -error);
    (f64::from(ray.t_min)..=f64::from(ray.t_max)).contains(&t).then_some((t, is_certain))
}

/// Six times that of the tetrahedron over three edges, and a bound of its error.
fn volume(d: DVec3, p: DVec3, q: DVec3) -> (f64, f64) {
    (d.dot(p.cross(q)), ROUNDING * d.length() * p.length() * q.length())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use halfdome_benches::rays::RayKind;

    use super::*;

    #[test]
    fn wrong_answers_are_told_from_right_ones_and_from_edges() {
        let at = |z: f32| [Vec3::new(-1.0, -1.0, z), Vec3::new(3.0, -1.0, z), Vec3::new(-1.0, 3.0, z)];
        let triangles = [at(2.0), at(1.0)];
        let ray = |x: f32| Ray::new(Vec3::new(x, 0.0, 0.0), Vec3::Z);
        let hit = |t: f32| Hit { t, u: 0.0, v: 0.0, prim_id: 0 };
        // Inside, beside, on the edge; and inside, with neither right.
        let set = RaySet { kind: RayKind::Diffuse, rays: vec![ray(0.0), ray(-1.5), ray(-1.0), ray(0.5)] };
        let ours = Answers::Nearest(vec![hit(1.0), hit(1.0), hit(1.0), hit(2.0)]);
        let embree = Answers::Nearest(vec![hit(2.0), Hit::MISS, Hit::MISS, Hit::MISS]);
        let expected = Tally { ours: 1, embree: 1, neither: 1, edge: 0 };
        let mut judged = tally(&triangles, &set, &ours, &embree);
        // Both triangles end at the same edge, so that a miss there is possible too.
        assert_eq!(core::mem::take(&mut judged.edge), 1);
        assert_eq!(judged, expected);

        let any = |occluded: &[bool]| Answers::Any(occluded.to_vec());
        let shadow = tally(&triangles, &set, &any(&[true, true, true, true]), &any(&[false, false, false, true]));
        assert_eq!(shadow, Tally { ours: 1, embree: 1, neither: 0, edge: 1 });
    }
}
