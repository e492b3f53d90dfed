//! Measured, model before, model after, channel by channel, for what a fit has used and for what it has not seen.
//!
//! "After" is the machine that was fitted without the held-out records (or, where nothing has a name, its response with
//! the correction of [`super::super::locate::correction`]), so that both kinds of channel are shown with one model.

use super::super::DiagnoseError;
use super::super::data::evidence::{Gap, held_out};
use super::super::fit::case::Case;
use super::super::locate::correction::Correction;
use crate::linalg::c64;
use crate::spindle::Effect;
use crate::spindle::response::{SIDE, Square};

#[derive(Clone, Debug, Default)]
pub(crate) struct Fitted {
    /// Nuisance parameters.
    pub small: Vec<f64>,
    /// Effects.
    pub effects: Vec<Effect>,
}

/// Kind of record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Record {
    /// Sweep: output and input axis.
    Sweep(usize, usize),
    /// Hammer: axis.
    Hammer(usize),
}

/// One measured response with the model's.
#[derive(Clone, Debug)]
pub struct MeasuredChannel {
    /// Which record.
    pub record: Record,
    /// Speed, rad/s.
    pub speed_rad_s: f64,
    /// Whether the fit has not seen it.
    pub held_out: bool,
    /// Lines, rad/s.
    pub omega_rad_s: Vec<f64>,
    /// Measured.
    pub measured: Vec<c64>,
    /// The machine as given.
    pub before: Vec<c64>,
    /// The machine as fitted without the held-out records.
    pub after: Vec<c64>,
    /// σ of the gap.
    pub sigma: Vec<f64>,
}

impl MeasuredChannel {
    /// |measured − model|/σ, before and after.
    pub fn residual(&self) -> (Vec<f64>, Vec<f64>) {
        let of = |model: &[c64]| {
            let both = self.measured.iter().zip(model).zip(&self.sigma);
            both.map(|((m, f), s)| (m - f).norm() / s).collect()
        };
        (of(&self.before), of(&self.after))
    }
}

/// Gaps before and after over channels of a kind.
pub(crate) fn gaps(channels: &[MeasuredChannel], wanted: impl Fn(&MeasuredChannel) -> bool) -> (f64, f64) {
    let (mut before, mut after) = (Gap::default(), Gap::default());
    for channel in channels.iter().filter(|c| wanted(c)) {
        let (b, a) = channel.residual();
        b.into_iter().for_each(|r| before.add(r));
        a.into_iter().for_each(|r| after.add(r));
    }
    (before.value(), after.value())
}

/// All channels; `correction` replaces the fitted response where there is one.
pub(crate) fn channels(
    case: &Case,
    fitted: &Fitted,
    correction: Option<&Correction>,
) -> Result<Vec<MeasuredChannel>, DiagnoseError> {
    let evidence = case.evidence;
    let origin = case.origin();
    let held_taps = !evidence.taps.is_empty();
    let mut all = vec![];
    let model = |p: &[f64], effects: &[Effect], speed: f64, omega: &[f64]| -> Result<_, _> {
        let assembled = case.model.assemble(p, effects, speed, false)?;
        Ok::<_, DiagnoseError>(assembled.responses(omega))
    };
    // Before and after, the correction in place of the latter where there is one.
    let both = |speed: f64, omega: &[f64], own: Option<&Vec<Square>>| -> Result<_, _> {
        let after = match own {
            Some(own) => own.clone(),
            None => model(&fitted.small, &fitted.effects, speed, omega)?,
        };
        Ok::<_, DiagnoseError>((model(&origin.p, &[], speed, omega)?, after))
    };
    for (s, sweep) in evidence.sweeps.iter().enumerate() {
        let own = correction.and_then(|c| c.sweeps.get(s));
        let (before, after) = both(sweep.speed_rad_s, &sweep.omega_rad_s, own)?;
        for n in 0..16 {
            let (i, j) = (n / 4, n % 4);
            all.push(MeasuredChannel {
                record: Record::Sweep(i, j),
                speed_rad_s: sweep.speed_rad_s,
                held_out: !held_taps && held_out(i, j),
                omega_rad_s: sweep.omega_rad_s.clone(),
                measured: sweep.response.iter().map(|g| g[n]).collect(),
                before: before.iter().map(|f| f[SIDE * i + j]).collect(),
                after: after.iter().map(|f| f[SIDE * i + j]).collect(),
                sigma: (0..sweep.omega_rad_s.len()).map(|line| sweep.sigma(line, i, j)).collect(),
            });
        }
    }
    for (t, tap) in evidence.taps.iter().enumerate() {
        let own = correction.and_then(|c| c.taps.get(t));
        let (before, after) = both(tap.speed_rad_s, &tap.omega_rad_s, own)?;
        let closed = |all: &[Square]| -> Vec<c64> {
            let lines = all.iter().enumerate();
            lines.map(|(line, f)| tap.close(line, f).0).collect()
        };
        all.push(MeasuredChannel {
            record: Record::Hammer(tap.axis),
            speed_rad_s: tap.speed_rad_s,
            held_out: true,
            omega_rad_s: tap.omega_rad_s.clone(),
            measured: tap.compliance.clone(),
            before: closed(&before),
            after: closed(&after),
            sigma: (0..tap.omega_rad_s.len()).map(|l| tap.sigma(l)).collect(),
        });
    }
    Ok(all)
}
