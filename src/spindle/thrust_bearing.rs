//! The magnet of the thrust axis as a spindle file has it, and the rules of its numbers.

use super::rule::{BrokenRules, positive, rule};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The magnet that holds the shaft along its axis; `thrust` of a spindle file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ThrustBearing {
    /// Force per control current of both coils in difference.
    pub ki_n_per_a: f64,
    /// Negative stiffness, as a positive number.
    pub ks_n_per_m: f64,
    /// Bias current.
    pub bias_current_a: f64,
    /// Largest coil current.
    pub max_current_a: f64,
    /// Air gap on each side of the disc.
    pub gap_m: f64,
    /// Mass that it carries; that of rotor and tool unless given.
    #[serde(default)]
    pub mass_kg: Option<f64>,
    /// Mass of a flexible thrust disc, a part of the mass carried; with `disc_mode_hz`.
    #[serde(default)]
    pub disc_mass_kg: Option<f64>,
    /// Natural frequency of the flexible disc on a shaft that is held; with `disc_mass_kg`.
    #[serde(default)]
    pub disc_mode_hz: Option<f64>,
    /// Damping ratio of that mode.
    #[serde(default)]
    pub disc_damping_ratio: Option<f64>,
    /// Corner of the eddy currents in a solid core; none unless given.
    #[serde(default)]
    pub eddy_corner_hz: Option<f64>,
}

/// Damping ratio of a thrust disc that says none: that of a shrink fit, at its low end.
pub(super) const DISC_DAMPING_RATIO: f64 = 0.002;

impl ThrustBearing {
    /// Notes every rule that the magnet breaks.
    pub(super) fn check(&self, broken: &mut BrokenRules) {
        let path = |key: &str| format!("thrust.{key}");
        let given = [
            ("ki_n_per_a", Some(self.ki_n_per_a)),
            ("bias_current_a", Some(self.bias_current_a)),
            ("max_current_a", Some(self.max_current_a)),
            ("gap_m", Some(self.gap_m)),
            ("mass_kg", self.mass_kg),
            ("disc_mass_kg", self.disc_mass_kg),
            ("disc_mode_hz", self.disc_mode_hz),
            ("eddy_corner_hz", self.eddy_corner_hz),
        ];
        for (key, value) in given.into_iter().filter_map(|(key, value)| Some((key, value?))) {
            broken.note(positive(&path(key), value));
        }
        let ks = "must be zero or a positive number: negative stiffness is given as a positive number";
        broken.note(rule(self.ks_n_per_m >= 0.0, path("ks_n_per_m"), self.ks_n_per_m, ks));
        let current = "must be larger than thrust.bias_current_a";
        broken.note(rule(self.bias_current_a < self.max_current_a, path("max_current_a"), self.max_current_a, current));
        let damping_ratio = self.disc_damping_ratio.unwrap_or(DISC_DAMPING_RATIO);
        broken.note(rule(
            (0.0..1.0).contains(&damping_ratio),
            path("disc_damping_ratio"),
            damping_ratio,
            "must lie between 0 and 1",
        ));
        let alone = "needs thrust.disc_mass_kg and thrust.disc_mode_hz, both or none";
        for (key, value, other) in [
            ("disc_mass_kg", self.disc_mass_kg, self.disc_mode_hz),
            ("disc_mode_hz", self.disc_mode_hz, self.disc_mass_kg),
        ] {
            if let Some(value) = value {
                broken.note(rule(other.is_some(), path(key), value, alone));
            }
        }
    }

    /// Current that keeps both coils in their range, A.
    pub(crate) fn current_range_a(&self) -> f64 {
        self.bias_current_a.min(self.max_current_a - self.bias_current_a)
    }
}
