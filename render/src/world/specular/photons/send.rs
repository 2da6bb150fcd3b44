//! Photons sent by lights at bodies with smooth faces, and followed to where they arrive.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::geometry::Aabb;
use halfdome_kernel::sampling::Frame;
use halfdome_kernel::sampling::warp::{PolarDisc, UniformSphere, Warp};
use rayon::prelude::*;

use super::cells::{Cells, Footprint};
use super::{Arrival, FOLD, Photon, Sent};
use crate::scene::{Mesh, PunctualLight};
use crate::world::specular::chain::{DifferentialRay, Reflection};
use crate::world::specular::{MAX_FACES, MIN_STRAIGHT_COS};
use crate::world::{Hit, MIDDLE, World};

/// Photons for all lights and bodies, ...
const PHOTONS: usize = 1 << 18;

/// ... and for one light and one body, at least and at most.
const OF_BODY: [usize; 2] = [64, 8192];

/// The least strength of a photon that is reflected.
const MIN_STRENGTH: f32 = 1e-3;

/// The least cosine with a surface that a photon's footprint on it is taken for.
const MIN_SLANT: f32 = 0.1;

/// A ball around a mesh with smooth faces.
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
    /// Finds where the light of points, spots and suns arrives that is refracted, or reflected once.
    pub(in crate::world) fn send_photons(&mut self) {
        let bodies = self.smooth_bodies();
        if bodies.is_empty() {
            return self.lights.sky.forget_sun();
        }
        let lights: Vec<(&PunctualLight, u32)> = (0..self.lights.lights().len() as u32)
            .filter_map(|index| Some((self.narrow_light(index)?, index)))
            .collect();
        let of_light = PHOTONS / lights.len().max(1);
        let count = (of_light / bodies.len().max(1)).clamp(OF_BODY[0], OF_BODY[1]);
        let follow = |&(light, index): &(&PunctualLight, u32)| {
            // The bodies that look largest from the light.
            let mut bodies = bodies.clone();
            bodies.sort_by(|a, b| b.size_from(light).total_cmp(&a.size_from(light)));
            bodies.truncate(of_light / count);
            let by_body: Vec<_> = bodies.par_iter().map(|body| self.footprints(light, *body, count)).collect();
            let [refracted, reflected]: [Vec<_>; 2] = by_body.into_iter().unzip().into();
            [refracted, reflected].map(|footprints| {
                let footprints: Vec<Footprint> = footprints.into_iter().flatten().collect();
                (index, Cells::new(self.isa(), &footprints))
            })
        };
        let arrived: Vec<_> = lights.par_iter().map(follow).collect();
        for [refracted, reflected] in arrived {
            for (map, (index, photons)) in
                [(&mut self.specular.refracted, refracted), (&mut self.specular.reflected, reflected)]
            {
                map.lights.extend(photons.map(|photons| (index, photons)));
            }
        }
    }

    /// The footprints of photons of a light that a body refracts, and that it reflects.
    fn footprints(&self, light: &PunctualLight, body: Body, count: usize) -> (Vec<Footprint>, Vec<Footprint>) {
        let (mut refracted, mut reflected) = (Vec::new(), Vec::new());
        for (beam, blur) in (0..count).filter_map(|i| self.photon(light, body, i, count)) {
            self.follow(Flight::new(beam, blur), &mut |arrival| {
                let is_reflected = arrival.photon.reflection.is_some();
                let footprints = if is_reflected { &mut reflected } else { &mut refracted };
                footprints.extend(Footprint::new(&arrival, body.radius));
            });
        }
        (refracted, reflected)
    }

    /// Balls around meshes of smooth glass and mirrors, and around their instances.
    fn smooth_bodies(&self) -> Vec<Body> {
        let mut bodies = Vec::new();
        let is_any = |of: &[bool], mesh: &Mesh| of.get(mesh.material).is_some_and(|&is_one| is_one);
        let is_smooth = |mesh: &&Mesh| is_any(&self.specular.transmits, mesh) || is_any(&self.specular.mirrors, mesh);
        for mesh in self.meshes.iter().filter(is_smooth) {
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

    /// Follows a photon until it leaves all smooth faces, and passes on where it arrives then, refracted or reflected.
    fn follow(&self, mut flight: Flight, arrive: &mut impl FnMut(Arrival)) {
        while usize::from(flight.faces) < MAX_FACES {
            let hit = self.intersect_at(&flight.beam.ray, MIDDLE);
            if !hit.is_hit() {
                return;
            }
            let [is_glass, is_mirror] = [self.is_clear_glass(&hit), self.is_mirror(&hit)];
            if !is_glass && !is_mirror {
                return flight.end(&hit, self.surface_at(&hit).normal).into_iter().for_each(arrive);
            }
            let face = self.face_at(hit, flight.beam.ray.direction);
            let transmits = is_glass && face.tint != Vec3::ZERO;
            if is_mirror && flight.reflected.is_none() {
                let mut mirrored = Flight { reflected: Some(flight.faces), ..flight };
                let goes_on = self.reflect(&mut mirrored.beam, &face).is_some();
                if goes_on && mirrored.beam.transmittance.max_element() > MIN_STRENGTH {
                    self.follow(mirrored.beyond(hit.t), arrive);
                }
            }
            if !transmits {
                return flight.end(&hit, face.surface.normal).into_iter().for_each(arrive);
            }
            if face.is_thin {
                let cos = face.surface.smooth_normal.dot(flight.beam.ray.direction).abs();
                flight.beam.transmittance *= face.thin_wall_transmittance(cos);
                flight.beam.straight(&face);
            } else if self.refract(&mut flight.beam, &face).is_none() {
                return;
            }
            flight = flight.beyond(hit.t);
        }
    }
}

/// A photon on its way.
#[derive(Clone, Copy)]
struct Flight {
    beam: DifferentialRay,
    blur: f32,
    sent: Sent,
    /// Whether it comes from infinity.
    is_distant: bool,
    /// The direction in which it was sent.
    first: Vec3,
    /// How many faces it has met, and the index of the one that reflected it.
    faces: u8,
    reflected: Reflection,
    /// The length of its path.
    length: f32,
}

impl Flight {
    fn new(beam: DifferentialRay, blur: f32) -> Self {
        let is_distant = beam.d_origin[0] != Vec3::ZERO;
        let sent = if is_distant {
            Sent { at: beam.ray.origin, by: beam.d_origin }
        } else {
            Sent { at: beam.ray.direction, by: beam.d_direction }
        };
        Self { beam, blur, sent, is_distant, first: beam.ray.direction, faces: 0, reflected: None, length: 0.0 }
    }

    /// The same behind a face at this distance.
    fn beyond(self, distance: f32) -> Self {
        Self { faces: self.faces + 1, length: self.length + distance, ..self }
    }

    /// The arrival at a surface, unless light comes there without the faces.
    fn end(self, hit: &Hit, normal: Vec3) -> Option<Arrival> {
        let Self { beam, blur, sent, first, faces, reflected, .. } = self;
        let direction = beam.ray.direction;
        if faces == 0 || (reflected.is_none() && direction.dot(first) >= MIN_STRAIGHT_COS) {
            return None;
        }
        let DifferentialRay { d_origin, d_direction, transmittance, .. } = beam;
        let reflection = reflected.map(|index| faces - 1 - index);
        let mut photon = Photon {
            origin: beam.ray.origin,
            direction,
            d_origin,
            d_direction,
            sent,
            blur,
            reflection,
            irradiance: 0.0,
        };
        let across = [0, 1].map(|axis| photon.across(axis, hit.t));
        // What has been sent, by what it arrives on.
        let (sent_by, area) = (sent.by[0].length(), across[0].cross(across[1]).length().max(f32::MIN_POSITIVE));
        photon.irradiance = transmittance.max_element() * (sent_by * sent_by / area);
        // By that of the light without faces at the same distance.
        let strength = photon.irradiance * if self.is_distant { 1.0 } else { (self.length + hit.t).powi(2) };
        if reflected.is_some() && (strength.is_nan() || strength < MIN_STRENGTH) {
            return None;
        }
        let slant = direction.dot(normal).abs().max(MIN_SLANT);
        // Where neighbouring rays hit the surface, along it.
        let [a, b] = across.map(|across| across.abs() + direction.abs() * (across.dot(normal).abs() / slant));
        let around = FOLD * a.length().max(b.length()) + blur * hit.t / slant;
        Some(Arrival { photon, point: beam.ray.at(hit.t), extent: a + b + around })
    }
}
