//! One model for other contacts than it was learned with: on a seat, on a pelvis that rests, with both
//! hands.
//!
//! What a seat holds (`a`, of the chain's coordinates) is known to stay at zero; the rest (`b`) is what the
//! model says given that:
//!
//! ```text
//! W' = W_bb - W_ba W_aa^-1 W_ab       m' = m_b - S_ba S_aa^-1 m_a       F' = F_b - C_ba C_aa^-1 F_a
//! ```

use super::model::PostureModel;
use super::modes::{Mode, Modes};
use super::pair::Pair;
use crate::human::{PELVIS_JOINTS, Pelvis};
use nalgebra::DMatrix;

/// Why a model cannot be used with other contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unsuitable {
    /// Its Gaussian process or primitive speaks of the contacts of its recordings only.
    Method,
    /// A matrix of it is not positive definite.
    Singular,
}

impl PostureModel {
    /// How the pelvis takes part in the movements it was learned from.
    pub fn pelvis(&self) -> Pelvis {
        match PELVIS_JOINTS.iter().filter(|p| self.joints.iter().any(|j| j == *p)).count() {
            0 => Pelvis::Rests,
            3 => Pelvis::Turns,
            _ => Pelvis::Moves,
        }
    }

    /// The same model on a pelvis with fewer free coordinates (never more), and for both hands where it
    /// was learned with one.
    ///
    /// # Errors
    /// Where the method does not allow it.
    pub fn adapted(&self, pelvis: Pelvis, both_hands: bool) -> Result<Self, Unsuitable> {
        let held = self.pelvis().free().saturating_sub(pelvis.free());
        if held == 0 && !both_hands {
            return Ok(self.clone());
        }
        let law = &self.law;
        if !law.processes.is_empty() || law.primitive.is_some() || law.is_direct {
            return Err(Unsuitable::Method);
        }
        let mut model = Self { modes: None, ..self.clone() };
        if held > 0 {
            model.hold(held).ok_or(Unsuitable::Singular)?;
        }
        if both_hands {
            model.pair().ok_or(Unsuitable::Singular)?;
        }
        // Modes go by where the feet stand: who sits has none.
        if let Some(modes) = self.modes.as_ref().filter(|_| held == 0) {
            let of = |mode: &Mode| {
                let (law, postures) = (mode.law.clone(), mode.postures.clone());
                let own = Self { law, postures, modes: None, ..self.clone() };
                let Self { law, postures, .. } = own.adapted(pelvis, both_hands)?;
                Ok(Mode { law, postures, ..*mode })
            };
            let all = modes.all.iter().map(of).collect::<Result<_, _>>()?;
            model.modes = Some(Modes { all, ..modes.clone() });
        }
        Ok(model)
    }

    /// Keeps the first `a` coordinates at zero and leaves them out.
    fn hold(&mut self, a: usize) -> Option<()> {
        let weights = slopes(&self.law.weight, a)?;
        self.law.weight = rest(&self.law.weight, a, &weights);
        if let Some(offset) = &self.law.offset {
            self.law.offset =
                Some(offset.rows_range(a..).into_owned() - &weights * offset.rows(0, a));
        }
        let spread = &self.postures.covariance.clone();
        let by_posture = slopes(spread, a)?;
        let by_place = match &self.postures.about_usual {
            Some(about) => slopes(about, a)?,
            None => by_posture.clone(),
        };
        if let Some(about) = &mut self.postures.about_usual {
            *about = rest(about, a, &by_place);
        }
        if let Some(low) = &mut self.postures.low {
            let by_place = slopes(&low.about_usual, a)?;
            low.about_usual = rest(&low.about_usual, a, &by_place);
        }
        let mean = &self.postures.mean;
        let (held, free) = (mean.rows(0, a).into_owned(), mean.rows_range(a..).into_owned());
        self.postures.covariance = rest(spread, a, &by_posture);
        self.postures.mean = free - &by_posture * held;
        if let Some(attraction) = &mut self.law.attraction {
            *attraction = attraction.regressed(|rows| {
                let (held, free) = (rows.columns(0, a), rows.columns_range(a..));
                free - held * by_place.transpose()
            });
        }
        let factor = &self.law.noise.factor;
        let covariance = factor * factor.transpose();
        // Noise that leaves what is held alone, or nearly, has nothing to say about the rest.
        let floor = 1e-9 * covariance.trace().max(f64::MIN_POSITIVE);
        let floored = &covariance + DMatrix::identity(factor.nrows(), factor.nrows()) * floor;
        let by_noise = slopes(&floored, a)?;
        self.law.noise.factor = factor.rows_range(a..) - by_noise * factor.rows(0, a);
        if let Some(low) = &mut self.law.noise.low {
            low.high = low.high.rows_range(a..).into_owned();
            low.low = low.low.rows_range(a..).into_owned();
        }
        self.joints.drain(..a);
        Some(())
    }

    /// Makes it speak of both hands.
    fn pair(&mut self) -> Option<()> {
        let pair = Pair::new(&self.joints);
        self.law.weight = pair.covariance(&self.law.weight)?;
        self.law.offset = None;
        self.postures = pair.postures(&self.postures)?;
        let factor = &self.law.noise.factor;
        let mut noise = factor * factor.transpose();
        let floor = 1e-9 * noise.trace().max(f64::MIN_POSITIVE);
        for i in 0..noise.nrows() {
            noise[(i, i)] += floor;
        }
        let eigen = pair.covariance(&noise)?.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let kept: Vec<usize> = (0..eigen.eigenvalues.len())
            .filter(|&i| eigen.eigenvalues[i] > 1e-6 * largest)
            .collect();
        self.law.noise.factor = DMatrix::from_fn(eigen.eigenvalues.len(), kept.len(), |r, c| {
            eigen.eigenvectors[(r, kept[c])] * eigen.eigenvalues[kept[c]].sqrt()
        });
        if let Some(low) = &mut self.law.noise.low {
            low.high = pair.sizes(&low.high);
            low.low = pair.sizes(&low.low);
        }
        self.joints = pair.joints(&self.joints);
        self.law.pair = Some(pair);
        Some(())
    }
}

/// `M_ba M_aa^-1`.
pub(super) fn slopes(matrix: &DMatrix<f64>, a: usize) -> Option<DMatrix<f64>> {
    let b = matrix.nrows() - a;
    let factor = matrix.view((0, 0), (a, a)).into_owned().cholesky()?;
    Some(factor.solve(&matrix.view((0, a), (a, b)).into_owned()).transpose())
}

/// `M_bb - M_ba M_aa^-1 M_ab`.
pub(super) fn rest(matrix: &DMatrix<f64>, a: usize, slopes: &DMatrix<f64>) -> DMatrix<f64> {
    let b = matrix.nrows() - a;
    let rest = matrix.view((a, a), (b, b)) - slopes * matrix.view((0, a), (a, b));
    (&rest + rest.transpose()) * 0.5
}
