//! The scene that all renderers get, as `benches/renderers/serve.py` describes it.

use glam::Vec3;
use halfdome::scene::{Material, Mesh, Scene};
use serde_json::{Value, json};

/// The scene as JSON for the peers' scripts, which only support diffuse reflection and lights with a surface. Pictures
/// have `side` by `side` pixels; paths survive `sure_bounces` bounces.
///
/// # Errors
/// If the scene has no camera.
pub(crate) fn description(scene: &Scene, side: u32, sure_bounces: u32) -> Result<Value, String> {
    let camera = scene.camera.as_ref().ok_or("the scene has no camera")?;
    let meshes: Vec<Value> = scene.meshes.iter().map(|mesh| describe(mesh, &scene.materials[mesh.material])).collect();
    Ok(json!({
        "width": side,
        "height": side,
        "eye": camera.eye.to_array(),
        "target": camera.target.to_array(),
        "up": camera.up.to_array(),
        "vfov": camera.vfov,
        "sure_bounces": sure_bounces,
        "meshes": meshes,
    }))
}

fn describe(mesh: &Mesh, material: &Material) -> Value {
    let positions: Vec<[f32; 3]> = mesh.positions.iter().map(Vec3::to_array).collect();
    json!({
        "name": mesh.name,
        "positions": positions,
        "triangles": mesh.triangles,
        "diffuse": material.inputs.base_color.to_array(),
        "emission": material.emission.to_array(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfdome::scene::cornell_box;

    #[test]
    fn the_description_has_every_number_to_the_last_bit() {
        let mut scene = cornell_box();
        let text = description(&scene, 64, 8).unwrap().to_string();
        let read: Value = serde_json::from_str(&text).unwrap();
        assert_eq!((&read["width"], &read["sure_bounces"]), (&json!(64), &json!(8)));
        let back = |value: &Value| value.as_f64().unwrap() as f32;
        assert_eq!(back(&read["vfov"]), scene.camera.unwrap().vfov);
        let meshes = read["meshes"].as_array().unwrap();
        assert_eq!(meshes.len(), scene.meshes.len());
        for (described, mesh) in meshes.iter().zip(&scene.meshes) {
            let corners = described["positions"].as_array().unwrap();
            let corners: Vec<Vec3> = corners.iter().map(|p| Vec3::new(back(&p[0]), back(&p[1]), back(&p[2]))).collect();
            assert_eq!(corners, mesh.positions);
            assert_eq!(described["triangles"], json!(mesh.triangles));
        }
        assert_eq!(meshes[7]["name"], "light");
        assert_eq!(meshes[7]["emission"].as_array().unwrap().iter().map(back).collect::<Vec<_>>(), [18.4, 15.6, 8.0]);
        scene.camera = None;
        assert!(description(&scene, 64, 8).is_err());
    }
}
