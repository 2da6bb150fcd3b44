//! The subtrees that a traversal keeps for later.

use crate::bvh::MAX_STACK;

/// A stack of fixed size. Trees that could overfill it are refused when they are loaded.
pub(super) struct Stack<T> {
    entries: [T; MAX_STACK],
    height: usize,
}

impl<T: Copy> Stack<T> {
    /// An empty stack; `blank` fills unused entries.
    #[inline(always)]
    pub(super) fn new(blank: T) -> Self {
        Self { entries: [blank; MAX_STACK], height: 0 }
    }

    /// Puts `entry` below those entries above the first `since` that `comes_first` says come first. A full stack stays as
    /// it is: validation excludes it, and tracing does not panic.
    #[inline(always)]
    pub(super) fn insert(&mut self, entry: T, since: usize, comes_first: impl Fn(&T) -> bool) {
        debug_assert!(self.height < MAX_STACK, "the tree was validated");
        if self.height == MAX_STACK {
            return;
        }
        let mut place = self.height;
        while place > since && comes_first(&self.entries[place - 1]) {
            self.entries[place] = self.entries[place - 1];
            place -= 1;
        }
        self.entries[place] = entry;
        self.height += 1;
    }

    /// The number of entries.
    #[inline(always)]
    pub(super) fn height(&self) -> usize {
        self.height
    }

    /// Takes the last entry.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<T> {
        self.height = self.height.checked_sub(1)?;
        self.entries.get(self.height).copied()
    }
}
