//! Arguments are parsed correctly, and help describes them.

use clap::CommandFactory;
use halfdome_kernel::sampling::Pattern;

use clap::Parser;

use super::super::command::{Arguments, Command};
use super::*;
use crate::scene::{
    CachedOverrides, CameraKind, CameraOverrides, Daylight, FisheyeMapping, IntegratorOverrides, LightOverrides,
    LightUnits, MomentOverrides, SensorFit, Sharing, Shutter, SkyOverrides,
};
use crate::settings::{
    AoWeighting, GatherLayout, Gradients, HemisphereSampling, Integrator, LightSampling, Metric, Stop, Survival,
};

fn render(arguments: &[&str]) -> Result<RenderArguments, clap::Error> {
    let all = ["halfdome", "render"].iter().chain(arguments);
    match Arguments::try_parse_from(all)?.command {
        Some(Command::Render(arguments)) => Ok(*arguments),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_definition_is_consistent() {
    Arguments::command().debug_assert();
    let Command::Render(arguments) = Command::cornell() else { panic!("not a render") };
    assert_eq!(arguments.outputs().unwrap(), [Path::new("cornell.exr"), Path::new("cornell.png")]);
}

#[test]
fn every_override_can_be_given() {
    let arguments = "s.glb --eye -1,2,3 --target 0,-0.5,0 --up 0,0,1 --vfov 30 --camera perspective --focal-length 35 --sensor 23.6,15.6 \
                     --sensor-fit vertical --shift -.1,.2 --aperture 8 --f-number 2.8 --focus 1.5 --focus-at -1,2,3 \
                     --blades 7 --blade-rotation -10 --anamorphic 2 --mm-per-unit 10 --ortho-height 3 --ortho-width 4 \
                     --ipd 64 --fisheye equisolid --fov 360 --near 0 --far 100 --model-clip --model-camera Top --camera-rays a.csv --width 10 --height 20 --filter tent \
                     --filter-width 2 --sharpness .5 --integrator direct --spp 7 --max-depth 3 \
                     --sampler random --lights direct --stop depth --cutoff .5 --add-back --roulette-after 0 --clamp-indirect 8 --filter-glossy .7 --guide=false \
                     --survival throughput --bounces 0 --rays 1 --sampling cosine --ao-weighting misses \
                     --ao-distance 3 --cache-error .25 --gradients off --metric bounded --layout hemicube \
                     --record-rays 300 --cache-bounces 4 \
                     --seed 18446744073709551615 --build medium --sky 1,2,3 --emission both --light-units radiometric --light-radius .25 --sun-angle .5 --variant oak --point-radius .01 --instances never --frame -12.5 --fps 30 --animation Walk --animation Camera --shutter -0.25,0.25 --shutter-ramp .1 --shutter-keys 9 \
                     --sky-picture a.hdr --sky-rotation -90 --sky-scale 2 --daylight 30,-90,4 --threads 2 --exposure -1.5";
    let arguments = render(&arguments.split_whitespace().collect::<Vec<_>>()).unwrap();
    let expected = Overrides {
        eye: Some([-1.0, 2.0, 3.0].into()),
        target: Some([0.0, -0.5, 0.0].into()),
        up: Some([0.0, 0.0, 1.0].into()),
        vfov: Some(30.0),
        camera: CameraOverrides {
            kind: Some(CameraKind::Perspective),
            focal_length: Some(35.0),
            sensor: Some([23.6, 15.6].into()),
            sensor_fit: Some(SensorFit::Vertical),
            shift: Some([-0.1, 0.2].into()),
            aperture: Some(8.0),
            f_number: Some(2.8),
            focus: Some(1.5),
            focus_at: Some([-1.0, 2.0, 3.0].into()),
            blades: Some(7),
            blade_rotation: Some(-10.0),
            anamorphic: Some(2.0),
            mm_per_unit: Some(10.0),
            ortho_height: Some(3.0),
            ortho_width: Some(4.0),
            ipd: Some(64.0),
            fisheye: Some(FisheyeMapping::Equisolid),
            fov: Some(360.0),
            near: Some(0.0),
            far: Some(100.0),
            model_clip: Some(true),
            rays: Some("a.csv".into()),
        },
        width: Some(10),
        height: Some(20),
        filter: Some("tent".into()),
        filter_width: Some(2.0),
        sharpness: Some(0.5),
        integrator: IntegratorOverrides {
            integrator: Integrator::named("direct"),
            max_depth: Some(3),
            lights: Some(LightSampling::Direct),
            stop: Stop::named("depth"),
            cutoff: Some(0.5),
            add_back: Some(true),
            roulette_after: Some(0),
            survival: Some(Survival::THROUGHPUT),
            clamp_indirect: Some(8.0),
            filter_glossy: Some(0.7),
            guide: Some(0),
            bounces: Some(0),
            rays: Some(1),
            sampling: Some(HemisphereSampling::Cosine),
            ao_weighting: Some(AoWeighting::CacheMisses),
            ao_distance: Some(3.0),
            cached: CachedOverrides {
                cache_error: Some(0.25),
                gradients: Some(Gradients::Off),
                metric: Some(Metric::Bounded),
                layout: Some(GatherLayout::Hemicube),
                record_rays: Some(300),
                cache_bounces: Some(4),
                accuracy: None,
            },
        },
        spp: Some(7),
        sampler: Some(Pattern::Random),
        seed: Some(u64::MAX),
        build: Some(halfdome_kernel::Quality::Medium),
        aov: None,
        aov_through: None,
        cryptomatte: None,
        cryptomatte_levels: None,
        aovs: Vec::new(),
        light_groups: None,
        light: LightOverrides {
            added: Vec::new(),
            sky: Some([1.0, 2.0, 3.0].into()),
            sky_light: SkyOverrides {
                picture: Some("a.hdr".into()),
                rotation: Some(-90.0),
                scale: Some(2.0),
                daylight: Some(Daylight { elevation: 30.0, azimuth: -90.0, turbidity: 4.0 }),
                daylight_model: None,
                daylight_albedo: None,
            },
            emits_both_sides: Some(true),
            light_units: Some(LightUnits::Radiometric),
            light_radius: Some(0.25),
            sun_angle: Some(0.5),
        },
        variant: Some("oak".into()),
        model_camera: Some("Top".into()),
        point_radius: Some(0.01),
        instances: Some(Sharing::Never),
        moment: MomentOverrides {
            frame: Some(-12.5),
            fps: Some(30.0),
            animations: Some(vec!["Walk".into(), "Camera".into()]),
            shutter: Some(Shutter { open: -0.25, close: 0.25, in_seconds: false }),
            shutter_ramp: Some(0.1),
            shutter_keys: Some(9),
        },
    };
    assert_eq!(arguments.overriding.overrides(), expected);
    assert_eq!(arguments.tone.mapping().exposure, -1.5);
}

#[test]
fn a_size_is_two_sides_and_excludes_single_ones() {
    let arguments = render(&["s.glb", "--size", "1280x720"]).unwrap().overriding.overrides();
    assert_eq!((arguments.width, arguments.height), (Some(1280), Some(720)));
    for wrong in ["1280", "0x720", "1280x65537", "x", "axb", "1280x720x3", "-1x5"] {
        assert!(render(&["s.glb", &format!("--size={wrong}")]).is_err(), "{wrong}");
    }
    assert!(render(&["s.glb", "--size", "1x1", "--width", "3"]).is_err());
}

#[test]
fn blocks_are_powers_of_two() {
    let side = |arguments: &[&str]| render(arguments).map(|arguments| arguments.progressive);
    assert_eq!(side(&["s.glb"]).unwrap(), None);
    assert_eq!(side(&["--progressive", "s.glb"]).unwrap(), Some(32));
    assert_eq!(side(&["s.glb", "--progressive=8"]).unwrap(), Some(8));
    for wrong in ["1", "12", "512", "x"] {
        assert!(side(&["s.glb", &format!("--progressive={wrong}")]).is_err(), "{wrong}");
    }
}

#[test]
fn errors_name_the_option_and_what_would_be_right() {
    let text = render(&["s.glb", "--vfov", "200"]).unwrap_err().to_string();
    assert!(text.contains("--vfov <DEGREES>") && text.contains("more than 0 and less than 180"), "{text}");
    for wrong in ["--exposure=nan", "--exposure=65", "--threads=0", "--tone=blue", "--progress=loud", "--spp=0"] {
        assert!(render(&["s.glb", wrong]).is_err(), "{wrong}");
    }
}

#[test]
fn outputs_are_named_after_the_scene_unless_given() {
    let names = |arguments: &[&str]| render(arguments).unwrap().outputs();
    assert_eq!(names(&["a/b.v2.toml"]).unwrap(), [Path::new("b.v2.exr"), Path::new("b.v2.png")]);
    assert_eq!(names(&["s.glb", "-o", "x.png", "-o", "y.exr"]).unwrap(), [Path::new("x.png"), Path::new("y.exr")]);
    assert!(names(&["s.glb", "-o", "x.png", "-o", "x.png"]).is_err());
    assert!(names(&["s.glb", "-o", "x.png", "-o", "./x.png"]).is_err());
    assert!(names(&["s.glb", "-o", "no/x.png", "-o", "./x.png"]).is_ok());
}
