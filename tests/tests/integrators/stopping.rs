//! What is left out where paths end early or are clamped.

use super::*;

/// Shirley's test: naive paths in a closed room have no noise at all, for there is no geometry in the series.
#[test]
fn each_stopping_rule_leaves_out_what_it_should() {
    let scene = room(0.5, 0.5);
    // The first terms of 1/2 + 1/4 + 1/8 + …
    let series = |terms: i32| Vec3::splat(1.0 - 0.5f32.powi(terms));
    for depth in [1, 2, 3, 7] {
        let by_depth =
            PathOptions { max_depth: depth, lights: LightSampling::Naive, stop: Stop::Depth, ..PathOptions::default() };
        let picture = render(&scene, &settings(Integrator::Path(by_depth), 2));
        all_are(&picture, series(depth as i32), 1e-6, &format!("depth {depth}"));
    }
    // 1/8 of the light would go on from the third surface, 1/16 from the fourth: there the path ends.
    let threshold = |add_back| path(LightSampling::Naive, Stop::Threshold { cutoff: 0.1, add_back });
    all_are(&render(&scene, &settings(threshold(false), 2)), series(4), 1e-6, "threshold");
    all_are(&render(&scene, &settings(threshold(true), 2)), Vec3::ONE, 1e-6, "threshold with the error added back");
    // Without bias, if not without noise.
    for survival in [Survival::Constant(0.8), Survival::THROUGHPUT, Survival::RootThroughput] {
        for after in [0, 3] {
            let roulette = path(LightSampling::Naive, Stop::Roulette { after, survival });
            let estimate = mean(&scene, &settings(roulette, 64), 12);
            let z = estimate.z(&DVec3::ONE.into(), 1e-5);
            assert!(z.max_element() < 4.0 && estimate.error.x < 0.02, "{survival:?} after {after}: {estimate:?}");
        }
    }
}

#[test]
fn what_is_added_back_helps_where_it_is_no_more_than_an_estimate() {
    let scene = cornell_box();
    let estimate =
        |stop| mean(&scene, &Settings { width: 16, height: 16, ..settings(path(LightSampling::Mis, stop), 64) }, 6);
    let truth = estimate(Stop::default()).mean;
    let error = |add_back| (estimate(Stop::Threshold { cutoff: 0.3, add_back }).mean - truth).abs() / truth;
    let (without, with) = (error(false), error(true));
    assert!(without.min_element() > 0.02 && (with / without).max_element() < 0.6, "{without} {with}");
}

/// By a small lamp on a shelf, and under a sky: light is found by bounces and by samples of every kind.
#[test]
fn a_clamp_dims_indirect_light_alone() {
    let mut scene = cornell_box();
    let intensity = Vec3::splat(0.02);
    scene.lights.push(PunctualLight::Point { position: Vec3::new(0.1, 0.1, 0.1), intensity, radius: 0.01 });
    scene.sky.radiance = Vec3::new(0.1, 0.2, 0.3);
    let clamped = |clamp_indirect, max_depth| {
        let integrator = Integrator::Path(PathOptions { clamp_indirect, max_depth, ..PathOptions::default() });
        pixels(&render(&scene, &Settings { width: 24, height: 24, ..settings(integrator, 8) }))
    };
    assert_eq!(clamped(Some(1e-4), 2), clamped(None, 2), "direct light");
    let whole = clamped(None, 8);
    assert_eq!(clamped(Some(1e6), 8), whole, "a clamp that nothing reaches");
    let direct = clamped(None, 2);
    let none = clamped(Some(1e-6), 8);
    let some = clamped(Some(0.5), 8);
    let mut dimmed = 0;
    for i in 0..whole.len() {
        assert!((none[i] - direct[i]).abs().max_element() < 1e-4 * (1.0 + direct[i].max_element()), "pixel {i}");
        assert!(some[i].cmple(whole[i] + 1e-6).all() && some[i].cmpge(direct[i] - 1e-6).all(), "pixel {i}");
        dimmed += u32::from(some[i] != whole[i]);
    }
    assert!(dimmed > 20, "{dimmed}");
}
