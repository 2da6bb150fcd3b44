//! Photons sent by lights through bodies of glass, and followed to where they fall.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::geometry::Aabb;
use halfdome_kernel::sampling::Frame;
use halfdome_kernel::sampling::warp::{PolarDisc, UniformSphere, Warp};
use rayon::prelude::*;

use super::{Arrival, FOLD, LightPhotons, Photon, Photons, Sent};
use crate::light::Light;
use crate::scene::PunctualLight;
use crate::world::glass::MOST;
use crate::world::glass::manifold::DifferentialRay;
use crate::world::{MIDDLE, World};

/// Photons for all lights and bodies of glass, ...
const PHOTONS: usize = 1 << 18;

/// ... and for one light and one body, at least and at most.
const OF_BODY: [usize; 2] = [64, 8192];

/// The least cosine with a surface that a photon's footprint on it is taken for.
const LEAST_SLANT: f32 = 0.1;

/// The least cosine, of 0.06°, between directions of light that a pane has not bent.
const STRAIGHT: f32 = 1.0 - 5e-7;

/// A ball around glass.
#[derive(Clone, Copy, Debug)]
struct Body {
    center: Vec3,
    radius: f32,
}

impl Body {
    /// The size as seen from a light.
    fn size_from(&self, light: &PunctualLight) -> f32 {
        light.place().map_or(self.radius, |(position, ..)| self.radius / position.distance(self.center))
    }
}

impl World {
    /// Finds where the light of points, spots and suns arrives that glass bends.
    pub(in crate::world) fn send_photons(&mut self) {
        self.glass.photons = Photons::default();
        if !self.has_clear_glass() {
            return;
        }
        let bodies = self.glass_bodies();
        let lights = self.lights.lights().iter().zip(0u32..);
        let lights: Vec<(&PunctualLight, u32)> = lights
            .filter_map(|(light, number)| if let Light::Punctual(light) = light { Some((light, number)) } else { None })
            .collect();
        let of_light = PHOTONS / lights.len().max(1);
        let count = (of_light / bodies.len().max(1)).clamp(OF_BODY[0], OF_BODY[1]);
        let follow = |&(light, number): &(&PunctualLight, u32)| {
            let mut arrived = LightPhotons::default();
            // The bodies that look largest from the light.
            let mut bodies = bodies.clone();
            bodies.sort_by(|a, b| b.size_from(light).total_cmp(&a.size_from(light)));
            for body in bodies.iter().take(of_light / count) {
                for arrival in (0..count).filter_map(|i| self.follow(self.photon(light, *body, i, count)?)) {
                    arrived.add(&arrival, body.radius);
                }
            }
            (number, arrived)
        };
        self.glass.photons = Photons { lights: lights.par_iter().map(follow).collect() };
    }

    /// Balls around meshes of smooth glass, and around their instances.
    fn glass_bodies(&self) -> Vec<Body> {
        let mut bodies = Vec::new();
        for mesh in self.meshes.iter().filter(|mesh| self.glass.transmits[mesh.material]) {
            let bounds = Aabb::around(&mesh.positions);
            if bounds.is_empty() {
                continue;
            }
            let (center, half) = (0.5 * (bounds.min + bounds.max), 0.5 * (bounds.max - bounds.min));
            bodies.extend(self.placements_of(mesh).into_iter().map(|placement| {
                let [x, y, z] = placement.matrix3.to_cols_array_2d().map(Vec3::from);
                let extent = x.abs() * half.x + y.abs() * half.y + z.abs() * half.z;
                Body { center: placement.transform_point3(center), radius: extent.length() }
            }));
        }
        bodies.retain(|body| body.center.is_finite() && body.radius > 0.0 && body.radius.is_finite());
        bodies
    }

    /// One of several photons from the middle of a light towards a body's disc, or in all directions from within; and
    /// the angular radius of the light.
    fn photon(&self, light: &PunctualLight, body: Body, photon: usize, count: usize) -> Option<(DifferentialRay, f32)> {
        // Fibonacci's lattice.
        let of_count = (photon as f32 + 0.5) / count as f32;
        let place = Vec2::new(of_count, (photon as f64 * 0.618_033_988_749_894_9).fract() as f32);
        let disc = body.radius * PolarDisc.map(place);
        let apart = body.radius * (PI / count as f32).sqrt();
        let beam = |origin: Vec3, direction: Vec3, by_origin: f32, by_direction: f32| {
            let frame = Frame::from_normal(direction);
            let axes = [Vec3::X, Vec3::Y].map(|axis| frame.to_world(axis));
            DifferentialRay {
                ray: Ray::new(origin, direction),
                d_origin: axes.map(|axis| by_origin * axis),
                d_direction: axes.map(|axis| by_direction * axis),
                transmittance: Vec3::ONE,
            }
        };
        Some(match *light {
            PunctualLight::Directional { direction, half_angle, .. } => {
                let away = self.diagonal() + (body.center - self.bounds.center()).length();
                let across = Frame::from_normal(direction).to_world(disc.extend(0.0));
                (beam(body.center + across - away * direction, direction, apart, 0.0), half_angle)
            }
            _ => {
                let (position, _, radius) = light.place()?;
                let axis = body.center - position;
                if axis.length() <= body.radius {
                    // How far the glass is from there is not known, but at most so far, about.
                    let angle = radius / body.radius;
                    return Some((beam(position, UniformSphere.map(place), 0.0, 2.0 * apart / body.radius), angle));
                }
                let angle = radius / axis.length();
                let frame = Frame::from_normal(axis.normalize());
                let way = body.center + frame.to_world(disc.extend(0.0)) - position;
                (beam(position, way.normalize_or_zero(), 0.0, apart / axis.length()), angle)
            }
        })
    }

    /// The arrival of a photon behind the glass that refracted it.
    fn follow(&self, (mut beam, blur): (DifferentialRay, f32)) -> Option<Arrival> {
        let is_sun = beam.d_origin[0] != Vec3::ZERO;
        let sent = if is_sun {
            Sent { at: beam.ray.origin, by: beam.d_origin }
        } else {
            Sent { at: beam.ray.direction, by: beam.d_direction }
        };
        let (first, mut is_behind) = (beam.ray.direction, false);
        for _ in 0..MOST {
            let Some(face) = self.face(&beam.ray, MIDDLE) else {
                let hit = self.intersect_at(&beam.ray, MIDDLE);
                let Ray { origin, direction, .. } = beam.ray;
                if !is_behind || direction.dot(first) >= STRAIGHT || !hit.is_hit() {
                    return None;
                }
                let DifferentialRay { d_origin, d_direction, .. } = beam;
                let photon = Photon { origin, direction, d_origin, d_direction, sent, blur };
                let normal = self.surface_at(&hit).normal;
                let slant = direction.dot(normal).abs().max(LEAST_SLANT);
                // Where neighbouring rays hit the surface, along it.
                let [a, b] = [0, 1].map(|axis| {
                    let across = photon.across(axis, hit.t);
                    across.abs() + direction.abs() * (across.dot(normal).abs() / slant)
                });
                let around = FOLD * a.length().max(b.length()) + blur * hit.t / slant;
                return Some(Arrival { photon, point: beam.ray.at(hit.t), extent: a + b + around });
            };
            if face.is_thin {
                beam.straight(&face);
            } else {
                self.refract(&mut beam, &face)?;
            }
            is_behind = true;
        }
        None
    }
}
