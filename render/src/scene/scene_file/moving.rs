//! Detects motion while the shutter is open, by reading the scene at each of the shutter's keys.

use std::sync::Arc;

use crate::scene::{Moment, Motion, Scene, SceneError};

/// Finds out what moves between the moments of the shutter's keys, of which the scene is that of the middle one.
pub(super) fn add_motion(
    scene: &mut Scene,
    moments: Vec<Moment>,
    ramp: f32,
    read: impl Fn(Moment) -> Result<Scene, SceneError>,
) -> Result<(), SceneError> {
    let mut motion = Motion { keys: moments.len(), ramp, ..Motion::default() };
    let middle = motion.keys / 2;
    for (key, moment) in moments.into_iter().enumerate().filter(|&(key, _)| key != middle) {
        if let Err(why) = motion.note(scene, key, read(moment)?) {
            scene.warnings.push(format!("motion is not blurred: {why}"));
            return Ok(());
        }
    }
    scene.motion = (!motion.is_still()).then_some(motion);
    Ok(())
}

impl Motion {
    /// Notes how `scene`, that of a key, differs from that of the middle one; or the reason why it cannot.
    fn note(&mut self, middle: &Scene, key: usize, scene: Scene) -> Result<(), String> {
        let Scene { meshes, instances, lights, camera, .. } = scene;
        let counts = [
            ("meshes", middle.meshes.len(), meshes.len()),
            ("instances", middle.instances.len(), instances.len()),
            ("lights", middle.lights.len(), lights.len()),
        ];
        if let Some((what, shown, other)) = counts.iter().find(|(_, shown, other)| shown != other) {
            return Err(format!("it has {shown} {what} in the middle, and {other} at another time"));
        }
        for (number, (mesh, still)) in meshes.into_iter().zip(&middle.meshes).enumerate() {
            if mesh.positions.len() != still.positions.len() || mesh.triangles != still.triangles {
                return Err(format!("mesh {number} ({:?}) has other triangles at another time", still.name));
            }
            if mesh.positions != still.positions {
                if mesh.object.is_some() {
                    return Err(format!("object mesh {number} ({:?}) changes its shape", still.name));
                }
                self.meshes.entry(number).or_insert_with(|| vec![still.positions.clone(); self.keys])[key] =
                    mesh.positions;
            }
        }
        for (number, (instance, still)) in instances.into_iter().zip(&middle.instances).enumerate() {
            if instance.to_world != still.to_world {
                let keys = self.instances.entry(number).or_insert_with(|| vec![still.to_world; self.keys].into());
                Arc::make_mut(keys)[key] = instance.to_world;
            }
        }
        for (number, (light, still)) in lights.into_iter().zip(&middle.lights).enumerate() {
            if light != *still {
                self.lights.entry(number).or_insert_with(|| vec![still.clone(); self.keys])[key] = light;
            }
        }
        if let (Some(pose), Some(still)) = (camera, middle.camera)
            && pose != still
        {
            if self.cameras.is_empty() {
                self.cameras = vec![still; self.keys];
            }
            self.cameras[key] = pose;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec3};
    use halfdome_kernel::geometry::Moment as Place;

    use super::*;
    use crate::scene::{CameraPose, Instance, Mesh, Object, PunctualLight};

    fn at(x: f32) -> Scene {
        let mesh = |x: f32| Mesh {
            positions: vec![Vec3::X * x, Vec3::X * x + Vec3::Y, Vec3::Z],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };
        let to_world = Affine3A::from_translation(Vec3::X * x);
        Scene {
            meshes: vec![mesh(0.0), mesh(x)],
            objects: vec![Object::default()],
            instances: vec![Instance { object: 0, to_world }],
            lights: vec![PunctualLight::Point { position: Vec3::X * x, intensity: Vec3::ONE, radius: 0.1 }],
            camera: Some(camera),
            ..Scene::default()
        }
    }

    #[test]
    fn what_moves_is_noted_and_the_rest_is_not() {
        let mut motion = Motion { keys: 3, ..Motion::default() };
        let middle = at(1.0);
        for (key, x) in [(0, 0.5), (2, 4.0)] {
            motion.note(&middle, key, at(x)).unwrap();
        }
        assert_eq!(motion.meshes.keys().collect::<Vec<_>>(), [&1]);
        assert_eq!(motion.meshes[&1].iter().map(|positions| positions[0].x).collect::<Vec<_>>(), [0.5, 1.0, 4.0]);
        assert_eq!(motion.instances[&0].iter().map(|it| it.translation.x).collect::<Vec<_>>(), [0.5, 1.0, 4.0]);
        assert!(motion.cameras.is_empty() && !motion.is_still());
        let [from, to] = [&motion.lights[&0][1], &motion.lights[&0][2]];
        let light = PunctualLight::Point { position: Vec3::ZERO, intensity: Vec3::splat(7.0), radius: 0.2 };
        let PunctualLight::Point { position, intensity, radius } =
            light.between(Place::new(0.75, 3).unwrap(), from, to)
        else {
            panic!("a point stays one")
        };
        assert_eq!((position, intensity, radius), (Vec3::X * 2.5, Vec3::splat(7.0), 0.2));

        let mut still = Motion { keys: 3, ..Motion::default() };
        still.note(&middle, 0, at(1.0)).unwrap();
        assert!(still.is_still());
        let mut other = at(1.0);
        other.meshes.pop();
        assert_eq!(still.note(&middle, 0, other).unwrap_err(), "it has 2 meshes in the middle, and 1 at another time");
    }
}
