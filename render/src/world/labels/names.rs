//! Names of surfaces and lights, for masks and light path expressions.

use glam::Vec3;

use crate::scene::{LightLabel, Mesh};
use crate::settings::MatteKind;
use crate::world::{Hit, World};

impl World {
    /// The names of all objects or materials, by their indices. One without a name is called by its index.
    pub(crate) fn names(&self, kind: MatteKind) -> Box<dyn Iterator<Item = String> + '_> {
        let named = move |(number, name): (usize, &String)| match name.as_str() {
            "" => format!("{} {number}", kind.name()),
            name => name.to_owned(),
        };
        match kind {
            MatteKind::Object => Box::new(self.meshes.iter().map(|mesh| &mesh.name).enumerate().map(named)),
            MatteKind::Material => Box::new(self.materials.iter().map(|it| &it.name).enumerate().map(named)),
        }
    }

    /// The index of the triangle at a hit in its mesh.
    pub(crate) fn triangle_number(&self, hit: &Hit) -> u32 {
        hit.prim_id - self.first_faces[self.mesh_number(hit.prim_id)]
    }

    /// The index of the object or the material at a hit.
    pub(crate) fn number_of(&self, kind: MatteKind, hit: &Hit) -> usize {
        let record = &self.triangle_records[hit.prim_id as usize];
        match kind {
            MatteKind::Object => record.mesh as usize,
            MatteKind::Material => record.material as usize,
        }
    }
}

/// The labels of lights without a name, and of the sky.
const REST: &str = "rest";
pub(super) const SKY: &str = "sky";

impl World {
    /// The index of the mesh that a triangle belongs to.
    #[inline]
    pub(crate) fn mesh_number(&self, prim_id: u32) -> usize {
        self.triangle_records[prim_id as usize].mesh as usize
    }

    /// Of each mesh what light path expressions call its surface: the names of the object and the material.
    pub(crate) fn surface_labels(&self) -> impl Iterator<Item = [String; 2]> {
        let materials: Vec<String> = self.names(MatteKind::Material).collect();
        let objects = self.names(MatteKind::Object);
        objects.zip(&self.meshes).map(move |(object, mesh)| [object, materials[mesh.material].clone()])
    }

    /// Of each mesh whether it is a lamp, and what light path expressions call its light: the names of its group and
    /// itself.
    pub(crate) fn emitter_labels(&self) -> impl Iterator<Item = (bool, [String; 2])> {
        self.meshes.iter().map(|mesh| {
            let material = &self.materials[mesh.material];
            let name = first_name([&mesh.name, &material.name]);
            (mesh.is_added && mesh.origin.is_none(), [first_name([&material.light_group, &name]), name])
        })
    }

    /// The same of those meshes alone that emit.
    pub(crate) fn lit_labels(&self) -> impl Iterator<Item = (bool, [String; 2])> {
        self.emitter_labels().zip(&self.meshes).filter(|(_, mesh)| self.emits(mesh)).map(|(labels, _)| labels)
    }

    /// The names of the group and of the light itself, for each punctual light in the scene's order.
    pub(crate) fn punctual_labels(&self) -> impl Iterator<Item = [String; 2]> {
        self.light_labels.iter().map(|LightLabel { name, group }| {
            let name = first_name([name, ""]);
            [first_name([group, &name]), name]
        })
    }

    /// The labels of the sky.
    pub(crate) fn sky_labels() -> [String; 2] {
        [SKY; 2].map(str::to_owned)
    }

    /// Whether a mesh has surfaces that emit.
    pub(super) fn emits(&self, mesh: &Mesh) -> bool {
        !mesh.triangles.is_empty() && self.materials[mesh.material].emission != Vec3::ZERO
    }

    /// The names of the groups of all lights, sorted; before them that of the sky, if it has light. Lamps may have a
    /// group of its name, which is another.
    pub(crate) fn light_groups(&self) -> (Option<String>, Vec<String>) {
        let labels = self.lit_labels().map(|(_, labels)| labels).chain(self.punctual_labels());
        let mut groups: Vec<String> = labels.map(|[group, _]| group).collect();
        groups.sort_unstable();
        groups.dedup();
        ((self.lights.sky.mean() != Vec3::ZERO).then(|| SKY.to_owned()), groups)
    }
}

/// The first of these that is not empty.
fn first_name(names: [&str; 2]) -> String {
    names.into_iter().find(|name| !name.is_empty()).unwrap_or(REST).to_owned()
}
