//! A stack in uninitialised memory: initialising it for each ray would take longer than tracing some rays.

use core::mem::MaybeUninit;

/// What an index of eight bits reaches, and room for the eight that a push writes.
const ROOM: usize = 256 + 8;

/// Up to 255 numbers, the last one on top. All below `len` have been written: a push moves `len` over what it wrote,
/// and one past 255 starts again at the bottom. Trees that could need that many are refused.
pub(crate) struct UninitStack<T> {
    len: u8,
    numbers: [MaybeUninit<T>; ROOM],
}

impl<T: Copy> UninitStack<T> {
    /// An empty stack.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { len: 0, numbers: [const { MaybeUninit::uninit() }; ROOM] }
    }

    /// Clears the stack.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Pushes a number.
    #[inline(always)]
    pub(crate) fn push(&mut self, number: T) {
        self.numbers[usize::from(self.len)] = MaybeUninit::new(number);
        self.len = self.len.wrapping_add(1);
    }

    /// Pushes the first `count` of the numbers, the last one topmost; `count` is at most 8.
    #[inline(always)]
    pub(crate) fn push_first(&mut self, numbers: [T; 8], count: usize) {
        let len = usize::from(self.len);
        for (place, number) in self.numbers[len..len + 8].iter_mut().zip(numbers) {
            *place = MaybeUninit::new(number);
        }
        self.len = self.len.wrapping_add(count.min(8) as u8);
    }

    /// Pops a number.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: what lay below `len` has been written, see the type.
        Some(unsafe { self.numbers[usize::from(self.len)].assume_init() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_on_top_comes_back_first() {
        let mut stack = UninitStack::new();
        assert_eq!(stack.pop(), None);
        stack.push(1);
        stack.push_first([2, 3, 4, 5, 6, 7, 8, 9], 3);
        stack.push_first([10; 8], 0);
        stack.push(11);
        for expected in [11, 4, 3, 2, 1] {
            assert_eq!(stack.pop(), Some(expected));
        }
        assert_eq!(stack.pop(), None);
        stack.push(12);
        stack.clear();
        assert_eq!(stack.pop(), None);
    }

    #[test]
    fn a_stack_that_is_too_full_starts_again_and_reads_nothing_unwritten() {
        let mut stack = UninitStack::new();
        (0..1000u32).for_each(|number| stack.push(number));
        // 1000 is 3 times 256 and 232.
        assert_eq!((stack.pop(), core::iter::from_fn(|| stack.pop()).count()), (Some(999), 231));
        (0..250u32).for_each(|number| stack.push(number));
        stack.push_first([1, 2, 3, 4, 5, 6, 7, 8], 8);
        assert_eq!(core::iter::from_fn(|| stack.pop()).count(), 2);
    }
}
