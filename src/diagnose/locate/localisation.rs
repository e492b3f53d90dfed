//! Where the disagreement sits, without a hypothesis.
//!
//! Every place gets a free complex law at every line; the nuisance parameters are fitted with it by variable projection
//! (`projection`). The place that explains most with fewest free numbers is the best: score = χ² + 2 × (real
//! numbers of the laws), after Akaike. Only sweeps are looked at, so that hammer tests stay held out. All places are
//! compared at a coarse model error on thinned lines; the better half and then the best few are followed down to the
//! model error at which a named model is judged.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::super::fit::model::Model;
use super::place::{LawUnit, Place};
use super::projection::{LawFit, Settled, lines, settle};
use super::recovered_law::Law;
use crate::linalg::c64;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Relative model error of the comparison: what an independent simulation or a good test rig leaves.
pub(crate) const MODEL_ERROR: f64 = 2e-3;
/// Floors with steps, and which lines are looked at (every n-th at least), of the three rounds: all places, the better
/// half, the best few.
type Round = (&'static [(f64, usize)], usize);
const ROUNDS: [Round; 3] = [(&[(0.1, 1), (0.03, 1)], 8), (&[(0.01, 2)], 4), (&[(MODEL_ERROR, 3)], 4)];
/// Lines of a record that compare places before the last round: a law is free at each of them, so that more say little
/// more.
const LINES: usize = 50;
/// Places that pass each round.
const PASS: [usize; 2] = [20, 8];
/// Shares of the distance between the magnets at which stations stand between them.
const BETWEEN: [f64; 4] = [0.2, 0.4, 0.6, 0.8];
/// Steps by which the best station is moved, in distances between the magnets: stations are a fifth apart.
const STATION_STEPS: [f64; 3] = [0.08, 0.04, 0.02];
/// Stations of one kind closer than this are one place, in distances between the magnets.
const ONE_PLACE: f64 = 0.13;
/// χ² per degree of freedom below which a place explains everything: noise and model error leave 0.6 to 0.8.
const EXPLAINED: f64 = 1.2;
/// Lines of a band, and χ² per degree of freedom that noise does not leave over so many.
const BAND: usize = 10;
const QUIET: f64 = 2.2;
/// Ratio to the χ² of every other place from which a place is the only one.
const FIRST_EFFECT_BIC_GAIN: f64 = 3.0;
/// A station closer than this to a named one has its name, in distances between the magnets.
const SAME_NAME: f64 = 0.03;
/// Nuisance parameters further out than this many standard deviations are tried without their prior, the furthest few.
const STRAINED: (f64, usize) = (2.5, 5);

/// What a place explains.
#[derive(Clone, Debug)]
pub struct PortScore {
    /// The place in words.
    pub port: String,
    /// The place.
    pub place: Place,
    /// χ² per residual without a law, nuisance parameters fitted.
    pub chi2_before: f64,
    /// χ² per degree of freedom with a free law at every line.
    pub chi2_after: f64,
    /// Score above the best place.
    pub score_above_best: f64,
    /// Free complex numbers at a line.
    pub numbers: usize,
    /// Lines of all sweeps, Hz.
    pub frequency_hz: Vec<f64>,
    /// χ² per residual of every line without a law.
    pub line_before: Vec<f64>,
    /// The same with the law, per degree of freedom.
    pub line_after: Vec<f64>,
    /// Recovered laws.
    pub laws: Vec<Law>,
    /// Nuisance parameters with the law.
    pub p: Vec<f64>,
}

impl PortScore {
    /// The law that matters most: the first.
    pub fn law(&self) -> Option<&Law> {
        self.laws.first()
    }

    /// Shape of the first law in words.
    pub fn shape(&self) -> String {
        self.law().map_or("nothing".into(), Law::words)
    }
}

/// Places, best first.
#[derive(Clone, Debug, Default)]
pub struct Localisation {
    /// Scores.
    pub ports: Vec<PortScore>,
}

impl Localisation {
    /// The best place at which something is, if any was followed to the end.
    pub fn named_port(&self) -> Option<&PortScore> {
        self.ports.iter().find(|p| p.place != Place::Nowhere)
    }

    /// The one place that explains everything while no other comes near. What is missing is then there, in the
    /// catalogue or not.
    pub(crate) fn sole(&self) -> Option<&Place> {
        let (best, others) = self.ports.split_first()?;
        let alone = others.iter().all(|p| p.chi2_after > FIRST_EFFECT_BIC_GAIN * best.chi2_after);
        // A second effect may hide in a narrow band.
        let mut left: Vec<(f64, f64)> =
            best.frequency_hz.iter().copied().zip(best.line_after.iter().copied()).collect();
        left.sort_by(|a, b| a.0.total_cmp(&b.0));
        let quiet = left.windows(BAND).all(|w| w.iter().map(|l| l.1).sum::<f64>() < QUIET * BAND as f64);
        (best.place != Place::Nowhere && best.chi2_after < EXPLAINED && alone && quiet).then_some(&best.place)
    }
}

/// All places of a machine that some sweep turns or not.
fn places(model: &Model, turning: bool) -> Vec<(String, Place)> {
    let machine = &model.reduced.machine;
    let planes = &machine.spindle.planes;
    let (from, to) = model.reduced.span_m();
    let (front, rear) = (planes.front_actuator_m, planes.rear_actuator_m);
    let between = |share: f64| front + share * (rear - front);
    let mut all: Vec<(String, Place)> = vec![
        ("nowhere".into(), Place::Nowhere),
        ("loop (all currents or all sensors)".into(), Place::Loop),
        ("housing".into(), Place::Housing),
    ];
    let jointed = machine.of_kind(crate::spindle::EffectKind::ToolJoint).next().is_some();
    if !jointed && !machine.tool.is_absent() {
        all.push(("tool joint".into(), Place::Joint));
    }
    let mut stations = vec![from, 0.0, front, rear, to];
    stations.extend(BETWEEN.map(between));
    let mut add = |place: Place| all.push((station_name(model, &place), place));
    stations.into_iter().for_each(|z| add(Place::Station(z)));
    if !turning {
        [front, rear].into_iter().for_each(|z| add(Place::Apart(z)));
        let apart = [from, front, between(0.5), rear];
        apart.into_iter().for_each(|z| add(Place::Circulating(z)));
    }
    for (b, name) in ["front", "rear"].into_iter().enumerate() {
        let other = ["rear", "front"][b];
        all.extend([
            (format!("{name} sensors"), Place::Sensors(b)),
            (format!("{name} currents"), Place::Currents(b)),
            (format!("{name} sensor axes, x to y"), Place::Turned(b)),
            (format!("{name} currents, x to y"), Place::Coupled(b)),
            (format!("{name} sensor plane"), Place::SensorPlane(b)),
            (format!("{name} actuator plane"), Place::ActuatorPlane(b)),
            (format!("{name} currents into the {other} bearing"), Place::Crosstalk(b)),
        ]);
        for (k, axis) in ["x", "y"].into_iter().enumerate() {
            all.push((format!("{name} sensor {axis}"), Place::Sensor(2 * b + k)));
            all.push((format!("{name} current {axis}"), Place::Current(2 * b + k)));
        }
    }
    all
}

/// Looks for the place from the machine as it is.
///
/// # Errors
/// [`DiagnoseError`] when a model cannot be assembled.
pub fn localise(case: &Case) -> Result<Localisation, DiagnoseError> {
    let field = ranked_places(case)?;
    let best = field.first().map_or(0.0, score);
    let nowhere = field.iter().find(|f| f.1 == Place::Nowhere);
    let before = nowhere.map_or_else(|| case.origin().p, |f| f.2.p.clone());
    let mut line_before = vec![];
    let fit =
        LawFit { place: &Place::Nowhere, p: &before, model_error: MODEL_ERROR, usage: Subset::ALL, derivatives: false };
    lines(case, &fit, |l| line_before.push(l.chi2.1 / 32.0))?;
    let mean = line_before.iter().sum::<f64>() / line_before.len().max(1) as f64;
    let ports: Result<Vec<PortScore>, DiagnoseError> = field
        .into_par_iter()
        .map(|entry| {
            let above = score(&entry) - best;
            let (port, place, settled) = entry;
            let mut seen = Seen::new(case, &place, &settled.p, Subset::ALL)?;
            Ok(PortScore {
                port,
                chi2_before: mean,
                chi2_after: seen.chi2 / seen.freedom.max(1.0),
                score_above_best: above,
                numbers: seen.numbers,
                laws: match place {
                    Place::Freed(k) => vec![seen.constant(settled.p[k].exp_m1())],
                    _ => seen.laws(),
                },
                frequency_hz: std::mem::take(&mut seen.frequency_hz),
                line_before: line_before.clone(),
                line_after: std::mem::take(&mut seen.line_after),
                p: settled.p,
                place,
            })
        })
        .collect();
    Ok(Localisation { ports: ports? })
}

/// A place with its name and its fit.
type Entry = (String, Place, Settled);

/// χ² + 2 k, k real numbers of laws; a freed parameter is one, and its prior does not count.
fn score(f: &Entry) -> f64 {
    let free = 2.0 * f.2.numbers as f64 + f64::from(u8::from(matches!(f.1, Place::Freed(_))));
    f.2.chi2 + 2.0 * free
}

fn sort(field: &mut [Entry]) {
    field.sort_by(|a, b| score(a).total_cmp(&score(b)));
}

/// A law at each of these places, fitted with the nuisance parameters.
fn fit_places(
    case: &Case,
    tried: Vec<(String, Place, Vec<f64>)>,
    stages: &[(f64, usize)],
    usage: Subset,
) -> Result<Vec<Entry>, DiagnoseError> {
    let fit = |(name, place, p): (String, Place, Vec<f64>)| {
        let settled = settle(case, &place, &p, stages, usage)?;
        Ok((name, place, settled))
    };
    tried.into_par_iter().map(fit).collect()
}

/// All places, screened on thinned lines and then fitted on more, best first.
fn ranked_places(case: &Case) -> Result<Vec<Entry>, DiagnoseError> {
    let turning = case.evidence.sweeps.iter().any(|s| s.speed_rad_s != 0.0);
    let mut field: Vec<Entry> = vec![];
    let origin = case.origin().p;
    let mut next: Vec<(String, Place, Vec<f64>)> =
        places(case.model, turning).into_iter().map(|(name, place)| (name, place, origin.clone())).collect();
    for (round, (stages, stride)) in ROUNDS.iter().enumerate() {
        let usage = Subset {
            stride: if round + 1 == ROUNDS.len() { *stride } else { (case.evidence.lines() / LINES).max(*stride) },
            ..Subset::ALL
        };
        field = fit_places(case, next, stages, usage)?;
        sort(&mut field);
        if round + 1 == ROUNDS.len() {
            move_best_station(case, &mut field, stages, usage)?;
            break;
        }
        let released = match round {
            0 => {
                let nowhere = field.iter().find(|f| f.1 == Place::Nowhere);
                nowhere.map_or(vec![], |f| start_from_strained(case.model, &f.2.p))
            }
            _ => vec![],
        };
        trim(&mut field, PASS[round.min(1)]);
        next = field.iter().map(again).collect();
        next.extend(released);
    }
    trim(&mut field, PASS[1]);
    Ok(field)
}

/// Moves the best station along the shaft; it replaces its neighbours.
fn move_best_station(
    case: &Case,
    field: &mut Vec<Entry>,
    stages: &[(f64, usize)],
    usage: Subset,
) -> Result<(), DiagnoseError> {
    let span_m = case.model.reduced.machine.spindle.planes.bearing_span_m();
    for step in STATION_STEPS {
        let Some((_, place, s)) = field.first() else {
            break;
        };
        let Some(z) = place.position_m() else { break };
        let (from, to) = case.model.reduced.span_m();
        let beside = [z - step * span_m, z + step * span_m].map(|z| z.clamp(from, to));
        let tried = beside.into_iter().filter(|b| *b != z).map(|z| {
            let moved = place.moved_to(z);
            (station_name(case.model, &moved), moved, s.p.clone())
        });
        let tried = fit_places(case, tried.collect(), stages, usage)?;
        field.extend(tried);
        sort(field);
        let kind = field.first().map(|f| f.1.clone());
        let mut first = true;
        field.retain(|f| {
            let twin = kind.as_ref().is_some_and(|k| k.within(ONE_PLACE * span_m, &f.1));
            let keep = first || !twin;
            first = false;
            keep
        });
    }
    Ok(())
}

type Start = (String, Place, Vec<f64>);

/// A place at a position by what is there, or by its distance from the nose.
fn station_name(model: &Model, place: &Place) -> String {
    let planes = &model.reduced.machine.spindle.planes;
    let (from, to) = model.reduced.span_m();
    let z = place.position_m().unwrap_or_default();
    let known = [
        ("tool", from),
        ("nose", 0.0),
        ("front bearing", planes.front_actuator_m),
        ("rear bearing", planes.rear_actuator_m),
        ("tail", to),
    ];
    let name = known
        .into_iter()
        .find(|(_, at)| (at - z).abs() < SAME_NAME * planes.bearing_span_m())
        .map_or_else(|| format!("shaft at {:.0} mm", 1e3 * z), |(name, _)| name.to_owned());
    match place {
        Place::Apart(_) => format!("{name}, x and y apart"),
        Place::Circulating(_) => format!("{name}, x to y"),
        _ => name,
    }
}

fn again((name, place, settled): &(String, Place, Settled)) -> Start {
    (name.clone(), place.clone(), settled.p.clone())
}

/// Keeps the best places, and the machine without a law, with which they are compared.
fn trim(field: &mut Vec<(String, Place, Settled)>, most: usize) {
    let mut kept = 0;
    field.retain(|(_, place, _)| {
        kept += usize::from(*place != Place::Nowhere);
        *place == Place::Nowhere || kept <= most
    });
}

/// Nuisance parameters that left their priors, as places of their own.
fn start_from_strained(model: &Model, p: &[f64]) -> Vec<Start> {
    let layout = &model.layout;
    let mut far: Vec<(usize, f64)> = p
        .iter()
        .enumerate()
        .map(|(k, p)| (k, layout.deviation(k, *p).0.abs()))
        .filter(|(_, away)| *away > STRAINED.0)
        .collect();
    far.sort_by(|a, b| b.1.total_cmp(&a.1));
    far.into_iter()
        // The mesh belongs to the model and axis gains to a record, not to the machine.
        .filter(|(k, _)| *k < layout.machine.mesh())
        .take(STRAINED.1)
        .map(|(k, _)| (model.name_of(k), Place::Freed(k), p.to_vec()))
        .collect()
}

/// What a place shows line by line.
pub(super) struct Seen {
    chi2: f64,
    freedom: f64,
    numbers: usize,
    frequency_hz: Vec<f64>,
    line_after: Vec<f64>,
    names: Vec<(&'static str, LawUnit)>,
    laws: Vec<Vec<(c64, f64)>>,
    /// X of every line, sweep by sweep.
    pub x: Vec<Vec<Vec<c64>>>,
}

impl Seen {
    pub(super) fn new(case: &Case, place: &Place, p: &[f64], usage: Subset) -> Result<Self, DiagnoseError> {
        let sweeps = case.evidence.sweeps.len();
        let mut seen = Self {
            chi2: 0.0,
            freedom: 0.0,
            numbers: 0,
            frequency_hz: vec![],
            line_after: vec![],
            names: vec![],
            laws: vec![],
            x: vec![vec![]; sweeps],
        };
        let fit = LawFit { place, p, model_error: MODEL_ERROR, usage, derivatives: false };
        lines(case, &fit, |line| {
            let freedom = (32 - 2 * line.x.len()) as f64;
            seen.chi2 += line.chi2.1;
            seen.freedom += freedom;
            seen.numbers = line.x.len();
            seen.frequency_hz.push(line.omega_rad_s / TAU);
            seen.line_after.push(line.chi2.1 / freedom);
            // At standstill a place may have fewer laws than at speed: the first of them are the same.
            let names = place.laws(line.view.split());
            if names.len() >= seen.names.len() {
                seen.names = names;
            }
            seen.laws.push(line.laws());
            seen.x[line.sweep].push(line.x.clone());
        })?;
        Ok(seen)
    }

    /// A relative change that is the same at every line.
    fn constant(&self, value: f64) -> Law {
        let mut hz = self.frequency_hz.clone();
        hz.sort_by(f64::total_cmp);
        let values = vec![c64::new(value, 0.0); hz.len()];
        // One per cent stands for what the prior would have allowed.
        let sd = vec![0.01; hz.len()];
        Law::new("", LawUnit::Relative, hz, values, sd)
    }

    /// Laws in order of frequency over all sweeps, each on the lines that have it.
    fn laws(&self) -> Vec<Law> {
        let mut order: Vec<usize> = (0..self.frequency_hz.len()).collect();
        order.sort_by(|a, b| self.frequency_hz[*a].total_cmp(&self.frequency_hz[*b]));
        let law = |(k, (name, unit)): (usize, &(&str, LawUnit))| {
            let (mut hz, mut values, mut sd) = (vec![], vec![], vec![]);
            for line in &order {
                if let Some((value, deviation)) = self.laws[*line].get(k) {
                    hz.push(self.frequency_hz[*line]);
                    values.push(*value);
                    sd.push(*deviation);
                }
            }
            Law::new(name, *unit, hz, values, sd)
        };
        self.names.iter().enumerate().map(law).collect()
    }
}
