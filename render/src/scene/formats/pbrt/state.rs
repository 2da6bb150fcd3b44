//! The graphics state: transform, material, area light and other attributes; transforms.

use std::rc::Rc;

use glam::{DAffine3, DMat4, DVec3};

use super::lights::AreaLight;
use super::parameters::Parameter;
use super::tokens::At;
use crate::scene::SceneError;

/// The state of the following shapes.
#[derive(Clone)]
pub(super) struct State {
    /// pbrt's current transformation matrix: to the world, or before `WorldBegin` from it.
    pub(super) transform: DAffine3,
    pub(super) reverses: bool,
    /// The index of a material; `None` for the default.
    pub(super) material: Option<usize>,
    pub(super) light: Option<Rc<AreaLight>>,
    /// Parameters that `Attribute` gave to all shapes, lights, ...
    pub(super) defaults: Rc<Vec<(String, Parameter)>>,
    /// Whether transforms count: those of a shutter's end alone do not.
    pub(super) is_at_start: bool,
}

impl Default for State {
    fn default() -> Self {
        Self {
            transform: DAffine3::IDENTITY,
            reverses: false,
            material: None,
            light: None,
            defaults: Rc::default(),
            is_at_start: true,
        }
    }
}

/// An open block.
pub(super) struct Saved {
    /// `Attribute`, `Transform` or `Object`; `Import` of a file.
    pub(super) what: &'static str,
    pub(super) at: At,
    pub(super) state: State,
}

impl State {
    /// Multiplies the transform from the right.
    pub(super) fn concat(&mut self, transform: DAffine3, at: &At) -> Result<(), SceneError> {
        self.replace(self.transform * transform, at)
    }

    pub(super) fn replace(&mut self, transform: DAffine3, at: &At) -> Result<(), SceneError> {
        if !self.is_at_start {
            return Ok(());
        }
        let inverse = transform.inverse();
        if !transform.is_finite() || transform.matrix3.determinant() == 0.0 || !inverse.is_finite() {
            let problem = "the transform is singular: it flattens space, or is not finite";
            return Err(at.error(problem, "scale by numbers that are not 0, and use axes that are not parallel"));
        }
        self.transform = transform;
        Ok(())
    }
}

/// A matrix of 16 numbers, column by column.
pub(super) fn matrix(numbers: [f64; 16], at: &At) -> Result<DAffine3, SceneError> {
    let matrix = DMat4::from_cols_array(&numbers);
    let last = matrix.row(3);
    let scale = last.w;
    if last.truncate() != DVec3::ZERO || scale == 0.0 {
        let problem = "the transform is a projection";
        return Err(at.error(problem, "write 0 for the 4th, 8th and 12th number and 1 for the 16th"));
    }
    Ok(DAffine3::from_mat4(matrix * scale.recip()))
}

/// `LookAt`: from the world to a camera at `eye`.
pub(super) fn look_at([eye, look, up]: [DVec3; 3], at: &At) -> Result<DAffine3, SceneError> {
    let forward = (look - eye).normalize_or_zero();
    let right = up.normalize_or_zero().cross(forward).normalize_or_zero();
    if right == DVec3::ZERO {
        let problem = "`LookAt` has no direction: the eye is at the target, or up is along the view";
        return Err(at.error(problem, "write an eye, a target and an up vector that are not on one line"));
    }
    let to_world = DAffine3::from_cols(right, forward.cross(right), forward, eye);
    Ok(to_world.inverse())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn look_at_puts_the_eye_at_the_origin_and_the_target_on_z() {
        let at = At { path: Path::new("a.pbrt").into(), line: 1 };
        let [eye, target, up] = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 2.0, -1.0), DVec3::Y];
        let camera = look_at([eye, target, up], &at).unwrap();
        let near = |found: DVec3, expected: DVec3| assert!((found - expected).length() < 1e-12, "{found}");
        near(camera.transform_point3(eye), DVec3::ZERO);
        near(camera.transform_point3(target), DVec3::new(0.0, 0.0, 5.0));
        near(camera.transform_vector3(up), DVec3::Y);
        assert!(camera.matrix3.determinant() > 0.0);
        assert!(look_at([eye, eye, up], &at).is_err() && look_at([eye, eye + up, up], &at).is_err());
    }

    #[test]
    fn matrices_have_their_translation_last() {
        let at = At { path: Path::new("a.pbrt").into(), line: 1 };
        let mut numbers = DMat4::IDENTITY.to_cols_array();
        numbers[12..15].copy_from_slice(&[5.0, 6.0, 7.0]);
        assert_eq!(matrix(numbers, &at).unwrap().translation, DVec3::new(5.0, 6.0, 7.0));
        numbers[3] = 1.0;
        assert!(matrix(numbers, &at).unwrap_err().problem.contains("projection"));
    }
}
