//! Which triangles of a mesh meet in a point, whether they share vertices or not.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

/// The triangles at each point of a mesh.
pub(super) struct Neighbours<'a> {
    triangles: &'a [[u32; 3]],
    /// The point of each vertex: the same for all vertices at one place.
    points: Vec<u32>,
    /// Where the triangles of each point begin in `faces`, and where they end.
    firsts: Vec<u32>,
    faces: Vec<u32>,
}

impl<'a> Neighbours<'a> {
    /// Of triangles with vertices at these positions, which have no negative zeros.
    pub(super) fn new(positions: &[Vec3], triangles: &'a [[u32; 3]]) -> Self {
        let place = |vertex: u32| positions[vertex as usize].to_array().map(f32::to_bits);
        let mut order: Vec<u32> = (0..positions.len() as u32).collect();
        order.par_sort_unstable_by_key(|&vertex| place(vertex));
        let (mut points, mut count) = (vec![0; positions.len()], 0);
        for same in order.chunk_by(|&a, &b| place(a) == place(b)) {
            same.iter().for_each(|&vertex| points[vertex as usize] = count);
            count += 1;
        }
        let mut firsts = vec![0; count as usize + 1];
        let corners = || triangles.iter().flatten().map(|&vertex| points[vertex as usize] as usize);
        corners().for_each(|point| firsts[point + 1] += 1);
        for point in 0..count as usize {
            firsts[point + 1] += firsts[point];
        }
        let (mut next, mut faces) = (firsts.clone(), vec![0; 3 * triangles.len()]);
        for (corner, point) in corners().enumerate() {
            faces[next[point] as usize] = (corner / 3) as u32;
            next[point] += 1;
        }
        Self { triangles, points, firsts, faces }
    }

    /// The most triangles that meet in a point.
    pub(super) fn most_meeting(&self) -> usize {
        self.firsts.windows(2).map(|ends| (ends[1] - ends[0]) as usize).max().unwrap_or(0)
    }

    /// A part of the triangles with all that meet them, and with all that meet those among these that are undecided, and so
    /// on; in order. `None` if there are more than `most`.
    pub(super) fn around_all(
        &self,
        part: Range<usize>,
        is_undecided: impl Fn(usize) -> bool,
        most: usize,
    ) -> Option<Vec<u32>> {
        let (mut is_known, mut found) = (vec![false; self.triangles.len()], Vec::new());
        let mut open: Vec<usize> = part.clone().collect();
        while let Some(face) = open.pop() {
            for near in self.around(face) {
                if !std::mem::replace(&mut is_known[near as usize], true) {
                    found.push(near);
                    if !part.contains(&(near as usize)) && is_undecided(near as usize) {
                        open.push(near as usize);
                    }
                }
            }
            if found.len() > most {
                return None;
            }
        }
        found.sort_unstable();
        Some(found)
    }

    /// The triangles that meet one, with itself, some more than once.
    fn around(&self, face: usize) -> impl Iterator<Item = u32> {
        self.triangles[face].into_iter().flat_map(|vertex| {
            let point = self.points[vertex as usize] as usize;
            self.faces[self.firsts[point] as usize..self.firsts[point + 1] as usize].iter().copied()
        })
    }
}
