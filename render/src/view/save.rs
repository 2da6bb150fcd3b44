//! Saves a camera into a scene file: its own, or a new one beside a model.
//!
//! The rest of a scene file stays unchanged, comments included. A model is never overwritten. If the file has no camera
//! yet, the optics are written with the pose: `eye` and `target` together make a new camera, which inherits nothing
//! from the model's.

use std::path::{Path, PathBuf};

use glam::Vec2;
use toml_edit::{Array, DocumentMut, Item, Table, Value, value};

use crate::output::OutputFile;
use crate::scene::{CameraOverrides, CameraPose, Clip, MM_PER_UNIT, Optics, Projection, SceneFile};

/// Where cameras are saved, and what is written of them.
#[derive(Clone, Debug)]
pub struct CameraFile {
    /// The scene as it was opened: a scene file or a model; `None` for the built-in one.
    pub scene: Option<PathBuf>,
    /// Keys of `[camera]` that say how its pictures are made, with their values as TOML.
    pub optics: Vec<(&'static str, String)>,
    /// Whether the file's own keys say that already.
    pub has_optics: bool,
}

impl CameraFile {
    /// Writes the camera at a pose; gives the scene file's path.
    ///
    /// # Errors
    /// If there is no place for it, or it cannot be written. All files are as they were then.
    pub fn save(&self, pose: &CameraPose) -> Result<PathBuf, String> {
        let Some(scene) = &self.scene else {
            return Err("the built-in scene has no file".to_owned());
        };
        let is_toml = |path: &Path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        let path = if is_toml(scene) { scene.clone() } else { scene.with_extension("toml") };
        let text = self.text(scene, &path, pose)?;
        // It must be one that can be opened again.
        SceneFile::parse(&path, &text).map_err(|error| error.to_string())?;
        let file = OutputFile::check(&path).map_err(|error| error.to_string())?;
        file.write(text.as_bytes()).map_err(|error| error.to_string())?;
        Ok(path)
    }

    /// The scene file's new text.
    fn text(&self, scene: &Path, path: &Path, pose: &CameraPose) -> Result<String, String> {
        let is_new = !path.exists();
        let mut document = if is_new {
            let mut document = DocumentMut::new();
            let model = scene.file_name().and_then(|name| name.to_str());
            let model = model.ok_or_else(|| format!("the name of {} is not text", scene.display()))?;
            let mut table = Table::new();
            table["file"] = value(model);
            document["scene"] = Item::Table(table);
            document
        } else {
            let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
            let of_this = SceneFile::parse(path, &text).map_err(|error| error.to_string())?;
            if path != scene && of_this.model.as_deref().and_then(Path::file_name) != scene.file_name() {
                let name = path.display();
                return Err(format!("{name} is there, and is not of {}: open or rename it", scene.display()));
            }
            text.parse::<DocumentMut>().map_err(|error| format!("{}: {error}", path.display()))?
        };
        let camera = document.entry("camera").or_insert_with(|| Item::Table(Table::new()));
        let camera = camera.as_table_like_mut().ok_or_else(|| format!("{}: camera is no table", path.display()))?;
        let mut set = |key: &str, new: Value| match camera.get_mut(key).and_then(Item::as_value_mut) {
            Some(old) => {
                // Comments beside it.
                let decor = old.decor().clone();
                *old = new;
                *old.decor_mut() = decor;
            }
            None => {
                camera.insert(key, Item::Value(new));
            }
        };
        set("eye", point(pose.eye.to_array()));
        set("target", point(pose.target.to_array()));
        set("up", point(pose.up.to_array()));
        if is_new || path != scene || !self.has_optics {
            for (key, text) in &self.optics {
                set(key, text.parse::<Value>().map_err(|error| format!("{key} = {text}: {error}"))?);
            }
            // They say otherwise, or nothing of a camera that is not the model's.
            let stale = |key: &str| !self.optics.iter().any(|(name, _)| *name == key);
            for key in
                ["vfov", "focal_length", "focus_at", "ortho_width", "model_clip"].into_iter().filter(|it| stale(it))
            {
                camera.remove(key);
            }
        }
        Ok(document.to_string())
    }
}

/// The keys of `[camera]` that make a camera of this pose and these optics, as `options` made it of whatever the model
/// has.
pub fn optics_keys(pose: &CameraPose, optics: &Optics, options: &CameraOverrides) -> Vec<(&'static str, String)> {
    let mut keys = options.keys();
    let has = |keys: &[(&str, String)], key: &str| keys.iter().any(|(name, _)| *name == key);
    if !has(&keys, "type") && !matches!(optics.projection, Projection::Perspective) {
        keys.push(("type", format!("{:?}", optics.projection.name())));
    }
    match optics.projection {
        Projection::Perspective if !has(&keys, "focal_length") => keys.push(("vfov", number(pose.vfov))),
        Projection::Orthographic { height } => keys.push(("ortho_height", number(height))),
        _ => {}
    }
    if !has(&keys, "shift") && optics.shift != Vec2::ZERO {
        keys.push(("shift", format!("[{:?}, {:?}]", optics.shift.x, optics.shift.y)));
    }
    if let Some(lens) = optics.lens {
        if !has(&keys, "aperture") && !has(&keys, "f_number") {
            keys.push(("aperture", number(2.0 * lens.radius * options.mm_per_unit.unwrap_or(MM_PER_UNIT))));
        }
        keys.push(("focus", number(lens.focus)));
    }
    let Clip { near, far } = optics.clip;
    if near > 0.0 {
        keys.push(("near", number(near)));
    }
    if far.is_finite() {
        keys.push(("far", number(far)));
    }
    keys
}

/// The shortest text that is this number again.
pub(crate) fn number(value: f32) -> String {
    format!("{value:?}")
}

fn point(values: [f32; 3]) -> Value {
    let exact = |value: f32| number(value).parse::<f64>().unwrap_or(f64::from(value));
    Value::Array(values.into_iter().map(exact).collect::<Array>())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use glam::Vec3;

    use super::*;

    const POSE: CameraPose =
        CameraPose { eye: Vec3::new(0.1, -2.0, 3e-7), target: Vec3::ZERO, up: Vec3::Y, vfov: 39.3 };

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("room.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        folder
    }

    fn file(scene: PathBuf, has_optics: bool) -> CameraFile {
        CameraFile { scene: Some(scene), optics: vec![("vfov", "39.3".to_owned())], has_optics }
    }

    #[test]
    fn beside_a_model_there_is_a_new_scene_file() {
        let folder = folder();
        let model = folder.path().join("room.obj");
        let before = fs::read(&model).unwrap();
        let path = file(model.clone(), false).save(&POSE).unwrap();
        assert_eq!(path, folder.path().join("room.toml"));
        let read = SceneFile::read(&path).unwrap();
        assert_eq!((read.model.as_deref(), fs::read(&model).unwrap()), (Some(model.as_path()), before));
        let options = read.overrides;
        assert_eq!((options.eye, options.target, options.up), (Some(POSE.eye), Some(POSE.target), Some(POSE.up)));
        assert_eq!(options.vfov, Some(POSE.vfov));
        // Again, into the same one.
        let moved = CameraPose { eye: Vec3::ONE, ..POSE };
        file(model, false).save(&moved).unwrap();
        assert_eq!(SceneFile::read(&path).unwrap().overrides.eye, Some(Vec3::ONE));
    }

    #[test]
    fn all_else_in_a_scene_file_stays() {
        let folder = folder();
        let path = folder.path().join("a.toml");
        let text = "# Mine.\n[scene]\nfile = \"room.obj\" # the room\n\n[camera]\neye = [1, 2, 3]   # by the door\n\
                    focal_length = 35\n\n[render]\nspp = 7\n";
        fs::write(&path, text).unwrap();
        let new =
            CameraFile { scene: Some(path.clone()), optics: vec![("vfov", "39.3".to_owned())], has_optics: false };
        new.save(&POSE).unwrap();
        let written = fs::read_to_string(&path).unwrap();
        let expected = "# Mine.\n[scene]\nfile = \"room.obj\" # the room\n\n[camera]\neye = [0.1, -2.0, 0.0000003]   # by the door\n\
                        target = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 39.3\n\n[render]\nspp = 7\n";
        assert_eq!(written, expected);
        // What the file has of the lens is left alone where it is right.
        fs::write(&path, text).unwrap();
        file(path.clone(), true).save(&POSE).unwrap();
        let written = fs::read_to_string(&path).unwrap();
        assert!(written.contains("focal_length = 35\n") && !written.contains("vfov"), "{written}");
    }

    #[test]
    fn what_is_not_of_the_scene_is_left_alone() {
        let folder = folder();
        let other = folder.path().join("room.toml");
        fs::write(folder.path().join("hall.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        for text in ["[scene]\nfile = \"hall.obj\"\n", "[tool]\nname = \"other\"\n"] {
            fs::write(&other, text).unwrap();
            file(folder.path().join("room.obj"), false).save(&POSE).unwrap_err();
            assert_eq!(fs::read_to_string(&other).unwrap(), text);
        }
        let nowhere = CameraFile { scene: None, optics: Vec::new(), has_optics: false };
        assert!(nowhere.save(&POSE).unwrap_err().contains("built-in"));
    }
}
