//! The values of all parameters at one place of the unfolded tree.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use crate::ParamId;

/// The values of all parameters at one place of the unfolded tree.
///
/// Cloning shares the values; [`set`](Self::set) copies them. Two environments are equal when their values are, bit by
/// bit (−0 is stored as 0, so that both zeros are one state).
///
/// A parameter without a value is *unset*: never assigned, or blanked because nothing below can read it.
#[derive(Clone, Debug)]
pub struct Env(Arc<[f64]>);

/// The value of an unset parameter. No calculation gives it: a result that is not a number is an error.
const UNSET: f64 = f64::NAN;

impl Env {
    /// An environment of `count` unset parameters.
    pub fn unset(count: usize) -> Self {
        Self(std::iter::repeat_n(UNSET, count).collect())
    }

    /// One more parameter, unset.
    pub(crate) fn extend(&mut self) {
        self.0 = self.0.iter().copied().chain([UNSET]).collect();
    }

    /// The value of `param`, or `None` while it is unset.
    ///
    /// # Panics
    /// If there are fewer parameters: it is one of another graph.
    pub fn get(&self, param: ParamId) -> Option<f64> {
        let value = self.0[param.index()];
        (!value.is_nan()).then_some(value)
    }

    /// Gives `param` a value; not a number takes it away.
    ///
    /// # Panics
    /// As [`get`](Self::get).
    pub fn set(&mut self, param: ParamId, value: f64) {
        // Of all that is not a number only one is stored, as of both zeros: equality is by bits.
        Arc::make_mut(&mut self.0)[param.index()] = if value.is_nan() { UNSET } else { value + 0.0 };
    }

    /// Takes the value of `param` away.
    ///
    /// # Panics
    /// As [`get`](Self::get).
    pub fn blank(&mut self, param: ParamId) {
        Arc::make_mut(&mut self.0)[param.index()] = UNSET;
    }

    /// All values by the index of their parameter; not a number where unset.
    pub(crate) fn values(&self) -> &[f64] {
        &self.0
    }
}

impl PartialEq for Env {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
            || self.0.len() == other.0.len()
                && self.0.iter().zip(other.0.iter()).all(|(a, b)| a.to_bits() == b.to_bits())
    }
}

impl Eq for Env {}

impl Hash for Env {
    fn hash<H: Hasher>(&self, state: &mut H) {
        for value in self.0.iter() {
            value.to_bits().hash(state);
        }
    }
}
