//! A camera's options as keys of `[camera]` in a scene file.

use glam::Vec2;

use super::CameraOverrides;

impl CameraOverrides {
    /// The options that are set, with their values as TOML, but for those that only make sense with a certain pose or
    /// model: what is sharp, how high an orthographic picture is, what is clipped, and a file of rays.
    pub(crate) fn keys(&self) -> Vec<(&'static str, String)> {
        let number = |value: Option<f32>| value.map(|value| format!("{value:?}"));
        let pair = |value: Option<Vec2>| value.map(|value| format!("[{:?}, {:?}]", value.x, value.y));
        let text = |value: Option<&'static str>| value.map(|value| format!("{value:?}"));
        let keys = [
            ("type", text(self.kind.map(|kind| kind.name()))),
            ("focal_length", number(self.focal_length)),
            ("sensor", pair(self.sensor)),
            ("sensor_fit", text(self.sensor_fit.map(|fit| fit.name()))),
            ("shift", pair(self.shift)),
            ("aperture", number(self.aperture)),
            ("f_number", number(self.f_number)),
            ("blades", self.blades.map(|blades| blades.to_string())),
            ("blade_rotation", number(self.blade_rotation)),
            ("anamorphic", number(self.anamorphic)),
            ("mm_per_unit", number(self.mm_per_unit)),
            ("ipd", number(self.ipd)),
            ("fisheye", text(self.fisheye.map(|mapping| mapping.name()))),
            ("fov", number(self.fov)),
        ];
        keys.into_iter().filter_map(|(key, value)| Some((key, value?))).collect()
    }
}
