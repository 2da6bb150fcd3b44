//! One function of each element of a slice, compiled for every instruction set.
//!
//! The loop is plain. Its functions are inlined and have no branch on their data, so the compiler vectorises it to the
//! width of the instruction set; as each lane does the scalar's operations, results are equal bit for bit.

use crate::simd::{Isa, Simd, Work, dispatch};

/// A function of one element. `apply` must be `#[inline(always)]`, as must all functions that it calls.
pub(super) trait Function {
    type Input: Copy;
    type Output;
    fn apply(&self, input: Self::Input) -> Self::Output;
}

/// Writes the function of each input with the instructions of `isa`. Elements beyond the end of the shorter slice are
/// left unchanged.
///
/// Never a part of its caller: where the compiler sees both slices as parts of one value, it does not vectorise the
/// loop.
#[inline(never)]
pub(super) fn apply_many<F: Function>(isa: Isa, function: F, inputs: &[F::Input], outputs: &mut [F::Output]) {
    dispatch(isa, Batch { function, inputs, outputs });
}

struct Batch<'a, F: Function> {
    function: F,
    inputs: &'a [F::Input],
    outputs: &'a mut [F::Output],
}

impl<F: Function> Work for Batch<'_, F> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        for (output, &input) in self.outputs.iter_mut().zip(self.inputs) {
            *output = self.function.apply(input);
        }
    }
}
