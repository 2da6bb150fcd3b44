//! Values of options about the shutter.

use super::{Reading, Value, expected};
use crate::scene::Shutter;

/// When the shutter opens and closes: two numbers of frames, or with an `s` behind of seconds; or one, the length of
/// the time about the frame.
pub(in crate::scene) fn shutter(value: &Value) -> Reading<Shutter> {
    const WHAT: &str = "when the shutter opens and closes, as -0.25,0.25 in frames or 0s,0.01s in seconds, or how many frames \
                        it is open, as 0.5; it closes after it opens";
    let times = match value {
        Value::List(values) => values.iter().map(time).collect::<Option<Vec<_>>>(),
        one => time(one).filter(|(_, in_seconds)| !in_seconds).map(|(length, _)| {
            let half = 0.5 * length;
            vec![(-half, false), (half, false)]
        }),
    };
    match times.as_deref() {
        Some(&[(open, in_seconds), (close, both)])
            if in_seconds == both && open < close && close - open <= MAX_TIME =>
        {
            Ok(Shutter { open, close, in_seconds })
        }
        _ => expected(WHAT),
    }
}

/// The longest time that a shutter may be open, frames or seconds.
const MAX_TIME: f64 = 1e6;

/// A number, and whether it is of seconds.
fn time(value: &Value) -> Option<(f64, bool)> {
    let (number, in_seconds) = match value {
        Value::Text(text) => (text.trim().strip_suffix('s')?.trim().parse().ok()?, true),
        number => (number.double()?, false),
    };
    (number.abs() <= MAX_TIME).then_some((number, in_seconds))
}

/// The part of the time in which the shutter opens.
pub(in crate::scene) fn shutter_ramp(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(ramp) if (0.0..=0.5).contains(&ramp) => Ok(ramp),
        _ => expected("a number from 0 (it opens at once) to 0.5 (it opens until it closes)"),
    }
}

/// At how many times it is known where things are.
pub(in crate::scene) fn shutter_keys(value: &Value) -> Reading<usize> {
    match value.integer::<usize>() {
        Some(keys @ 3..=Shutter::MAX_KEYS) if keys % 2 == 1 => Ok(keys),
        _ => expected(format!("an odd number from 3 to {}", Shutter::MAX_KEYS)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::argument;
    use super::*;

    #[test]
    fn shutters_are_two_times_or_a_length() {
        let read = argument(shutter);
        let frames = |open, close| Ok(Shutter { open, close, in_seconds: false });
        assert_eq!(read("-0.25,0.25"), frames(-0.25, 0.25));
        assert_eq!(read("0,1"), frames(0.0, 1.0));
        assert_eq!(read("0.5"), frames(-0.25, 0.25));
        assert_eq!(read("0s, 0.01s"), Ok(Shutter { open: 0.0, close: 0.01, in_seconds: true }));
        for wrong in ["0.5,0.25", "0,0", "0", "-1", "nan,1", "0,inf", "0s,1", "1,2,3", "fast", "0,1e9", "0.5s", ""] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
        assert_eq!(argument(shutter_keys)("7"), Ok(7));
        assert!(["1", "4", "131", "x"].iter().all(|wrong| argument(shutter_keys)(wrong).is_err()));
        assert!(["-0.1", "0.6", "nan"].iter().all(|wrong| argument(shutter_ramp)(wrong).is_err()));
    }
}
