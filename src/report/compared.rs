//! Controllers side by side, and beside measured hammer tests: figures by key, tables, words, pictures.

use super::comparison::{
    figure_9_words, measured_row, measured_topic, ratio_topic, statements_table, tool_plane_topic,
};
use super::comparison_figures::{NamedWorst, worst_figures};
use super::pictures::Picture;
use super::pid_summary::{OF_DELIVERED, certificate_topic, no_pid_topic, pid_topic};
use super::plot::machining::chatter_lobes;
use super::plot::{Curve, Role};
use super::prediction_summary::damping_ratios;
use super::run_figures::{Measured, predictions};
use super::speed_summary::{speed_proof_topic, verification_topic};
use super::summary::{Summary, omit_absent};
use super::whole::{Report, ReportError};
use super::worst::worst_records;
use crate::controller::Controller;
use crate::controller::verification::Verification;
use crate::identify::HammerFrf;
use crate::identify::peaks::Resonance;
use crate::input::measurement::Hammer;
use crate::linalg::{Mat, c64};
use crate::pipeline::compared::{Compared, Ground, KnownFigures, OwnControllers};
use crate::pipeline::comparison::Prediction;
use crate::pipeline::run::Rivals;
use crate::predict::chatter::{StabilityLimit, milling};
use crate::predict::sensitivity::Zone;
use crate::rotor::PlanarModes;
use crate::spindle::SpindleError;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::path::Path;

/// Points of the stability lobes over speed: lobes of a two-tooth cutter stay smooth down to a tenth of the top speed.
const LOBE_POINTS: usize = 1000;

/// A measured hammer test: its curve, its key, the resonances that a local fit resolves.
pub(crate) struct HammerCurve {
    pub curve: Measured,
    /// Key under `tool_plane`.
    pub key: String,
    pub resonances: Vec<Resonance>,
    /// Compliance on the lines of the curve, m/N.
    pub compliance: Vec<c64>,
    /// Lines that do not tell the response, which the curve leaves out.
    pub lines_left_out: usize,
}

impl HammerCurve {
    /// Of records, each under the stem of its file; those of one stem get a number.
    pub(crate) fn of_all(hammers: &[Hammer]) -> Vec<Self> {
        let stem = |hammer: &Hammer| {
            let stem = Path::new(&hammer.name).file_stem().and_then(|s| s.to_str());
            stem.unwrap_or(&hammer.name).to_owned()
        };
        let stems: Vec<String> = hammers.iter().map(stem).collect();
        let number = |k: usize| stems[..=k].iter().filter(|s| **s == stems[k]).count();
        let name = |k: usize| if number(k) > 1 { format!("{} {}", stems[k], number(k)) } else { stems[k].clone() };
        hammers.iter().enumerate().map(|(k, hammer)| Self::of(&name(k), &hammer.frf)).collect()
    }

    fn of(name: &str, frf: &HammerFrf) -> Self {
        let valid = frf.valid_lines();
        // A record without a line that tells is shown as it is.
        let all = !valid.contains(&true);
        let kept: Vec<usize> = (0..valid.len()).filter(|k| all || valid[*k]).collect();
        let compliance: Vec<c64> = kept.iter().map(|k| frf.compliance[*k]).collect();
        Self {
            curve: Measured {
                name: format!("measured ({name})"),
                role: Role::Measured,
                speed_rpm: frf.speed_rpm,
                frequency_hz: kept.iter().map(|k| frf.frequency_hz[*k]).collect(),
                stiffness_n_per_m: compliance.iter().map(|c| c.norm().recip()).collect(),
            },
            key: format!("tool_plane.measured_{}", name.replace(['.', ' '], "_")),
            resonances: frf.resonances(),
            lines_left_out: valid.len() - kept.len(),
            compliance,
        }
    }

    /// Stability lobes of a tool that answers alike in x and y.
    fn lobes(&self, ground: &Ground<'_>) -> Option<StabilityLimit> {
        let omega_rad_s: Vec<f64> = self.curve.frequency_hz.iter().map(|f| f * TAU).collect();
        let zero = c64::new(0.0, 0.0);
        let alike = |h: &c64| Mat::from_fn(2, 2, |i, j| if i == j { *h } else { zero });
        let both: Vec<Mat<c64>> = self.compliance.iter().map(alike).collect();
        milling(&omega_rad_s, &both, ground.material, ground.cut).ok()
    }
}

/// Flexible modes whose damping is listed and at which stiffness is stated.
const LISTED_MODES: usize = 3;

/// Adds what the PID search found to the summary, and returns the controllers that there are, with what is known of
/// them.
pub(crate) fn add_own(summary: &mut Summary, own: OwnControllers) -> Vec<(Role, Controller, KnownFigures)> {
    let [of_mu, of_pid, of_textbook] = own.known_controllers();
    let Rivals { tuned, textbook, effort } = own.rivals;
    let mut controllers = vec![(Role::Mu, own.design.delivery.controller, of_mu)];
    match tuned {
        Ok((pid, _)) => {
            summary.set("pid", pid_topic(&pid, &effort, OF_DELIVERED));
            controllers.push((Role::Pid, pid.controller, of_pid));
        }
        Err(reason) => {
            summary.set("pid", no_pid_topic(&format!("No PID was found ({reason}).")));
        }
    }
    if let Ok((plain, _)) = textbook {
        summary.set("pid.textbook", certificate_topic(&plain.certificate));
        controllers.push((Role::TextbookPid, plain.controller, of_textbook));
    }
    controllers
}

/// Names of the controllers as keys: blanks become underscores, repeated names get a number.
pub(crate) fn controller_keys(controllers: &[(Role, Controller, KnownFigures)]) -> Vec<String> {
    let mut names: Vec<String> = vec![];
    for (role, controller, _) in controllers {
        let base = match role {
            Role::Mu => "mu".to_owned(),
            Role::Pid => "pid".to_owned(),
            Role::TextbookPid => "textbook_pid".to_owned(),
            _ => controller.name.replace([' ', '.'], "_").to_lowercase(),
        };
        let repeats = names.iter().filter(|n| **n == base || n.starts_with(&format!("{base}_"))).count();
        names.push(if repeats == 0 { base } else { format!("{base}_{}", repeats + 1) });
    }
    names
}

/// Whether every loop is acceptable.
pub(crate) fn all_acceptable(list: &[(Role, Compared)]) -> bool {
    list.iter().all(|(role, each)| is_acceptable(*role, each))
}

/// Proven stable at every speed, and in an acceptable zone. The textbook PID shows what is left without tuning: its
/// zone is no target.
fn is_acceptable(role: Role, each: &Compared) -> bool {
    let mut zones = each.predictions.iter().map(Prediction::zone);
    let zones_hold = role == Role::TextbookPid || zones.all(|z| z.is_some_and(|z| z < Zone::D));
    each.verification.is_proven() && zones_hold
}

/// Adds controllers and hammer tests to a report, and whether every target is met, in a sentence that is returned.
pub(crate) fn add_compared(
    report: &mut Report,
    ground: &Ground<'_>,
    list: &[(Role, Compared)],
    hammers: Vec<HammerCurve>,
    met: bool,
) -> Result<&'static str, ReportError> {
    let mut flexible_hz = PlanarModes::new(&ground.machine.rotor()?).map_err(SpindleError::Shaft)?.flexible_hz();
    flexible_hz.truncate(LISTED_MODES);
    let flexible_hz = flexible_hz.as_slice();
    let sentence = if met {
        "every loop is proven stable at every speed"
    } else {
        "a loop is not proven stable at every speed, is in zone D, or the design misses its specification"
    };
    report.verdict(met, sentence);
    let top_hz = ground.machine.spindle.max_rpm / 60.0;
    for (_, each) in list {
        report.predictions(&each.name, each.ends.each_ref());
        let damping = damping_ratios(&each.ends[0], flexible_hz.len());
        report.summary.set(&format!("damping_ratio.{}", each.name), damping);
        add_one(&mut report.summary, each, flexible_hz, top_hz);
    }
    for hammer in &hammers {
        let (curve, left_out) = (&hammer.curve, hammer.lines_left_out);
        let own = measured_topic(curve, left_out, &hammer.resonances, flexible_hz, top_hz);
        report.summary.set(&hammer.key, own);
    }
    let of_hammers: Vec<Option<StabilityLimit>> = hammers.iter().map(|hammer| hammer.lobes(ground)).collect();
    for (hammer, lobes) in hammers.iter().zip(&of_hammers) {
        let key = hammer.key.replacen("tool_plane", "chatter", 1);
        report.summary.set(&key, chatter_topic(lobes.as_ref()));
    }
    let names: Vec<String> = hammers.iter().map(|hammer| hammer.curve.name.clone()).collect();
    let measured_lobes = names.iter().zip(&of_hammers).map(|(name, own)| (Role::Measured, name.as_str(), own.as_ref()));
    let lobes = list.iter().map(|(role, c)| (*role, c.name.as_str(), c.lobes.as_ref())).chain(measured_lobes).collect();
    let measured: Vec<Measured> = hammers.into_iter().map(|h| h.curve).collect();
    add_ratios(&mut report.summary, list);
    let every: Vec<&Prediction> = list.iter().flat_map(|(_, c)| &c.predictions).collect();
    let worst: Vec<NamedWorst> = list.iter().map(|(role, c)| (*role, c.name.clone(), c.worst.clone())).collect();
    let mut statements = statements_table(&every, &worst, flexible_hz, top_hz);
    statements.extend(measured.iter().map(|m| measured_row(m, flexible_hz, top_hz)));
    let summary = &mut report.summary;
    summary.set("statements", statements);
    summary.set("plain_words", figure_9_words(&every, &worst));
    summary.set("speeds_rpm", ground.speeds_rpm);
    summary.set("top_speed_hz", top_hz);
    let drawn: Vec<(Role, &Prediction)> =
        list.iter().flat_map(|(role, c)| c.predictions.iter().map(|p| (*role, p))).collect();
    report.figures(predictions(&drawn, &measured, top_hz))?;
    report.figures(worst_figures(&worst))?;
    add_lobes(report, lobes, ground.machine.spindle.max_rpm)?;
    Ok(sentence)
}

/// Figures of one controller.
fn add_one(summary: &mut Summary, each: &Compared, flexible_hz: &[f64], top_hz: f64) {
    let name = &each.name;
    let stations = each.predictions.iter();
    let stations: Vec<Value> = stations.map(|p| tool_plane_topic(p, flexible_hz, top_hz)).collect();
    summary.set(&format!("tool_plane.{name}"), stations);
    let stability = stability_topic(&each.verification);
    summary.set(&format!("stability.{name}"), stability);
    summary.set(&format!("worst_case.{name}"), worst_records(&each.worst));
    summary.set(&format!("chatter.{name}"), chatter_topic(each.lobes.as_ref()));
}

/// `stability.<controller>`.
pub(crate) fn stability_topic(checked: &Verification) -> Value {
    let topic = json!({
        "stable": checked.is_proven(),
        "proof": checked.proof.as_ref().map(speed_proof_topic),
        "proof_failure": checked.proof_failure,
        "certificates": verification_topic(checked),
    });
    omit_absent(topic, &["proof", "proof_failure"])
}

/// `chatter.<controller>`: the smallest stable depth of cut.
fn chatter_topic(lobes: Option<&StabilityLimit>) -> Value {
    let minimum = lobes.and_then(StabilityLimit::minimum);
    json!({
        "minimum_depth_m": minimum.map(|m| m.depth_m),
        "frequency_hz": minimum.map(|m| m.omega_rad_s / TAU),
    })
}

/// Stiffness of the first controller over that of each other one, speed by speed.
fn add_ratios(summary: &mut Summary, list: &[(Role, Compared)]) {
    let Some(((_, first), others)) = list.split_first() else {
        return;
    };
    for (_, other) in others {
        let both = first.predictions.iter().zip(&other.predictions);
        let ratios: Vec<Value> = both.map(|(own, its)| ratio_topic(own, its)).collect();
        summary.set(&format!("stiffness_ratio.{}_over_{}", first.name, other.name), ratios);
    }
}

/// The picture of the stability lobes.
fn add_lobes(
    report: &mut Report,
    list: Vec<(Role, &str, Option<&StabilityLimit>)>,
    top_rpm: f64,
) -> Result<(), ReportError> {
    let speeds: Vec<f64> = (1..=LOBE_POINTS).map(|k| top_rpm * k as f64 / LOBE_POINTS as f64).collect();
    let angular: Vec<f64> = speeds.iter().map(|rpm| rpm * TAU / 60.0).collect();
    let lobes: Vec<(Role, &str, Vec<f64>)> =
        list.into_iter().filter_map(|(role, name, own)| Some((role, name, own?.depths(&angular)))).collect();
    let curves: Vec<Curve> =
        lobes.iter().map(|(role, name, depth)| Curve { name, role: *role, x: &speeds, y: depth }).collect();
    if curves.is_empty() {
        return Ok(());
    }
    let figure = chatter_lobes("Stable depth of cut", &curves, top_rpm);
    report.figures([(Picture::Chatter, figure)])
}
