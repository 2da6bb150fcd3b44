//! Counts as colours: from black over purple, red and yellow to white, with lightness that grows evenly, and a legend
//! below the picture.
//!
//! The legend's right end is the 99th percentile, rounded up to 1, 2 or 5 times a power of ten: a few pixels of extreme
//! cost would leave all others dark. Values above have the last colour.

/// sRGB codes at equal distances.
const COLORS: [[u8; 3]; 8] = [
    [0, 0, 10],
    [38, 11, 84],
    [95, 19, 110],
    [151, 39, 98],
    [203, 65, 68],
    [237, 112, 30],
    [250, 186, 38],
    [252, 253, 191],
];

/// Rows below the picture: a gap, the scale, a gap, the numbers, a gap.
const LEGEND: [usize; 5] = [2, 6, 3, GLYPH_HEIGHT, 2];
const GLYPH_WIDTH: usize = 3;
const GLYPH_HEIGHT: usize = 5;
/// The digits: a row of three bits each, from the top.
const GLYPHS: [[u8; GLYPH_HEIGHT]; 10] = [
    [7, 5, 5, 5, 7],
    [2, 6, 2, 2, 7],
    [7, 1, 7, 4, 7],
    [7, 1, 7, 1, 7],
    [5, 5, 7, 1, 1],
    [7, 4, 7, 1, 7],
    [7, 4, 7, 5, 7],
    [7, 1, 1, 1, 1],
    [7, 5, 7, 5, 7],
    [7, 5, 7, 1, 7],
];
/// What a digit takes, with the gap after it.
const ADVANCE: usize = GLYPH_WIDTH + 1;

/// The height of the picture of `values` with its legend, and its sRGB codes.
pub(super) fn encode(values: &[f32], width: u32) -> (u32, Vec<u8>) {
    let width = width as usize;
    let greatest = scale(values);
    let mut codes: Vec<u8> = values.iter().flat_map(|&value| color(value / greatest as f32)).collect();
    codes.extend(legend(width, greatest));
    ((codes.len() / 3 / width) as u32, codes)
}

/// The sRGB codes of a number from 0 to 1.
pub(crate) fn color(x: f32) -> [u8; 3] {
    let last = COLORS.len() - 1;
    let place = if x > 0.0 { x.min(1.0) * last as f32 } else { 0.0 };
    let below = (place as usize).min(last - 1);
    let part = place - below as f32;
    let mix = |channel: usize| {
        let (a, b) = (f32::from(COLORS[below][channel]), f32::from(COLORS[below + 1][channel]));
        (a + (b - a) * part).round() as u8
    };
    [mix(0), mix(1), mix(2)]
}

/// The hue that tells this number from others, in 0..1: steps of the golden ratio leave numbers close to each other far
/// apart on the circle, however many there are.
pub(crate) fn categorical_hue(number: u32) -> f64 {
    (f64::from(number) * 0.618_033_988_749_895).fract()
}

/// The scale's right end, white: a round number of at least 10, above which hardly any value is.
pub(crate) fn scale(values: &[f32]) -> u64 {
    let mut sorted: Vec<f32> = values.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let percentile = sorted.get(sorted.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0);
    let powers = (1..19).map(|exponent| 10u64.pow(exponent));
    let mut round = powers.flat_map(|power| [power, 2 * power, 5 * power]);
    round.find(|&number| number as f32 >= percentile).unwrap_or(u64::MAX)
}

/// The rows below a picture of this width: colours from 0 to `greatest`, with the numbers at the ends and in the middle
/// as far as there is room.
fn legend(width: usize, greatest: u64) -> Vec<u8> {
    let mut rows = vec![[0u8; 3]; LEGEND.iter().sum::<usize>() * width];
    for row in LEGEND[0]..LEGEND[0] + LEGEND[1] {
        for x in 0..width {
            rows[row * width + x] = color(x as f32 / (width - 1).max(1) as f32);
        }
    }
    let top = LEGEND[..3].iter().sum();
    let numbers = [0, greatest / 2, greatest].map(|number| number.to_string());
    if numbers.iter().map(|number| (number.len() + 1) * ADVANCE).sum::<usize>() <= width {
        for (place, number) in numbers.iter().enumerate() {
            let left = (width + 1 - number.len() * ADVANCE) * place / 2;
            print(&mut rows, width, left, top, number);
        }
    }
    rows.into_flattened()
}

/// Draws digits in white.
fn print(rows: &mut [[u8; 3]], width: usize, left: usize, top: usize, number: &str) {
    for (place, digit) in number.bytes().enumerate() {
        let glyph = GLYPHS[usize::from(digit - b'0')];
        for (y, bits) in glyph.into_iter().enumerate() {
            for x in (0..GLYPH_WIDTH).filter(|x| bits >> (GLYPH_WIDTH - 1 - x) & 1 == 1) {
                rows[(top + y) * width + left + place * ADVANCE + x] = [255; 3];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::film::LUMINANCE;

    #[test]
    fn colours_grow_lighter_from_end_to_end() {
        assert_eq!((color(0.0), color(1.0), color(7.0)), (COLORS[0], COLORS[7], COLORS[7]));
        assert_eq!((color(-1.0), color(f32::NAN)), (COLORS[0], COLORS[0]));
        let luma = |x: f32| DVec3::from_array(color(x).map(f64::from)).dot(LUMINANCE);
        assert!((0..100).all(|i| luma(i as f32 / 100.0) < luma((i + 1) as f32 / 100.0)));
    }

    #[test]
    fn scales_are_round_and_pass_over_outliers() {
        assert_eq!(scale(&[]), 10);
        assert_eq!(scale(&[10.0; 5]), 10);
        assert_eq!(scale(&[11.0; 5]), 20);
        assert_eq!(scale(&[201.0; 5]), 500);
        let mut values = vec![60.0; 200];
        values[7] = 1e6;
        assert_eq!(scale(&values), 100);
    }

    #[test]
    fn the_legend_lies_below_the_picture() {
        let (height, codes) = encode(&vec![100.0; 64 * 4], 64);
        assert_eq!(height, 4 + 18);
        assert_eq!(codes.len(), 64 * 22 * 3);
        let pixel = |x: usize, y: usize| &codes[(y * 64 + x) * 3..][..3];
        assert_eq!(pixel(63, 3), COLORS[7]);
        assert_eq!((pixel(0, 6), pixel(63, 6)), (&COLORS[0][..], &COLORS[7][..]));
        // The last digit of 100, a ring, ends at the right border.
        assert_eq!((pixel(63, 15), pixel(62, 16), pixel(61, 15)), (&[255; 3][..], &[0; 3][..], &[255; 3][..]));
        // No room for numbers.
        let narrow = encode(&[5.0], 1).1;
        assert!(narrow.chunks(3).all(|pixel| pixel != [255; 3]));
    }
}
