//! `halfdome info`: the contents of a scene.

mod camera;
mod lights;

use std::fmt::Write as _;

use std::path::PathBuf;

use glam::Vec3;
use halfdome_kernel::Isa;
use halfdome_kernel::bvh::WIDTH;
use serde::Serialize;

use self::camera::Camera;
use self::lights::Lights;
use super::tree;
use crate::cli::args::InfoArguments;
use crate::cli::error::{CliError, EXIT_DONE, invalid};
use crate::cli::memory;
use crate::cli::messages::Style;
use crate::cli::prepare::prepare;
use crate::cli::print::print;
use crate::scene::{Animation, Overrides, Scene};
use crate::world::World;

/// The description of a scene; lengths in the model's units.
#[derive(Serialize)]
struct Info {
    scene: String,
    meshes: usize,
    /// All triangles, with those of instances.
    triangles: usize,
    #[serde(flatten)]
    shared: Shared,
    materials: usize,
    lights: Lights,
    camera: Camera,
    animations: Vec<Animation>,
    bounds: Option<Bounds>,
    tree: Tree,
    /// The instruction set.
    instruction_set: &'static str,
    warnings: Vec<String>,
}

/// Objects and instances.
#[derive(Clone, Copy, Serialize)]
struct Shared {
    objects: usize,
    instances: usize,
    /// Triangles in memory.
    stored_triangles: usize,
    /// Memory of what is known of each instance, and of their tree.
    #[serde(rename = "instance_bytes")]
    bytes: usize,
}

#[derive(Serialize)]
struct Bounds {
    lower: Vec3,
    upper: Vec3,
}

#[derive(Serialize)]
struct Tree {
    degenerate_triangles: usize,
    not_finite_triangles: usize,
    out_of_range_triangles: usize,
    bytes: usize,
    sah_cost: f32,
    depth: usize,
    nodes: usize,
    leaf_blocks: usize,
    /// The share of the blocks' lanes that hold a triangle.
    block_fill: f32,
}

/// Prints the table or JSON to stdout.
pub(crate) fn run(arguments: &InfoArguments) -> Result<u8, CliError> {
    let overrides = arguments.overriding.overrides();
    if tree::is_tree(&arguments.scene) {
        if overrides != Overrides::default() {
            let problem = format!("{} is a tree, which has no options of a scene", arguments.scene.display());
            return Err(invalid(problem, "leave them out, or name the scene"));
        }
        return tree::describe(&arguments.scene, arguments.json);
    }
    let (scene, _) = prepare::<PathBuf>(&arguments.scene, overrides, &[], Style::for_people())?;
    let info = Info::of(arguments.scene.display().to_string(), scene)?;
    let text = if arguments.json {
        let json = serde_json::to_string_pretty(&info).map_err(CliError::system)?;
        json + "\n"
    } else {
        info.table()
    };
    print(&text)?;
    Ok(EXIT_DONE)
}

impl Info {
    fn of(name: String, mut scene: Scene) -> Result<Self, CliError> {
        let camera = Camera::of(&scene);
        let mut lights = Lights::of(&scene);
        let (meshes, triangles, materials) = (scene.meshes.len(), scene.triangle_count(), scene.materials.len());
        let shared = Shared::of(&scene);
        let bounds = scene.bounds().map(|(lower, upper)| Bounds { lower, upper });
        let (warnings, animations) = (std::mem::take(&mut scene.warnings), std::mem::take(&mut scene.animations));
        let world = World::new(scene).map_err(CliError::input)?;
        lights.share(&world);
        Ok(Self {
            scene: name,
            meshes,
            triangles,
            shared: Shared { bytes: world.instance_bytes(), ..shared },
            materials,
            lights,
            camera,
            animations,
            bounds,
            instruction_set: Isa::detect().level().name(),
            warnings,
            tree: Tree::of(&world),
        })
    }

    fn table(&self) -> String {
        let Self { lights, camera, animations, tree, .. } = self;
        let mut table = String::new();
        let mut row = |name: &str, value: String| {
            // Writing to a string cannot fail.
            let _ = writeln!(table, "{name:<20}{value}");
        };
        row("scene", self.scene.clone());
        row("meshes", self.meshes.to_string());
        row("triangles", format!("{} ({} degenerate, dropped)", self.triangles, tree.degenerate_triangles));
        let Shared { objects, instances, stored_triangles, bytes } = self.shared;
        if instances > 0 {
            let size = memory::size(bytes as u64);
            row(
                "instances",
                format!("{instances} of {objects} objects, {stored_triangles} triangles kept, {size} besides"),
            );
        }
        row("materials", self.materials.to_string());
        lights.rows(&mut row);
        camera.rows(&mut row);
        for Animation { name, begin, end } in animations {
            row("animation", format!("{name}, {begin:.3} to {end:.3} s"));
        }
        match &self.bounds {
            Some(Bounds { lower, upper }) => {
                row("bounds", format!("{}  to  {}", coordinates(*lower), coordinates(*upper)));
            }
            None => row("bounds", "empty".to_owned()),
        }
        row("tree memory", memory::size(tree.bytes as u64));
        row("tree quality", format!("SAH cost {:.2}", tree.sah_cost));
        row("tree shape", format!("depth {}, {} nodes, {} leaf blocks", tree.depth, tree.nodes, tree.leaf_blocks));
        row("instruction set", self.instruction_set.to_owned());
        for warning in &self.warnings {
            row("warning", warning.clone());
        }
        table
    }
}

impl Shared {
    fn of(scene: &Scene) -> Self {
        let (objects, instances) = (scene.objects.len(), scene.instances.len());
        Self { objects, instances, stored_triangles: scene.stored_triangle_count(), bytes: 0 }
    }
}

impl Tree {
    fn of(world: &World) -> Self {
        let (tree, report) = (world.tree_statistics(), world.build_report());
        Self {
            degenerate_triangles: report.degenerate,
            not_finite_triangles: report.not_finite,
            out_of_range_triangles: report.out_of_range,
            bytes: tree.memory_bytes,
            sah_cost: tree.cost,
            depth: tree.depth,
            nodes: tree.nodes,
            leaf_blocks: tree.blocks,
            block_fill: tree.triangles as f32 / (WIDTH * tree.blocks).max(1) as f32,
        }
    }
}

fn coordinates(v: Vec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

/// Numbers with four decimals.
fn spaced(values: [f64; 3]) -> String {
    values.map(|value| format!("{value:.4}")).join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::cornell_box;

    #[test]
    fn the_table_and_the_json_tell_the_same() {
        let info = Info::of("cornell".to_owned(), cornell_box()).unwrap();
        let table = info.table();
        assert!(table.contains("triangles           32 (0 degenerate, dropped)"), "{table}");
        assert!(table.contains("0 0 0  to  0.556 0.5488 0.5592"), "{table}");
        let json = serde_json::to_value(&info).unwrap();
        assert_eq!(json["triangles"], 32);
        assert_eq!(json["meshes"], 8);
        assert_eq!(json["camera"]["up"], serde_json::json!([0.0, 1.0, 0.0]));
        assert_eq!(json["camera"]["type"], "perspective");
        assert_eq!(json["warnings"], serde_json::json!([]));
    }
}
