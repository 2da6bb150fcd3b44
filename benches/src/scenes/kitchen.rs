//! The kitchen, an interior of 57,000 triangles: `assets/kitchen.obj.zst` in the source of the crate obvhs, which
//! Cargo has on disk as the benchmarks depend on it.

use std::error::Error;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use halfdome::scene;
use halfdome_kernel::Triangle;
use ruzstd::decoding::StreamingDecoder;

/// Loads the kitchen.
///
/// # Errors
/// If Cargo cannot be asked, the crate's source has no such file, or the file cannot be read.
pub(super) fn triangles() -> Result<Vec<Triangle>, Box<dyn Error>> {
    let assets = obvhs_source()?.join("assets");
    let archive = assets.join("kitchen.obj.zst");
    let missing = |error: io::Error| format!("{}: {error}", archive.display());
    let directory = tempfile::tempdir()?;
    let model = directory.path().join("kitchen.obj");
    let mut decoder = StreamingDecoder::new(File::open(&archive).map_err(missing)?)?;
    io::copy(&mut decoder, &mut File::create(&model)?)?;
    // Only the triangles matter: without its materials the model loads just as well.
    let _ = fs::copy(assets.join("kitchen.mtl"), directory.path().join("kitchen.mtl"));
    Ok(super::triangles(&scene::load(&model)?))
}

/// Where Cargo keeps the source of obvhs.
fn obvhs_source() -> Result<PathBuf, Box<dyn Error>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let output =
        Command::new(cargo).args(["metadata", "--format-version=1", "--manifest-path"]).arg(manifest).output()?;
    if !output.status.success() {
        return Err(format!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr).trim()).into());
    }
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    let packages = metadata["packages"].as_array().ok_or("cargo metadata lists no packages")?;
    let obvhs = packages.iter().find(|package| package["name"] == "obvhs").ok_or("obvhs is not a dependency")?;
    let manifest = obvhs["manifest_path"].as_str().ok_or("cargo metadata does not say where obvhs is")?;
    Ok(Path::new(manifest).with_file_name(""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kitchen_is_an_interior_of_known_size() {
        let triangles = triangles().unwrap();
        assert_eq!(triangles.len(), 56_939);
    }
}
