//! The options that say what kind of camera there is, and which of them belong to which kind.
//!
//! An option that the camera would not use is refused: whoever gives it expects something else than would happen.

use std::path::PathBuf;

use clap::Args;
use glam::{Vec2, Vec3};

use super::super::value::{self, argument};
use super::super::{CameraKind, FisheyeMapping, Optics, Projection, SensorFit};
use super::Overrides;
use crate::settings::Invalid;

/// Options that are set here; the others are `None` and leave the model's camera, or a new one's defaults.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Camera")]
pub struct CameraOverrides {
    /// Kind of camera: perspective, orthographic, panorama, fisheye, cube or rays [default: the model's, or perspective]
    #[arg(id = "camera", long, value_name = "KIND", value_parser = argument(value::camera_kind))]
    pub kind: Option<CameraKind>,
    /// perspective: focal length in mm, in place of --vfov
    #[arg(long, value_name = "MM", value_parser = argument(value::length), allow_negative_numbers = true)]
    pub focal_length: Option<f32>,
    /// perspective: width and height of the sensor in mm, for focal length and f-number [default: 36,24]
    #[arg(long, value_name = "W,H", value_parser = argument(value::sensor), allow_hyphen_values = true)]
    pub sensor: Option<Vec2>,
    /// Side of the picture that the sensor fits: auto (its width is the longer side), horizontal (its width is the width)
    /// or vertical (its height is the height) [default: auto]
    #[arg(long, value_name = "SIDE", value_parser = argument(value::sensor_fit))]
    pub sensor_fit: Option<SensorFit>,
    /// perspective, orthographic: shift of the lens to the right and up, in parts of the side that the sensor fits, as
    /// Blender's Shift X and Y [default: 0,0]
    #[arg(long, value_name = "X,Y", value_parser = argument(value::shift), allow_hyphen_values = true)]
    pub shift: Option<Vec2>,
    /// perspective, orthographic: diameter of the lens's aperture in mm; 0 is a pinhole [default: 0]
    #[arg(long, value_name = "MM", value_parser = argument(value::aperture), allow_negative_numbers = true)]
    pub aperture: Option<f32>,
    /// perspective: the aperture as the focal length over its diameter
    #[arg(long, value_name = "N", value_parser = argument(value::length), allow_negative_numbers = true)]
    pub f_number: Option<f32>,
    /// Distance along the view at which a lens is sharp, in the model's units [default: the target's, if one is given]
    #[arg(long, value_name = "DISTANCE", value_parser = argument(value::length), allow_negative_numbers = true)]
    pub focus: Option<f32>,
    /// A point at whose distance along the view a lens is sharp, in place of --focus
    #[arg(long, value_name = "X,Y,Z", value_parser = argument(value::point), allow_hyphen_values = true)]
    pub focus_at: Option<Vec3>,
    /// Blades of the aperture, which make it a polygon, from 3 on; 0 is a disc [default: 0]
    #[arg(long, value_name = "N", value_parser = argument(value::blades), allow_negative_numbers = true)]
    pub blades: Option<u32>,
    /// Turn of the blades in degrees, from right to up; at 0 a corner is on the right [default: 0]
    #[arg(long, value_name = "DEGREES", value_parser = argument(value::degrees), allow_negative_numbers = true)]
    pub blade_rotation: Option<f32>,
    /// Height of the aperture over its width: 2 for anamorphic lenses with a squeeze of 2 [default: 1]
    #[arg(long, value_name = "RATIO", value_parser = argument(value::anamorphic), allow_negative_numbers = true)]
    pub anamorphic: Option<f32>,
    /// Millimetres in one of the model's units, for aperture and eye distance [default: 1000, for metres]
    #[arg(long, value_name = "MM", value_parser = argument(value::length), allow_negative_numbers = true)]
    pub mm_per_unit: Option<f32>,
    /// orthographic: height of what is seen, in the model's units [default: the model's, or what a perspective camera sees
    /// at the target, if one is given]
    #[arg(long, value_name = "LENGTH", value_parser = argument(value::length), allow_negative_numbers = true)]
    pub ortho_height: Option<f32>,
    /// orthographic: its width, in place of the height
    #[arg(long, value_name = "LENGTH", value_parser = argument(value::length), allow_negative_numbers = true)]
    pub ortho_width: Option<f32>,
    /// panorama: distance of two eyes in mm, 64 for most people; the upper half of the picture is the left eye's [default:
    /// one eye]
    #[arg(long, value_name = "MM", value_parser = argument(value::aperture), allow_negative_numbers = true)]
    pub ipd: Option<f32>,
    /// fisheye: how distance from the middle grows with the angle: equidistant or equisolid [default: equidistant]
    #[arg(long, value_name = "MAPPING", value_parser = argument(value::fisheye))]
    pub fisheye: Option<FisheyeMapping>,
    /// fisheye: angle that the disc sees, in degrees, up to 360 [default: 180]
    #[arg(long, value_name = "DEGREES", value_parser = argument(value::fisheye_fov), allow_negative_numbers = true)]
    pub fov: Option<f32>,
    /// Nothing nearer is seen: along the view of perspective and orthographic cameras, from the eye of others [default: 0]
    #[arg(long, value_name = "DISTANCE", value_parser = argument(value::near), allow_negative_numbers = true)]
    pub near: Option<f32>,
    /// Nothing farther is seen [default: no limit]
    #[arg(long, value_name = "DISTANCE", value_parser = argument(value::length), allow_negative_numbers = true)]
    pub far: Option<f32>,
    /// Clip at the planes of the model's camera, where --near and --far do not say otherwise (glTF's znear and zfar)
    #[arg(long, num_args = 0..=1, require_equals = true)]
    #[arg(value_name = "BOOL", default_missing_value = "true", value_parser = argument(value::flag))]
    pub model_clip: Option<bool>,
    /// rays: the ray of each pixel, a line `ox oy oz dx dy dz` for each, or an EXR with channels of these names
    #[arg(id = "camera-rays", long, value_name = "FILE")]
    pub rays: Option<PathBuf>,
}

/// What can be done with each option but the kind.
macro_rules! each_option {
    ($($option:ident),+) => {
        impl CameraOverrides {
            /// The names of these options, and whether they are set.
            fn given(&self) -> impl Iterator<Item = (&'static str, bool)> {
                [$((stringify!($option), self.$option.is_some())),+].into_iter()
            }

            /// Without the options that are not among `used`.
            fn only(mut self, used: &[&str]) -> Self {
                $(if !used.contains(&stringify!($option)) {
                    self.$option = None;
                })+
                self
            }

            fn or_each(self, fallback: Self) -> Self {
                Self { kind: self.kind.or(fallback.kind), $($option: self.$option.or(fallback.$option)),+ }
            }
        }
    };
}

each_option!(
    focal_length,
    sensor,
    sensor_fit,
    shift,
    aperture,
    f_number,
    focus,
    focus_at,
    blades,
    blade_rotation,
    anamorphic,
    mm_per_unit,
    ortho_height,
    ortho_width,
    ipd,
    fisheye,
    fov,
    near,
    far,
    model_clip,
    rays
);

impl CameraKind {
    /// The kind of a camera that is there.
    pub(super) fn of(optics: &Optics) -> Self {
        match optics.projection {
            Projection::Perspective => Self::Perspective,
            Projection::Orthographic { .. } => Self::Orthographic,
            Projection::Panorama { .. } => Self::Panorama,
            Projection::Fisheye { .. } => Self::Fisheye,
            Projection::Cube => Self::Cube,
            Projection::Rays(_) => Self::Rays,
        }
    }

    /// The options that belong to it.
    fn used(self) -> &'static [&'static str] {
        match self {
            Self::Perspective => &[
                "eye",
                "target",
                "up",
                "vfov",
                "focal_length",
                "sensor",
                "sensor_fit",
                "shift",
                "aperture",
                "f_number",
                "focus",
                "focus_at",
                "blades",
                "blade_rotation",
                "anamorphic",
                "mm_per_unit",
                "near",
                "far",
                "model_clip",
            ],
            Self::Orthographic => &[
                "eye",
                "target",
                "up",
                "ortho_height",
                "ortho_width",
                "sensor_fit",
                "shift",
                "aperture",
                "focus",
                "focus_at",
                "blades",
                "blade_rotation",
                "anamorphic",
                "mm_per_unit",
                "near",
                "far",
                "model_clip",
            ],
            Self::Panorama => &["eye", "target", "up", "ipd", "mm_per_unit", "near", "far", "model_clip"],
            Self::Fisheye => &["eye", "target", "up", "fisheye", "fov", "near", "far", "model_clip"],
            Self::Cube => &["eye", "target", "up", "near", "far", "model_clip"],
            Self::Rays => &["rays", "near", "far"],
        }
    }
}

impl CameraOverrides {
    /// These options, and those of `fallback` where these are not set. Of two ways to say the same the fallback's does not
    /// count, nor do its options that another kind of camera has no use for.
    pub(super) fn or(self, mut fallback: Self) -> Self {
        if let Some(kind) = self.kind() {
            fallback = Self { kind: None, ..fallback.only(kind.used()) };
        }
        if self.aperture.is_some() || self.f_number.is_some() {
            (fallback.aperture, fallback.f_number) = (None, None);
        }
        if self.focus.is_some() || self.focus_at.is_some() {
            (fallback.focus, fallback.focus_at) = (None, None);
        }
        if self.ortho_height.is_some() || self.ortho_width.is_some() {
            (fallback.ortho_height, fallback.ortho_width) = (None, None);
        }
        self.or_each(fallback)
    }

    /// The kind, which a file of rays says too.
    fn kind(&self) -> Option<CameraKind> {
        self.kind.or(self.rays.is_some().then_some(CameraKind::Rays))
    }

    /// Whether a field of view from elsewhere does not count besides these.
    pub(super) fn replaces_vfov(&self) -> bool {
        self.focal_length.is_some() || self.kind().is_some_and(|kind| kind != CameraKind::Perspective)
    }

    /// Whether any option is set.
    pub(super) fn sets_any(&self) -> bool {
        *self != Self::default()
    }
}

impl Overrides {
    /// The kind of camera that the options and the model's `optics` make.
    pub(super) fn camera_kind(&self, optics: &Optics) -> CameraKind {
        let of_model = if self.is_new_camera() { CameraKind::Perspective } else { CameraKind::of(optics) };
        self.camera.kind().unwrap_or(of_model)
    }

    /// The width over the height of pictures by a kind of camera that has one of its own.
    pub(super) fn natural_aspect(&self, kind: CameraKind) -> Option<f64> {
        match kind {
            CameraKind::Panorama => Some(if self.camera.ipd.is_some() { 1.0 } else { 2.0 }),
            CameraKind::Fisheye => Some(1.0),
            CameraKind::Cube => Some(6.0),
            CameraKind::Perspective | CameraKind::Orthographic | CameraKind::Rays => None,
        }
    }

    /// Refuses options that belong to another kind of camera, that say the same as others, or that lack others.
    pub(super) fn check_camera(&self, kind: CameraKind) -> Result<(), Invalid> {
        let pose = [
            ("eye", self.eye.is_some()),
            ("target", self.target.is_some()),
            ("up", self.up.is_some()),
            ("vfov", self.vfov.is_some()),
        ];
        let given: Vec<&str> =
            pose.into_iter().chain(self.camera.given()).filter(|&(_, given)| given).map(|(name, _)| name).collect();
        let used = kind.used();
        if let Some(name) = given.iter().find(|name| !used.contains(name)) {
            let users: Vec<&str> =
                CameraKind::ALL.into_iter().filter(|kind| kind.used().contains(name)).map(CameraKind::name).collect();
            return Err(Invalid::new(
                format!("the {} camera does not use `{name}`", kind.name()),
                format!(
                    "leave it out, or choose {} by --camera or type in [camera]; used are {}",
                    users.join(" or "),
                    used.join(", ")
                ),
            ));
        }
        for pair in
            [["vfov", "focal_length"], ["aperture", "f_number"], ["focus", "focus_at"], ["ortho_height", "ortho_width"]]
        {
            if pair.iter().all(|name| given.contains(name)) {
                let [one, other] = pair;
                return Err(Invalid::new(format!("both `{one}` and `{other}` are given"), "leave one of them out"));
            }
        }
        for (name, needed) in [
            ("sensor", &["focal_length", "f_number"][..]),
            ("sensor_fit", &["focal_length", "f_number", "shift"]),
            ("mm_per_unit", &["aperture", "f_number", "ipd"]),
        ] {
            if given.contains(&name) && !needed.iter().any(|other| given.contains(other)) {
                let remedy = format!("give {} too, or leave `{name}` out", needed.join(" or "));
                return Err(Invalid::new(format!("`{name}` changes nothing by itself"), remedy));
            }
        }
        Ok(())
    }
}
