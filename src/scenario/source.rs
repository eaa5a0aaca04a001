//! The text behind a scenario: refusals that show the place, and the values that every part needs.

use super::file::PoseFile;
use super::plausible::{self, Doubt, FARTHEST_M};
use crate::files::InputError;
use crate::math::{Pose, Vec3};
use nalgebra::{Quaternion, UnitQuaternion};
use std::cell::RefCell;
use std::path::Path;
use toml::Spanned;

/// The text behind a scenario, for errors that show the place.
pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    pub folder: &'a Path,
    /// What looks odd and may be meant.
    pub doubts: RefCell<Vec<Doubt>>,
}

impl Source<'_> {
    pub(super) fn error<T>(&self, at: &Spanned<T>, message: impl Into<String>) -> InputError {
        InputError::new(self.path, message).at(self.text, at.span())
    }

    /// The error of another file that a value names.
    pub(super) fn named<T>(&self, at: &Spanned<T>, key: &str, error: InputError) -> InputError {
        error.named_in(self.path, key, self.text, at.span())
    }

    /// A refusal that asks.
    pub(super) fn question(&self, doubt: &Doubt) -> InputError {
        doubt.question(self.path)
    }

    /// Keeps a doubt as a warning.
    pub(super) fn doubt(&self, doubt: Option<Doubt>) {
        self.doubts.borrow_mut().extend(doubt);
    }

    /// The place in the text of an error, for values whose own place is not kept.
    pub(super) fn at<T>(&self, at: &Spanned<T>, error: InputError) -> InputError {
        error.at(self.text, at.span())
    }

    pub(super) fn plain(&self, message: impl Into<String>) -> InputError {
        InputError::new(self.path, message)
    }

    /// A finite number in a range.
    pub(super) fn number(
        &self,
        at: &Spanned<f64>,
        key: &str,
        low: f64,
        high: f64,
    ) -> Result<f64, InputError> {
        let value = *at.get_ref();
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        Err(self
            .error(at, format!("{key} = {value} is outside {low} to {high}"))
            .remedy("check value and unit: metres, seconds, kilograms; degrees only in keys that end in _deg"))
    }

    pub(super) fn pose(&self, at: &Spanned<PoseFile>, key: &str) -> Result<Pose, InputError> {
        self.pose_of(at.get_ref(), key).map_err(|e| e.at(self.text, at.span()))
    }

    pub(super) fn pose_of(&self, pose: &PoseFile, key: &str) -> Result<Pose, InputError> {
        let position = Vec3::from(pose.position_m);
        self.refuse_far(&format!("{key}.position_m"), &pose.position_m)?;
        let rotation = self.rotation(pose.rpy_deg, pose.quaternion_wxyz, key)?;
        Ok(Pose::from_parts(position.into(), rotation))
    }

    /// Refuses coordinates that no cell has.
    pub(super) fn refuse_far(&self, key: &str, position_m: &[f64]) -> Result<(), InputError> {
        match position_m.iter().find(|v| v.is_nan() || v.abs() > FARTHEST_M) {
            Some(&value) => {
                Err(self.question(&Doubt::Millimetres { place: key.to_owned(), value }))
            }
            None => Ok(()),
        }
    }

    fn rotation(
        &self,
        rpy_deg: Option<[f64; 3]>,
        quaternion: Option<[f64; 4]>,
        key: &str,
    ) -> Result<UnitQuaternion<f64>, InputError> {
        match (rpy_deg, quaternion) {
            (Some(_), Some(_)) => Err(self
                .plain(format!("{key} has both rpy_deg and quaternion_wxyz"))
                .remedy("keep one of them")),
            (Some(rpy), None) => {
                if !rpy.iter().all(|v| v.abs() <= 720.0) {
                    let message = format!("{key}.rpy_deg = {rpy:?} is not plausible");
                    return Err(self.plain(message).remedy("angles are in degrees"));
                }
                self.doubt(plausible::radians(&format!("{key}.rpy_deg"), &rpy));
                let [r, p, y] = rpy.map(f64::to_radians);
                Ok(UnitQuaternion::from_euler_angles(r, p, y))
            }
            (None, Some([w, x, y, z])) => {
                let q = Quaternion::new(w, x, y, z);
                if !(0.99..=1.01).contains(&q.norm()) {
                    let message = format!("{key}.quaternion_wxyz has norm {:.4}, not 1", q.norm());
                    return Err(self.plain(message).remedy("the scalar part w comes first"));
                }
                Ok(UnitQuaternion::new_normalize(q))
            }
            (None, None) => Ok(UnitQuaternion::identity()),
        }
    }
}
