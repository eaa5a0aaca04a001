//! The poses of the hands that hold on: one, or two.

use crate::math::Pose;

/// Grip poses in one frame: of the leading hand, and of the other where both hold on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grips {
    /// Of the leading hand.
    pub first: Pose,
    /// Of the other hand.
    pub second: Option<Pose>,
}

impl From<Pose> for Grips {
    fn from(first: Pose) -> Self {
        Self { first, second: None }
    }
}

impl From<&Pose> for Grips {
    fn from(first: &Pose) -> Self {
        (*first).into()
    }
}

impl From<&Self> for Grips {
    fn from(grips: &Self) -> Self {
        *grips
    }
}

impl Grips {
    /// One after the other.
    pub fn iter(&self) -> impl Iterator<Item = &Pose> {
        std::iter::once(&self.first).chain(self.second.as_ref())
    }

    /// Each changed alike.
    #[must_use]
    pub fn map(&self, change: impl Fn(&Pose) -> Pose) -> Self {
        Self { first: change(&self.first), second: self.second.as_ref().map(change) }
    }

    /// Each with that of another of as many hands.
    #[must_use]
    pub fn zip(&self, other: &Self, change: impl Fn(&Pose, &Pose) -> Pose) -> Self {
        let second = self.second.as_ref().zip(other.second.as_ref()).map(|(a, b)| change(a, b));
        Self { first: change(&self.first, &other.first), second }
    }
}
