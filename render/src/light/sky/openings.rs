//! Openings: the places through which surfaces see the sky, as windows and doors of a room.
//!
//! From within a room nearly all directions to the sky are blocked. An opening is a sphere about a part of a window; from a
//! receiver it is a cone, of which directions are sampled evenly. It is chosen in proportion to `v cos θ sin² α`, with the
//! cone's half angle `α`, and the part `v` of such directions that were free at receivers nearby. What the openings leave
//! out is found by bounces and by the sky's other samples, so that they only affect noise.
//!
//! All is by one opening and one receiver, without branches, so that loops over either become lanes.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use halfdome_kernel::Aabb;
use halfdome_kernel::sampling::Frame;
use halfdome_kernel::sampling::warp::{Cone, Warp};

use crate::light::Receiver;
use crate::light::grid::Grid;

/// Spheres through which receivers see the sky.
#[derive(Clone, Debug)]
pub(crate) struct Openings {
    count: usize,
    centers: [Vec3; Self::MOST],
    squared_radii: [f32; Self::MOST],
    /// The part of directions through each that are free.
    free: Grid<[f32; Self::MOST]>,
}

/// An opening as a receiver sees it.
#[derive(Clone, Copy)]
pub(crate) struct OpeningCone {
    /// The unit vector to its middle.
    towards: Vec3,
    /// The squared sine of its half angle; 1 from inside.
    sin_squared: f32,
}

impl Openings {
    /// The most openings.
    pub(crate) const MOST: usize = 16;

    /// Openings by center and radius, for receivers in a box. At first all directions are free.
    pub(crate) fn new(spheres: &[(Vec3, f32)], receivers: Aabb) -> Self {
        let count = spheres.len().min(Self::MOST);
        let (mut centers, mut squared_radii) = ([Vec3::ZERO; Self::MOST], [0.0; Self::MOST]);
        for (i, &(center, radius)) in spheres[..count].iter().enumerate() {
            (centers[i], squared_radii[i]) = (center, radius * radius);
        }
        Self { count, centers, squared_radii, free: Grid::new(receivers, [1.0; Self::MOST]) }
    }

    /// How many there are.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The part of directions through each opening that are free about a place.
    #[inline(always)]
    pub(crate) fn free_at(&self, place: Vec3) -> &[f32; Self::MOST] {
        self.free.at(place)
    }

    /// The grid of those parts.
    pub(crate) fn grid_mut(&mut self) -> &mut Grid<[f32; Self::MOST]> {
        &mut self.free
    }

    /// The cone of an opening, seen from a place.
    #[inline(always)]
    pub(crate) fn cone(&self, opening: usize, from: Vec3) -> OpeningCone {
        let way = self.centers[opening] - from;
        let squared = way.length_squared();
        let inv_squared = squared.max(f32::MIN_POSITIVE).recip();
        let towards = if squared > 0.0 { way * inv_squared.sqrt() } else { Vec3::Z };
        OpeningCone { towards, sin_squared: (self.squared_radii[opening] * inv_squared).clamp(1e-12, 1.0) }
    }

    /// The density per solid angle with which a receiver looks to openings in a direction, if it looks for the sky.
    pub(crate) fn density(&self, receiver: &Receiver, direction: Vec3) -> f32 {
        let (mut sum, mut total) = (0.0, 0.0);
        for (opening, free) in self.free_at(receiver.position).iter().enumerate().take(self.count) {
            let cone = self.cone(opening, receiver.position);
            let weight = free * cone.weight(receiver);
            sum += weight * cone.density(direction);
            total += weight;
        }
        if total > 0.0 { sum / total } else { 0.0 }
    }
}

impl OpeningCone {
    /// An estimate of the irradiance by a sky of radiance 1, if nothing is in between.
    #[inline(always)]
    pub(crate) fn weight(&self, receiver: &Receiver) -> f32 {
        let cosine = receiver.normal.dot(self.towards);
        let cosine = if receiver.behind > 0.0 { cosine.abs() } else { cosine };
        // Of a cone at the horizon about a quarter of its sine.
        let height = cosine.max(0.25 * (cosine + self.sin_squared.sqrt())).max(0.0);
        PI * self.sin_squared * height
    }

    /// A direction in it, by two numbers in [0, 1).
    #[inline(always)]
    pub(crate) fn direction(&self, u: Vec2) -> Vec3 {
        Frame::from_normal(self.towards).to_world(Cone::from_sin_squared(self.sin_squared).map(u)).normalize()
    }

    /// The density per solid angle of [`direction`](Self::direction).
    #[inline(always)]
    pub(crate) fn density(&self, direction: Vec3) -> f32 {
        // 1 - cos α, of which half the squared chord of a direction in the cone is no more.
        let height = self.sin_squared / (1.0 + (1.0 - self.sin_squared).sqrt());
        // A little more, for what was rounded.
        let is_inside = 0.5 * direction.distance_squared(self.towards) <= 1.0001 * height;
        let density = (TAU * height).recip();
        if is_inside { density } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use halfdome_kernel::sampling::Stream;
    use halfdome_kernel::sampling::warp::UniformSphere;

    use super::*;

    fn openings() -> Openings {
        let spheres =
            [(Vec3::new(2.0, 1.0, 0.0), 0.5), (Vec3::new(2.0, 1.3, 0.4), 0.7), (Vec3::new(-1.0, 3.0, 5.0), 0.2)];
        let mut openings = Openings::new(&spheres, Aabb { min: Vec3::splat(-2.0), max: Vec3::splat(2.0) });
        let cell = openings.grid_mut().cell(Vec3::ZERO);
        openings.grid_mut().cell_mut(cell)[0] = 0.3;
        openings
    }

    /// Far away, within spheres, and above and below the horizon.
    const PLACES: [Vec3; 4] =
        [Vec3::ZERO, Vec3::new(1.9, 0.9, 0.1), Vec3::new(-300.0, 40.0, 0.0), Vec3::new(1.0, 1.0, -0.3)];

    #[test]
    fn densities_are_those_of_directions_and_add_up_to_1() {
        let openings = openings();
        for (place, both_sides) in PLACES.into_iter().zip([false, true, false, true]) {
            let receiver = Receiver::new(place, Vec3::new(0.6, 0.8, 0.0), both_sides);
            for opening in 0..openings.count() {
                let cone = openings.cone(opening, place);
                let density = cone.density(cone.towards);
                for i in 0..1000 {
                    let direction = cone.direction(Stream::new(3, i, 0).uniform2(0));
                    assert!(direction.is_normalized() && cone.density(direction) == density, "{place} {opening}");
                }
            }
            // By directions that are sampled as openings are, two thirds of them, or evenly over the sphere.
            let count = 100_000;
            let mut sum = 0.0;
            for i in 0..count {
                let [choice, x, y, ..] = Stream::new(4, i, 0).uniform4(0);
                let opening = (choice * 4.0) as usize;
                let u = Vec2::new(x, y);
                let direction =
                    if opening < 3 { openings.cone(opening, place).direction(u) } else { UniformSphere.map(u) };
                let cones = (0..3).map(|opening| openings.cone(opening, place).density(direction)).sum::<f32>();
                let sampled = 0.25 * (cones + 0.5 / TAU);
                sum += f64::from(openings.density(&receiver, direction) / sampled);
            }
            let mean = sum / f64::from(count);
            assert!((mean - 1.0).abs() < 0.02, "{place}: {mean}");
        }
    }

    #[test]
    fn weights_are_irradiances_and_vanish_only_below_the_horizon() {
        let openings = openings();
        for place in [Vec3::ZERO, Vec3::new(-300.0, 40.0, 0.0)] {
            for i in 0..200 {
                let normal = UniformSphere.map(Stream::new(5, i, 0).uniform2(0));
                let receiver = Receiver::new(place, normal, false);
                for opening in 0..openings.count() {
                    let cone = openings.cone(opening, place);
                    let (weight, sine) = (cone.weight(&receiver), cone.sin_squared.sqrt());
                    let cosine = receiver.normal.dot(cone.towards);
                    if cosine > sine {
                        let exact = PI * cone.sin_squared * cosine;
                        assert!((weight / exact - 1.0).abs() < 1e-5, "{weight} of {exact}");
                    }
                    assert_eq!(weight > 0.0, cosine > -sine, "{weight} at {cosine} of {sine}");
                }
            }
        }
    }

    #[test]
    fn openings_that_nobody_sees_have_no_density() {
        let openings = openings();
        let receiver = Receiver::new(Vec3::ZERO, Vec3::new(-0.8, -0.6, 0.0), false);
        assert_eq!(openings.density(&receiver, Vec3::new(2.0, 1.0, 0.0).normalize()), 0.0);
        let none = Openings::new(&[], Aabb { min: Vec3::ZERO, max: Vec3::ONE });
        assert_eq!(none.density(&receiver, Vec3::X), 0.0);
    }
}
