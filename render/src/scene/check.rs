//! Checks a scene built in memory: indices are in range, and lists have the right lengths.

use thiserror::Error;

use super::{Mesh, Scene};

/// Errors of a [`Scene`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneFault {
    /// A number that names nothing.
    #[error("{owner} {number} names {what} {index}, and there are {count}\n  help: numbers begin at 0")]
    Dangling {
        /// Whose index it is.
        owner: &'static str,
        /// The index.
        number: usize,
        /// The kind of its target.
        what: &'static str,
        /// The number.
        index: usize,
        /// How many of them there are.
        count: usize,
    },
    /// A triangle whose corner is no position.
    #[error(
        "triangle {triangle} of mesh {mesh} has the corner {corner}, and the mesh has {positions} positions\n  help: numbers begin at 0"
    )]
    Corner {
        /// The mesh's index.
        mesh: usize,
        /// The triangle's index.
        triangle: usize,
        /// The number in it.
        corner: u32,
        /// How many positions there are.
        positions: usize,
    },
    /// A position that is infinite or not a number.
    #[error("position {position} of mesh {mesh} is not finite")]
    NotFinite {
        /// The mesh's index.
        mesh: usize,
        /// The position's index.
        position: usize,
    },
    /// A list that is neither empty nor as long as another.
    #[error("mesh {mesh} has {count} {what}, and {of}\n  help: give one for each, or none")]
    Length {
        /// The mesh's index.
        mesh: usize,
        /// The contents of the list.
        what: &'static str,
        /// How many.
        count: usize,
        /// How many of what there are.
        of: String,
    },
}

/// An index, of which there are so many.
fn within(owner: (&'static str, usize), what: &'static str, index: usize, count: usize) -> Result<(), SceneFault> {
    let (owner, number) = owner;
    if index < count { Ok(()) } else { Err(SceneFault::Dangling { owner, number, what, index, count }) }
}

impl Scene {
    /// Finds what would make no sense; scenes that were read from files have nothing of it.
    ///
    /// # Errors
    /// The first fault, of a scene made in memory.
    pub fn check(&self) -> Result<(), SceneFault> {
        for (number, mesh) in self.meshes.iter().enumerate() {
            within(("mesh", number), "material", mesh.material, self.materials.len())?;
            mesh.object.map_or(Ok(()), |object| within(("mesh", number), "object", object, self.objects.len()))?;
            mesh.check(number)?;
        }
        for (number, material) in self.materials.iter().enumerate() {
            for map in material.texture_maps() {
                within(("material", number), "texture", map.texture, self.textures.len())?;
            }
        }
        for (number, instance) in self.instances.iter().enumerate() {
            within(("instance", number), "object", instance.object, self.objects.len())?;
        }
        for (number, variant) in self.variants.iter().enumerate() {
            for &(mesh, material) in &variant.materials {
                within(("variant", number), "mesh", mesh, self.meshes.len())?;
                within(("variant", number), "material", material, self.materials.len())?;
            }
        }
        let Some(motion) = &self.motion else { return Ok(()) };
        for (&mesh, keys) in &motion.meshes {
            within(("motion of mesh", mesh), "mesh", mesh, self.meshes.len())?;
            let positions = self.meshes[mesh].positions.len();
            let lengths = keys.iter().map(Vec::len).chain((keys.len() != motion.keys).then_some(keys.len()));
            if let Some(count) = lengths.into_iter().find(|&count| count != positions) {
                let of = format!("{positions} positions at each of {} keys", motion.keys);
                return Err(SceneFault::Length { mesh, what: "positions in motion", count, of });
            }
        }
        motion
            .instances
            .keys()
            .try_for_each(|&it| within(("motion of instance", it), "instance", it, self.instances.len()))?;
        motion.lights.keys().try_for_each(|&it| within(("motion of light", it), "light", it, self.lights.len()))
    }
}

impl Mesh {
    fn check(&self, mesh: usize) -> Result<(), SceneFault> {
        let positions = self.positions.len();
        if let Some(position) = self.positions.iter().position(|position| !position.is_finite()) {
            return Err(SceneFault::NotFinite { mesh, position });
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&corner) = corners.iter().find(|&&corner| corner as usize >= positions) {
                return Err(SceneFault::Corner { mesh, triangle, corner, positions });
            }
        }
        let (by_position, by_triangle) =
            (format!("{positions} positions"), format!("{} triangles", self.triangles.len()));
        for (what, count, whole, of) in [
            ("normals", self.normals.len(), positions, &by_position),
            ("texcoords", self.texcoords.len(), positions, &by_position),
            ("lightmap_texcoords", self.lightmap_texcoords.len(), positions, &by_position),
            ("colors", self.colors.len(), positions, &by_position),
            ("tangents", self.tangents.len(), self.triangles.len(), &by_triangle),
        ] {
            if count != 0 && count != whole {
                return Err(SceneFault::Length { mesh, what, count, of: of.clone() });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec2, Vec3};

    use super::*;
    use crate::scene::{Instance, Material, Object, Variant};

    fn scene() -> Scene {
        let mesh =
            Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], triangles: vec![[0, 1, 2]], ..Mesh::default() };
        Scene { meshes: vec![mesh], materials: vec![Material::default()], ..Scene::default() }
    }

    #[test]
    fn faults_name_what_is_wrong() {
        assert_eq!(scene().check(), Ok(()));
        let of = |change: fn(&mut Scene)| {
            let mut scene = scene();
            change(&mut scene);
            scene.check().unwrap_err().to_string()
        };
        let first = |text: String| text.lines().next().unwrap().to_owned();
        for (found, expected) in [
            (of(|it| it.meshes[0].material = 1), "mesh 0 names material 1, and there are 1"),
            (of(|it| it.meshes[0].object = Some(0)), "mesh 0 names object 0, and there are 0"),
            (
                of(|it| it.meshes[0].triangles.push([0, 3, 1])),
                "triangle 1 of mesh 0 has the corner 3, and the mesh has 3 positions",
            ),
            (of(|it| it.meshes[0].positions[2].y = f32::NAN), "position 2 of mesh 0 is not finite"),
            (of(|it| it.meshes[0].normals = vec![Vec3::Z; 2]), "mesh 0 has 2 normals, and 3 positions"),
            (of(|it| it.meshes[0].texcoords = vec![Vec2::ZERO; 4]), "mesh 0 has 4 texcoords, and 3 positions"),
            (
                of(|it| it.materials[0].emission_map = Some(crate::scene::TextureMap::default())),
                "material 0 names texture 0, and there are 0",
            ),
            (
                of(|it| {
                    it.objects.push(Object::default());
                    it.instances.push(Instance { object: 1, to_world: Affine3A::IDENTITY });
                }),
                "instance 0 names object 1, and there are 1",
            ),
            (
                of(|it| it.variants.push(Variant { materials: vec![(2, 0)], ..Variant::default() })),
                "variant 0 names mesh 2, and there are 1",
            ),
        ] {
            assert_eq!(first(found), expected);
        }
    }
}
