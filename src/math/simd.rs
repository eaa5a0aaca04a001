//! Element-wise functions whose loops the compiler turns into vector instructions of the processor at
//! hand ([`wide`]). Every operation is a correctly rounded one, so all processors give the same bits.

use pulp::Arch;

/// Runs a computation with the widest instructions that this processor has.
///
/// The closure has to be marked `#[inline(always)]`: one that the compiler keeps apart is compiled for
/// the oldest processor, and there each `mul_add` is a call, thirty times slower.
#[inline]
pub fn wide<R>(computation: impl FnOnce() -> R) -> R {
    Arch::new().dispatch(computation)
}

/// Adding this rounds to an integer, which then stands in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// `exp(x)` for `x <= 0`; relative error below 1e-14 above -690, and about 1e-300 below.
#[inline(always)]
#[allow(clippy::inline_always, reason = "must be compiled inside the vectorised loop")]
pub fn exp(x: f64) -> f64 {
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_588e-10;
    let x = if x < -690.0 { -690.0 } else { x };
    let shifted = x.mul_add(std::f64::consts::LOG2_E, ROUND);
    let n = shifted - ROUND;
    let r = n.mul_add(-LN2_LOW, n.mul_add(-LN2_HIGH, x));
    // Taylor series to r^12, |r| <= 0.347: remainder below 2e-16.
    let mut p: f64 = 1.0 / 479_001_600.0;
    for c in [
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ] {
        p = p.mul_add(r, c);
    }
    p * f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52)
}

/// `(sin x, cos x)` for |x| up to about 1e5; absolute error below 1e-12.
#[inline(always)]
#[allow(clippy::inline_always, reason = "must be compiled inside the vectorised loop")]
pub fn sin_cos(x: f64) -> (f64, f64) {
    const PI_HIGH: f64 = std::f64::consts::PI;
    const PI_LOW: f64 = 1.224_646_799_147_353_2e-16;
    let shifted = x.mul_add(std::f64::consts::FRAC_1_PI, ROUND);
    let n = shifted - ROUND;
    let r = n.mul_add(-PI_LOW, n.mul_add(-PI_HIGH, x));
    let sign = shifted.to_bits() << 63;
    let s = r * r;
    // Taylor series to r^19 and r^18, |r| <= pi/2.
    let mut a: f64 = -1.0 / 121_645_100_408_832_000.0;
    for c in [
        1.0 / 355_687_428_096_000.0,
        -1.0 / 1_307_674_368_000.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 39_916_800.0,
        1.0 / 362_880.0,
        -1.0 / 5_040.0,
        1.0 / 120.0,
        -1.0 / 6.0,
        1.0,
    ] {
        a = a.mul_add(s, c);
    }
    let mut b: f64 = -1.0 / 6_402_373_705_728_000.0;
    for c in [
        1.0 / 20_922_789_888_000.0,
        -1.0 / 87_178_291_200.0,
        1.0 / 479_001_600.0,
        -1.0 / 3_628_800.0,
        1.0 / 40_320.0,
        -1.0 / 720.0,
        1.0 / 24.0,
        -0.5,
        1.0,
    ] {
        b = b.mul_add(s, c);
    }
    (f64::from_bits((a * r).to_bits() ^ sign), f64::from_bits(b.to_bits() ^ sign))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agree_with_the_standard_library() {
        for i in 0..20_000 {
            let x = -0.034 * f64::from(i);
            let (own, exact) = (wide(|| exp(x)), x.exp());
            assert!((own / exact - 1.0).abs() < 1e-14, "exp({x}) = {own}, {exact}");
            let y = 0.37 * f64::from(i - 10_000);
            let (s, c) = wide(|| sin_cos(y));
            assert!((s - y.sin()).abs() < 1e-12 && (c - y.cos()).abs() < 1e-12, "{y}: {s} {c}");
        }
        assert!(wide(|| exp(-1e9)) < 1e-290);
        assert_eq!(wide(|| exp(0.0)), 1.0);
    }
}
