//! One effect of a spindle file: its kind, its location and its values, checked against the table.

use super::kind::EffectKind;
use super::location::{Location, LocationKind};
use crate::spindle::SpindleError;

/// One effect of a spindle file.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// What it is.
    pub kind: EffectKind,
    /// Where it acts.
    pub location: Location,
    /// Its numbers, in the order and units of [`EffectKind::parameters`].
    pub values: Vec<f64>,
}

impl Effect {
    /// An effect that keeps the rules of its kind.
    ///
    /// # Errors
    /// [`SpindleError::Value`] or [`SpindleError::Name`] with a path relative to the effect.
    pub fn new(kind: EffectKind, location: Location, values: Vec<f64>) -> Result<Self, SpindleError> {
        let effect = Self { kind, location, values };
        effect.validate()?;
        Ok(effect)
    }

    /// The value of the parameter of that name; `None` when the kind has none.
    pub fn value(&self, parameter: &str) -> Option<f64> {
        let names = self.kind.parameters();
        let i = names.iter().position(|p| p.name == parameter)?;
        self.values.get(i).copied()
    }

    /// Checks location and numbers against the kind.
    pub(crate) fn validate(&self) -> Result<(), SpindleError> {
        let matches = matches!(
            (self.kind.location(), &self.location),
            (LocationKind::None, Location::None)
                | (LocationKind::Bearing, Location::Bearing(_))
                | (LocationKind::Across, Location::Across { from: 0..4, to: 0..4 })
                | (LocationKind::Position, Location::Position(_))
                | (LocationKind::Mode, Location::Mode(_))
                | (LocationKind::Region, Location::Region(_))
        ) || self.kind.entry().one_axis
            && matches!(
                (self.kind.location(), &self.location),
                (LocationKind::Bearing | LocationKind::None, Location::Axis(0..4))
                    | (LocationKind::Position, Location::InPlane(..))
            );
        if !matches {
            return Err(SpindleError::Name {
                path: "effect".into(),
                name: self.kind.name().into(),
                rule: match self.kind.location() {
                    LocationKind::None if self.kind.entry().one_axis => "takes no location, or one axis".into(),
                    LocationKind::None => "takes no location".into(),
                    LocationKind::Bearing if self.kind.entry().one_axis => {
                        "needs bearing: front, rear or both, or one axis".into()
                    }
                    LocationKind::Bearing => "needs bearing: front, rear or both".into(),
                    LocationKind::Across => "needs from and to, each an axis".into(),
                    LocationKind::Position if self.kind.entry().one_axis => {
                        "needs position_m, with axis: x or y where it acts in one plane".into()
                    }
                    LocationKind::Position => "needs position_m".into(),
                    LocationKind::Mode => "needs mode, counted from 1".into(),
                    LocationKind::Region => "needs region".into(),
                },
            });
        }
        if let Location::Mode(0) = self.location {
            return Err(SpindleError::Value {
                path: "mode".into(),
                value: 0.0,
                rule: "must be 1 or more: flexible modes are counted from 1".into(),
            });
        }
        let parameters = self.kind.parameters();
        if parameters.len() != self.values.len() {
            let names: Vec<&str> = parameters.iter().map(|p| p.name).collect();
            return Err(SpindleError::Name {
                path: "effect".into(),
                name: self.kind.name().into(),
                rule: format!("needs the parameters {}", names.join(", ")),
            });
        }
        for (parameter, value) in parameters.iter().zip(&self.values) {
            let rule = if !value.is_finite() {
                "must be a number"
            } else if parameter.positive && *value <= 0.0 {
                "must be positive"
            } else {
                continue;
            };
            return Err(SpindleError::Value { path: parameter.name.into(), value: *value, rule: rule.into() });
        }
        Ok(())
    }
}
