//! Glass that stands still, in a tree of its own: which panes does a ray cross on its straight way, and what is left of
//! its light?
//!
//! A pane is a thin wall, or two parallel flat faces of one solid, of smooth glass and nothing else. With the
//! reflectance `F` of each face and the transmittance `a` between them, all inner reflections summed,
//!
//! `T = (1 - F)² a / (1 - F² a²)`, `R = F + (1 - F)² F a² / (1 - F² a²)`,
//!
//! times the tint at each crossing of a face. A thin wall has `a = 1`.
//!
//! Deviations: a pane does not offset light sideways. Where the offset would be more than a few percent of the distance
//! to the pane, the ray [`Bends`](Next::Bends).

use glam::Vec3;
use halfdome_kernel::{BuildOptions, Bvh, Error, Executor, Hit, Ray, Triangle};

use super::super::MAX_FACES;
use super::MIN_PARALLEL_COS;
use crate::material::fresnel::Dielectric;
use crate::scene::{Material, Mesh};
use crate::world::TriangleRecord;

/// The greatest offset by a pane, relative to the distance to it.
const MAX_OFFSET: f32 = 0.03;

/// Triangles of glass, and a tree of them.
#[derive(Debug)]
pub(crate) struct GlassTree {
    tree: Bvh,
    /// By triangle of the tree; those without are curved, rough, or more than glass.
    faces: Vec<Option<PaneFace>>,
    pub(in crate::world) has_panes: bool,
}

/// A flat triangle of clear glass.
#[derive(Clone, Copy, Debug)]
struct PaneFace {
    /// The unit normal of its front.
    front: Vec3,
    /// Its material; triangles of one solid have the same.
    material: u32,
    glass: ClearGlass,
}

/// Smooth glass without anything else.
#[derive(Clone, Copy, Debug)]
struct ClearGlass {
    tint: Vec3,
    absorption: Vec3,
    ior: f32,
    fresnel: Dielectric,
    is_thin: bool,
}

/// A pane on the way of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pane {
    /// Where the ray meets its faces; twice the same of a thin wall.
    pub enters: f32,
    pub leaves: f32,
    /// The unit normal on the side that the ray comes from.
    pub normal: Vec3,
    pub transmittance: Vec3,
    pub reflectance: Vec3,
}

/// What a ray meets first of glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Next {
    Nothing,
    Pane(Pane),
    /// Glass that it does not cross straight.
    Bends,
}

impl GlassTree {
    /// The glass among the triangles of `records`, of which the first have these `corners`; `None` if there is none.
    pub(in crate::world) fn new<E: Executor>(
        (meshes, first_faces): (&[Mesh], &[u32]),
        materials: &[Material],
        (records, corners): (&[TriangleRecord], &[Triangle]),
        (executor, options): (&E, &BuildOptions),
    ) -> Result<Option<Self>, Error> {
        let is_glass: Vec<bool> = materials.iter().map(|it| it.is_glass() && !it.has_holes()).collect();
        if !is_glass.contains(&true) {
            return Ok(None);
        }
        let glasses: Vec<_> = materials.iter().map(ClearGlass::of).collect();
        let (mut faces, mut placed) = (Vec::new(), Vec::new());
        for (prim, (record, corners)) in records.iter().zip(corners).enumerate() {
            let mesh = &meshes[record.mesh as usize];
            // The alpha of vertices may make holes.
            if is_glass[record.material as usize] && mesh.colors.is_empty() {
                let face = prim - first_faces[record.mesh as usize] as usize;
                let (front, glass) = (flat_front(record, mesh, face), glasses[record.material as usize]);
                let face = front.zip(glass).map(|(front, glass)| PaneFace { front, material: record.material, glass });
                faces.push(face);
                placed.push(*corners);
            }
        }
        if faces.is_empty() {
            return Ok(None);
        }
        let (tree, _) = Bvh::build_on(executor, &placed, options)?;
        let glass = Self { tree, faces, has_panes: false };
        Ok(Some(Self { has_panes: glass.has_panes(&placed), ..glass }))
    }

    /// The number of its triangles.
    pub(in crate::world) fn count(&self) -> usize {
        self.faces.len()
    }

    /// Whether any of them is a pane's: the surface of water is as flat, but nothing is parallel to it.
    fn has_panes(&self, corners: &[Triangle]) -> bool {
        self.faces.iter().zip(corners).any(|(face, [a, b, c])| {
            let Some(PaneFace { front, .. }) = face else { return false };
            let distance = 1e-3 * (*b - *a).length().max((*c - *a).length());
            let ray = Ray::new((*a + *b + *c) / 3.0 + distance * *front, -*front);
            matches!(self.next(&ray), Next::Pane(_))
        })
    }

    /// Whether a ray meets any glass.
    pub(crate) fn is_met(&self, ray: &Ray) -> bool {
        self.tree.view().occluded(ray)
    }

    /// The nearest glass along each of some rays.
    pub(crate) fn intersect_many(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.tree.view().intersect_many(rays, hits);
    }

    /// The nearest glass along a ray.
    pub(crate) fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.tree.view().intersect(ray)
    }

    /// What a ray meets first of glass, whatever else is in its way.
    pub(crate) fn next(&self, ray: &Ray) -> Next {
        self.intersect(ray).map_or(Next::Nothing, |entry| self.next_at(ray, &entry))
    }

    /// The same where the nearest glass is known.
    fn next_at(&self, ray: &Ray, entry: &Hit) -> Next {
        let Some(face) = &self.faces[entry.prim_id as usize] else { return Next::Bends };
        let length = ray.direction.length();
        let along = face.front.dot(ray.direction) / length;
        let glass = &face.glass;
        let (cos, side) = (along.abs(), -along.signum());
        let (reflected, cos_inside) = glass.fresnel.at(cos);
        let f = reflected.max_element();
        if glass.is_thin {
            return Next::Pane(Pane {
                enters: entry.t,
                leaves: entry.t,
                normal: side * face.front,
                transmittance: glass.tint * ((1.0 - f) / (1.0 + f)),
                reflectance: 2.0 * reflected / (1.0 + reflected),
            });
        }
        // From within, or along the face, which lets nothing through.
        if along > 0.0 || f >= 1.0 {
            return Next::Bends;
        }
        let Some(exit) = self.intersect(&Ray { t_min: entry.t.next_up(), ..*ray }) else {
            return Next::Bends;
        };
        let Some(behind) = &self.faces[exit.prim_id as usize] else { return Next::Bends };
        if behind.material != face.material || behind.front.dot(face.front) > -MIN_PARALLEL_COS {
            return Next::Bends;
        }
        let thickness = (exit.t - entry.t) * length * cos;
        let (sin, cos_inside) = ((1.0 - cos * cos).max(0.0).sqrt(), cos_inside.max(1e-3));
        let offset = thickness * sin * (1.0 - cos / (glass.ior * cos_inside));
        if offset > MAX_OFFSET * entry.t * length {
            return Next::Bends;
        }
        let absorbed = (-thickness / cos_inside * glass.absorption).exp();
        // Both faces have the same angles.
        let inner = (1.0 - f) * (1.0 - f) / (1.0 - f * f * absorbed * absorbed);
        Next::Pane(Pane {
            enters: entry.t,
            leaves: exit.t,
            normal: face.front,
            transmittance: glass.tint * glass.tint * absorbed * inner,
            reflectance: reflected + f * glass.tint * glass.tint * absorbed * absorbed * inner,
        })
    }

    /// Takes a shadow ray, whose nearest glass is known, through all panes on its way: the part of it behind them, and
    /// their transmittance; `None` if glass bends it. `before` is shown the parts of the ray before and inside of panes.
    pub(crate) fn cross(&self, shadow: &Ray, first: &Hit, mut before: impl FnMut(Ray)) -> Option<(Ray, Vec3)> {
        let (mut ray, mut transmittance) = (*shadow, Vec3::ONE);
        let mut next = self.next_at(shadow, first);
        for _ in 0..MAX_FACES {
            let pane = match next {
                Next::Nothing => return Some((ray, transmittance)),
                Next::Pane(pane) => pane,
                Next::Bends => return None,
            };
            before(Ray { t_max: pane.enters.next_down(), ..ray });
            if pane.enters < pane.leaves {
                before(pane.inside(&ray));
            }
            transmittance *= pane.transmittance;
            ray.t_min = pane.leaves.next_up();
            next = self.next(&ray);
        }
        None
    }
}

impl Pane {
    /// The part of a ray between its faces.
    pub(crate) fn inside(&self, ray: &Ray) -> Ray {
        Ray { t_min: self.enters.next_up(), t_max: self.leaves.next_down(), ..*ray }
    }
}

impl ClearGlass {
    fn of(material: &Material) -> Option<Self> {
        let inputs = material.clear_glass_inputs()?;
        Some(Self {
            tint: inputs.transmission_color,
            absorption: inputs.absorption,
            ior: inputs.specular_ior,
            fresnel: Dielectric::new(inputs.specular_ior, false, inputs.specular_weight, inputs.specular_color),
            is_thin: inputs.thin_walled,
        })
    }
}

/// The unit normal of a triangle's front, if the vertex normals are about the same.
fn flat_front(record: &TriangleRecord, mesh: &Mesh, face: usize) -> Option<Vec3> {
    if mesh.normals.is_empty() {
        return Some(record.normal);
    }
    let normals = mesh.triangles[face].map(|corner| mesh.normals[corner as usize].normalize_or_zero());
    let side = record.normal.dot(normals[0]).signum();
    let front = side * record.normal;
    normals.iter().all(|normal| front.dot(*normal) > MIN_PARALLEL_COS).then_some(front)
}

#[cfg(test)]
mod tests;
