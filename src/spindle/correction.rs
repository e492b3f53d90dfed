//! A law without a name in the machine: what a diagnosis recovered line by line at a place, fitted as a stable transfer
//! function. On the shaft it is a force −Δ(s) x, on a signal or a current a factor 1 + X(s).
//!
//! A power of s has no state space: on the shaft the constant, jω and −ω² are a spring, a damper and a mass, which the
//! model knows; only the rest is a filter. Outside of the lines the fit is an extrapolation.

use super::SpindleError;
use super::effects::{AXIS_NAMES, Bearings, Effect, EffectKind, Location, Plane};
use crate::linalg::c64;
use crate::lti::partial_fractions::{FitLine, PartialFractions};

/// Most poles of a law.
const MOST_POLES: usize = 8;
/// Lines that carry one independent piece of information: neighbours share what the nuisance parameters left.
const CORRELATED: f64 = 8.0;
/// Share of the weighted square of a law that its fit must carry: the rest may be noise, but not half of it.
const CARRIED: f64 = 0.6;

/// Where a law acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LawSite {
    /// Between ground and a position of the shaft, m.
    Shaft(f64),
    /// At the sensor signal of an axis.
    Signal(usize),
    /// At the current of an axis.
    Current(usize),
}

/// A law of a file, with its values over frequency.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RecoveredLaw {
    /// Which law of the place, empty where there is one only.
    pub name: String,
    /// Angular frequency in rad/s, value and standard deviation.
    pub lines: Vec<(f64, c64, f64)>,
}

/// A fitted law.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedLaw {
    pub site: LawSite,
    pub law: PartialFractions,
}

/// What a correction adds to a machine.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ModelCorrection {
    /// The file, as it was read.
    pub text: String,
    /// Spring, damper and mass.
    pub effects: Vec<Effect>,
    /// What has poles.
    pub laws: Vec<PlacedLaw>,
    /// Largest share of the weighted square of a law that its fit leaves out.
    pub left_out: f64,
}

/// A place of the file by its name.
enum Site {
    Shaft(f64),
    Signals(Vec<usize>),
    Currents(Vec<usize>),
}

impl Site {
    fn from_name(name: &str) -> Result<Self, SpindleError> {
        let (kind, at) = name.split_once(':').unwrap_or((name, ""));
        let axes = || -> Option<Vec<usize>> {
            let axis = AXIS_NAMES.iter().position(|axis| *axis == at);
            let of = |which: Bearings| (0..4).filter(|axis| which.includes(axis / 2)).collect();
            axis.map(|axis| vec![axis]).or_else(|| Bearings::from_name(at).map(of))
        };
        let site = match kind {
            "shaft" => at.parse().ok().filter(|z: &f64| z.is_finite()).map(Self::Shaft),
            "signals" => axes().map(Self::Signals),
            "currents" => axes().map(Self::Currents),
            "loop" => Some(Self::Currents(vec![0, 1, 2, 3])),
            _ => None,
        };
        site.ok_or_else(|| SpindleError::Name {
            path: "place".into(),
            name: name.into(),
            rule: "is no place whose law a model takes: shaft:position_m, signals: or currents: with a bearing or an \
                   axis, or loop"
                .into(),
        })
    }
}

/// Whether a model takes a law at a place of this name.
pub(crate) fn is_taken(place: &str) -> bool {
    Site::from_name(place).is_ok()
}

impl ModelCorrection {
    /// Fits the laws at a place.
    ///
    /// # Errors
    /// [`SpindleError::Name`] for a place whose law no model takes, [`SpindleError::Value`] for a law that no stable
    /// transfer function of at most eight poles carries.
    pub(crate) fn fit(place: &str, laws: &[RecoveredLaw], text: String) -> Result<Self, SpindleError> {
        let mut all = Self { text, effects: vec![], laws: vec![], left_out: 0.0 };
        let site = Site::from_name(place)?;
        for law in laws {
            match &site {
                Site::Shaft(z) => all.add_on_shaft(*z, law)?,
                Site::Signals(axes) => all.add_on_axes(axes, LawSite::Signal, law)?,
                Site::Currents(axes) => all.add_on_axes(axes, LawSite::Current, law)?,
            }
        }
        Ok(all)
    }

    fn add_on_axes(
        &mut self,
        axes: &[usize],
        site: fn(usize) -> LawSite,
        law: &RecoveredLaw,
    ) -> Result<(), SpindleError> {
        let fitted = self.fit_law(law, 1, MOST_POLES)?;
        self.laws.extend(axes.iter().map(|axis| PlacedLaw { site: site(*axis), law: fitted.clone() }));
        Ok(())
    }

    fn add_on_shaft(&mut self, z: f64, law: &RecoveredLaw) -> Result<(), SpindleError> {
        let plane = Plane::from_name(&law.name);
        let (powers, poles) = match (plane, law.name.as_str()) {
            (None, "x to y") => (1, 0),
            (None, _) => (3, MOST_POLES),
            // A mass or a filter that acts in one plane has no place in the shaft.
            (Some(_), _) => (2, 0),
        };
        let fitted = self.fit_law(law, powers, poles)?;
        let at = || plane.map_or(Location::Position(z), |plane| Location::InPlane(z, plane));
        let [spring, damper, mass] = [0, 1, 2].map(|k| fitted.polynomial.get(k).copied().filter(|c| *c != 0.0));
        if law.name == "x to y" {
            // The law that couples the planes is a force jq of the displacement x + jy.
            self.effects.extend(spring.map(|k| Effect {
                kind: EffectKind::CrossCoupling,
                location: at(),
                values: vec![k],
            }));
            return Ok(());
        }
        let mut add = |kind, value: Option<f64>| {
            self.effects.extend(value.map(|value| Effect { kind, location: at(), values: vec![value] }));
        };
        add(EffectKind::AddedDamper, damper);
        add(EffectKind::AddedMass, mass);
        if fitted.order() == 0 {
            add(EffectKind::AddedStiffness, spring);
        } else {
            self.laws.push(PlacedLaw { site: LawSite::Shaft(z), law: fitted.without_powers() });
        }
        Ok(())
    }

    /// The transfer function with the best n ln χ² + k ln n, n the number of independent lines, k that of its numbers.
    fn fit_law(&mut self, law: &RecoveredLaw, powers: usize, poles: usize) -> Result<PartialFractions, SpindleError> {
        let lines = weigh(&law.lines);
        let seen = lines.iter().filter(|line| line.weight > 0.0).count();
        let n = 2.0 * seen as f64 / CORRELATED;
        let total: f64 = lines.iter().map(|line| line.weight * line.value.norm_sqr()).sum();
        let mut best: Option<(f64, f64, PartialFractions)> = None;
        for (powers, order) in (1..=powers).flat_map(|p| (0..=poles).map(move |n| (p, n))) {
            let numbers = (powers + 2 * order) as f64;
            if numbers > n {
                continue;
            }
            // More terms than the values show have no solution; fewer have.
            let Ok(fitted) = PartialFractions::fit(&lines, order, powers) else { continue };
            let off = |line: &FitLine| line.weight * (fitted.at(line.omega_rad_s) - line.value).norm_sqr();
            let chi2: f64 = lines.iter().map(off).sum();
            // What lies below the noise is no better.
            let score = n * chi2.max(seen as f64).ln() + numbers * n.ln();
            if chi2.is_finite() && best.as_ref().is_none_or(|(least, ..)| score < *least) {
                best = Some((score, chi2, fitted));
            }
        }
        let left_out = best.as_ref().map_or(1.0, |(_, chi2, _)| chi2 / total.max(f64::MIN_POSITIVE));
        match best {
            Some((_, _, fitted)) if left_out <= 1.0 - CARRIED => {
                self.left_out = self.left_out.max(left_out);
                Ok(fitted)
            }
            _ => Err(SpindleError::Value {
                path: if law.name.is_empty() { "law".into() } else { format!("law {}", law.name) },
                value: left_out,
                rule: format!(
                    "of the law is left out by the best stable transfer function that was found, with {poles} poles at \
                     most; more than {:.1} is too much for a model",
                    1.0 - CARRIED
                ),
            }),
        }
    }

    /// Where its laws act on the shaft, m.
    pub(super) fn positions_m(&self) -> impl Iterator<Item = f64> {
        let filters = self.laws.iter().filter_map(|own| match own.site {
            LawSite::Shaft(z) => Some(z),
            _ => None,
        });
        self.effects.iter().filter_map(|e| e.location.position_m()).chain(filters)
    }

    /// The same with what acts in x and y alike only.
    pub(crate) fn retain_alike(&mut self) {
        self.effects.retain(|e| matches!(e.location, Location::Position(_)));
        let laws = std::mem::take(&mut self.laws);
        let has = |site: LawSite| laws.iter().any(|own| own.site == site);
        let alike = |site: LawSite| match site {
            LawSite::Shaft(_) => true,
            LawSite::Signal(axis) => has(LawSite::Signal(axis ^ 1)),
            LawSite::Current(axis) => has(LawSite::Current(axis ^ 1)),
        };
        self.laws = laws.iter().filter(|own| alike(own.site)).cloned().collect();
    }
}

/// Lines with the weights of their standard deviations; a line on which the law cannot be seen weighs nothing, one that
/// is seen far too well does not decide alone.
fn weigh(lines: &[(f64, c64, f64)]) -> Vec<FitLine> {
    let seen = |(w, v, sd): &(f64, c64, f64)| *w > 0.0 && v.re.is_finite() && v.im.is_finite() && *sd > 0.0;
    let mut typical: Vec<f64> = lines.iter().filter(|line| seen(line)).map(|line| line.2).collect();
    typical.sort_by(f64::total_cmp);
    let least = 0.1 * typical.get(typical.len() / 4).copied().unwrap_or(1.0);
    let lines = lines.iter().filter(|line| seen(line));
    lines.map(|(w, v, sd)| FitLine { omega_rad_s: *w, value: *v, weight: sd.max(least).powi(-2) }).collect()
}
