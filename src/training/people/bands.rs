//! What bands of repetitions hold of a record, how wide they are, and proper scores of the whole distribution.

use super::super::rollout_check::band_end;
use super::super::strangers::mean_energy_deg;
use super::{FEATURES, Features};
use serde::Serialize;

/// What bands of one feature held.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FeatureScore {
    /// Name.
    pub feature: &'static str,
    /// Share of the frames inside the central 50 and 90 %.
    pub coverage: [f64; 2],
    /// Mean width of the 90 % band, cm or deg.
    pub width_90: f64,
    /// Continuous ranked probability score, mean over time, cm or deg; none for fewer than two repetitions.
    pub crps: Option<f64>,
}

/// What repetitions of strangers say of a movement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bands {
    /// Bands.
    pub features: Vec<FeatureScore>,
    /// Mean energy score of the four angles, deg.
    pub energy_deg: f64,
    /// Share of the repetitions that could not follow the hand to its end.
    pub ended_share: f64,
}

/// A difference in the unit of the scores: of hips, leg lengths become cm of a leg of `leg_m`.
pub(super) fn in_units(difference: f64, feature: usize, leg_m: f64) -> f64 {
    if feature == 0 { 100.0 * leg_m * difference } else { difference }
}

impl Bands {
    /// Of repetitions (R x T) against the record (T), in a body with legs of `leg_m`.
    pub(super) fn of(
        walks: &[Vec<Features>],
        seen: &[Features],
        leg_m: f64,
        ended_share: f64,
    ) -> Self {
        if walks.len() < 2 {
            let none =
                |feature| FeatureScore { feature, coverage: [0.0; 2], width_90: 0.0, crps: None };
            let features = FEATURES.into_iter().map(none).collect();
            return Self { features, energy_deg: f64::NAN, ended_share };
        }
        let features = FEATURES.iter().enumerate().map(|(c, &feature)| {
            let (mut inside, mut width, mut ranked) = ([0.0; 2], 0.0, 0.0);
            for (t, seen) in seen.iter().enumerate() {
                let mut values: Vec<f64> = walks.iter().map(|w| w[t][c]).collect();
                values.sort_by(f64::total_cmp);
                let at = |p: f64| band_end(&values, p);
                let within =
                    |low: f64, high: f64| f64::from(u8::from((low..=high).contains(&seen[c])));
                inside[0] += within(at(0.25), at(0.75));
                inside[1] += within(at(0.05), at(0.95));
                width += in_units(at(0.95) - at(0.05), c, leg_m);
                ranked += in_units(crps(&values, seen[c]), c, leg_m);
            }
            let count = seen.len() as f64;
            FeatureScore {
                feature,
                coverage: inside.map(|i| i / count),
                width_90: width / count,
                crps: Some(ranked / count),
            }
        });
        let features = features.collect();
        Self { features, energy_deg: mean_energy_deg(walks, seen), ended_share }
    }
}

/// Continuous ranked probability score of draws (sorted, two or more) against what was seen: the mean distance to it
/// less half the mean distance between two of them (Gneiting and Raftery 2007, eq. 21).
fn crps(sorted: &[f64], seen: f64) -> f64 {
    let count = sorted.len() as f64;
    let to_seen = sorted.iter().map(|x| (x - seen).abs()).sum::<f64>() / count;
    // The i-th of them is above i others and below the rest.
    let above = |(i, x): (usize, &f64)| x * (2.0 * i as f64 + 1.0 - count);
    let between = sorted.iter().enumerate().map(above).sum::<f64>();
    to_seen - between / (count * (count - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_proper_scores_are_those_of_naive_loops() {
        let seen = vec![[0.0, 1.0, 2.0, 3.0, 4.0]; 2];
        let walks: Vec<Vec<Features>> =
            (0..5).map(|i| vec![[0.0, f64::from(i), 2.0, 3.0 - f64::from(i), 4.0]; 2]).collect();
        let found = Bands::of(&walks, &seen, 0.9, 0.0);
        // |x - y| is hypot(i - 1, i); |x - x'| is root two times |i - j|.
        let to: f64 =
            (0..5).map(|i| f64::hypot(f64::from(i) - 1.0, f64::from(i))).sum::<f64>() / 5.0;
        let mut between = 0.0;
        for i in 0..5 {
            for j in 0..5 {
                between += f64::from(i - j).abs() * 2f64.sqrt() / 20.0;
            }
        }
        let energy = found.energy_deg;
        assert!((energy - (to - 0.5 * between)).abs() < 1e-12, "{energy}");
        assert_eq!(found.features[3].coverage[1], 1.0);
        assert_eq!(found.features[2].width_90, 0.0);
        // Of the trunk: 0 to 4 against 1.
        let to: f64 = (0..5).map(|i| (f64::from(i) - 1.0).abs()).sum::<f64>() / 5.0;
        let crps = found.features[1].crps.unwrap();
        assert!((crps - (to - 0.5 * between / 2f64.sqrt())).abs() < 1e-12, "{crps}");
        // Hips in cm, and nothing to tell of a single repetition.
        let hips = vec![vec![[0.1, 0.0, 0.0, 0.0, 0.0]; 2]; 3];
        let found = Bands::of(&hips, &[[0.0; 5]; 2], 0.9, 0.0);
        assert!((found.features[0].crps.unwrap() - 9.0).abs() < 1e-12);
        assert!(Bands::of(&hips[..1], &seen, 0.9, 0.0).features[0].crps.is_none());
    }
}
