//! A material at a point of a mesh, with its textures and vertex attributes.
//!
//! # Normals
//!
//! Normal maps are read as MikkTSpace defines them: `n = x T + y B + z N` with tangent `T` and normal `N` as they are
//! interpolated, not normalised, and `B = w N × T`, in the coordinates of [`Mesh::map_space`]. Bump maps follow Blinn
//! 1978 in Mikkelsen's form (2010): `n ∥ N - (h_u (P_v × N) + h_v (N × P_u)) / (N · (P_u × P_v))`, with `h_u` a central
//! difference over one texel. Both give the normal on the front. Deviation: normals that point below the surface are
//! handled in shading, where the direction of light is known.

use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::material::Inputs;
use crate::scene::{BumpMap, CoatNormal, Material, Mesh, NormalMap, Texture, TextureMap, Turn};

/// A point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct MeshPoint<'a> {
    /// The scene's.
    pub textures: &'a [Texture],
    /// The position.
    pub mesh: &'a Mesh,
    /// The triangle's index in the mesh.
    pub triangle: usize,
    /// Barycentric weights of its corners, which add up to 1.
    pub weights: [f32; 3],
    /// How an instance turns the mesh; `None` if it is in world space.
    pub turn: Option<Turn>,
}

/// The inputs of shading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadingInputs {
    /// The inputs of the closure.
    pub inputs: Inputs,
    /// Shading normal and tangent.
    pub frame: ShadingFrame,
    /// Radiance emitted, from the sides that emit.
    pub emission: Vec3,
}

/// Axes of the shading frame; the third one is `normal × tangent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadingFrame {
    /// Unit vector, on the front.
    pub normal: Vec3,
    /// Unit vector across it, along which anisotropy is measured; zero where any will do.
    pub tangent: Vec3,
}

impl<'a> MeshPoint<'a> {
    /// The sum of three values by the weights.
    #[inline]
    fn mix<T: core::ops::Mul<f32, Output = T> + core::ops::Add<Output = T>>(&self, [a, b, c]: [T; 3]) -> T {
        a * self.weights[0] + b * self.weights[1] + c * self.weights[2]
    }

    #[inline]
    pub(crate) fn corners<T: Copy>(&self, values: &[T]) -> [T; 3] {
        let [a, b, c] = self.mesh.triangles[self.triangle];
        [values[a as usize], values[b as usize], values[c as usize]]
    }

    /// Texture coordinates of a set, if the mesh has it.
    #[inline]
    pub fn texcoord(&self, set: u32) -> Option<Vec2> {
        let texcoords = self.mesh.texcoord_set(set)?;
        Some(self.mix(self.corners(texcoords)))
    }

    /// The texel of a map; the texture's mean where the mesh lacks its coordinates.
    #[inline]
    pub fn texel(&self, map: &TextureMap) -> Vec4 {
        let texture = &self.textures[map.texture];
        self.texcoord(map.set).map_or_else(|| texture.mean_in(map.space), |texcoord| texture.sample(map, texcoord))
    }

    /// The interpolated tangent, with the bitangent's sign; `None` if the mesh has none.
    fn tangent(&self) -> Option<Vec4> {
        let tangent = self.mix(*self.mesh.tangents.get(self.triangle)?);
        Some(self.map_turn().or(self.turn).map_or(tangent, |turn| turn.tangent(tangent)))
    }

    /// The turn from the coordinates in which normal maps apply to the world, if these are not the mesh's own.
    fn map_turn(&self) -> Option<Turn> {
        let space = self.mesh.map_space?;
        Some(self.turn.map_or_else(|| Turn::new(space), |turn| turn.after(space)))
    }

    /// The normal by a map, where `normal` is the one by the vertices, not normalised; `None` if the mesh has no
    /// tangents.
    fn mapped_normal(&self, map: &NormalMap, normal: Vec3) -> Option<Vec3> {
        let tangent = self.mix(*self.mesh.tangents.get(self.triangle)?);
        let texel = self.texel(&map.texture);
        Some(match self.map_turn() {
            Some(turn) => turn.normal(map.normal(texel, turn.normal_before(normal), tangent)),
            None => map.normal(texel, normal, self.turn.map_or(tangent, |turn| turn.tangent(tangent))),
        })
    }

    /// The colour of the vertices; white if they have none.
    #[inline]
    fn vertex_color(&self) -> Vec4 {
        if self.mesh.colors.is_empty() { Vec4::ONE } else { self.mix(self.corners(&self.mesh.colors)) }
    }

    /// Derivatives of position and normal direction for the texture coordinates of a set; `None` where these do not
    /// span the triangle.
    fn derivatives(&self, set: u32) -> Option<[Vec3; 2]> {
        let texcoords = self.corners(self.mesh.texcoord_set(set)?);
        let [a, b, c] = self.corners(&self.mesh.positions).map(Vec3::as_dvec3);
        let (edge1, edge2) = (b - a, c - a);
        let [d1, d2] = [texcoords[1] - texcoords[0], texcoords[2] - texcoords[0]].map(Vec2::as_dvec2);
        let determinant = d1.perp_dot(d2);
        let along = (edge1 * d2.y - edge2 * d1.y) / determinant;
        let down = (edge2 * d1.x - edge1 * d2.x) / determinant;
        let finite = along.is_finite() && down.is_finite() && determinant != 0.0;
        let turned = |vector: DVec3| self.turn.map_or(vector.as_vec3(), |turn| turn.vector(vector.as_vec3()));
        finite.then(|| [along, down].map(turned))
    }
}

impl Material {
    /// All that is needed for shading at a point whose interpolated normal is `normal`: a vector on the front, not
    /// normalised, or the triangle's own normal.
    pub fn shading_at(&self, point: &MeshPoint<'_>, normal: Vec3) -> ShadingInputs {
        let (inputs, emission) = (self.inputs_at(point), self.emission_at(point));
        ShadingInputs { inputs, emission, frame: self.frame_at(point, normal) }
    }

    /// The closure's inputs at a point.
    pub fn inputs_at(&self, point: &MeshPoint<'_>) -> Inputs {
        let color = if self.uses_vertex_colors { point.vertex_color().truncate() } else { Vec3::ONE };
        self.inputs_by(|map| point.texel(map), color.clamp(Vec3::ZERO, Vec3::ONE))
    }

    /// Radiance emitted at a point, from the sides that emit.
    pub fn emission_at(&self, point: &MeshPoint<'_>) -> Vec3 {
        let mapped =
            self.emission_map.as_ref().map_or(self.emission, |map| self.emission * point.texel(map).truncate());
        // What is unlit shows its base colour, which vertex colours multiply.
        let vertex = if self.unlit && self.uses_vertex_colors { point.vertex_color().truncate() } else { Vec3::ONE };
        (mapped * vertex).max(Vec3::ZERO)
    }

    /// The opacity at a point: 0 to 1, of a mask 0 or 1.
    pub fn opacity_at(&self, point: &MeshPoint<'_>) -> f32 {
        let texel = self.opacity.map.as_ref().map_or(Vec4::ONE, |(map, _)| point.texel(map));
        self.opacity.at(texel, if self.uses_vertex_colors { point.vertex_color().w } else { 1.0 })
    }

    /// Whether a map makes shading normals other than the interpolated ones.
    pub fn tilts_normals(&self) -> bool {
        self.normal_map.is_some() || self.bump_map.is_some()
    }

    /// The coat's normal at a point, on the front, where it is not that of what the coat covers; `smooth` is the unit
    /// normal by the vertices.
    pub fn coat_normal_at(&self, point: &MeshPoint<'_>, smooth: Vec3) -> Option<Vec3> {
        match &self.coat_normal {
            CoatNormal::OfBase => None,
            CoatNormal::OfVertices => Some(smooth),
            CoatNormal::Map(map) => point.mapped_normal(map, smooth).and_then(Vec3::try_normalize).or(Some(smooth)),
        }
    }

    /// Normal and tangent at a point, whose interpolated normal is `interpolated`, as in
    /// [`shading_at`](Self::shading_at).
    pub fn frame_at(&self, point: &MeshPoint<'_>, interpolated: Vec3) -> ShadingFrame {
        let mapped = self.normal_map.as_ref().and_then(|map| point.mapped_normal(map, interpolated));
        let mut normal = mapped.unwrap_or(interpolated);
        if let Some(map) = &self.bump_map {
            normal = map.normal(point, normal.normalize_or(interpolated));
        }
        let normal = normal.normalize_or(interpolated.normalize_or(Vec3::Z));
        let tangent = self.is_anisotropic().then(|| point.tangent()).flatten().and_then(|tangent| {
            let along = tangent.truncate().reject_from(normal).try_normalize()?;
            let bitangent = normal.cross(along) * tangent.w.signum();
            Some(self.turned(point, along, bitangent))
        });
        ShadingFrame { normal, tangent: tangent.unwrap_or(Vec3::ZERO) }
    }

    /// The tangent, turned as anisotropy asks.
    fn turned(&self, point: &MeshPoint<'_>, tangent: Vec3, bitangent: Vec3) -> Vec3 {
        let map = self.anisotropy.as_ref().and_then(|anisotropy| anisotropy.map.as_ref());
        if self.tangent_rotation == 0.0 && map.is_none() {
            return tangent;
        }
        let turn = Vec2::from_angle(self.tangent_rotation);
        let texel = map.map_or(Vec2::X, |map| point.texel(map).truncate().truncate() * 2.0 - 1.0);
        let slope = turn.rotate(texel.try_normalize().unwrap_or(Vec2::X));
        (tangent * slope.x + bitangent * slope.y).normalize_or(tangent)
    }
}

impl NormalMap {
    /// The normal of a texel, with the interpolated normal, and tangent with the bitangent's sign; not normalised.
    fn normal(&self, texel: Vec4, normal: Vec3, tangent: Vec4) -> Vec3 {
        let local = texel.truncate() * 2.0 - 1.0;
        let bitangent = normal.cross(tangent.truncate()) * tangent.w.signum();
        let (x, y) = (local.x * self.scale.x, local.y * self.scale.y);
        let mapped = tangent.truncate() * x + bitangent * y + normal * local.z;
        // A texel of 128 in all channels has no direction, but for rounding.
        if local.length_squared() > 1e-3 && mapped.length_squared() > 1e-12 * normal.length_squared() {
            mapped
        } else {
            normal
        }
    }
}

impl BumpMap {
    /// The unit normal, turned by the slope of the heights.
    fn normal(&self, point: &MeshPoint<'_>, normal: Vec3) -> Vec3 {
        let set = self.texture.set;
        let (Some([along, down]), Some(texcoord)) = (point.derivatives(set), point.texcoord(set)) else {
            return normal;
        };
        let texture = &point.textures[self.texture.texture];
        let (width, height) = texture.size();
        // A texel in texture coordinates before their transform.
        let scale = self.texture.transform.matrix2;
        let step = Vec2::new(
            1.0 / (width as f32 * scale.x_axis.length().max(1e-6)),
            1.0 / (height as f32 * scale.y_axis.length().max(1e-6)),
        );
        let height_at = |at: Vec2| self.channel.of(texture.sample(&self.texture, at)).x * self.height;
        let slope = |by: Vec2| height_at(texcoord + 0.5 * by) - height_at(texcoord - 0.5 * by);
        let slope_along = slope(Vec2::X * step.x) / step.x;
        let slope_down = slope(Vec2::Y * step.y) / step.y;
        let volume = normal.dot(along.cross(down));
        let turned = normal - (slope_along * down.cross(normal) + slope_down * normal.cross(along)) / volume;
        if turned.is_finite() && volume != 0.0 { turned } else { normal }
    }
}

#[cfg(test)]
mod tests;
