//! References take minutes, and so are kept in files, in `target/renderers/references`.

use std::error::Error;
use std::fs;
use std::path::Path;

/// The two halves of the reference of the model file `model`, of `[width, height, samples]`: from their file, or as
/// `render` makes them. A model that has changed has others.
pub(crate) fn load_or_render(
    name: &str,
    model: &Path,
    shape: [u32; 3],
    render: impl FnOnce() -> Result<[Vec<f32>; 2], String>,
) -> Result<[Vec<f32>; 2], Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/renderers/references");
    load_or_render_in(&folder, name, model, shape, render)
}

fn load_or_render_in(
    folder: &Path,
    name: &str,
    model: &Path,
    [width, height, samples]: [u32; 3],
    render: impl FnOnce() -> Result<[Vec<f32>; 2], String>,
) -> Result<[Vec<f32>; 2], Box<dyn Error>> {
    let hash = fs::read(model)?
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash: u64, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    let file = folder.join(format!("{name}-{width}x{height}-{samples}-{hash:016x}"));
    let length = 3 * width as usize * height as usize;
    if let Ok(bytes) = fs::read(&file) {
        let values: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|&value| f32::from_ne_bytes(value)).collect();
        if values.len() == 2 * length {
            return Ok([values[..length].to_vec(), values[length..].to_vec()]);
        }
    }
    let halves = render()?;
    let bytes: Vec<u8> = halves.iter().flatten().flat_map(|value| value.to_ne_bytes()).collect();
    fs::create_dir_all(folder)?;
    fs::write(&file, bytes)?;
    Ok(halves)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_is_rendered_once_for_each_model() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("model");
        let halves = [vec![1.0, 2.0, 3.0], vec![4.0, 5.0, 6.0]];
        let ask = |samples, may_render| {
            load_or_render_in(folder.path(), "yard", &model, [1, 1, samples], || {
                if may_render { Ok(halves.clone()) } else { Err("rendered again".to_owned()) }
            })
        };
        fs::write(&model, "one").unwrap();
        assert_eq!(ask(8, true).unwrap(), halves);
        assert_eq!(ask(8, false).unwrap(), halves);
        assert!(ask(9, false).is_err());
        fs::write(&model, "two").unwrap();
        assert!(ask(8, false).is_err());
    }
}
