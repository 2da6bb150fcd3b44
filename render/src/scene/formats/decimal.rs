//! Decimal numbers in text, to the nearest `f32`, like `str::parse`, but several times as fast.
//!
//! Most numbers in models have less than 16 digits and a small power of ten. Then both are exact in double precision,
//! and their product or quotient is rounded once (Clinger, "How to read floating point numbers accurately", 1990).
//! Rounding it again to single precision is correct unless it is exactly between two of these; that case and all others
//! are left to the standard library.

/// The powers of ten that are exact in double precision.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// This many digits stay below 2⁶³.
const MAX_DIGITS: usize = 18;

/// The number in `word`; `None` if it is not a number.
pub(super) fn parse(word: &[u8]) -> Option<f32> {
    match prefix(word) {
        Some((number, length)) if length == word.len() => Some(number),
        _ => str::from_utf8(word).ok()?.parse().ok(),
    }
}

/// The number that `text` begins with, and its length, if it is one of the many that are quick to read. What follows
/// may belong to it.
pub(super) fn prefix(text: &[u8]) -> Option<(f32, usize)> {
    let is_negative = text.first() == Some(&b'-');
    let begin = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let (mut digits, end) = take_digits(text, begin, 0);
    let (mut at, mut length, mut exponent) = (end, end - begin, 0);
    if text.get(at) == Some(&b'.') {
        let (all, end) = take_digits(text, at + 1, digits);
        exponent = -((end - at - 1) as i32);
        length += end - at - 1;
        (digits, at) = (all, end);
    }
    if length == 0 || length > MAX_DIGITS {
        return None;
    }
    if let Some(b'e' | b'E') = text.get(at) {
        let sign = text.get(at + 1);
        let begin = at + 1 + usize::from(matches!(sign, Some(b'-' | b'+')));
        let (power, end) = take_digits(text, begin, 0);
        if !(1..=4).contains(&(end - begin)) {
            return None;
        }
        exponent += if sign == Some(&b'-') { -(power as i32) } else { power as i32 };
        at = end;
    }
    let sign = if is_negative { -1.0 } else { 1.0 };
    if digits == 0 {
        return Some((sign * 0.0, at));
    }
    let power = *POWERS.get(exponent.unsigned_abs() as usize)?;
    if digits > 1 << f64::MANTISSA_DIGITS {
        return None;
    }
    let number = if exponent < 0 { digits as f64 / power } else { digits as f64 * power };
    /// The bits of a double that a single has not, and the first of them.
    const DROPPED: u64 = (1 << 29) - 1;
    const HALF: u64 = 1 << 28;
    let is_between = number.to_bits() & DROPPED == HALF;
    let is_normal = (f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX)).contains(&number);
    (is_normal && !is_between).then_some((sign * number as f32, at))
}

/// Appends the digits from `at` on to `number`, which wraps if they are too many; and where they end.
fn take_digits(text: &[u8], mut at: usize, mut number: u64) -> (u64, usize) {
    while let Some(digit) = text.get(at).map(|byte| byte.wrapping_sub(b'0')).filter(|digit| *digit < 10) {
        number = number.wrapping_mul(10).wrapping_add(digit.into());
        at += 1;
    }
    (number, at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_as_standard(word: &str) -> bool {
        let expected: Option<f32> = word.parse().ok();
        assert_eq!(parse(word.as_bytes()).map(f32::to_bits), expected.map(f32::to_bits), "{word}");
        prefix(word.as_bytes()).is_some()
    }

    #[test]
    fn what_is_a_number_and_what_is_none() {
        let quick = ["0", "-0", "+1", "1.", ".5", "-.5e1", "1E-3", "007.50", "16777218", "1e22", "9007199254740992"];
        assert!(quick.iter().all(|word| assert_as_standard(word)));
        let slow = ["", "-", ".", "e5", "1e", "1e+", "1e12345", "--1", "inf", "nan", "1e39", "1e-42", "1e-50", "٣"];
        assert!(!slow.iter().any(|word| assert_as_standard(word)));
        // A prefix of these is a number.
        for word in ["1.2.3", "1,5", "1x", "0x10", "1e5.0", "1_000", "1 "] {
            assert_as_standard(word);
        }
        assert_eq!(prefix(b"-12.50 7"), Some((-12.5, 6)));
    }

    /// Between two singles double precision alone would round twice.
    #[test]
    fn numbers_between_two_singles() {
        let near =
            ["16777217", "16777217.0000001", "16777216.9999999", "1.00000005960464477539", "0.100000001490116119"];
        for word in near {
            assert_as_standard(word);
        }
        assert_eq!(parse(b"16777217.000000001"), Some(16777218.0));
        assert_eq!(prefix(b"16777217"), None);
    }

    #[test]
    fn numbers_of_all_lengths_and_powers() {
        let mut state = 1_u64;
        let mut random = |count: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % count
        };
        let mut quick = 0;
        for _ in 0..100_000 {
            let mut word = String::new();
            let digits = 1 + random(20);
            let point = random(digits + 3);
            for place in 0..digits {
                if place == point {
                    word.push('.');
                }
                word.push(char::from(b'0' + random(10) as u8));
            }
            if random(3) == 0 {
                word += &format!("e{}", random(100) as i64 - 50);
            }
            quick += usize::from(assert_as_standard(&word));
        }
        assert!(quick > 30_000, "{quick}");
        // What programs write of singles.
        for _ in 0..100_000 {
            let number = f32::from_bits((random(1 << 31) as u32) << 1);
            assert_as_standard(&number.to_string());
            assert_as_standard(&format!("{number:e}"));
            assert_as_standard(&format!("{number:.9}"));
        }
    }
}
