//! Pictures of a run from its results.

use super::pictures::Picture;
use super::plot::loops::{MarkedFrequency, bode, dynamic_stiffness, sensitivity};
use super::plot::robustness::{d_fits, mu_against_order, mu_over_frequency, mu_per_iteration};
use super::plot::shaft::{OutlinePiece, Station, StationKind, mode_shapes};
use super::plot::speed::{mu_over_speed, stability_over_speed};
use super::plot::{Curve, Figure, Role};
use crate::augment::channels::channel_names;
use crate::controller::stiffness_limit::StiffnessLimit;
use crate::linalg::c64;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::design::Design;
use crate::pipeline::dk_design::DkDesign;
use crate::pipeline::model_curves::{FreeRotor, OpenLoopCurves};
use crate::pipeline::overspeed::OVERSPEED;
use crate::pipeline::problems::Problems;
use crate::rotor::modes::RIGID;
use crate::spindle::Machine;

/// Open-loop Bode diagrams of the coaxial channels front and rear, models side by side.
pub(crate) fn open_loop(
    models: &[(&str, Role, &OpenLoopCurves)],
    marked: &[Vec<MarkedFrequency>; 2],
) -> Vec<(Picture, Figure)> {
    let bearings = [(Picture::BodeFront, "Front bearing"), (Picture::BodeRear, "Rear bearing")];
    let each = bearings.into_iter().enumerate();
    each.map(|(axis, (picture, title))| {
        let curves: Vec<Curve<c64>> = models
            .iter()
            .map(|(name, role, of)| Curve { name, role: *role, x: &of.frequency_hz, y: &of.response[axis] })
            .collect();
        let title = format!("{title}: sensor over current, open loop");
        let marked = &marked[axis];
        (picture, bode(&title, "|sensor / current|", "m/A", &curves, marked))
    })
    .collect()
}

/// Shapes of the first three flexible modes of a machine over its outline.
pub(crate) fn shapes(name: &str, role: Role, machine: &Machine, free: &FreeRotor) -> Figure {
    let FreeRotor { rotor, modes } = free;
    let nodes = rotor.node_positions_m();
    let [front, rear] = machine.effective().bearings;
    let station = |name, position_m, kind| Station { name, position_m, kind };
    let stations = [
        station("tool", machine.tool_plane_m(), StationKind::Other),
        station("front sensor", front.sensor_m, StationKind::Sensor),
        station("front actuator", front.actuator_m, StationKind::Actuator),
        station("rear sensor", rear.sensor_m, StationKind::Sensor),
        station("rear actuator", rear.actuator_m, StationKind::Actuator),
    ];
    let at = |k: usize, i: usize| if RIGID + k < modes.len() { modes.shapes[(2 * i, RIGID + k)] } else { 0.0 };
    let amplitudes = [0, 1, 2].map(|k| (0..nodes.len()).map(|i| at(k, i)).collect::<Vec<f64>>());
    let hz = modes.flexible_hz();
    let panels: Vec<(String, Vec<Curve>)> = amplitudes
        .iter()
        .enumerate()
        .map(|(k, amplitude)| {
            let hz = hz.get(k).copied().unwrap_or(f64::NAN);
            let curve = Curve { name, role, x: nodes, y: amplitude };
            (format!("mode {}: {hz:.0} Hz", k + 1), vec![curve])
        })
        .collect();
    mode_shapes("Flexible modes of the free rotor", &OutlinePiece::list(rotor), &stations, &panels)
}

/// μ over frequency and over speed; over the iteration and the order of the controller where there was an iteration.
pub(crate) fn robustness(design: &Design) -> Vec<(Picture, Figure)> {
    let delivery = &design.delivery;
    let steps = [
        ("with gyroscopic cover", delivery.covered_curve.as_slice()),
        ("specification as written", &delivery.specification_curve),
    ];
    let [stability, mu_speed] = over_speed(design);
    let mut drawn = vec![
        (Picture::Mu, mu_over_frequency("µ of the sampled loop with rounded coefficients", &steps)),
        stability,
        mu_speed,
    ];
    if let Some(dk) = &design.dk {
        drawn.extend(iteration(&design.problems, dk));
    }
    drawn
}

/// The D-K iteration and the reduction of its controller; without uncertainty there are no D-scales.
fn iteration(problems: &Problems, dk: &DkDesign) -> Vec<(Picture, Figure)> {
    let gamma: Vec<f64> = dk.steps.iter().map(|s| s.gamma).collect();
    let peak: Vec<f64> = dk.steps.iter().map(|s| s.mu_peak).collect();
    let orders: Vec<f64> = dk.orders_tried.iter().map(|o| 2.0 * o.0 as f64).collect();
    let values: Vec<f64> = dk.orders_tried.iter().map(|o| o.1).collect();
    let tried = Curve { name: "tried", role: Role::Other(0), x: &orders, y: &values };
    let chosen = (2.0 * dk.reduced.order as f64, dk.reduced.synthesis);
    let modes = problems.covered_modes.iter();
    let names: Vec<String> =
        modes.map(|mode| format!("mode {}", mode.number + 1)).chain(channel_names(&problems.aim)).collect();
    let scales = d_fits("D-scales of the uncertainty", &names, &dk.d_scales);
    let scales = (!dk.d_scales.is_empty()).then_some((Picture::DScales, scales));
    let title = "µ of the synthesis problem against the order of the controller";
    let others = [
        (Picture::MuIterations, mu_per_iteration("D-K iteration", &gamma, &peak)),
        (Picture::MuOrder, mu_against_order(title, &[tried], dk.reduction_limit, chosen)),
    ];
    scales.into_iter().chain(others).collect()
}

/// Pictures over speed: stability with its proof, and μ.
fn over_speed(design: &Design) -> [(Picture, Figure); 2] {
    let proof = &design.delivery.speed_proof;
    let speeds: Vec<f64> = design.delivery.speed_mu.iter().map(|s| s.speed_rpm).collect();
    let at_speed: Vec<f64> = design.delivery.speed_mu.iter().map(|s| s.mu).collect();
    let title = "Stability over speed, proven between the computed speeds";
    let stability = stability_over_speed(title, &proof.intervals, proof.to_rpm / OVERSPEED);
    let mu = mu_over_speed("µ of the specification over speed", &speeds, &at_speed);
    [(Picture::SpeedStability, stability), (Picture::MuSpeed, mu)]
}

/// A dynamic stiffness that is no prediction of a loop: measured, or a limit.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    pub name: String,
    /// What it stands for.
    pub role: Role,
    pub speed_rpm: f64,
    pub frequency_hz: Vec<f64>,
    /// |F/x|, N/m.
    pub stiffness_n_per_m: Vec<f64>,
}

impl Measured {
    /// The limit of the smallest stiffness at rest, as a line over the band of the stiffness.
    pub(crate) fn limit(limit: &StiffnessLimit, band_hz: (f64, f64)) -> Self {
        Self {
            name: "limit of the smallest stiffness".to_owned(),
            role: Role::Limit,
            speed_rpm: 0.0,
            frequency_hz: vec![band_hz.0, band_hz.1],
            stiffness_n_per_m: vec![limit.stiffness_n_per_m; 2],
        }
    }
}

/// Dynamic stiffness at the tool and sensitivity, at every speed given. A picture without a stable loop
/// or a record is left out.
pub(crate) fn predictions(
    runs: &[(Role, &Prediction)],
    measured: &[Measured],
    max_speed_hz: f64,
) -> Vec<(Picture, Figure)> {
    // An unstable loop has no response to draw.
    let runs: Vec<(Role, &Prediction)> = runs.iter().copied().filter(|(_, p)| p.is_stable()).collect();
    let mut speeds: Vec<f64> = runs.iter().map(|(_, p)| p.speed_rpm).collect();
    speeds.extend(measured.iter().map(|m| m.speed_rpm));
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    let mut figures = vec![];
    if !speeds.is_empty() {
        let panel = |rpm: &f64| {
            let predicted = runs.iter().filter(|(_, p)| p.speed_rpm == *rpm).map(|(role, p)| {
                let [own, _] = &p.stiffness;
                Curve { name: &p.name, role: *role, x: &own.frequency_hz, y: &own.magnitude_n_per_m }
            });
            let measured = measured.iter().filter(|m| m.speed_rpm == *rpm);
            let measured =
                measured.map(|m| Curve { name: &m.name, role: m.role, x: &m.frequency_hz, y: &m.stiffness_n_per_m });
            (format!("{rpm:.0} rpm"), predicted.chain(measured).collect::<Vec<Curve>>())
        };
        let panels: Vec<_> = speeds.iter().map(panel).collect();
        let figure = dynamic_stiffness("Dynamic stiffness at the tool", &panels, &[(max_speed_hz, "top speed")]);
        figures.push((Picture::Stiffness, figure));
    }
    if !runs.is_empty() {
        let magnitudes = |axis: usize| -> Vec<Vec<f64>> {
            runs.iter().map(|(_, p)| p.sensitivity.magnitude.iter().map(|s| s[axis]).collect()).collect()
        };
        let sides = [("front", magnitudes(0)), ("rear", magnitudes(2))];
        let mut panels: Vec<(String, Vec<Curve>)> = vec![];
        for (side, magnitudes) in &sides {
            for rpm in &speeds {
                let own = runs.iter().zip(magnitudes).filter(|((_, p), _)| p.speed_rpm == *rpm);
                let curves =
                    own.map(|((role, p), y)| Curve { name: &p.name, role: *role, x: &p.sensitivity.frequency_hz, y });
                panels.push((format!("{side}, {rpm:.0} rpm"), curves.collect()));
            }
        }
        figures.push((Picture::Sensitivity, sensitivity("Sensitivity and the zones of ISO 14839-3", &panels)));
    }
    figures
}
