//! From coarse to fine: the first sample of every pixel in an order in which the picture can be looked at early.
//!
//! The ray of a square is the first sample of its upper left pixel, so that no work is done twice and the final picture
//! is unchanged: a level takes the pixels on its grid that are not on the grid before. (Driscoll renders squares of 32,
//! 16, 8 … pixels as separate pictures.)

use crate::film::Picture;
use crate::watch::MAX_PREVIEW_SIDE;

/// The sides of the squares from `coarsest` down to 1, halved each time.
pub(super) fn sides(coarsest: u32) -> impl Iterator<Item = u32> {
    let coarsest = 1 << coarsest.clamp(1, MAX_PREVIEW_SIDE).ilog2();
    std::iter::successors(Some(coarsest), |side| Some(side / 2).filter(|&side| side > 0))
}

/// Whether the pixel is the corner of a square at this level and of none at the one before, if there is one.
pub(super) fn is_new(x: u32, y: u32, side: u32, coarsest: u32) -> bool {
    let is_corner = |side: u32| x.is_multiple_of(side) && y.is_multiple_of(side);
    is_corner(side) && (side == coarsest || !is_corner(2 * side))
}

/// Fills each square with its upper left pixel.
pub(super) fn fill_squares(picture: &mut Picture, side: u32) {
    let (width, side) = (picture.width as usize, side as usize);
    for channel in &mut picture.channels {
        for i in 0..channel.values.len() {
            let (x, y) = (i % width, i / width);
            channel.values[i] = channel.values[(y - y % side) * width + (x - x % side)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Channel, Metadata};

    #[test]
    fn each_pixel_is_new_once() {
        let all: Vec<u32> = sides(32).collect();
        assert_eq!(all, [32, 16, 8, 4, 2, 1]);
        for coarsest in [1, 2, 32] {
            let mut total = 0;
            for (x, y) in (0..40).flat_map(|y| (0..50).map(move |x| (x, y))) {
                let times = sides(coarsest).filter(|&side| is_new(x, y, side, coarsest)).count();
                assert_eq!(times, 1, "{x}, {y}");
                total += usize::from(is_new(x, y, coarsest, coarsest));
            }
            let across = |length: usize| length.div_ceil(coarsest as usize);
            assert_eq!(total, across(50) * across(40), "squares of the first level");
        }
    }

    #[test]
    fn blocks_have_the_colour_of_their_corner() {
        let values = (0..15).map(|i| i as f32).collect();
        let channels = vec![Channel { name: "R".to_owned(), values }];
        let mut picture = Picture { width: 5, height: 3, channels, metadata: Metadata::default() };
        fill_squares(&mut picture, 2);
        let expected = [0, 0, 2, 2, 4, 0, 0, 2, 2, 4, 10, 10, 12, 12, 14].map(|i| i as f32);
        assert_eq!(picture.channels[0].values, expected);
        fill_squares(&mut picture, 1);
        assert_eq!(picture.channels[0].values, expected);
    }
}
