//! Rules that the numbers of a spindle keep: signs, finite sizes, and values that must not contradict each other.

use super::rule::{BrokenRules, MOST_DELAY_SAMPLES, positive, rule};
use super::{Side, Spindle, SpindleError};
use crate::rotor::Rotor;

impl Spindle {
    /// Checks every rule that concerns the spindle alone.
    pub(crate) fn validate(&self) -> Result<(), SpindleError> {
        self.broken_rules().into_iter().next().map_or(Ok(()), Err)
    }

    /// Every rule that the spindle alone breaks; rules of planes and modes are judged on a shaft that is right.
    pub(crate) fn broken_rules(&self) -> Vec<SpindleError> {
        let mut broken = BrokenRules::default();
        let rotor = broken.rotor(&self.sections, &self.discs, SpindleError::Rotor);
        for side in Side::ALL {
            self.check_bearing(side, &mut broken);
        }
        self.check_electronics(&mut broken);
        broken.note(positive("speed.max_rpm", self.max_rpm));
        broken.note(positive("backup_clearance_m", self.backup_clearance_m));
        self.backup_bearings.check(&mut broken);
        if let Some(thrust) = &self.thrust {
            thrust.check(&mut broken);
        }
        for side in Side::ALL {
            let gap_m = self.bearing(side).gap_m;
            broken.note(rule(
                self.backup_clearance_m < gap_m,
                "backup_clearance_m".into(),
                self.backup_clearance_m,
                &format!(
                    "must be smaller than bearings.{}.gap_m ({gap_m}): the rotor must land before it touches a magnet",
                    side.name()
                ),
            ));
        }
        let (from, to) = self.stiffness_band_hz;
        broken.note(positive("stiffness_band.from_hz", from));
        broken.note(rule(
            to > from && to.is_finite(),
            "stiffness_band.to_hz".into(),
            to,
            &format!("must be larger than stiffness_band.from_hz ({from})"),
        ));
        self.check_damping(&mut broken);
        if let Some(rotor) = rotor {
            let most = rotor.dofs() - 2;
            broken.note(rule(
                self.flexible_modes >= 1 && self.flexible_modes <= most,
                "rotor.flexible_modes".into(),
                self.flexible_modes as f64,
                &format!("must lie between 1 and the {most} flexible modes of the rotor model"),
            ));
            self.check_planes(&rotor, &mut broken);
            if let Some(output_m) = self.output_m {
                broken.note(on_rotor(&rotor, "output_m", output_m));
            }
        }
        for (i, effect) in self.effects.iter().enumerate() {
            broken.note(effect.validate().map_err(|error| at_effect(i, error)));
        }
        broken.list()
    }

    fn check_bearing(&self, side: Side, broken: &mut BrokenRules) {
        let (b, name) = (self.bearing(side), side.name());
        let path = |key: &str| format!("bearings.{name}.{key}");
        broken.note(positive(&path("ki_n_per_a"), b.ki_n_per_a));
        let ks = "must be zero or a positive number: negative stiffness is given as a positive number";
        broken.note(rule(b.ks_n_per_m >= 0.0, path("ks_n_per_m"), b.ks_n_per_m, ks));
        broken.note(positive(&path("max_force_n"), b.max_force_n));
        broken.note(positive(&path("bias_current_a"), b.bias_current_a));
        broken.note(positive(&path("max_current_a"), b.max_current_a));
        broken.note(rule(
            b.bias_current_a < b.max_current_a,
            path("bias_current_a"),
            b.bias_current_a,
            &format!(
                "must be smaller than max_current_a ({}): the control current moves round the bias",
                b.max_current_a
            ),
        ));
        broken.note(positive(&path("gap_m"), b.gap_m));
        broken.note(positive(&path("sensor_gain"), b.sensor_gain));
    }

    fn check_electronics(&self, broken: &mut BrokenRules) {
        let e = &self.electronics;
        let path = |key: &str| format!("electronics.{key}");
        broken.note(positive(&path("amplifier_bandwidth_hz"), e.amplifier_bandwidth_hz));
        broken.note(positive(&path("sensor_bandwidth_hz"), e.sensor_bandwidth_hz));
        broken.note(positive(&path("sample_rate_hz"), e.sample_rate_hz));
        let zero = "must be zero or a positive number";
        let noise = e.sensor_noise_m;
        broken.note(rule(noise >= 0.0, path("sensor_noise_m"), noise, zero));
        broken.note(rule(e.delay_s >= 0.0, path("delay_s"), e.delay_s, zero));
        broken.note(rule(
            // A rounding step below half a sample is still half a sample.
            e.delay_s >= 0.5 * e.sample_period_s() * (1.0 - 1e-9),
            path("delay_s"),
            e.delay_s,
            "must be at least half a sample period: the hold alone delays that much",
        ));
        let samples = e.delay_s / e.sample_period_s();
        broken.note(rule(
            samples <= MOST_DELAY_SAMPLES,
            path("delay_s"),
            e.delay_s,
            &format!(
                "is {samples:.0} sample periods of {:e} s, must be {MOST_DELAY_SAMPLES} at most",
                e.sample_period_s()
            ),
        ));
    }

    fn check_damping(&self, broken: &mut BrokenRules) {
        if self.damping_ratio.is_empty() {
            broken.note(Err(SpindleError::Name {
                path: "rotor.damping_ratio".into(),
                name: "[]".into(),
                rule: "needs at least one value".into(),
            }));
        }
        for (i, zeta) in self.damping_ratio.iter().enumerate() {
            let ok = (0.0..1.0).contains(zeta);
            let path = format!("rotor.damping_ratio[{i}]");
            broken.note(rule(ok, path, *zeta, "must be at least 0 and below 1"));
        }
    }

    fn check_planes(&self, rotor: &Rotor, broken: &mut BrokenRules) {
        let p = &self.planes;
        let planes = [
            ("planes.front_sensor_m", p.front_sensor_m),
            ("planes.front_actuator_m", p.front_actuator_m),
            ("planes.rear_actuator_m", p.rear_actuator_m),
            ("planes.rear_sensor_m", p.rear_sensor_m),
        ];
        for (path, value) in planes {
            broken.note(on_rotor(rotor, path, value));
        }
        for (name, front, rear) in
            [("sensor", p.front_sensor_m, p.rear_sensor_m), ("actuator", p.front_actuator_m, p.rear_actuator_m)]
        {
            broken.note(rule(
                rear > front,
                format!("planes.rear_{name}_m"),
                rear,
                &format!("must lie behind front_{name}_m ({front}): z grows from the nose face to the tail"),
            ));
        }
    }
}

fn on_rotor(rotor: &Rotor, path: &str, position_m: f64) -> Result<(), SpindleError> {
    let text = format!("must lie on the rotor, between 0 and {:.6}", rotor.to_m());
    rule(position_m >= 0.0 && position_m <= rotor.to_m() + 1e-6, path.into(), position_m, &text)
}

fn at_effect(i: usize, error: SpindleError) -> SpindleError {
    match error {
        SpindleError::Value { path, value, rule } => {
            SpindleError::Value { path: format!("effects[{i}].{path}"), value, rule }
        }
        SpindleError::Name { path, name, rule } => {
            SpindleError::Name { path: format!("effects[{i}].{path}"), name, rule }
        }
        other => other,
    }
}
