//! Does the paper's method lead, and is its W a fact about people? Counted set by set.

use super::result::SetResult;
use crate::math::stats::{mean, quantile, rank_correlation};
use crate::posture::Method;
use serde::Serialize;

/// MI-NsGP against another method, over training sets.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Against {
    /// The other method.
    pub other: Method,
    /// Training sets.
    pub sets: usize,
    /// In how many of them MI-NsGP has the smaller relative RMSE.
    pub rmse_better: usize,
    /// In how many it has the higher log-likelihood.
    pub ll_better: usize,
    /// In how many once both are rescaled in hindsight ([`MethodOnSet::ll_rescaled`](super::MethodOnSet)).
    pub ll_rescaled_better: usize,
    /// Median over sets of the ratio of its relative RMSE to the other's.
    pub rmse_ratio: f64,
    /// Median over sets of its log-likelihood less the other's, nats per frame.
    pub ll_gain: f64,
}

/// How far the weights that a method learned agree between training sets: logarithm of the diagonal of W, mean
/// zero over the joints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WeightAgreement {
    /// The method.
    pub method: Method,
    /// Rms over joints and sets of the logarithms: what W = I would be off by.
    pub spread: f64,
    /// Pairs of sets of one person, and of two people.
    pub pairs: [usize; 2],
    /// Mean over such pairs of the rms difference of the logarithms; none without pairs.
    pub difference: [Option<f64>; 2],
    /// Mean over such pairs of the rank correlation.
    pub rank_correlation: [Option<f64>; 2],
}

/// Against all other methods that were asked for; nothing without MI-NsGP.
pub(super) fn against(sets: &[SetResult]) -> Vec<Against> {
    let Some(first) = sets.first() else { return Vec::new() };
    let Some(own) = first.methods.iter().position(|m| m.method == Method::MiNsgp) else {
        return Vec::new();
    };
    let one = |i: usize| {
        let pairs: Vec<_> = sets.iter().map(|s| (&s.methods[own], &s.methods[i])).collect();
        let median = |of: &dyn Fn(usize) -> f64| {
            quantile(&(0..pairs.len()).map(of).collect::<Vec<f64>>(), 0.5)
        };
        Against {
            other: first.methods[i].method,
            sets: sets.len(),
            rmse_better: pairs
                .iter()
                .filter(|(a, b)| a.relative_rmse_q < b.relative_rmse_q)
                .count(),
            ll_better: pairs.iter().filter(|(a, b)| a.ll_q > b.ll_q).count(),
            ll_rescaled_better: pairs.iter().filter(|(a, b)| a.ll_rescaled > b.ll_rescaled).count(),
            rmse_ratio: median(&|s| pairs[s].0.relative_rmse_q / pairs[s].1.relative_rmse_q),
            ll_gain: median(&|s| pairs[s].0.ll_q - pairs[s].1.ll_q),
        }
    };
    (0..first.methods.len()).filter(|i| *i != own).map(one).collect()
}

/// Of each method that learns W.
pub(super) fn weight_agreement(sets: &[SetResult]) -> Vec<WeightAgreement> {
    let Some(first) = sets.first() else { return Vec::new() };
    (0..first.methods.len()).filter_map(|m| agreement(sets, m)).collect()
}

fn agreement(sets: &[SetResult], m: usize) -> Option<WeightAgreement> {
    let logs: Option<Vec<(&str, Vec<f64>)>> = sets
        .iter()
        .map(|s| {
            let own = s.methods[m].weights.as_ref()?;
            Some((s.who.as_str(), own.iter().map(|w| w.ln()).collect()))
        })
        .collect();
    let logs = logs?;
    let rms = |values: &[f64]| mean(&values.iter().map(|v| v * v).collect::<Vec<_>>()).sqrt();
    // Of one person, of two.
    let mut differences: [Vec<f64>; 2] = Default::default();
    let mut correlations: [Vec<f64>; 2] = Default::default();
    for (i, (who, a)) in logs.iter().enumerate() {
        for (other, b) in &logs[..i] {
            let kind = usize::from(who != other);
            let off: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            differences[kind].push(rms(&off));
            correlations[kind].extend(rank_correlation(a, b));
        }
    }
    let middle = |values: &Vec<f64>| (!values.is_empty()).then(|| mean(values));
    Some(WeightAgreement {
        method: sets.first()?.methods[m].method,
        spread: rms(&logs.iter().flat_map(|(_, l)| l.clone()).collect::<Vec<_>>()),
        pairs: [differences[0].len(), differences[1].len()],
        difference: [0, 1].map(|k| middle(&differences[k])),
        rank_correlation: [0, 1].map(|k| middle(&correlations[k])),
    })
}

#[cfg(test)]
mod tests {
    use super::super::result::{MethodOnSet, SetSize};
    use super::*;

    fn set(who: &str, figures: [(Method, f64, f64, Option<Vec<f64>>); 2]) -> SetResult {
        let size = SetSize { people: 1, movements: 1, frames: 1 };
        let of = |(method, relative_rmse_q, ll_q, weights)| MethodOnSet {
            method,
            relative_rmse_q,
            ll_q,
            surprise: 1.0,
            ll_rescaled: -ll_q,
            weights,
            bands: None,
            movements: Vec::new(),
        };
        SetResult {
            who: who.to_owned(),
            task: String::new(),
            train: size,
            test: size,
            rank: 1.0,
            methods: figures.map(of).to_vec(),
        }
    }

    #[test]
    fn wins_are_counted_and_weights_compared_within_and_between_people() {
        let (own, full) = (Method::MiNsgp, Method::FullW);
        let e = std::f64::consts::E;
        let sets = [
            set("a", [(own, 0.4, 10.0, Some(vec![e, 1.0 / e])), (full, 0.5, 11.0, None)]),
            set("a", [(own, 0.6, 10.0, Some(vec![1.0, 1.0])), (full, 0.5, 9.0, None)]),
            set("b", [(own, 0.2, 8.0, Some(vec![e, 1.0 / e])), (full, 0.5, 9.0, None)]),
        ];
        let found = against(&sets);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].other, found[0].sets), (full, 3));
        assert_eq!((found[0].rmse_better, found[0].ll_better), (2, 1));
        assert_eq!(found[0].ll_rescaled_better, 2);
        assert!((found[0].rmse_ratio - 0.8).abs() < 1e-12 && found[0].ll_gain == -1.0);
        let weights = weight_agreement(&sets);
        assert_eq!((weights.len(), weights[0].method, weights[0].pairs), (1, own, [1, 2]));
        assert!((weights[0].difference[0].unwrap() - 1.0).abs() < 1e-12);
        assert!((weights[0].difference[1].unwrap() - 0.5).abs() < 1e-12);
        assert!((weights[0].spread - (2.0f64 / 3.0).sqrt()).abs() < 1e-12);
        // Weights that are all alike have no order.
        assert_eq!(weights[0].rank_correlation, [None, Some(1.0)]);
        assert!(against(&[]).is_empty() && weight_agreement(&[]).is_empty());
    }
}
