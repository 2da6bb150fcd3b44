//! The reflectance of interfaces: Fresnel's equations, and approximations.
//!
//! `cos` is the cosine between a direction and the (micro)facet's normal, 0 to 1.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A dielectric's reflectance for unpolarized light, and the cosine of the refracted direction: 1 and 0 where reflection
/// is total. `eta`: refractive index beyond the interface by that on the side of `cos`.
#[inline(always)]
pub fn dielectric(cos: f32, eta: f32) -> (f32, f32) {
    let sin2_beyond = (1.0 - cos) * (1.0 + cos) / (eta * eta);
    // Without a branch, for lanes. Where reflection is total, both reflectances come out as 1, but for 0 by 0.
    let is_total = sin2_beyond >= 1.0;
    let cos_beyond = (1.0 - sin2_beyond).max(0.0).sqrt();
    let reflectance = of_refraction(cos, cos_beyond, eta);
    (if is_total { 1.0 } else { reflectance }, cos_beyond)
}

/// The reflectance where both cosines are known: that from the other side, `of_refraction(cos_beyond, cos, 1/eta)`, is the
/// same.
#[inline(always)]
pub fn of_refraction(cos: f32, cos_beyond: f32, eta: f32) -> f32 {
    let perpendicular = (cos - eta * cos_beyond) / (cos + eta * cos_beyond);
    let parallel = (eta * cos - cos_beyond) / (eta * cos + cos_beyond);
    0.5 * (perpendicular * perpendicular + parallel * parallel)
}

/// Reflectance of an interface at normal incidence, for the ratio of refractive indices or its inverse.
#[inline]
pub fn normal_reflectance(ior: f32) -> f32 {
    let root = (ior - 1.0) / (ior + 1.0);
    root * root
}

/// Reflectance of a conductor with the complex refractive index `n + ik`, for unpolarized light.
pub fn conductor(cos: f32, n: f32, k: f32) -> f32 {
    let (cos2, sin2) = (cos * cos, (1.0 - cos) * (1.0 + cos));
    let a = n * n - k * k - sin2;
    let a2_b2 = (a * a + 4.0 * n * n * k * k).sqrt();
    let root = (0.5 * (a2_b2 + a)).max(0.0).sqrt();
    let perpendicular = (a2_b2 + cos2 - 2.0 * root * cos) / (a2_b2 + cos2 + 2.0 * root * cos);
    let (sum, middle) = (a2_b2 * cos2 + sin2 * sin2, 2.0 * root * cos * sin2);
    let parallel = perpendicular * (sum - middle) / (sum + middle);
    0.5 * (perpendicular + parallel)
}

/// `(1 - cos)⁵`, by which Schlick's formula goes from normal to grazing incidence.
#[inline(always)]
pub fn schlick(cos: f32) -> f32 {
    let s = 1.0 - cos;
    (s * s) * (s * s) * s
}

/// The angle at which a metal's `edge` is given: about 82°.
const EDGE_COS: f32 = 1.0 / 7.0;

/// Schlick's formula with a dip before grazing incidence: `F82-tint`, Kutz, Hašan and Edmondson, "Novel aspects of the
/// Adobe Standard Material" (2021):
///
/// `F(c) = F₀ + (1 - F₀)(1 - c)⁵ - a c (1 - c)⁶`, with `a` such that `F(1/7)` is `edge` times Schlick's.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Metal {
    normal: Vec3,
    dip: Vec3,
}

/// The two colours of a [`Metal`] with the complex refractive index `n + ik` in red, green and blue. The second may be
/// greater than 1.
pub fn complex_index_colors(n: Vec3, k: Vec3) -> [Vec3; 2] {
    let exact = |cos| Vec3::from_array(std::array::from_fn(|i| conductor(cos, n[i], k[i])));
    let normal = exact(1.0);
    [normal, exact(EDGE_COS) / (normal + (1.0 - normal) * schlick(EDGE_COS))]
}

impl Metal {
    /// `normal`: reflectance at normal incidence. `edge`: see above; 1 is Schlick's formula.
    #[inline]
    pub fn new(normal: Vec3, edge: Vec3) -> Self {
        let s = 1.0 - EDGE_COS;
        let at_edge = normal + (1.0 - normal) * schlick(EDGE_COS);
        let dip = at_edge * (1.0 - edge) * (1.0 / (EDGE_COS * schlick(EDGE_COS) * s));
        Self { normal, dip }
    }

    /// The metal with the complex refractive index `n + ik` in red, green and blue: exact at 0° and 82°.
    pub fn from_complex_index(n: Vec3, k: Vec3) -> Self {
        let [normal, edge] = complex_index_colors(n, k);
        Self::new(normal, edge)
    }

    /// Reflectance.
    #[inline(always)]
    pub fn at(&self, cos: f32) -> Vec3 {
        let schlick = schlick(cos);
        // A deep dip would go below zero beside its angle.
        (self.normal + (1.0 - self.normal) * schlick - self.dip * (cos * (1.0 - cos) * schlick)).max(Vec3::ZERO)
    }

    /// Reflectance at normal incidence.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Mean reflectance of uniform light, `2 ∫ F(c) c dc`.
    #[inline]
    pub fn mean(&self) -> Vec3 {
        self.normal + (1.0 - self.normal) * (1.0 / 21.0) - self.dip * (1.0 / 126.0)
    }

    /// What is left by further reflections of light that microfacets reflect more than once, if the mean of what they do not
    /// reflect at once is `lost`: Kulla and Conty, "Revisiting physically based shading at Imageworks" (2017).
    #[inline]
    pub fn multiple(&self, lost: f32) -> Vec3 {
        let mean = self.mean();
        mean * (1.0 - lost) / (1.0 - mean * lost)
    }

    /// The albedo of a lobe which is `full` where all is reflected, and `schlick` and `dip` with the other terms.
    pub fn albedo(&self, full: f32, schlick: f32, dip: f32) -> Vec3 {
        self.normal * full + (1.0 - self.normal) * schlick - self.dip * dip
    }
}

/// A dielectric's reflectance as Fresnel gives it, stretched to other ends: `normal` at normal incidence, `grazing` at
/// grazing angles. With the ends 1 and that of its refractive index it is Fresnel's.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Dielectric {
    /// Refractive index beyond by that on this side.
    pub eta: f32,
    /// Reflectance at normal incidence.
    pub normal: Vec3,
    /// Reflectance at grazing angles, and where reflection is total.
    pub grazing: f32,
    /// What Fresnel has at normal incidence, and 1 by the rest to 1.
    physical: f32,
    per_rest: f32,
}

impl Dielectric {
    /// `color` scales the reflectance at normal incidence, which is clamped to 1; `weight` all of it.
    #[inline]
    pub fn new(ior: f32, is_inside: bool, weight: f32, color: Vec3) -> Self {
        let physical = normal_reflectance(ior);
        let eta = if is_inside { 1.0 / ior } else { ior };
        let normal = weight * (physical * color).min(Vec3::ONE);
        Self { eta, normal, grazing: weight, physical, per_rest: 1.0 / (1.0 - physical) }
    }

    /// Reflectance, and the cosine of the refracted direction.
    #[inline(always)]
    pub fn at(&self, cos: f32) -> (Vec3, f32) {
        let (reflectance, cos_beyond) = dielectric(cos, self.eta);
        (self.stretch(reflectance), cos_beyond)
    }

    /// What becomes of Fresnel's reflectance.
    #[inline(always)]
    pub fn stretch(&self, reflectance: f32) -> Vec3 {
        self.normal + (self.grazing - self.normal) * ((reflectance - self.physical) * self.per_rest)
    }

    /// The albedo of a lobe which is `full` where all is reflected, and `fresnel` with Fresnel's reflectance.
    #[inline]
    pub fn albedo(&self, full: f32, fresnel: f32) -> Vec3 {
        let stretched = (fresnel - self.physical * full) * self.per_rest;
        self.normal * (full - stretched) + self.grazing * stretched
    }

    /// The greatest of its three colours.
    #[inline]
    pub fn greatest_albedo(&self, full: f32, fresnel: f32) -> f32 {
        let normal = self.normal.max_element();
        let stretched = (fresnel - self.physical * full) * self.per_rest;
        normal * (full - stretched) + self.grazing * stretched
    }
}
