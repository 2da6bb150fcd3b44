//! Pictures beside each other, all made in the same time: ours, the peers' with as many samples as that allows, and the
//! reference.

use std::error::Error;
use std::fs;
use std::path::Path;

use halfdome::output::{ToneCurve, ToneMapping, encode_png};

use crate::error::Reference;
use crate::renderer::Renderer;
use crate::table::Record;

/// What becomes of the median of the reference.
const MIDDLE_GREY: f64 = 0.18;

/// Renders and writes the PNG, and says with how many samples each picture was made and what its error is. Each has
/// the time that the first renderer takes for `spp` samples.
pub(crate) fn write(
    path: &Path,
    renderers: &mut [Box<dyn Renderer + '_>],
    records: &[Record],
    reference: &Reference,
    width: u32,
    spp: u32,
) -> Result<(), Box<dyn Error>> {
    let time = records[0].seconds();
    let mut pictures = Vec::new();
    for (renderer, record) in renderers.iter_mut().zip(records) {
        let samples = (f64::from(spp) * time / record.seconds()).round().max(1.0) as u32;
        let rendering = renderer.render(samples, 1)?;
        println!(
            "{}: {} in {:.2} s with {samples} samples, error {:.4}",
            path.display(),
            renderer.name(),
            rendering.seconds,
            reference.trimmed_error(&rendering.pixels),
        );
        pictures.push(rendering.pixels);
    }
    pictures.push(reference.pixels());
    let exposure = (MIDDLE_GREY / reference.median().max(1e-6)).log2() as f32;
    let tone = ToneMapping { exposure, curve: ToneCurve::Neutral };
    let codes = beside(&pictures, 3 * width as usize, &tone);
    let height = pictures[0].len() / (3 * width as usize);
    fs::create_dir_all(path.parent().ok_or("the picture has no folder")?)?;
    fs::write(path, encode_png(path, width * pictures.len() as u32, height as u32, &codes)?)?;
    Ok(())
}

/// Codes of a picture whose rows are those of all `pictures`, of `row` values each.
fn beside(pictures: &[Vec<f32>], row: usize, tone: &ToneMapping) -> Vec<u8> {
    let rows = pictures[0].len() / row;
    let values = (0..rows).flat_map(|number| pictures.iter().map(move |picture| &picture[number * row..][..row]));
    values.flat_map(|row| row.as_chunks::<3>().0).flat_map(|&pixel| tone.to_srgb8(pixel)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_each_other() {
        let black_over_white = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let white_over_black = vec![1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
        let tone = ToneMapping { exposure: 0.0, curve: ToneCurve::Linear };
        let codes = beside(&[black_over_white, white_over_black], 3, &tone);
        assert_eq!(codes, [0, 0, 0, 255, 255, 255, 255, 255, 255, 0, 0, 0]);
    }
}
