//! Values that each stand for some time.

/// Values with weights, in ascending order.
pub(super) struct Weighted {
    pairs: Vec<(f64, f64)>,
    total: f64,
}

impl Weighted {
    pub(super) fn new(mut pairs: Vec<(f64, f64)>) -> Self {
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total = pairs.iter().map(|p| p.1).sum();
        Self { pairs, total }
    }

    pub(super) fn mean(&self) -> f64 {
        self.pairs.iter().map(|(v, w)| v * w).sum::<f64>() / self.total
    }

    /// The smallest value that at least a share `p` of the time does not exceed.
    pub(super) fn quantile(&self, p: f64) -> f64 {
        let mut below = 0.0;
        for (value, weight) in &self.pairs {
            below += weight;
            if below >= p * self.total - 1e-12 * self.total {
                return *value;
            }
        }
        self.pairs.last().map_or(f64::NAN, |l| l.0)
    }

    /// Share of the time for which a claim holds.
    pub(super) fn share(&self, claim: impl Fn(f64) -> bool) -> f64 {
        let time = self.pairs.iter().filter(|(v, _)| claim(*v)).map(|(_, w)| w).sum::<f64>();
        // The sum of nothing is -0.
        (time + 0.0) / self.total
    }

    /// The value farthest from zero.
    pub(super) fn farthest(&self) -> f64 {
        let far = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        self.pairs.iter().map(|p| p.0).fold(0.0, far)
    }
}

/// Share of the time at each score from 1 to `most`.
pub(super) fn shares(scores: &Weighted, most: u8) -> Vec<f64> {
    (1..=most).map(|k| scores.share(|v| v == f64::from(k))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_weighs() {
        let all = Weighted::new(vec![(7.0, 1.0), (1.0, 3.0), (-9.0, 0.0)]);
        assert!((all.mean() - 2.5).abs() < 1e-12);
        assert_eq!((all.quantile(0.5), all.quantile(0.75), all.quantile(0.76)), (1.0, 1.0, 7.0));
        assert_eq!(all.farthest(), -9.0);
        assert_eq!(shares(&all, 7), [0.75, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25]);
    }
}
