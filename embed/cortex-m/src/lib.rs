//! The built-in scene under ambient occlusion, as text: one program for the microcontroller and for the host, so that
//! both must draw the same characters and find the same hits.
//!
//! A pixel is one camera ray, and where it hits a surface [`FEELERS`] rays into the hemisphere over it: the more of
//! them reach [`REACH`] without a hit, the lighter.
#![no_std]
#![forbid(unsafe_code)]

use core::fmt::{self, Write};

use glam::{Vec3, vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Frame, Pattern, Sampler};
use halfdome_kernel::{BvhView, Hit, Ray, Triangle, offset_origin, triangle_normal};

/// The tree of `halfdome tree cornell`, which stays in flash.
pub static CORNELL: &[u8] = halfdome_kernel::include_blob!("../cornell.bvh");

/// Triangles of the scene.
const TRIANGLES: usize = 32;

/// Characters a line, and lines; a character is twice as high as wide.
const WIDTH: usize = 64;
const HEIGHT: usize = 32;

/// Rays into each hemisphere.
pub const FEELERS: usize = 64;

/// The distance in metres that counts as open.
pub const REACH: f32 = 0.35;

/// From closed to open.
const SHADES: &[u8; 12] = b".,:;-=+*xX#@";

/// The scene's camera: a square of 25 mm behind a lens of 35 mm.
const EYE: Vec3 = vec3(0.278, 0.273, -0.8);
const HALF_HEIGHT: f32 = 0.5 * 0.025 / 0.035;

/// What was traced, and what that took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traced {
    /// Rays.
    pub rays: u32,
    /// Time by the caller's clock.
    pub time: u64,
}

/// What a picture took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// Camera rays, traced to the nearest hit.
    pub closest: Traced,
    /// Rays into hemispheres, traced to any hit.
    pub any: Traced,
    /// FNV-1a of the bits of all hits.
    pub checksum: u64,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} + {} rays, checksum {:016x}", self.closest.rays, self.any.rays, self.checksum)
    }
}

/// Draws the picture of `tree`, and a line with the rays and the checksum. `clock` gives the time.
///
/// # Errors
/// Those of `out`.
#[inline(never)]
pub fn draw(tree: &BvhView, out: &mut impl Write, mut clock: impl FnMut() -> u64) -> Result<Report, fmt::Error> {
    let triangles = triangles(tree);
    let mut report = Report { closest: Traced::default(), any: Traced::default(), checksum: 0xCBF2_9CE4_8422_2325 };
    for y in 0..HEIGHT {
        let rays: [Ray; WIDTH] = core::array::from_fn(|x| camera_ray(x, y));
        let mut hits = [Hit::MISS; WIDTH];
        report.closest.time(WIDTH, &mut clock, || tree.intersect_many(&rays, &mut hits));
        for (x, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
            report.add([hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.prim_id]);
            let Some(triangle) = triangles.get(hit.prim_id as usize) else {
                out.write_char(' ')?;
                continue;
            };
            let feelers = feelers(ray, hit, triangle, (y * WIDTH + x) as u32);
            let mut occluded = [false; FEELERS];
            report.any.time(FEELERS, &mut clock, || tree.occluded_many(&feelers, &mut occluded));
            report.add(occluded.map(u32::from));
            let open = occluded.iter().filter(|occluded| !**occluded).count();
            out.write_char(SHADES[open * (SHADES.len() - 1) / FEELERS].into())?;
        }
        out.write_char('\n')?;
    }
    writeln!(out, "{report}")?;
    Ok(report)
}

impl Traced {
    fn time(&mut self, rays: usize, clock: &mut impl FnMut() -> u64, trace: impl FnOnce()) {
        let start = clock();
        trace();
        self.time += clock() - start;
        self.rays += rays as u32;
    }
}

impl Report {
    fn add(&mut self, words: impl IntoIterator<Item = u32>) {
        for byte in words.into_iter().flat_map(u32::to_le_bytes) {
            self.checksum = (self.checksum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3);
        }
    }
}

/// The triangles by their indices, out of the tree's blocks.
fn triangles(tree: &BvhView) -> [Triangle; TRIANGLES] {
    let mut triangles = [[Vec3::ZERO; 3]; TRIANGLES];
    for block in tree.blocks() {
        for (lane, &number) in block.prim_id.iter().enumerate() {
            if let Some(triangle) = triangles.get_mut(number as usize) {
                *triangle = block.triangle(lane);
            }
        }
    }
    triangles
}

/// The ray through the middle of a pixel. It looks along z; x grows to the left.
fn camera_ray(x: usize, y: usize) -> Ray {
    let across = (2 * x + 1) as f32 / WIDTH as f32 - 1.0;
    let down = (2 * y + 1) as f32 / HEIGHT as f32 - 1.0;
    Ray::new(EYE, vec3(-across * HALF_HEIGHT, -down * HALF_HEIGHT, 1.0))
}

/// Rays from a hit over the side of its triangle that `ray` sees.
fn feelers(ray: &Ray, hit: &Hit, triangle: &Triangle, pixel: u32) -> [Ray; FEELERS] {
    let normal = triangle_normal(triangle);
    let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
    let frame = Frame::from_normal(normal);
    core::array::from_fn(|sample| {
        let u = Sampler::new(Pattern::Sobol, 0, pixel, sample as u32).uniform2(0);
        let direction = frame.to_world(CosineHemisphere.map(u));
        let origin = offset_origin(triangle, normal, hit.u, hit.v, direction);
        Ray { t_max: REACH, ..Ray::new(origin, direction) }
    })
}
