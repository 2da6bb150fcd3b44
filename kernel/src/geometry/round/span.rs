//! Selects a line's crossing with a surface that a ray hits.

use super::RayFrame;
use super::line_test::{Crossing, LineTest, Span};

/// A bound of the work.
const MAX_TURNS: u32 = 16;

impl Span {
    /// A span that grows with each crossing that is found.
    #[inline(always)]
    pub(super) fn grow(span: &mut Option<Self>, z: f64, u: f64) {
        let crossing = Crossing { z, u, outward: [0.0; 3] };
        match span {
            None => *span = Some(Self { enter: crossing, exit: crossing }),
            Some(span) if z < span.enter.z => span.enter = crossing,
            Some(span) if z > span.exit.z => span.exit = crossing,
            Some(_) => {}
        }
    }
}

/// The first crossing with the surface of a round primitive that is not before `least`, and whether the line enters
/// there.
///
/// The primitive is the union of its spans. A line that begins inside leaves the union at the end of the connected
/// spans: each pass extends the known end by the spans around it, forwards and backwards in turn, as the primitive may
/// run in either direction, until none is left. A cubic curve runs back and forth three times at most.
#[inline(always)]
pub(super) fn first_crossing<P: LineTest>(
    frame: &RayFrame,
    numbers: &P::Numbers,
    least: f64,
) -> Option<(Crossing, bool)> {
    let (mut enter, mut exit): (Option<Crossing>, Option<Crossing>) = (None, None);
    let (mut known, mut turns, mut idle) = (least, 0, 0);
    loop {
        let before = known;
        P::spans(frame, numbers, turns & 1 != 0, |span| {
            if span.enter.z >= known {
                if exit.is_none() && enter.is_none_or(|first| span.enter.z < first.z) {
                    enter = Some(span.enter);
                }
            } else if span.exit.z >= known {
                exit = Some(span.exit);
                known = span.exit.z;
            }
        });
        let Some(exit) = exit else { return enter.map(|enter| (enter, true)) };
        turns += 1;
        idle = if known > before { 0 } else { idle + 1 };
        if P::IS_CONVEX || idle == 2 || turns == MAX_TURNS {
            return Some((exit, false));
        }
    }
}
