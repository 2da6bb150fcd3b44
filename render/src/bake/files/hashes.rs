//! Hashes of a bake's inputs, to detect what has changed.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::bake::options::BakeOptions;
use crate::scene::{Mesh, Scene, fnv};

/// Hashes, 64 bits each, of what a bake depends on.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hashes {
    /// The hash of all options.
    pub options: Hash,
    /// The hash of all materials.
    pub materials: Hash,
    /// The hash of delta lights.
    pub lights: Hash,
    /// The hash of the sky.
    pub sky: Hash,
    /// The hash of each mesh, with its name, in the scene's order.
    pub meshes: Vec<(String, Hash)>,
}

/// A hash of 64 bits; 16 hexadecimal digits in JSON, whose numbers have fewer bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Hash(pub u64);

/// Hashes of all that a bake depends on; equal ones give equal maps.
pub fn hashes(scene: &Scene, options: &BakeOptions) -> Hashes {
    let nothing = Scene::default();
    let mesh = |mesh: &Mesh| {
        let shape = Scene { meshes: vec![mesh.clone()], ..nothing.clone() }.hash();
        let numbers = mesh.lightmap_texcoords.iter().flat_map(|uv| uv.to_array());
        let bytes: Vec<u8> = numbers.flat_map(f32::to_le_bytes).chain(shape.to_le_bytes()).collect();
        (mesh.name.clone(), Hash::of(&bytes))
    };
    let named: Vec<String> = options.named().into_iter().map(|(name, value)| format!("{name}={value}")).collect();
    Hashes {
        options: Hash::of(named.join("\n").as_bytes()),
        materials: Hash(Scene { materials: scene.materials.clone(), ..nothing.clone() }.hash()),
        lights: Hash(Scene { lights: scene.lights.clone(), ..nothing.clone() }.hash()),
        sky: Hash(Scene { sky: scene.sky.clone(), ..nothing.clone() }.hash()),
        meshes: scene.meshes.iter().map(mesh).collect(),
    }
}

/// One hash of all of them and of this version of the program.
pub fn combined(hashes: &Hashes) -> u64 {
    let Hashes { options, materials, lights, sky, meshes } = hashes;
    let all = [options, materials, lights, sky].into_iter().chain(meshes.iter().map(|(_, hash)| hash));
    let bytes: Vec<u8> = all.flat_map(|hash| hash.0.to_le_bytes()).chain(env!("CARGO_PKG_VERSION").bytes()).collect();
    Hash::of(&bytes).0
}

impl Hashes {
    /// The differences between two bakes, one line each; empty if there are none.
    pub fn changes_since(&self, old: &Self) -> Vec<String> {
        let fields = [
            (self.options, old.options, "the options"),
            (self.materials, old.materials, "materials"),
            (self.lights, old.lights, "lights"),
            (self.sky, old.sky, "the sky"),
        ];
        let changed = fields.iter().filter(|(new, old, _)| new != old);
        let mut changes: Vec<String> = changed.map(|(_, _, what)| format!("{what} changed")).collect();
        // Of several meshes with one name each is compared with the one in its place among them.
        let (mut of_new, mut of_old) = (by_name(&self.meshes), by_name(&old.meshes));
        let mut told: BTreeSet<&str> = BTreeSet::new();
        for (name, _) in self.meshes.iter().filter(|(name, _)| told.insert(name)) {
            let [now, before] = [&mut of_new, &mut of_old].map(|of| of.remove(name.as_str()).unwrap_or_default());
            let change = match now.len().cmp(&before.len()) {
                Ordering::Less => "was removed",
                Ordering::Greater => "was added",
                Ordering::Equal if now != before => "changed",
                Ordering::Equal => continue,
            };
            changes.push(format!("mesh {name:?} {change}"));
        }
        changes.extend(of_old.keys().map(|name| format!("mesh {name:?} was removed")));
        if changes.is_empty() && self.meshes != old.meshes {
            changes.push("the order of meshes changed".to_owned());
        }
        changes
    }
}

/// The hashes of the meshes of each name, in their order.
fn by_name(meshes: &[(String, Hash)]) -> BTreeMap<&str, Vec<Hash>> {
    let mut named: BTreeMap<&str, Vec<Hash>> = BTreeMap::new();
    meshes.iter().for_each(|(name, hash)| named.entry(name).or_default().push(*hash));
    named
}

impl Hash {
    /// FNV-1a of these bytes (Fowler, Noll and Vo).
    pub fn of(bytes: &[u8]) -> Self {
        Self(fnv(bytes))
    }
}

impl From<Hash> for String {
    fn from(hash: Hash) -> Self {
        format!("{:016x}", hash.0)
    }
}

impl TryFrom<String> for Hash {
    type Error = String;

    fn try_from(digits: String) -> Result<Self, String> {
        let hash = u64::from_str_radix(&digits, 16).ok().filter(|_| digits.len() == 16 && !digits.starts_with('+'));
        hash.map(Self).ok_or_else(|| format!("{digits:?} is not a hash of 16 hexadecimal digits"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_told() {
        let meshes = vec![("wall".to_owned(), Hash(1)), (String::new(), Hash(2))];
        let old = Hashes { options: Hash(5), meshes, ..Hashes::default() };
        assert!(old.changes_since(&old).is_empty());
        let mut new = old.clone();
        (new.sky, new.meshes[0].1) = (Hash(7), Hash(8));
        assert_eq!(new.changes_since(&old), ["the sky changed", "mesh \"wall\" changed"]);
        new.meshes[1].0 = "door".to_owned();
        new.meshes.push(("wall".to_owned(), Hash(9)));
        let told = ["the sky changed", "mesh \"wall\" was added", "mesh \"door\" was added", "mesh \"\" was removed"];
        assert_eq!(new.changes_since(&old), told);
        let mut turned = old.clone();
        turned.meshes.reverse();
        assert_eq!(turned.changes_since(&old), ["the order of meshes changed"]);
    }
}
