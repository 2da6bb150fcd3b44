//! Queries other than the nearest hit and occlusion: filters, one-sided triangles, all hits, the closest point, the
//! triangles in a box, and what a ray costs. All walk the tree as the single-ray intersector does.

mod closest_point;
mod facing;
mod filter;
mod hits;
mod overlap;
mod round;
// Miri would take hours.
#[cfg(all(test, not(miri)))]
mod tests;
mod visits;

pub use facing::Facing;
pub use filter::Verdict;
pub use hits::Hits;
pub use visits::Visits;
