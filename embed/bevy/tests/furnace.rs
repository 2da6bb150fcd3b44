//! Two sealed rooms, one that glows and one that does not, baked by halfdome and shown by Bevy without a window:
//! entities have their lightmaps, texels the irradiance over π that is known, and so have pixels. Cube maps and an
//! irradiance volume of the room that glows are textures as Bevy's probes want them.
//!
//! In the room that glows each wall emits 1/4 and reflects one half, so that everything has the radiance 1/2.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use bevy::asset::RenderAssetUsages;
use bevy::camera::{Exposure, Hdr, RenderTarget};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::pbr::Lightmap;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages, TextureViewDimension};
use bevy::window::ExitCondition;
use halfdome_bevy::BakedLightmapPlugin;
use serde_json::json;

/// Pixels across and down, of four half floats each: rows of 256 bytes, which need no padding.
const SIDE: u32 = 32;
/// What the plugin multiplies light by.
const EXPOSURE: f32 = 2.0;

/// A GLB file with two rooms, 10 units apart.
fn level() -> Vec<u8> {
    let (mut floats, mut indices): (Vec<f32>, Vec<u16>) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for (side, order) in [(-1.0, [0, 1, 2, 0, 2, 3]), (1.0, [0, 2, 1, 0, 3, 2])] {
            let first = floats.len() as u16 / 6;
            for (u, v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let (mut corner, mut normal) = ([0.0; 3], [0.0; 3]);
                (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (side, u, v);
                // Inwards.
                normal[axis] = -side;
                floats.extend(corner.into_iter().chain(normal));
            }
            indices.extend(order.map(|i| first + i));
        }
    }
    let split = 4 * floats.len();
    let mut bytes: Vec<u8> = floats.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
    let material = |emitted: f32| {
        let surface = json!({"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0});
        // Matte, so that what it reflects is known.
        let extensions = json!({"KHR_materials_specular": {"specularFactor": 0}});
        json!({"pbrMetallicRoughness": surface, "emissiveFactor": [emitted, emitted, emitted], "extensions": extensions})
    };
    let mesh = |material: usize| {
        let attributes = json!({"POSITION": 0, "NORMAL": 1});
        json!({"primitives": [{"attributes": attributes, "indices": 2, "material": material}]})
    };
    let json = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_specular"],
        "buffers": [{"byteLength": bytes.len()}],
        "bufferViews": [
            {"buffer": 0, "byteLength": split, "byteStride": 24},
            {"buffer": 0, "byteOffset": split, "byteLength": bytes.len() - split},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 24, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1]},
            {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 24, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
        ],
        "materials": [material(0.25), material(0.0)],
        "meshes": [mesh(0), mesh(1)],
        "nodes": [{"name": "furnace", "mesh": 0}, {"name": "dark", "mesh": 1, "translation": [10, 0, 0]}],
        "scenes": [{"nodes": [0, 1]}],
        "scene": 0,
    });
    let padded = |mut bytes: Vec<u8>, with: u8| {
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let chunks = [(padded(json.to_string().into_bytes(), b' '), b"JSON"), (padded(bytes, 0), b"BIN\0")];
    let length: usize = 12 + chunks.iter().map(|(bytes, _)| 8 + bytes.len()).sum::<usize>();
    let mut glb = [b"glTF".as_slice(), &2u32.to_le_bytes(), &(length as u32).to_le_bytes()].concat();
    for (bytes, kind) in chunks {
        glb.extend([&(bytes.len() as u32).to_le_bytes(), kind.as_slice(), &bytes].concat());
    }
    glb
}

/// Writes the level into a folder, and bakes it there by the program of this repository.
fn bake(folder: &Path) {
    std::fs::write(folder.join("level.glb"), level()).unwrap();
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
    for command in [
        "bake level.glb -o level.baked.glb --preset bevy --size 128 --spp 1024",
        "cubemap level.glb --at 0,0,0 -o cube.ktx2 --size 16 --spp 64 --diffuse=8",
        "probes level.glb --grid 2x3x4 --min=-1,-1,-1 --max 1,1,1 -o volume.ktx2",
    ] {
        let done = Command::new(env!("CARGO"))
            .args(["run", "--quiet", "--release", "-p", "halfdome", "--manifest-path", manifest, "--"])
            .args(command.split(' '))
            .args(["--progress", "none"])
            .current_dir(folder)
            .status()
            .unwrap();
        assert!(done.success(), "{command}");
    }
}

/// An app without a window, for the files of a folder.
fn app(folder: &Path) -> App {
    let mut app = App::new();
    let assets = AssetPlugin { file_path: folder.to_str().unwrap().to_owned(), ..default() };
    let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    let render = RenderPlugin { synchronous_pipeline_compilation: true, ..default() };
    app.add_plugins((
        DefaultPlugins.set(assets).set(window).set(render).disable::<PipelinedRenderingPlugin>(),
        BakedLightmapPlugin { exposure: EXPOSURE, bicubic: true },
    ));
    app.insert_resource(ClearColor(Color::BLACK));
    app.insert_resource(GlobalAmbientLight { affects_lightmapped_meshes: false, ..default() });
    app.finish();
    app.cleanup();
    app
}

/// The pixels of a camera.
#[derive(Component, Default)]
struct Shot(Vec<f32>);

/// Puts a camera into the middle of a room, which looks into a corner and passes on radiance as it is.
fn place_camera(app: &mut App, x: f32) -> Entity {
    let size = Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 };
    let usage = RenderAssetUsages::RENDER_WORLD;
    let mut image = Image::new_uninit(size, TextureDimension::D2, TextureFormat::Rgba16Float, usage);
    image.texture_descriptor.usage |= TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    let image = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    // 2^ev100 times 1.2 is 1.
    let exposure = Exposure { ev100: -1.2f32.log2() };
    let pose = Transform::from_xyz(x, 0.0, 0.0).looking_to(Vec3::new(1.0, -0.6, 0.8), Vec3::Y);
    app.world_mut().spawn((
        Camera3d::default(),
        RenderTarget::from(image.clone()),
        Hdr,
        Tonemapping::None,
        Msaa::Off,
        exposure,
        pose,
    ));
    let keep = |event: On<ReadbackComplete>, mut shots: Query<&mut Shot>| {
        let pixels = event.data.chunks_exact(2).map(|bytes| half(bytes[0], bytes[1])).collect();
        shots.get_mut(event.entity).unwrap().0 = pixels;
    };
    app.world_mut().spawn((Readback::texture(image), Shot::default())).observe(keep).id()
}

/// A half float that is positive, and normal or zero.
fn half(low: u8, high: u8) -> f32 {
    let bits = u32::from(u16::from_le_bytes([low, high]));
    if bits == 0 { 0.0 } else { f32::from_bits((bits << 13) + (112 << 23)) }
}

/// For each surface whose lightmap is there: the name of its node, and all texels that are lit.
fn lightmaps(app: &mut App) -> Vec<(String, Vec<f32>)> {
    let world = app.world_mut();
    let mut surfaces = world.query::<(&Lightmap, &Mesh3d, &ChildOf)>();
    let world = &*world;
    let (images, meshes) = (world.resource::<Assets<Image>>(), world.resource::<Assets<Mesh>>());
    let found = surfaces.iter(world).filter_map(|(lightmap, mesh, parent)| {
        assert!(lightmap.bicubic_sampling);
        assert!(meshes.get(&mesh.0)?.contains_attribute(Mesh::ATTRIBUTE_UV_1));
        let image = images.get(&lightmap.image)?;
        assert_eq!(image.texture_descriptor.format, TextureFormat::Rgba16Float);
        let bytes = image.data.as_ref()?;
        let name = world.get::<Name>(parent.parent())?.to_string();
        let red = bytes.chunks_exact(8).map(|texel| half(texel[0], texel[1]));
        Some((name, red.filter(|value| *value > 0.0).collect()))
    });
    let mut found: Vec<_> = found.collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    found
}

/// Whether a texture is there; then it must be of this kind, and all of its texels be light of the radiance 1/2.
fn has_light(app: &App, image: &Handle<Image>, dimension: TextureViewDimension, extent: [u32; 3], levels: u32) -> bool {
    let Some(image) = app.world().resource::<Assets<Image>>().get(image) else { return false };
    let Image { texture_descriptor: texture, texture_view_descriptor: view, data: Some(bytes), .. } = image else {
        return false;
    };
    assert_eq!(view.as_ref().and_then(|view| view.dimension), Some(dimension));
    let Extent3d { width, height, depth_or_array_layers } = texture.size;
    assert_eq!([width, height, depth_or_array_layers], extent);
    assert_eq!((texture.format, texture.mip_level_count), (TextureFormat::Rgba16Float, levels));
    let red: Vec<f32> = bytes.chunks_exact(8).map(|texel| half(texel[0], texel[1])).collect();
    let mean = red.iter().sum::<f32>() / red.len() as f32;
    assert!((mean / 0.5 - 1.0).abs() < 0.02 && red.iter().all(|value| (value / 0.5 - 1.0).abs() < 0.3), "{mean}");
    true
}

#[test]
fn a_furnace_has_its_light() {
    let folder = tempfile::tempdir().unwrap();
    bake(folder.path());
    let mut app = app(folder.path());
    let [lit, dark] = [0.0, 10.0].map(|x| place_camera(&mut app, x));
    let scene = app.world().resource::<AssetServer>().load(GltfAssetLabel::Scene(0).from_asset("level.baked.glb"));
    app.world_mut().spawn(WorldAssetRoot(scene));
    let load = |file: &'static str| app.world().resource::<AssetServer>().load(file);
    let [radiance, diffuse, volume] = ["cube.ktx2", "cube-diffuse.ktx2", "volume.ktx2"].map(load);

    let started = Instant::now();
    // Emitted, and reflected with the plugin's exposure.
    let expected = 0.25 + 0.5 * 0.5 * EXPOSURE;
    let pixels = |app: &App, shot: Entity| app.world().get::<Shot>(shot).unwrap().0.clone();
    let is_lit = |app: &App| pixels(app, lit).first().is_some_and(|value| (value - expected).abs() < 0.1);
    while lightmaps(&mut app).len() < 2 || !is_lit(&app) {
        app.update();
        let found = lightmaps(&mut app).len();
        let shown = pixels(&app, lit);
        assert!(started.elapsed() < Duration::from_secs(300), "{found} lightmaps, {:?}", shown.get(..4));
        std::thread::sleep(Duration::from_millis(5));
    }

    let found = lightmaps(&mut app);
    assert_eq!(found.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["dark", "furnace"]);
    // Both are on one page, and half of the rooms is dark.
    let texels = &found[1].1;
    assert!(texels.len() > 2000, "{} texels are lit", texels.len());
    assert!(texels.iter().all(|value| (value / 0.5 - 1.0).abs() < 0.03), "E/π is 1/2");

    let near = |pixels: &[f32], expected: f32| {
        assert_eq!(pixels.len(), 4 * (SIDE * SIDE) as usize);
        let colors = pixels.chunks_exact(4).flat_map(|pixel| &pixel[..3]);
        let worst = colors.map(|value| (value - expected).abs()).fold(0.0, f32::max);
        assert!(worst <= 0.02 * expected, "pixels are {worst} off from {expected}");
    };
    near(&pixels(&app, lit), expected);
    near(&pixels(&app, dark), 0.0);
    use TextureViewDimension::{Cube, D3};
    while !has_light(&app, &radiance, Cube, [16, 16, 6], 3)
        || !has_light(&app, &diffuse, Cube, [8, 8, 6], 1)
        || !has_light(&app, &volume, D3, [2, 6, 12], 1)
    {
        app.update();
        assert!(started.elapsed() < Duration::from_secs(300), "cube maps or the volume do not load");
        std::thread::sleep(Duration::from_millis(5));
    }
    println!("the furnace's pixels have the right value after {:.1} s", started.elapsed().as_secs_f32());
}
