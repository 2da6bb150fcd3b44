//! Low-discrepancy sequences: Sobol' with Owen scrambling by hashing, and Roberts' R2.
//!
//! Sobol': direction numbers of Joe and Kuo (2008), of which the first two dimensions are a (0, 2)-sequence. Scrambling
//! and shuffling: Burley, "Practical hash-based Owen scrambling" (2020), with Vegdahl's constants (2021), whose low
//! bits mix better than those of the hash of Laine and Karras (2011). R2: Roberts, "The unreasonable effectiveness of
//! quasirandom sequences" (2018), x_i = i (1/g, 1/g²) mod 1 with g³ = g + 1.

/// The dimensions that [`sobol`] has. More are made by padding: further sets with shuffled indices.
pub const DIMENSIONS: usize = 4;

/// Direction numbers, the lowest index bit first, each as a 32-bit fraction.
const DIRECTIONS: [[u32; 32]; DIMENSIONS] = [
    van_der_corput(),
    // x + 1, x² + x + 1 and x³ + x + 1.
    directions([1, 0, 0], 1, 0),
    directions([1, 3, 0], 2, 1),
    directions([1, 3, 1], 3, 1),
];

const fn van_der_corput() -> [u32; 32] {
    let mut v = [0; 32];
    let mut i = 0;
    while i < 32 {
        v[i] = 1 << (31 - i);
        i += 1;
    }
    v
}

/// The recurrence of Bratley and Fox (1988) for a primitive polynomial of degree `degree` with inner coefficients
/// `inner` (highest power first, as bits), from `degree` odd initial numbers.
const fn directions(initial: [u32; 3], degree: usize, inner: u32) -> [u32; 32] {
    let mut v = [0; 32];
    let mut i = 0;
    while i < 32 {
        v[i] = if i < degree {
            initial[i] << (31 - i)
        } else {
            let mut next = v[i - degree] ^ (v[i - degree] >> degree);
            let mut k = 1;
            while k < degree {
                if inner >> (degree - 1 - k) & 1 == 1 {
                    next ^= v[i - k];
                }
                k += 1;
            }
            next
        };
        i += 1;
    }
    v
}

/// Point `index` of the Sobol' sequence, its coordinates as 32-bit fractions.
#[inline(always)]
pub fn sobol(index: u32) -> [u32; DIMENSIONS] {
    // The first two dimensions without a loop: the radical inverse, and the same of the index times Pascal's triangle
    // modulo 2, which is a Kronecker power of ((1, 1), (0, 1)).
    let mut x = index;
    x ^= x >> 1 & 0x5555_5555;
    x ^= x >> 2 & 0x3333_3333;
    x ^= x >> 4 & 0x0f0f_0f0f;
    x ^= x >> 8 & 0x00ff_00ff;
    x ^= x >> 16;
    [index.reverse_bits(), x.reverse_bits(), product(&DIRECTIONS[2], index), product(&DIRECTIONS[3], index)]
}

/// The exclusive or of those `directions` whose bit of `index` is set: a product of a matrix and a vector modulo 2.
#[inline(always)]
fn product(directions: &[u32; 32], index: u32) -> u32 {
    let mut point = 0;
    let mut bit = 0;
    while bit < 32 {
        // All ones where the bit is set: bits of an index are hard to predict.
        point ^= directions[bit] & (index >> bit & 1).wrapping_neg();
        bit += 1;
    }
    point
}

/// A permutation of words where each bit depends on itself and lower bits alone (Laine and Karras's property).
#[inline(always)]
fn owen_hash(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3D20_ADEA);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6C56);
    x ^ x.wrapping_mul(0x53A2_2864)
}

/// Owen's nested uniform scramble of a 32-bit fraction: each half of each dyadic interval is swapped with the other or
/// not, as `seed` decides. Of an index it is a shuffle that maps every aligned block of 2^k indices to such a block.
#[inline(always)]
pub fn nested_uniform_scramble(x: u32, seed: u32) -> u32 {
    owen_hash(x.reverse_bits(), seed).reverse_bits()
}

/// Point `index` of the R2 sequence as 32-bit fractions, turned about the torus by `rotation` (Cranley and Patterson,
/// 1976).
#[inline(always)]
pub fn r2(index: u32, rotation: [u32; 2]) -> [u32; 2] {
    // 1/g and 1/g² in units of 2⁻³², so that the arithmetic of words is the one modulo 1.
    const STEP: [u32; 2] = [3_242_174_889, 2_447_445_414];
    [index.wrapping_mul(STEP[0]).wrapping_add(rotation[0]), index.wrapping_mul(STEP[1]).wrapping_add(rotation[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_dimensions_are_those_of_the_direction_numbers() {
        for i in 0..10_000u32 {
            let index = i.wrapping_mul(0x9e37_79b9);
            for dimension in [0, 1] {
                let set = (0..32).filter(|bit| index >> bit & 1 == 1);
                let point = set.fold(0, |point, bit| point ^ DIRECTIONS[dimension][bit]);
                assert_eq!(sobol(index)[dimension], point);
            }
        }
    }

    /// The first two dimensions of a point.
    fn pair(index: u32) -> [u32; 2] {
        let [x, y, ..] = sobol(index);
        [x, y]
    }

    /// Whether the points (x, y) put exactly one into each elementary interval of area 2^-bits.
    fn is_net(points: &[[u32; 2]], bits: u32) -> bool {
        assert_eq!(points.len(), 1 << bits);
        (0..=bits).all(|across| {
            let mut seen = alloc::vec![false; points.len()];
            points.iter().all(|[x, y]| {
                let column = (u64::from(*x) >> (32 - across)) as usize;
                let row = (u64::from(*y) >> (32 - (bits - across))) as usize;
                !core::mem::replace(&mut seen[column << (bits - across) | row], true)
            })
        })
    }

    #[test]
    fn first_points_are_the_published_ones() {
        // The first 8 points in eighths. Joe and Kuo list them in Gray-code order, where the i-th is ours at i ^ i/2.
        let listed = [
            [0, 0, 0, 0],
            [4, 4, 4, 4],
            [6, 2, 2, 2],
            [2, 6, 6, 6],
            [3, 3, 5, 7],
            [7, 7, 1, 3],
            [5, 1, 7, 5],
            [1, 5, 3, 1],
        ];
        for (i, point) in (0u32..).zip(listed) {
            assert_eq!(sobol(i ^ (i / 2)).map(|x| x >> 29), point, "point {i}");
        }
    }

    #[test]
    fn direction_numbers_follow_the_recurrence() {
        // Bratley and Fox's example: x³ + x + 1 from 1, 3, 7 goes on with 5, 7, 43. From Joe and Kuo's 1, 3, 1 the same
        // m_k = 4 m_(k-2) ^ 8 m_(k-3) ^ m_(k-3) gives 12 ^ 8 ^ 1, 4 ^ 24 ^ 3, 20 ^ 8 ^ 1.
        let odd = |v: [u32; 32]| [0, 1, 2, 3, 4, 5].map(|i| v[i] >> (31 - i));
        assert_eq!(odd(directions([1, 3, 7], 3, 1)), [1, 3, 7, 5, 7, 43]);
        assert_eq!(odd(DIRECTIONS[3]), [1, 3, 1, 5, 31, 29]);
        assert_eq!(odd(DIRECTIONS[1]), [1, 3, 5, 15, 17, 51]);
    }

    #[test]
    fn aligned_blocks_are_nets() {
        for bits in 0..=10 {
            for block in [0, 1, 5] {
                let indices = block << bits..(block + 1) << bits;
                let points: Vec<_> = indices.map(pair).collect();
                assert!(is_net(&points, bits), "2^{bits} points, block {block}");
            }
        }
        assert!(!is_net(&[[0, 0], [1, 1 << 31]], 1));
    }

    #[test]
    fn every_dimension_is_stratified() {
        for dimension in 0..DIMENSIONS {
            let mut strata: Vec<_> = (0..1024).map(|i| sobol(i)[dimension] >> 22).collect();
            strata.sort_unstable();
            assert!(strata.into_iter().eq(0..1024), "dimension {dimension}");
        }
    }

    #[test]
    fn scrambled_nets_are_nets() {
        for seed in 0..50u32 {
            let [s, t] = [seed.wrapping_mul(0x9E37_79B9), !seed.wrapping_mul(0x85EB_CA6B)];
            for bits in [1, 4, 7, 10] {
                let points: Vec<_> = (0..1 << bits)
                    .map(|i| {
                        let [x, y] = pair(i);
                        [nested_uniform_scramble(x, s), nested_uniform_scramble(y, t)]
                    })
                    .collect();
                assert!(is_net(&points, bits), "seed {seed}, 2^{bits} points");
            }
        }
    }

    /// Flipping a bit flips itself, never a higher one, and the lower ones half of the time.
    #[test]
    fn scramble_is_nested_and_uniform() {
        const TRIALS: u32 = 4096;
        for bit in 0..32 {
            let mut flips = [0u32; 32];
            for trial in 0..TRIALS {
                let (x, seed) = (trial.wrapping_mul(0x2545_F491), trial.wrapping_mul(0x9E37_79B9) ^ 0x68E3_1DA4);
                let changed = nested_uniform_scramble(x, seed) ^ nested_uniform_scramble(x ^ 1 << bit, seed);
                assert_eq!(changed >> bit, 1, "bit {bit} of {x:#x} under {seed:#x}");
                for (lower, flips) in flips.iter_mut().enumerate() {
                    *flips += changed >> lower & 1;
                }
            }
            for &flips in &flips[..bit] {
                let share = f64::from(flips) / f64::from(TRIALS);
                // The hash is not ideal where two bits are neighbours.
                assert!((0.3..0.7).contains(&share), "bit {bit}: {share}");
            }
        }
    }

    #[test]
    fn shuffle_keeps_aligned_blocks() {
        for bits in [3, 6, 10] {
            let mut indices: Vec<_> = (0..1 << bits).map(|i| nested_uniform_scramble(i, 0xDEAD_10CC)).collect();
            indices.sort_unstable();
            assert_eq!(indices[0] % (1 << bits), 0);
            assert!(indices.windows(2).all(|pair| pair[0] + 1 == pair[1]));
        }
    }

    #[test]
    fn r2_steps_are_powers_of_the_plastic_number() {
        let g: f64 = (0..64).fold(1.3, |g: f64, _| (g + 1.0).cbrt());
        let [x, y] = r2(1, [0; 2]).map(|x| f64::from(x) / 4_294_967_296.0);
        assert!((x - 1.0 / g).abs() < 2f64.powi(-32) && (y - 1.0 / (g * g)).abs() < 2f64.powi(-32));
    }

    /// Steinhaus's three-distance theorem, and points that keep away from each other on the torus.
    #[test]
    fn r2_points_are_spread() {
        let points: Vec<_> = (0..1000).map(|i| r2(i, [0x1234_5678, 0x9ABC_DEF0])).collect();
        for axis in 0..2 {
            let mut sorted: Vec<_> = points.iter().map(|p| p[axis]).collect();
            sorted.sort_unstable();
            let mut gaps: Vec<_> = (0..1000).map(|i| sorted[(i + 1) % 1000].wrapping_sub(sorted[i])).collect();
            gaps.sort_unstable();
            gaps.dedup();
            assert!(gaps.len() <= 3, "{gaps:?}");
        }
        let unit = |d: u32| f64::from(d as i32) / 4_294_967_296.0;
        let mut least = f64::INFINITY;
        for (i, a) in points.iter().enumerate() {
            for b in &points[..i] {
                least = least.min(unit(a[0].wrapping_sub(b[0])).hypot(unit(a[1].wrapping_sub(b[1]))));
            }
        }
        // A square grid has 1 here, 1000 random points about .02.
        assert!(least * 1000f64.sqrt() > 0.5, "{least}");
    }
}
