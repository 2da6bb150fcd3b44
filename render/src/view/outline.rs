//! The scene's tree: its contents, with the names of masks and light path expressions.

use glam::Vec3;

use crate::scene::{Material, Mesh, Projection, PunctualLight, Scene, count};

/// A line of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutlineLine {
    /// The depth.
    pub depth: usize,
    /// The text.
    pub text: String,
    /// The name of the object that it is, as [`PickedSurface::object`](super::PickedSurface::object) has it.
    pub object: Option<String>,
}

/// The tree of a scene with this name.
pub fn outline(scene: &Scene, name: &str) -> Vec<OutlineLine> {
    let mut lines = Vec::new();
    let mut line = |depth: usize, text: String| lines.push(OutlineLine { depth, text, object: None });
    line(0, name.to_owned());
    line(1, format!("camera: {}", camera(scene)));
    let has_sky = scene.sky.mean() != Vec3::ZERO;
    line(1, format!("lights besides what emits: {}", scene.lights.len() + usize::from(has_sky)));
    for (number, light) in scene.lights.iter().enumerate() {
        let label = scene.light_labels.get(number).map_or("", |label| &label.name);
        line(2, format!("{} ({})", named(label, "light", number), kind(light)));
    }
    if has_sky {
        line(2, if scene.sky.picture.is_some() { "sky (picture)" } else { "sky" }.to_owned());
    }
    line(1, format!("materials: {}", scene.materials.len()));
    for (number, material) in scene.materials.iter().enumerate() {
        let emits = if material.emission.max_element() > 0.0 { " (emits)" } else { "" };
        line(2, named(&material.name, "material", number) + emits);
    }
    let in_world = || scene.meshes.iter().enumerate().filter(|(_, mesh)| mesh.object.is_none());
    lines.push(heading(format!("objects: {}", in_world().count())));
    lines.extend(in_world().map(|(number, mesh)| of_mesh(2, mesh, number, &scene.materials)));
    if !scene.objects.is_empty() {
        let instances = count(scene.instances.len(), "instance", "instances");
        lines.push(heading(format!("shared objects: {}, {instances}", scene.objects.len())));
    }
    let mut shown = vec![0; scene.objects.len()];
    scene.instances.iter().for_each(|instance| shown[instance.object] += 1);
    let mut meshes = vec![Vec::new(); scene.objects.len()];
    for (number, mesh) in scene.meshes.iter().enumerate() {
        if let Some(object) = mesh.object {
            meshes[object].push((number, mesh));
        }
    }
    for (number, object) in scene.objects.iter().enumerate() {
        let text = format!("{}, {}", named(&object.name, "shared", number), count(shown[number], "time", "times"));
        lines.push(OutlineLine { depth: 2, text, object: None });
        let parts = meshes[number].iter().map(|&(mesh_number, mesh)| OutlineLine {
            // All parts of an object have its name, if it has one.
            object: (!object.name.is_empty()).then(|| object.name.clone()),
            ..of_mesh(3, mesh, mesh_number, &scene.materials)
        });
        lines.extend(parts);
    }
    lines
}

fn heading(text: String) -> OutlineLine {
    OutlineLine { depth: 1, text, object: None }
}

fn of_mesh(depth: usize, mesh: &Mesh, number: usize, materials: &[Material]) -> OutlineLine {
    let name = named(&mesh.name, "object", number);
    let triangles = count(mesh.triangles.len(), "triangle", "triangles");
    let text = format!("{name}: {triangles}, {}", named(&materials[mesh.material].name, "material", mesh.material));
    OutlineLine { depth, text, object: Some(name) }
}

fn named(name: &str, what: &str, number: usize) -> String {
    if name.is_empty() { format!("{what} {number}") } else { name.to_owned() }
}

fn camera(scene: &Scene) -> String {
    let name = scene.optics.projection.name();
    match (&scene.optics.projection, scene.camera) {
        (Projection::Perspective, Some(pose)) => format!("{name}, {:.1}°", pose.vfov),
        _ => name.to_owned(),
    }
}

fn kind(light: &PunctualLight) -> &'static str {
    match light {
        PunctualLight::Point { .. } => "point",
        PunctualLight::Spot { .. } => "spot",
        PunctualLight::Profiled { .. } => "IES profile",
        PunctualLight::Directional { .. } => "directional",
    }
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::scene::{Instance, Object, cornell_box};

    #[test]
    fn all_that_is_in_a_scene_has_a_line() {
        let mut scene = cornell_box();
        scene.objects.push(Object { name: "chair".to_owned() });
        scene.meshes.push(Mesh { object: Some(0), ..scene.meshes[0].clone() });
        scene.instances = vec![Instance { object: 0, to_world: Affine3A::IDENTITY }; 3];
        let lines = outline(&scene, "box.toml");
        let text = |line: &OutlineLine| format!("{}{}", "  ".repeat(line.depth), line.text);
        let text = lines.iter().map(text).collect::<Vec<_>>().join("\n");
        for expected in [
            "box.toml\n  camera: perspective, 39.3°",
            "    white\n",
            "    light (emits)\n",
            "  objects: 8\n    floor: 2 triangles, white\n",
            "  shared objects: 1, 3 instances\n    chair, 3 times\n      floor: 2 triangles, white",
        ] {
            assert!(text.contains(expected), "{expected} is not in:\n{text}");
        }
        assert!(lines.iter().any(|line| line.object.as_deref() == Some("tall block")));
        assert_eq!(lines.last().unwrap().object.as_deref(), Some("chair"));
    }
}
