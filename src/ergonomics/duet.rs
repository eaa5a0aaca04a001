//! DUET, the distal upper extremity tool: what a day of hand exertions does to tendons of hand, wrist and elbow.
//!
//! Gallagher, Schall, Sesek and Huangfu, Human Factors 60:1146-1162, 2018. An exertion is rated by the worker or
//! an expert on the OMNI-RES scale (0 extremely easy, 10 extremely hard):
//!
//! ```text
//! S     stress, % of ultimate tendon strength: 71.4 at 10, in proportion; 3.6 at 0 (table 1)
//! N   = 10^((101.25 - S) / 14.83)     exertions to failure, human tendons (Schechtman and Bader 1997)
//! CD  = sum over tasks of n / N       cumulative damage of n exertions a day (Palmgren and Miner)
//! P   = 1 / (1 + exp(-(0.573 + 0.747 log10 CD)))   eq. 6: injury, and pain in the last year
//! ```
//!
//! `P` is the share of people with that outcome at that damage, by 1022 people in 738 jobs of car makers; it is
//! no forecast for a person. Posture, vibration and contact stress do not enter. The constants were checked against a
//! summary of the paper and two published examples, not against its pages.

/// Where formulas and examples were checked; for reports.
pub const DUET_PROVENANCE: &str = "DUET (Gallagher, Schall, Sesek and Huangfu, Human Factors 60:1146-1162, 2018): table 1 and \
     equation 6 checked against a summary of the paper and two published examples, not against its printed pages.";

/// Stress of each OMNI-RES rating from 0 to 10, % of ultimate tendon strength, as table 1 rounds it.
const STRESS: [f64; 11] = [3.6, 7.1, 14.3, 21.4, 28.6, 35.7, 42.9, 50.0, 57.1, 64.3, 71.4];

/// Damage of one exertion of an OMNI-RES rating; none above 10.
pub fn duet_damage(omni_res: u8) -> Option<f64> {
    let stress = STRESS.get(usize::from(omni_res))?;
    Some(10f64.powf((stress - 101.25) / 14.83))
}

/// Share of people with the outcome "injury, and pain in the last year" at a day's cumulative damage; 0 without
/// any.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::{duet_damage, duet_probability};
/// // 5400 easy exertions a day (rating 2): cumulative damage 0.0074, 26.5 %.
/// let damage = 5400.0 * duet_damage(2).unwrap();
/// assert!((damage - 0.0074).abs() < 5e-5);
/// assert!((duet_probability(damage) - 0.265).abs() < 5e-4);
/// ```
pub fn duet_probability(cumulative_damage: f64) -> f64 {
    if cumulative_damage <= 0.0 {
        return 0.0;
    }
    let y = 0.573 + 0.747 * cumulative_damage.log10();
    1.0 / (1.0 + (-y).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 1 of the paper: exertions to failure.
    #[test]
    fn the_table_of_the_paper() {
        let printed = [
            3_842_605.0,
            2_231_607.0,
            729_651.0,
            242_301.0,
            79_223.0,
            26_308.0,
            8_602.0,
            2_856.0,
            949.0,
            310.0,
            103.0,
        ];
        for (rating, printed) in (0u8..).zip(printed) {
            let ours = 1.0 / duet_damage(rating).unwrap();
            assert!((ours - printed).abs() < 1.0, "{rating}: {ours} {printed}");
        }
        assert_eq!(duet_damage(11), None);
    }

    /// The example of the paper (fig. 2): rating 2, 5400 times, 26.5 %; and one of the tool's Flemish guide: rating 4,
    /// 1350 times, 32.1 %.
    #[test]
    fn two_published_examples() {
        for (rating, times, printed) in [(2, 5400.0, 0.265), (4, 1350.0, 0.321)] {
            let p = duet_probability(times * duet_damage(rating).unwrap());
            assert!((p - printed).abs() < 5e-4, "{rating}: {p}");
        }
    }

    #[test]
    fn more_is_worse_and_nothing_is_nothing() {
        let of = |rating, times: f64| duet_probability(times * duet_damage(rating).unwrap());
        assert!((1..=10).all(|r| of(r, 100.0) > of(r - 1, 100.0)));
        assert!(of(3, 200.0) > of(3, 100.0));
        assert_eq!((of(5, 0.0), duet_probability(f64::NAN).is_nan()), (0.0, true));
        assert!((0.99..=1.0).contains(&duet_probability(1e9)));
    }
}
