//! Shards: equal parts of some work, numbered, for several machines.

/// Every `count`-th item of a list, from `number` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shard {
    number: u32,
    count: u32,
}

impl Default for Shard {
    fn default() -> Self {
        Self::ALL
    }
}

impl Shard {
    /// All items.
    pub const ALL: Self = Self { number: 0, count: 1 };

    /// The shard `number` of `count`; `None` if there is no such one, as numbers begin with 0.
    pub fn new(number: u32, count: u32) -> Option<Self> {
        (number < count).then_some(Self { number, count })
    }

    /// From 0 up to [`count`](Self::count).
    pub fn number(self) -> u32 {
        self.number
    }

    /// How many shards there are, at least 1.
    pub fn count(self) -> u32 {
        self.count
    }

    /// Whether an item is in it.
    pub fn has(&self, item: usize) -> bool {
        item as u64 % u64::from(self.count) == u64::from(self.number)
    }

    /// How many of so many items are in it.
    pub fn items(&self, of: usize) -> usize {
        of.saturating_sub(self.number as usize).div_ceil(self.count as usize)
    }

    /// Counts of present, duplicate and missing shards.
    ///
    /// # Errors
    /// The error of shards with these names: they must have the same number of shards, each once.
    pub(crate) fn check_all(shards: &[(String, Self)]) -> Result<(), super::Invalid> {
        let Some((first, Self { count, .. })) = shards.first() else { return Ok(()) };
        let remedy = "name all shards of one number, each once";
        if let Some((other, shard)) = shards.iter().find(|(_, shard)| shard.count != *count) {
            let problem = format!("{first} is one of {count} shards, and {other} one of {}", shard.count);
            return Err(super::Invalid::new(problem, remedy));
        }
        for (at, (name, shard)) in shards.iter().enumerate() {
            if let Some((before, _)) = shards[..at].iter().find(|(_, before)| before == shard) {
                let problem = format!("{before} and {name} both are shard {}/{count}", shard.number + 1);
                return Err(super::Invalid::new(problem, "leave one of them out"));
            }
        }
        let is_missing = |number: &u32| shards.iter().all(|(_, shard)| shard.number != *number);
        let missing: Vec<String> = (0..*count).filter(is_missing).map(|it| format!("{}/{count}", it + 1)).collect();
        match &missing[..] {
            [] => Ok(()),
            [one] => Err(super::Invalid::new(format!("the shard {one} is missing"), remedy)),
            [first, ..] => {
                let problem = format!("{} of {count} shards are missing, the first of them {first}", missing.len());
                Err(super::Invalid::new(problem, remedy))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_is_in_one_shard() {
        for (count, of) in [(1, 5), (2, 5), (3, 9), (16, 5), (4, 0)] {
            let shards = (0..count).map(|number| Shard::new(number, count).unwrap());
            let items: Vec<usize> = shards.map(|shard| (0..of).filter(|&item| shard.has(item)).count()).collect();
            let counts: Vec<usize> = (0..count).map(|number| Shard::new(number, count).unwrap().items(of)).collect();
            assert_eq!((items.iter().sum::<usize>(), &items), (of, &counts));
        }
    }

    #[test]
    fn shards_that_do_not_exist_are_none() {
        assert_eq!([Shard::new(0, 0), Shard::new(2, 2), Shard::new(u32::MAX, 1)], [None; 3]);
        assert_eq!(Shard::new(0, 1), Some(Shard::default()));
        let last = Shard::new(u32::MAX - 1, u32::MAX).unwrap();
        assert_eq!((last.items(5), last.has(5), last.items(usize::MAX)), (0, false, usize::MAX / u32::MAX as usize));
    }

    #[test]
    fn shards_that_are_missing_twice_there_or_of_another_number_are_named() {
        let of = |list: &[(u32, u32)]| {
            let shard = |(place, &(number, count)): (usize, &(u32, u32))| {
                (format!("part{place}"), Shard::new(number - 1, count).unwrap())
            };
            let named: Vec<_> = list.iter().enumerate().map(shard).collect();
            Shard::check_all(&named).map_err(|error| error.problem)
        };
        assert_eq!(of(&[(2, 3), (1, 3), (3, 3)]), Ok(()));
        assert_eq!(of(&[(1, 1)]), Ok(()));
        let wrong = |list: &[(u32, u32)], problem: &str| assert_eq!(of(list), Err(problem.to_owned()));
        wrong(&[(1, 3), (2, 3)], "the shard 3/3 is missing");
        wrong(&[(4, 4)], "3 of 4 shards are missing, the first of them 1/4");
        wrong(&[(1, 2), (2, 2), (1, 2)], "part0 and part2 both are shard 1/2");
        wrong(&[(1, 2), (2, 3)], "part0 is one of 2 shards, and part1 one of 3");
    }
}
