//! Healing, for those who may not know the stages.

pub use crate::heal::{Action, Defect, HealOptions, HealReport, Healed, Repair, heal};
