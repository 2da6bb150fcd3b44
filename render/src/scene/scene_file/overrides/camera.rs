//! The options of cameras, and the kinds that they belong to.
//!
//! An option that the camera would not use is refused, as it would have no effect.

use std::path::PathBuf;

use glam::{Vec2, Vec3};

use super::super::value;
use super::Overrides;
use super::options::options;
use crate::scene::{CameraKind, FisheyeMapping, Optics, Projection, SensorFit};
use crate::settings::Invalid;

options! {
    /// Options that are set here; the others are `None` and leave the model's camera, or a new one's defaults.
    #[command(next_help_heading = "Camera")]
    pub struct CameraOverrides;
    options {
        /// Kind of camera: perspective, orthographic, panorama, fisheye, cube or rays [default: the model's, or
        /// perspective]
        #[arg(id = "camera", value_name = "KIND")]
        kind: CameraKind = value::camera_kind, in "camera" "type";
        /// perspective: focal length in mm, in place of --vfov
        #[arg(value_name = "MM", allow_hyphen_values = true)]
        focal_length: f32 = value::length, in "camera";
        /// perspective: width and height of the sensor in mm, for focal length and f-number [default: 36,24]
        #[arg(value_name = "W,H", allow_hyphen_values = true)]
        sensor: Vec2 = value::sensor, in "camera";
        /// Side of the picture that the sensor fits: auto (its width is the longer side), horizontal (its width is the
        /// width) or vertical (its height is the height) [default: auto]
        #[arg(value_name = "SIDE")]
        sensor_fit: SensorFit = value::sensor_fit, in "camera";
        /// perspective, orthographic: shift of the lens to the right and up, in parts of the side that the sensor fits,
        /// as Blender's Shift X and Y [default: 0,0]
        #[arg(value_name = "X,Y", allow_hyphen_values = true)]
        shift: Vec2 = value::shift, in "camera";
        /// perspective, orthographic: diameter of the lens's aperture in mm; 0 is a pinhole [default: 0]
        #[arg(value_name = "MM", allow_hyphen_values = true)]
        aperture: f32 = value::aperture, in "camera";
        /// perspective: the aperture as the focal length over its diameter
        #[arg(value_name = "N", allow_hyphen_values = true)]
        f_number: f32 = value::length, in "camera";
        /// Distance along the view at which a lens is sharp, in the model's units [default: the target's, if one is
        /// given]
        #[arg(value_name = "DISTANCE", allow_hyphen_values = true)]
        focus: f32 = value::length, in "camera";
        /// A point in the plane of focus, in place of --focus
        #[arg(value_name = "X,Y,Z", allow_hyphen_values = true)]
        focus_at: Vec3 = value::point, in "camera";
        /// Blades of the polygonal aperture, at least 3; 0 is a disc [default: 0]
        #[arg(value_name = "N", allow_hyphen_values = true)]
        blades: u32 = value::blades, in "camera";
        /// Turn of the blades in degrees, from right to up; at 0 a corner is on the right [default: 0]
        #[arg(value_name = "DEGREES", allow_hyphen_values = true)]
        blade_rotation: f32 = value::degrees, in "camera";
        /// Height of the aperture over its width: 2 for anamorphic lenses with a squeeze of 2 [default: 1]
        #[arg(value_name = "RATIO", allow_hyphen_values = true)]
        anamorphic: f32 = value::anamorphic, in "camera";
        /// Millimetres in one of the model's units, for aperture and eye distance [default: 1000, for metres]
        #[arg(value_name = "MM", allow_hyphen_values = true)]
        mm_per_unit: f32 = value::length, in "camera";
        /// orthographic: height of the view, in the model's units [default: the model's, or that of a perspective view
        /// at the target, if one is given]
        #[arg(value_name = "LENGTH", allow_hyphen_values = true)]
        ortho_height: f32 = value::length, in "camera";
        /// orthographic: its width, in place of the height
        #[arg(value_name = "LENGTH", allow_hyphen_values = true)]
        ortho_width: f32 = value::length, in "camera";
        /// panorama: distance of two eyes in mm, 64 for most people; the upper half of the picture is the left eye's
        /// [default: one eye]
        #[arg(value_name = "MM", allow_hyphen_values = true)]
        ipd: f32 = value::aperture, in "camera";
        /// fisheye: how distance from the middle grows with the angle: equidistant or equisolid [default: equidistant]
        #[arg(value_name = "MAPPING")]
        fisheye: FisheyeMapping = value::fisheye, in "camera";
        /// fisheye: angle across the disc in degrees, up to 360 [default: 180]
        #[arg(value_name = "DEGREES", allow_hyphen_values = true)]
        fov: f32 = value::fisheye_fov, in "camera";
        /// Clip nearer geometry: along the view of perspective and orthographic cameras, from the eye of others
        /// [default: 0]
        #[arg(value_name = "DISTANCE", allow_hyphen_values = true)]
        near: f32 = value::near, in "camera";
        /// Clip farther geometry [default: no limit]
        #[arg(value_name = "DISTANCE", allow_hyphen_values = true)]
        far: f32 = value::length, in "camera";
        /// Clip at the planes of the model's camera (glTF's znear and zfar), unless --near and --far are given
        #[arg(num_args = 0..=1, require_equals = true)]
        #[arg(value_name = "BOOL", default_missing_value = "true")]
        model_clip: bool = value::flag, in "camera";
    }
    others {
        /// rays: the ray of each pixel, a line `ox oy oz dx dy dz` for each, or an EXR with channels of these names
        #[arg(id = "camera-rays", long, value_name = "FILE")]
        rays: Option<PathBuf>, in "camera";
    }
}

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
    /// These options, and those of `fallback` where these are not set. Of two ways to say the same the fallback's does
    /// not count, nor do its options that another kind of camera has no use for.
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
        let options = self.camera.given().filter(|&(name, _)| name != "kind");
        let given: Vec<&str> =
            pose.into_iter().chain(options).filter(|&(_, given)| given).map(|(name, _)| name).collect();
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
