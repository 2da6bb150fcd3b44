//! Transforms that are refused, and where rays go.

use glam::{Mat3, Quat, vec3};

use super::*;

fn error_of(result: Result<Placement, Error>) -> Option<InvalidScene> {
    match result {
        Ok(_) => None,
        Err(Error::InvalidScene(error)) => Some(error),
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn transforms_without_an_inverse_hide_and_are_no_keys() {
    let flat = Affine3A::from_scale(vec3(1.0, 0.0, 1.0));
    let skewed = Affine3A::from_mat3(Mat3::from_cols(Vec3::X, Vec3::Y, vec3(1.0, 1.0, 0.0)));
    let nearly = Affine3A::from_scale(vec3(1.0, 1e-5, 1.0));
    // Flat in a way that rounding hides.
    let turned = Affine3A::from_quat(Quat::from_rotation_x(0.7)) * flat * Affine3A::from_rotation_z(0.3);
    for bad in [flat, skewed, turned, nearly, Affine3A::from_scale(Vec3::ZERO)] {
        if bad == nearly {
            assert_eq!(error_of(Placement::still(&bad)), Some(InvalidScene::Singular { key: 0 }));
        } else {
            assert!(matches!(Placement::still(&bad), Ok(Placement::Flat { .. })), "{bad:?}");
        }
        let keys = [Affine3A::IDENTITY, Affine3A::IDENTITY, bad];
        assert_eq!(error_of(Placement::moving(Keys::Borrowed(&keys))), Some(InvalidScene::Singular { key: 1 }));
    }
    for bad in [f32::NAN, f32::INFINITY] {
        let bad = Affine3A::from_translation(vec3(0.0, bad, 0.0));
        assert_eq!(error_of(Placement::still(&bad)), Some(InvalidScene::NotFinite { key: 0 }));
        let keys = [Affine3A::IDENTITY, bad];
        assert_eq!(error_of(Placement::moving(Keys::Borrowed(&keys))), Some(InvalidScene::NotFinite { key: 1 }));
    }
    assert_eq!(error_of(Placement::moving(Keys::Borrowed(&[]))), Some(InvalidScene::NoKeys));
    // Small, large and mirrored ones have an inverse.
    for scale in [vec3(1e-12, 1e-12, 2e-12), Vec3::splat(1e15), vec3(-1.0, 1.0, 1e-4)] {
        assert_eq!(error_of(Placement::still(&Affine3A::from_scale(scale))), None);
    }
}

#[test]
fn a_turn_that_collapses_between_keys_is_refused() {
    let turn = |angle: f32| Affine3A::from_quat(Quat::from_rotation_z(angle));
    let half = [turn(0.0), turn(core::f32::consts::PI)];
    assert_eq!(error_of(Placement::moving(Keys::Borrowed(&half))), Some(InvalidScene::Singular { key: 0 }));
    let mirrored = [Affine3A::IDENTITY, Affine3A::from_scale(vec3(1.0, -1.0, 1.0))];
    assert_eq!(error_of(Placement::moving(Keys::Borrowed(&mirrored))), Some(InvalidScene::Singular { key: 0 }));
    let quarters = [turn(0.0), turn(1.5), turn(3.0)];
    assert_eq!(error_of(Placement::moving(Keys::Borrowed(&quarters))), None);
}

#[test]
fn rays_go_where_points_come_from() {
    let transform = Affine3A::from_scale_rotation_translation(
        vec3(0.5, 4.0, -1.0),
        Quat::from_rotation_x(0.7),
        vec3(3.0, -1e5, 2.0),
    );
    let placement = Placement::still(&transform).unwrap();
    let local = Ray::new(vec3(0.3, 0.2, -0.7), vec3(1.0, -2.0, 0.5));
    let exact = |p: Vec3| linear(&transform) * p.as_dvec3() + translation(&transform);
    let ray = Ray {
        origin: exact(local.origin).as_vec3(),
        direction: (linear(&transform) * local.direction.as_dvec3()).as_vec3(),
        ..local
    };
    let back = placement.to_local(&ray, 0.0).unwrap();
    // The scene's ray was rounded at coordinates of 1e5.
    assert!((back.origin - local.origin).abs().max_element() < 0.02);
    assert!((back.direction - local.direction).abs().max_element() < 1e-6);
    // Powers of two and whole translations are exact.
    let exact = Affine3A::from_scale_rotation_translation(Vec3::splat(0.25), Quat::IDENTITY, vec3(7.0, 0.0, -2.0));
    let back = Placement::still(&exact).unwrap().to_local(&Ray::new(vec3(8.0, 1.0, 1.0), Vec3::X), 0.0).unwrap();
    assert_eq!(back, Ray::new(vec3(4.0, 4.0, 12.0), vec3(4.0, 0.0, 0.0)));
}
