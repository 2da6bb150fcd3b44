//! Filters: what decoded attributes stand for.

use serde::Deserialize;

/// What is done to attributes afterwards.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
}

impl Filter {
    /// Replaces decoded attributes, `stride` bytes each, by what they stand for; or says why the filter does not fit them.
    pub(super) fn apply(self, bytes: &mut [u8], stride: usize) -> Result<(), String> {
        let wrong = || Err(format!("its filter {self:?} does not go with a stride of {stride}"));
        match (self, stride) {
            (Self::None, _) => {}
            (Self::Octahedral, 4) => {
                for vector in bytes.chunks_exact_mut(4) {
                    let [x, y, one] = [0, 1, 2].map(|slot| f32::from(vector[slot] as i8));
                    let unit = octahedral(x, y, one, 127.0);
                    [0, 1, 2].into_iter().zip(unit).for_each(|(slot, number)| vector[slot] = number as i8 as u8);
                }
            }
            (Self::Octahedral, 8) => {
                for vector in bytes.chunks_exact_mut(8) {
                    let [x, y, one, _] = shorts(vector).map(f32::from);
                    let [x, y, z] = octahedral(x, y, one, 32767.0).map(|number| number as i16);
                    write(vector, [x, y, z, shorts(vector)[3]]);
                }
            }
            (Self::Octahedral, _) => return wrong(),
            (Self::Quaternion, 8) => {
                for quaternion in bytes.chunks_exact_mut(8) {
                    write(quaternion, full_quaternion(shorts(quaternion)));
                }
            }
            (Self::Quaternion, _) => return wrong(),
            (Self::Exponential, _) => {
                for number in bytes.as_chunks_mut::<4>().0 {
                    let code = i32::from_le_bytes(*number);
                    let (mantissa, exponent) = ((code << 8) >> 8, code >> 24);
                    *number = ((f64::from(mantissa) * f64::from(exponent).exp2()) as f32).to_le_bytes();
                }
            }
        }
        Ok(())
    }
}

/// A unit vector from its place on an octahedron, of which `one` is the extent, times `scale` and rounded.
fn octahedral(x: f32, y: f32, one: f32, scale: f32) -> [f32; 3] {
    let z = one - x.abs() - y.abs();
    let fold = z.min(0.0);
    let unfold = |number: f32| number + if number >= 0.0 { fold } else { -fold };
    let (x, y) = (unfold(x), unfold(y));
    let length = (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|number| (number * (scale / length)).round())
}

/// A quaternion from its three smaller components; which one is left out stands in the lowest bits of the last number.
fn full_quaternion([x, y, z, last]: [i16; 4]) -> [i16; 4] {
    let scale = core::f32::consts::FRAC_1_SQRT_2 / f32::from(last | 3);
    let small = [x, y, z].map(|number| f32::from(number) * scale);
    let rest = 1.0 - small.iter().map(|number| number * number).sum::<f32>();
    let first = (last & 3) as usize;
    let mut full = [0; 4];
    for (place, number) in [rest.max(0.0).sqrt(), small[0], small[1], small[2]].into_iter().enumerate() {
        full[(first + place) % 4] = (number * 32767.0).round() as i16;
    }
    full
}

fn shorts(bytes: &[u8]) -> [i16; 4] {
    core::array::from_fn(|place| i16::from_le_bytes([bytes[2 * place], bytes[2 * place + 1]]))
}

fn write(bytes: &mut [u8], numbers: [i16; 4]) {
    for (place, number) in numbers.into_iter().enumerate() {
        bytes[2 * place..2 * place + 2].copy_from_slice(&number.to_le_bytes());
    }
}
