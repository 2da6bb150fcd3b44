//! Pixel filters.

/// A separable pixel filter, centred on the pixel. Widths are full widths in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// Constant.
    Box {
        /// Full width.
        width: f32,
    },
    /// Linear fall-off to zero at the border.
    Tent {
        /// Full width.
        width: f32,
    },
    /// A Gaussian less its value at the border, so that it ends at zero.
    Gaussian {
        /// Full width.
        width: f32,
    },
    /// Mitchell and Netravali's cubic with `C = sharpness / 2` and `B = 1 - sharpness`.
    Mitchell {
        /// Full width.
        width: f32,
        /// From 0 (soft, the cubic B-spline) to 1 (Catmull-Rom); 2/3 is what the authors recommend.
        sharpness: f32,
    },
}

impl Default for Filter {
    fn default() -> Self {
        Self::Box { width: 1.0 }
    }
}
