//! How bright, or how opaque, a texture is within triangles: a table of sums over all rectangles that begin at its corner
//! (Crow 1984, "Summed-area tables for texture mapping").
//!
//! Deviations: a triangle counts as the rectangle around it, rounded up to blocks of texels. Sums are integers, so that a
//! rectangle is black only if all its texels are, and they do not depend on threads.

use glam::{Vec2, Vec4};
use rayon::prelude::*;

use super::{Texture, TextureMap, Wrap};

/// The most blocks across and down.
const MAX_BLOCKS: u32 = 512;
/// The sum of a block that is as bright as the brightest.
const BRIGHTEST: f64 = 4_294_967_296.0;

/// The brightness of a texture.
#[derive(Debug)]
pub(crate) struct BrightnessTable {
    size: [u32; 2],
    /// Texels along a block's edge.
    block: u32,
    /// Blocks across and down.
    blocks: [usize; 2],
    /// The sum of all blocks left of and above the corner of each, row by row, with one corner more than blocks.
    sums: Vec<u64>,
    /// What a unit of the sums stands for.
    unit: f64,
}

impl Texture {
    /// The table of this function of its texels, which must not be negative. Numbers below 0 count as 0.
    pub(crate) fn brightness(&self, map: &TextureMap, of: impl Fn(Vec4) -> f32 + Sync) -> BrightnessTable {
        let size = [self.width, self.height];
        let block = self.width.max(self.height).div_ceil(MAX_BLOCKS);
        let blocks = size.map(|size| size.div_ceil(block) as usize);
        let texels = |at: usize, size: u32| at as u32 * block..((at as u32 + 1) * block).min(size);
        let mean = |number: usize| {
            let (columns, rows) = (texels(number % blocks[0], size[0]), texels(number / blocks[0], size[1]));
            let count = f64::from(columns.end - columns.start) * f64::from(rows.end - rows.start);
            let indices = rows.flat_map(|y| columns.clone().map(move |x| (y * size[0] + x) as usize));
            let texel = |index| self.fetch(map.space, index).max(Vec4::ZERO);
            indices.map(|index| f64::from(of(texel(index)))).sum::<f64>() / count
        };
        let means: Vec<f64> = (0..blocks[0] * blocks[1]).into_par_iter().map(mean).collect();
        let unit = means.iter().copied().fold(f64::MIN_POSITIVE, f64::max) / BRIGHTEST;
        let row = blocks[0] + 1;
        let mut sums = vec![0; row * (blocks[1] + 1)];
        for (number, mean) in means.iter().enumerate() {
            let at = (number / blocks[0] + 1) * row + number % blocks[0] + 1;
            sums[at] = (mean / unit).ceil() as u64 + sums[at - 1] + sums[at - row] - sums[at - row - 1];
        }
        BrightnessTable { size, block, blocks, sums, unit }
    }
}

impl BrightnessTable {
    /// The longest edge of a triangle with these texture coordinates, in texels.
    pub(crate) fn extent(&self, map: &TextureMap, corners: &[Vec2; 3]) -> f32 {
        let [a, b, c] = corners.map(|corner| self.place(map, corner));
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        if longest.is_finite() { longest } else { 0.0 }
    }

    /// The mean about a triangle with these texture coordinates; 0 only if all is black there.
    pub(crate) fn mean(&self, map: &TextureMap, corners: &[Vec2; 3]) -> f32 {
        let (low, high) = self.rectangle(map, corners);
        // Most of the light is from the texels in between.
        let wide = self.widened_mean(map, (low, high));
        if wide == 0.0 { 0.0 } else { 0.5 * (wide + self.mean_of(map, low, high)) }
    }

    /// Whether all is black about a triangle with these texture coordinates.
    pub(crate) fn is_black(&self, map: &TextureMap, corners: &[Vec2; 3]) -> bool {
        self.widened_mean(map, self.rectangle(map, corners)) == 0.0
    }

    /// The rectangle around a triangle, in texels.
    fn rectangle(&self, map: &TextureMap, corners: &[Vec2; 3]) -> (Vec2, Vec2) {
        let [a, b, c] = corners.map(|corner| self.place(map, corner));
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// The mean of a rectangle with all texels that are mixed in it, and some more.
    fn widened_mean(&self, map: &TextureMap, (low, high): (Vec2, Vec2)) -> f32 {
        self.mean_of(map, low - 1.0, high + 1.0)
    }

    /// The mean of the blocks with a rectangle's texels.
    fn mean_of(&self, map: &TextureMap, low: Vec2, high: Vec2) -> f32 {
        let [across, down] = [0, 1].map(|axis| self.spans(map.wrap[axis], axis, (low[axis], high[axis])));
        let (mut sum, mut count) = (0, 0);
        for [left, right] in across.into_iter().flatten() {
            for [top, bottom] in down.into_iter().flatten() {
                let at = |x: usize, y: usize| self.sums[y * (self.blocks[0] + 1) + x];
                sum += at(right, bottom) + at(left, top) - at(left, bottom) - at(right, top);
                count += (right - left) * (bottom - top);
            }
        }
        (self.unit * sum as f64 / count as f64) as f32
    }

    /// Texture coordinates in texels.
    fn place(&self, map: &TextureMap, texcoord: Vec2) -> Vec2 {
        map.place(texcoord) * Vec2::new(self.size[0] as f32, self.size[1] as f32)
    }

    /// Spans of blocks, from the first to before the last, that have all texels between two places along an axis.
    fn spans(&self, wrap: Wrap, axis: usize, (low, high): (f32, f32)) -> [Option<[usize; 2]>; 2] {
        let size = i64::from(self.size[axis]);
        let (first, last) = (low.floor() as i64, high.floor() as i64);
        let all = [Some([0, size - 1]), None];
        // What is not a number becomes 0, and what is too large the greatest number.
        let is_all = !low.is_finite() || !high.is_finite() || last.saturating_sub(first) >= size;
        let texels = match wrap {
            Wrap::Clamp if low.is_finite() && high.is_finite() => {
                [Some([first.clamp(0, size - 1), last.clamp(0, size - 1)]), None]
            }
            _ if is_all => all,
            Wrap::Mirror => {
                let start = first.rem_euclid(2 * size);
                let end = start + (last - first);
                let mirrored = |place: i64| (2 * size - 1 - place).abs().min(size - 1);
                let span = match (start < size, end < size, end < 2 * size) {
                    (true, true, _) => [start, end],
                    (true, false, _) => [start.min(mirrored(end)), size - 1],
                    (false, _, true) => [mirrored(end), mirrored(start)],
                    (false, _, false) => [0, mirrored(start).max(end - 2 * size)],
                };
                [Some(span), None]
            }
            _ => {
                let start = first.rem_euclid(size);
                let end = start + (last - first);
                match end < size {
                    true => [Some([start, end]), None],
                    false => [Some([start, size - 1]), Some([0, end - size])],
                }
            }
        };
        let block = i64::from(self.block);
        texels.map(|span| span.map(|[first, last]| [(first / block) as usize, (last / block) as usize + 1]))
    }
}

#[cfg(test)]
mod tests {
    use super::super::TextureFilter;
    use super::*;

    /// A texture that is black but for a few texels, in blocks of several.
    fn texture(width: u32, height: u32, bright: &[[u32; 2]]) -> Texture {
        let texel =
            |index: u32| if bright.contains(&[index % width, index / width]) { [255; 4] } else { [0, 0, 0, 255] };
        Texture::new(width, height, (0..width * height).map(texel).collect())
    }

    fn map(wrap: Wrap) -> TextureMap {
        TextureMap { wrap: [wrap; 2], ..TextureMap::default() }
    }

    #[test]
    fn means_are_those_of_the_texels() {
        let texture = texture(8, 4, &[[2, 1], [3, 1], [7, 3]]);
        let map = map(Wrap::Clamp);
        let table = texture.brightness(&map, |color| 2.0 * color.x);
        let mean = |from: [f32; 2], to: [f32; 2]| {
            let [from, to] = [from, to].map(|place| Vec2::from(place) / Vec2::new(8.0, 4.0));
            table.mean(&map, &[from, to, from])
        };
        assert!((mean([-9.0, -9.0], [99.0, 99.0]) - 2.0 * 3.0 / 32.0).abs() < 1e-6);
        // One lit texel, and texels 1 to 3 across and 0 to 2 down.
        assert!((mean([2.1, 1.1], [2.2, 1.2]) - (1.0 + 2.0 / 9.0)).abs() < 1e-6);
        // None, and 3 to 5 across and 0 to 2 down.
        assert!((mean([4.1, 1.1], [4.2, 1.2]) - 1.0 / 9.0).abs() < 1e-6);
        assert_eq!(mean([5.5, 0.5], [5.6, 1.4]), 0.0);
    }

    /// Wherever a lookup finds light, the table does.
    #[test]
    fn what_is_black_is_black_everywhere() {
        // The greater one has blocks of three texels.
        for (width, height, bright) in [(9, 5, &[[4, 2]][..]), (7, 6, &[[0, 0], [6, 3]]), (1200, 700, &[[600, 0]])] {
            let texture = texture(width, height, bright);
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                for filter in [TextureFilter::Bilinear, TextureFilter::Nearest] {
                    let map = TextureMap { filter, ..map(wrap) };
                    let table = texture.brightness(&map, |color| color.x);
                    let (mut black, mut found) = (0, 0);
                    for i in 0..30_000u32 {
                        let number = |k: u32| (i.wrapping_mul(2_654_435_769).rotate_left(8 * k) as f32 / 4.3e9).fract();
                        let texel = Vec2::new(width as f32, height as f32).recip();
                        let near = Vec2::new(bright[0][0] as f32, bright[0][1] as f32) * texel;
                        // Beyond the picture, unless that is its border.
                        let shift = Vec2::new((i % 7) as f32 - 3.0, (i % 5) as f32 - 2.0);
                        let shift = if wrap == Wrap::Clamp { Vec2::ZERO } else { shift };
                        let corner = near + shift + (Vec2::new(number(0), number(1)) - 0.5) * 9.0 * texel;
                        let edge = Vec2::new(number(2), number(3)) * 3.0 * texel;
                        let mean = table.mean(&map, &[corner, corner + edge, corner]);
                        let texel = texture.sample(&map, corner + number(1) * edge).x;
                        assert!(mean > 0.0 || texel == 0.0, "{width} {wrap:?} {filter:?} {corner}");
                        assert_eq!(table.is_black(&map, &[corner, corner + edge, corner]), mean == 0.0);
                        black += u32::from(mean == 0.0);
                        found += u32::from(texel > 0.0);
                    }
                    assert!(black > 3000 && found > 50, "{width} {wrap:?} {filter:?}: {black}, {found}");
                }
            }
        }
    }

    #[test]
    fn no_coordinate_is_too_far_out() {
        let texture = texture(4, 4, &[[0, 0]]);
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            let table = texture.brightness(&map(wrap), |color| color.x);
            for u in [f32::MAX, f32::MIN, f32::NAN, f32::INFINITY, 1e9, -1e9] {
                let corners = [Vec2::splat(u), Vec2::ZERO, Vec2::X];
                assert!(table.mean(&map(wrap), &corners) > 0.0, "{wrap:?}, {u}");
                assert!(table.extent(&map(wrap), &corners) >= 0.0);
            }
        }
    }
}
