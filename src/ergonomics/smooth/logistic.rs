//! The logistic step and its slope.

/// Width of the steps unless another is asked for, deg.
pub const DEFAULT_WIDTH_DEG: f64 = 1.0;

/// Length of a step in metres for each deg of width: about what a turn of 1 deg at the shoulder moves
/// the wrist of a straight arm (0.57 m).
pub const METRES_PER_DEG: f64 = 0.01;

/// The narrowest width, deg: below it a slope would not be a finite number.
const LEAST_WIDTH_DEG: f64 = 1e-9;

/// From this many scales on, a step is 0 or 1 to within 5e-18 and needs no exponential.
const FLAT_FROM: f64 = 40.0;

/// A number and its derivative with respect to one angle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Soft {
    pub(super) value: f64,
    pub(super) slope: f64,
}

impl Soft {
    pub(super) fn times(self, factor: f64) -> Self {
        Self { value: self.value * factor, slope: self.slope * factor }
    }
}

impl std::ops::Add for Soft {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, slope: self.slope + other.slope }
    }
}

/// Steps of one width; angles in deg.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blur {
    /// One over the scale s of the logistic function, 1/deg.
    sharpness: f64,
}

impl Blur {
    /// `width_deg` from 10 to 90 % of a step.
    pub(super) fn new(width_deg: f64) -> Self {
        // logistic(z) = 0.9 at z = ln 9.
        Self { sharpness: 2.0 * 9.0f64.ln() / width_deg.max(LEAST_WIDTH_DEG) }
    }

    /// The same steps for an argument in metres.
    pub(super) fn in_metres(self) -> Self {
        Self { sharpness: self.sharpness / METRES_PER_DEG }
    }

    /// From 0 below the threshold to 1 above it.
    pub(super) fn above(self, x: f64, threshold: f64) -> Soft {
        let z = (x - threshold) * self.sharpness;
        if z > FLAT_FROM {
            Soft { value: 1.0, slope: 0.0 }
        } else if z < -FLAT_FROM {
            Soft::default()
        } else {
            let value = 1.0 / (1.0 + (-z).exp());
            // 1 - value loses its digits near 1; logistic(-z) keeps them.
            Soft { value, slope: self.sharpness * value / (1.0 + z.exp()) }
        }
    }

    /// From 1 below the threshold to 0 above it.
    pub(super) fn below(self, x: f64, threshold: f64) -> Soft {
        let mirrored = self.above(-x, -threshold);
        Soft { value: mirrored.value, slope: -mirrored.slope }
    }

    /// From 0 inside -limit to limit to 1 outside it, smooth at zero for any limit.
    pub(super) fn outside(self, x: f64, limit: f64) -> Soft {
        self.above(x, limit) + self.below(x, -limit)
    }

    /// What `x` exceeds the threshold by, or 0, rounded off: its slope is [`Blur::above`].
    pub(super) fn excess(self, x: f64, threshold: f64) -> Soft {
        let z = (x - threshold) * self.sharpness;
        let value = (z.max(0.0) + (-z.abs()).exp().ln_1p()) / self.sharpness;
        Soft { value, slope: self.above(x, threshold).value }
    }
}

/// The chance that at least one of two holds.
pub(super) fn either(p: f64, q: f64) -> f64 {
    p + q * (1.0 - p)
}
