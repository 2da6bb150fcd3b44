//! Union-find: which numbers hang together, told by pairs of them.

/// Disjoint sets of numbers from 0 on. The least number of a set is its root, so that roots do not depend on the order
/// in which sets are joined.
#[derive(Debug, Default)]
pub(crate) struct UnionFind {
    parents: Vec<u32>,
}

impl UnionFind {
    /// Numbers from 0 up to `count`, each in a set of its own.
    pub(crate) fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).collect() }
    }

    /// Adds the next number, in a set of its own.
    pub(crate) fn push(&mut self) -> u32 {
        let number = self.parents.len() as u32;
        self.parents.push(number);
        number
    }

    /// Joins the sets of two numbers; whether these were two.
    pub(crate) fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// The least number of a set. Halves the path to it.
    pub(crate) fn root(&mut self, mut number: u32) -> u32 {
        while self.parents[number as usize] != number {
            self.parents[number as usize] = self.parents[self.parents[number as usize] as usize];
            number = self.parents[number as usize];
        }
        number
    }

    /// The root of each number.
    pub(crate) fn roots(mut self) -> Vec<u32> {
        (0..self.parents.len() as u32).map(|number| self.root(number)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_the_least_of_their_sets_in_any_order() {
        let mut pairs = [(6, 4), (1, 3), (4, 2), (3, 6)];
        for _ in 0..pairs.len() {
            pairs.rotate_left(1);
            let mut sets = UnionFind::new(6);
            assert_eq!(sets.push(), 6);
            assert!(pairs.iter().all(|&(a, b)| sets.join(a, b)));
            assert!(!sets.join(2, 6), "they are joined already");
            assert_eq!(sets.roots(), [0, 1, 1, 1, 1, 5, 1]);
        }
    }
}
