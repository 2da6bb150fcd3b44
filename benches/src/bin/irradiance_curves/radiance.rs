//! Radiance's `rtrace -I`, which `benches/setup-radiance.sh` installs.

use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use glam::Vec3;
use halfdome::irradiance::Sensor;
use halfdome::scene::Scene;

/// Six reflections, and 1024 rays a record.
const SETTINGS: [&str; 4] = ["-ab", "6", "-ad", "1024"];
/// Further settings to measure. Radiance 6.0a uses a record as far as `-aa` times its radius, which is at most a fifth
/// of the scene: with .1 that is 11 mm in the Cornell box, and every other sensor of a row, in every other row, gets a
/// record of its own. With the fourth root of .1 and with .3 it uses its cache as one would expect; and without samples
/// that each stand for much of the lamp, which are most of its error then, it is at its best.
pub(crate) const ACCURACIES: [&[&str]; 4] =
    [&["-aa", ".5623"], &["-aa", ".3"], &["-aa", ".3", "-ds", ".05", "-dt", "0", "-dc", "1"], &["-aa", ".1"]];
/// How far sensors are before their walls, in metres: Radiance must not take the wall for an occluder.
const CLEARANCE: f32 = 1e-5;

/// Where Radiance's programs and its library are.
pub(crate) struct Radiance {
    programs: PathBuf,
    /// Where its functions in `.cal` files are.
    calculations: PathBuf,
}

impl Radiance {
    /// Finds the installed programs.
    ///
    /// # Errors
    /// If they are not there, with what to do.
    pub(crate) fn find() -> Result<Self, String> {
        let missing = || "no Radiance: run benches/setup-radiance.sh".to_owned();
        let lib = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/radiance/lib");
        let pythons = fs::read_dir(&lib).map_err(|_| missing())?.flatten();
        let packages = pythons.map(|python| python.path().join("site-packages/pyradiance"));
        let package = packages.into_iter().find(|package| package.join("bin/rtrace").is_file()).ok_or_else(missing)?;
        Ok(Self { programs: package.join("bin"), calculations: package.join("lib") })
    }

    /// The irradiance at `sensors`, with one of the [`ACCURACIES`].
    ///
    /// # Errors
    /// If a program fails, or does not answer as it should.
    pub(crate) fn irradiance(
        &self,
        scene: &Scene,
        sensors: &[Sensor],
        accuracy: &[&str],
    ) -> Result<Vec<Vec3>, Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let [rad, octree, points, values] =
            ["scene.rad", "scene.oct", "points.txt", "values.txt"].map(|name| folder.path().join(name));
        fs::write(&rad, description(scene))?;
        fs::write(&points, lines(sensors))?;
        self.run(Command::new(self.programs.join("oconv")).arg(&rad).stdout(File::create(&octree)?))?;
        let mut rtrace = Command::new(self.programs.join("rtrace"));
        rtrace.args(["-I+", "-h", "-n", "1"]).args(SETTINGS).args(accuracy).arg(&octree);
        self.run(rtrace.stdin(File::open(&points)?).stdout(File::create(&values)?))?;
        let text = fs::read_to_string(&values)?;
        let values: Vec<Vec3> = text.lines().map(parse).collect::<Result<_, _>>()?;
        if values.len() != sensors.len() {
            return Err(format!("rtrace gives {} values for {} sensors", values.len(), sensors.len()).into());
        }
        Ok(values)
    }

    fn run(&self, command: &mut Command) -> Result<(), String> {
        let status = command.env("RAYPATH", &self.calculations).status();
        match status {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(format!("{command:?}: {status}")),
            Err(error) => Err(format!("{command:?}: {error}")),
        }
    }
}

/// The scene in Radiance's words: each triangle a polygon, materials without gloss, and lamps that reflect nothing.
fn description(scene: &Scene) -> String {
    let mut text = String::new();
    for (number, material) in scene.materials.iter().enumerate() {
        let Vec3 { x, y, z } = material.emission;
        let _ = if material.emission == Vec3::ZERO {
            let Vec3 { x, y, z } = material.inputs.base_color;
            writeln!(text, "void plastic m{number} 0 0 5 {x} {y} {z} 0 0")
        } else {
            writeln!(text, "void light m{number} 0 0 3 {x} {y} {z}")
        };
    }
    for (number, mesh) in scene.meshes.iter().enumerate() {
        for face in 0..mesh.triangles.len() {
            let _ = write!(text, "m{} polygon p{number}_{face} 0 0 9", mesh.material);
            for Vec3 { x, y, z } in mesh.corners(face) {
                let _ = write!(text, " {x} {y} {z}");
            }
            text.push('\n');
        }
    }
    text
}

/// `x y z nx ny nz` for each sensor.
fn lines(sensors: &[Sensor]) -> String {
    let line = |sensor: &Sensor| {
        let [Vec3 { x, y, z }, normal] = [sensor.position + CLEARANCE * sensor.normal, sensor.normal];
        format!("{x} {y} {z} {} {} {}\n", normal.x, normal.y, normal.z)
    };
    sensors.iter().map(line).collect()
}

/// Three numbers.
fn parse(line: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = line.split_whitespace().flat_map(str::parse).collect();
    <[f32; 3]>::try_from(numbers).map(Vec3::from).map_err(|_| format!("rtrace answers {line:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfdome::scene::cornell_box;

    #[test]
    fn the_cornell_box_is_described() {
        let text = description(&cornell_box());
        assert_eq!(text.lines().filter(|line| line.contains(" polygon ")).count(), 32);
        assert!(text.contains("void plastic m1 0 0 5 0.57 0.043 0.044 0 0\n"));
        assert!(text.contains("void light m3 0 0 3 18.4 15.6 8\n"));
        let lamp = text.lines().last().unwrap().strip_prefix("m3 polygon p7_1 0 0 9 ").unwrap();
        let corners: Vec<f32> = lamp.split(' ').map(|number| number.parse().unwrap()).collect();
        assert_eq!(corners.len(), 9);
        for corner in corners.chunks(3) {
            let is = |axis: usize, values: [f32; 2]| values.iter().any(|value| (corner[axis] - value).abs() < 1e-6);
            assert!(is(0, [0.213, 0.343]) && is(1, [0.5487; 2]) && is(2, [0.227, 0.332]), "{lamp}");
        }
    }

    #[test]
    fn answers_are_three_numbers() {
        assert_eq!(parse("1.5e+00\t2\t 0\t"), Ok(Vec3::new(1.5, 2.0, 0.0)));
        assert!(parse("1 2").is_err() && parse("a b c").is_err() && parse("").is_err());
    }
}
