//! The order in which records lie in memory: along Morton's space-filling curve (1966), so that a lookup finds all
//! records of a neighbourhood within a few pages.

use glam::Vec3;

/// Bits of each coordinate.
const BITS: u32 = 21;

/// Sorts `items` by their places along the curve; those at the same place by `tie`.
pub(crate) fn sort_by_morton_code<T, K: Ord>(items: &mut [T], position: impl Fn(&T) -> Vec3, tie: impl Fn(&T) -> K) {
    let Some(first) = items.first().map(&position) else { return };
    let (lower, upper) = items
        .iter()
        .map(&position)
        .fold((first, first), |(lower, upper), position| (lower.min(position), upper.max(position)));
    let extent = (upper - lower).max_element().max(f32::MIN_POSITIVE);
    let cells = (1u64 << BITS) as f32;
    items.sort_by_cached_key(|item| {
        let cell = ((position(item) - lower) / extent * cells).min(Vec3::splat(cells - 1.0));
        let [x, y, z] = cell.to_array().map(|coordinate| spread(coordinate as u64));
        (x | y << 1 | z << 2, tie(item))
    });
}

/// The lower 21 bits, each followed by two zeros.
fn spread(bits: u64) -> u64 {
    const STEPS: [(u32, u64); 5] = [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ];
    STEPS.into_iter().fold(bits & 0x1f_ffff, |bits, (shift, mask)| (bits | bits << shift) & mask)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread_by_threes() {
        for bits in [0, 1, 0b1011, 0x15_5555, 0x1f_ffff] {
            let expected = (0..BITS).filter(|bit| bits >> bit & 1 == 1).fold(0, |sum, bit| sum | 1 << (3 * bit));
            assert_eq!(spread(bits), expected, "{bits:b}");
        }
    }

    #[test]
    fn octants_follow_each_other_and_ties_are_broken() {
        let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let mut corners: Vec<(usize, Vec3)> = (0..16).rev().map(|i| (i, corner(i % 8))).collect();
        sort_by_morton_code(&mut corners, |&(_, position)| position, |&(i, _)| i);
        let order: Vec<usize> = corners.into_iter().map(|(i, _)| i).collect();
        assert_eq!(order, (0..8).flat_map(|i| [i, i + 8]).collect::<Vec<_>>());
    }
}
