//! What a sample of a light says.

use glam::Vec3;
use halfdome_kernel::Ray;

/// Light that arrives from a light if nothing is in between.
pub(crate) struct LightSample {
    pub shadow: Ray,
    /// Unit vector to the light.
    pub direction: Vec3,
    /// Radiance over density; of a delta light, irradiance on what faces it over probability.
    pub radiance: Vec3,
    /// The reciprocal of the density per solid angle of this direction; 0 for a light that no bounce can hit.
    pub inv_density: f32,
    /// Whether it comes from a light without a surface, which bounces meet where they look for it (see
    /// [`seen_lights`](super::seen_lights)).
    pub is_punctual: bool,
    /// Whether `shadow` is the part of the way behind all glass.
    pub is_glass_known: bool,
}
