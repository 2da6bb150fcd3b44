//! `halfdome info`: what is in a scene.

use std::f64::consts::PI;
use std::fmt::Write as _;

use glam::{DVec3, Vec3};
use halfdome_kernel::Isa;
use halfdome_kernel::bvh::WIDTH;
use serde::Serialize;

use super::args::InfoArguments;
use super::error::{CliError, EXIT_DONE};
use super::prepare::prepare;
use super::print::print;
use super::{memory, tree};
use crate::scene::{LightUnits, Overrides, PunctualLight, Scene};
use crate::world::World;

/// All that is told of a scene; lengths in the model's units.
#[derive(Serialize)]
struct Info {
    scene: String,
    meshes: usize,
    triangles: usize,
    materials: usize,
    lights: Lights,
    camera: Camera,
    bounds: Option<Bounds>,
    tree: Tree,
    /// What rays are traced with.
    instruction_set: &'static str,
    warnings: Vec<String>,
}

#[derive(Debug, Default, PartialEq, Serialize)]
struct Lights {
    emissive_triangles: usize,
    /// Counted once, even if both sides emit.
    emissive_area: f64,
    /// Watts in red, green and blue if a unit is a metre.
    emissive_power: [f64; 3],
    point: usize,
    spot: usize,
    directional: usize,
    /// What the file's numbers of these were taken for.
    units: Option<&'static str>,
    /// Radiant intensities of points and spots together, W/sr.
    intensity: [f32; 3],
    /// Irradiance of directional lights together, W/m².
    irradiance: [f32; 3],
    sky_radiance: [f32; 3],
}

#[derive(Serialize)]
struct Camera {
    eye: Vec3,
    target: Vec3,
    up: Vec3,
    vfov: f32,
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
pub(super) fn run(arguments: &InfoArguments) -> Result<u8, CliError> {
    if tree::is_tree(&arguments.scene) {
        return tree::describe(&arguments.scene, arguments.json);
    }
    let (scene, _) = prepare(&arguments.scene, Overrides::default())?;
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
        let pose = scene.camera.expect("overrides give every scene a camera");
        let facts = Self {
            scene: name,
            meshes: scene.meshes.len(),
            triangles: scene.triangle_count(),
            materials: scene.materials.len(),
            lights: Lights::of(&scene),
            camera: Camera { eye: pose.eye, target: pose.target, up: pose.up, vfov: pose.vfov },
            bounds: scene.bounds().map(|(lower, upper)| Bounds { lower, upper }),
            instruction_set: Isa::detect().level().name(),
            warnings: std::mem::take(&mut scene.warnings),
            tree: Tree::of(&World::new(scene).map_err(CliError::input)?),
        };
        Ok(facts)
    }

    fn table(&self) -> String {
        let Self { lights, camera, tree, .. } = self;
        let mut table = String::new();
        let mut row = |name: &str, value: String| {
            // Writing to a string cannot fail.
            let _ = writeln!(table, "{name:<20}{value}");
        };
        row("scene", self.scene.clone());
        row("meshes", self.meshes.to_string());
        row("triangles", format!("{} ({} degenerate, dropped)", self.triangles, tree.degenerate_triangles));
        row("materials", self.materials.to_string());
        row("emissive triangles", format!("{}, area {:.6}", lights.emissive_triangles, lights.emissive_area));
        row("emitted power", format!("{} W (red, green, blue)", spaced(lights.emissive_power)));
        row(
            "other lights",
            format!("{} point, {} spot, {} directional", lights.point, lights.spot, lights.directional),
        );
        if let Some(units) = lights.units {
            row("light units", format!("{units} in the file"));
            row("point, spot lights", format!("{} W/sr together", spaced(lights.intensity.map(f64::from))));
            row("directional lights", format!("{} W/m² together", spaced(lights.irradiance.map(f64::from))));
        }
        row("sky radiance", format!("{} W/(m² sr)", spaced(lights.sky_radiance.map(f64::from))));
        row("camera eye", coordinates(camera.eye));
        row("camera target", coordinates(camera.target));
        row("camera up", coordinates(camera.up));
        row("camera vfov", format!("{}°", camera.vfov));
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

impl Tree {
    fn of(world: &World) -> Self {
        let (tree, report) = (world.tree_statistics(), world.build_report());
        Self {
            degenerate_triangles: report.degenerate,
            not_finite_triangles: report.not_finite,
            out_of_range_triangles: report.out_of_range,
            bytes: tree.bytes,
            sah_cost: tree.cost,
            depth: tree.depth,
            nodes: tree.nodes,
            leaf_blocks: tree.blocks,
            block_fill: tree.triangles as f32 / (WIDTH * tree.blocks).max(1) as f32,
        }
    }
}

impl Lights {
    fn of(scene: &Scene) -> Self {
        let mut lights = Self { sky_radiance: scene.sky.mean().to_array(), ..Self::default() };
        let mut power = DVec3::ZERO;
        for mesh in &scene.meshes {
            let material = scene.materials[mesh.material].without_maps(&scene.textures);
            if material.emission == Vec3::ZERO {
                continue;
            }
            lights.emissive_triangles += mesh.triangles.len();
            let area: f64 = mesh
                .triangles
                .iter()
                .map(|triangle| {
                    let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
                    0.5 * (b - a).cross(c - a).length()
                })
                .sum();
            lights.emissive_area += area;
            // A Lambertian side of area A and radiance L emits pi A L.
            let sides = if material.emits_both_sides { 2.0 } else { 1.0 };
            power += PI * sides * area * material.emission.as_dvec3();
        }
        lights.emissive_power = power.to_array();
        lights.units = scene.light_units.map(LightUnits::name);
        let (mut intensities, mut irradiances) = (Vec3::ZERO, Vec3::ZERO);
        for light in &scene.lights {
            match light {
                PunctualLight::Point { intensity, .. } => {
                    lights.point += 1;
                    intensities += intensity;
                }
                PunctualLight::Spot { intensity, .. } => {
                    lights.spot += 1;
                    intensities += intensity;
                }
                PunctualLight::Directional { irradiance, .. } => {
                    lights.directional += 1;
                    irradiances += irradiance;
                }
            }
        }
        (lights.intensity, lights.irradiance) = (intensities.to_array(), irradiances.to_array());
        lights
    }
}

fn coordinates(v: Vec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

fn spaced(values: [f64; 3]) -> String {
    values.map(|value| format!("{value:.4}")).join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::cornell_box;

    #[test]
    fn the_cornell_light_has_the_power_of_its_area() {
        let lights = Lights::of(&cornell_box());
        assert_eq!(lights.emissive_triangles, 2);
        let area = 0.130 * 0.105;
        assert!((lights.emissive_area - area).abs() < 1e-8);
        for (power, radiance) in lights.emissive_power.into_iter().zip([18.4, 15.6, 8.0]) {
            assert!((power - PI * area * radiance).abs() < 1e-6 * radiance, "{power}");
        }
        let mut both = cornell_box();
        both.materials[3].emits_both_sides = true;
        assert_eq!(Lights::of(&both).emissive_power, lights.emissive_power.map(|power| 2.0 * power));
    }

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
        assert_eq!(json["warnings"], serde_json::json!([]));
    }
}
