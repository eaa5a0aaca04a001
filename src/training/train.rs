//! The whole training: judge all methods on held-out movement, then learn the chosen one on all.
//!
//! ```text
//! Dataset ─ evaluate ─► quality of every method
//!         ─ all frames ─► z and W, attraction, postures
//!         ─ unseen residuals (with the attraction) ─► noise
//! ```

use super::dataset::{Dataset, Frame};
use super::evaluate::evaluate;
use super::methods::{Law, learn_laws};
use super::settings::TrainSettings;
use super::spread::{learn_attraction, learn_noise, learn_postures, unseen_residuals};
use crate::files::InputError;
use crate::posture::{Attraction, Method, Noise, PostureDistribution, PostureModel, Provenance};
use nalgebra::{DMatrix, DVector};

/// Significant digits kept of learned numbers, and of scores. Fewer than computed, so that the file
/// does not depend on the rounding of one processor.
const DIGITS: i32 = 9;
const SCORE_DIGITS: i32 = 5;

/// Learns a posture model.
///
/// # Errors
/// Where a setting is out of range or the chain is singular in the data.
pub fn train(
    dataset: &Dataset,
    name: &str,
    method: Method,
    settings: &TrainSettings,
    provenance: Provenance,
) -> Result<PostureModel, InputError> {
    settings.check()?;
    let mut quality = evaluate(dataset, &dataset.held_out(), settings)?;
    for q in &mut quality {
        for value in [
            &mut q.relative_rmse,
            &mut q.rmse_rad_s,
            &mut q.log_likelihood_null,
            &mut q.log_likelihood,
        ] {
            *value = rounded(*value, SCORE_DIGITS);
        }
        q.path_error_deg =
            q.path_error_deg.map(|(a, b)| (rounded(a, SCORE_DIGITS), rounded(b, SCORE_DIGITS)));
    }
    let all: Vec<&Frame> = dataset.frames.iter().collect();
    let laws = learn_laws(&[method], &all, settings, None)?;
    let noise = unseen_residuals(dataset, &dataset.blocks(), &laws, settings, true)?
        .first()
        .map_or_else(|| Noise::none(dataset.joints.len()), |r| learn_noise(r));
    let attraction = learn_attraction(dataset, &all, settings);
    let law = laws.into_iter().next().ok_or_else(|| InputError::new(name, "has no law"))?;
    let mut provenance = provenance;
    provenance.settings.extend(described(settings, &law, &noise));
    provenance.notes.extend(notes(dataset, &all, &law, settings));
    let postures = learn_postures(&all);
    let mut model = bare_model(dataset, law, attraction);
    name.clone_into(&mut model.name);
    model.weight = symmetric(&rounded_matrix(&model.weight));
    model.noise = Noise {
        factor: rounded_matrix(&noise.factor),
        correlation_time_s: rounded(noise.correlation_time_s, DIGITS),
        speed_floor_m_s: noise.speed_floor_m_s,
    };
    model.postures = PostureDistribution {
        mean: postures.mean.map(|v| rounded(v, DIGITS)),
        covariance: symmetric(&rounded_matrix(&postures.covariance)),
    };
    model.quality = quality;
    model.provenance = provenance;
    Ok(model)
}

/// A model of a law alone, for rollouts without noise.
pub(super) fn bare_model(
    dataset: &Dataset,
    law: Law,
    attraction: Option<Attraction>,
) -> PostureModel {
    let n = dataset.joints.len();
    PostureModel {
        name: String::new(),
        method: law.method,
        side: dataset.side,
        size: dataset.size,
        joints: dataset.joints.clone(),
        weight: law.weight,
        attraction,
        gp: law.gp,
        noise: Noise::none(n),
        postures: PostureDistribution {
            mean: DVector::zeros(n),
            covariance: DMatrix::identity(n, n),
        },
        quality: Vec::new(),
        provenance: Provenance {
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            simulated: false,
            recordings: Vec::new(),
            body: (String::new(), String::new()),
            settings: Vec::new(),
            notes: Vec::new(),
        },
    }
}

fn described(settings: &TrainSettings, law: &Law, noise: &Noise) -> Vec<(String, String)> {
    let mut list = vec![("method", law.method.name().to_owned())];
    if let Some(a) = law.shrinkage {
        list.push(("shrinkage", a.to_string()));
        list.push(("diagonal_share", settings.diagonal_share.to_string()));
    }
    if settings.has_attraction {
        list.push(("attraction_rate_per_s", settings.attraction_rate_per_s.to_string()));
        list.push(("attraction_length", settings.attraction_length.to_string()));
        list.push(("attraction_noise", settings.attraction_noise.to_string()));
        list.push(("attraction_postures", settings.attraction_postures.to_string()));
    }
    if let Some(gp) = &law.gp {
        let h = gp.hyper;
        list.push(("gp_samples", settings.gp_samples.to_string()));
        list.push(("gp_length_posture", format!("{:.4}", h.length_posture)));
        list.push(("gp_length_velocity", format!("{:.4}", h.length_velocity)));
        list.push(("gp_noise_ratio", format!("{:.4}", h.noise_ratio)));
    }
    list.push(("noise_speed_floor_m_s", noise.speed_floor_m_s.to_string()));
    list.into_iter().map(|(k, v)| (k.to_owned(), v)).collect()
}

fn notes(dataset: &Dataset, frames: &[&Frame], law: &Law, settings: &TrainSettings) -> Vec<String> {
    let mut notes = vec![if dataset.trials > 1 {
        format!("judged on whole trials held out, {} in all", dataset.trials)
    } else {
        "judged on the last part of the only trial: the first 70 % of the time trained, 0.5 s were \
         left out; what differs between repetitions is not known from one trial"
            .to_owned()
    }];
    let sparse = frames.iter().filter(|f| f.is_sparse).count();
    if law.method == Method::MiNsgp && sparse > settings.gp_samples {
        notes.push(format!(
            "mi-nsgp learned from {} of {sparse} frames, evenly spread",
            settings.gp_samples
        ));
    }
    notes
}

/// `value` with a number of significant digits.
fn rounded(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    // Through decimal text: the nearest number that prints with so many digits.
    let text = format!("{value:.*e}", digits.unsigned_abs() as usize - 1);
    text.parse().unwrap_or(value)
}

fn rounded_matrix(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    matrix.map(|v| rounded(v, DIGITS))
}

/// The upper triangle decides, so that rounding leaves the matrix symmetric.
fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i.min(j), i.max(j))])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_keeps_significant_digits() {
        assert_eq!(rounded(1.234_567_890_123, 5), 1.2346);
        assert_eq!(rounded(-0.000_123_456_7, 3), -0.000_123);
        assert_eq!(rounded(0.0, 3), 0.0);
    }
}
