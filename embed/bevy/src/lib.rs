//! Gives glTF files that `halfdome bake --preset bevy` made their lightmaps.
//!
//! A node of such a file says in its extras, which Bevy keeps in [`GltfExtras`], which file is the lightmap of each
//! primitive of its mesh: `"halfdome_lightmaps": ["level-0.ktx2", null]`. The files are beside the glTF file; their
//! texels are irradiance over π, and the meshes' second texture coordinates say where each surface is. So all that is
//! left to do is to load the pictures and to hang a [`Lightmap`] on each entity:
//!
//! ```no_run
//! use bevy::prelude::*;
//!
//! App::new()
//!     .add_plugins((DefaultPlugins, halfdome_bevy::BakedLightmapPlugin::default()))
//!     .add_systems(Startup, |mut commands: Commands, assets: Res<AssetServer>| {
//!         commands.spawn(WorldAssetRoot(assets.load(GltfAssetLabel::Scene(0).from_asset("level.baked.glb"))));
//!     })
//!     .run();
//! ```
//!
//! What was baked is not to be lit again: leave out the file's own lights if the bake was of mode `full`, and tell
//! Bevy's ambient light to spare what has a lightmap (`affects_lightmapped_meshes`).

use bevy::asset::AssetPath;
use bevy::gltf::GltfExtras;
use bevy::image::{ImageLoaderSettings, ImageSampler};
use bevy::pbr::Lightmap;
use bevy::prelude::*;
use serde_json::Value;

/// The member of a node's extras that names the lightmaps.
const KEY: &str = "halfdome_lightmaps";

/// Hangs lightmaps on the meshes of baked files when they are spawned.
#[derive(Clone, Copy, Debug, Resource)]
pub struct BakedLightmapPlugin {
    /// What the light of the maps is multiplied by, before the camera's exposure. With 1, a bake in W/m² looks to Bevy
    /// like light in lux; set it to what your own lights were multiplied by.
    pub exposure: f32,
    /// Whether the maps are sampled smoothly, which takes longer. Bake with `--sampling bicubic` for it.
    pub bicubic: bool,
}

impl Default for BakedLightmapPlugin {
    fn default() -> Self {
        Self { exposure: 1.0, bicubic: false }
    }
}

impl Plugin for BakedLightmapPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(*self).add_systems(Update, attach);
    }
}

/// Attaches the lightmaps of all nodes that have just been spawned.
fn attach(
    mut commands: Commands,
    options: Res<BakedLightmapPlugin>,
    assets: Res<AssetServer>,
    nodes: Query<(&GltfExtras, &Children), Added<GltfExtras>>,
    surfaces: Query<(&Mesh3d, &MeshMaterial3d<StandardMaterial>)>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for (extras, children) in &nodes {
        let Some(files) = files(&extras.value) else { continue };
        for child in children {
            let Ok((mesh, material)) = surfaces.get(*child) else { continue };
            let Some((model, primitive)) = place(mesh) else { continue };
            let Some(Some(file)) = files.get(primitive) else { continue };
            let path = match model.resolve_embed_str(file) {
                Ok(path) => path,
                Err(error) => {
                    warn!("the lightmap {file:?} cannot be found: {error}");
                    continue;
                }
            };
            let settings = |settings: &mut ImageLoaderSettings| {
                settings.is_srgb = false;
                // There are gutters around charts, but no smaller levels.
                settings.sampler = ImageSampler::linear();
            };
            let image = assets.load_builder().with_settings(settings).load(path);
            if let Some(mut material) = materials.get_mut(&material.0) {
                material.lightmap_exposure = options.exposure;
            }
            let bicubic_sampling = options.bicubic;
            commands.entity(*child).insert(Lightmap { image, bicubic_sampling, ..default() });
        }
    }
}

/// The lightmap of each primitive, if the extras have them.
fn files(extras: &str) -> Option<Vec<Option<String>>> {
    let extras: Value = serde_json::from_str(extras).ok()?;
    let files = extras.get(KEY)?.as_array()?.iter();
    Some(files.map(|file| file.as_str().map(str::to_owned)).collect())
}

/// The glTF file that a mesh is of, and the index of its primitive: Bevy labels meshes `Mesh3/Primitive1`.
fn place(mesh: &Mesh3d) -> Option<(AssetPath<'static>, usize)> {
    let path = mesh.0.path()?;
    let (_, primitive) = path.label()?.rsplit_once("Primitive")?;
    Some((path.without_label().into_owned(), primitive.parse().ok()?))
}
