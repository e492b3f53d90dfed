//! Where the disagreement sits, without a hypothesis.
//!
//! A change Δ(jω) at a port k gives F_new = F + b c Δ/(1 − g_kk Δ) with b = ∂x/∂f_k and c = ∂x_k/∂u. Line by line X = Δ/(1 − g_kk Δ) is
//! the weighted least squares fit ⟨B, R⟩/⟨B, B⟩ of the residual R by B = b c, and Δ = X/(1 + g_kk X) the impedance that is
//! missing. B and g_kk come from two small springs at the port. Rows (a sensor), columns (a current), all columns (the loop)
//! and the housing are ports of their own. Score: reduced χ² of what remains; shape: the simplest law that Δ follows.

use super::DiagnoseError;
use super::evidence::whiten;
use super::model::{Assembled, SIDE, Square, ZERO};
use super::search::{Search, Standing};
use crate::linalg::c64;
use crate::spindle::{Effect, EffectKind, Location};
use std::f64::consts::TAU;

/// Model floor of the localisation: coarse, so that sharp resonances do not decide alone.
const FLOOR: f64 = 3e-3;
/// Springs that probe a port, N/m: small against any stiffness of a shaft, large against rounding.
const PROBES_N_PER_M: [f64; 2] = [1e3, 1e6];

/// What a port explains.
#[derive(Clone, Debug)]
pub struct PortScore {
    /// The port.
    pub port: String,
    /// χ² per residual before, and with a free complex number per line at this port.
    pub chi2_before: f64,
    /// After.
    pub chi2_after: f64,
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// χ² per residual of every line after.
    pub line_chi2: Vec<f64>,
    /// Recovered law: impedance in N/m at mechanical ports, relative change at electrical ones.
    pub law: Vec<c64>,
    /// Its shape in words.
    pub shape: &'static str,
    /// Root mean square size of the law: N/m, or relative.
    pub size: f64,
    /// True for relative changes.
    pub relative: bool,
}

/// Ports, best first.
#[derive(Clone, Debug, Default)]
pub struct Localisation {
    /// Scores.
    pub ports: Vec<PortScore>,
}

enum Port {
    Station(f64),
    Row(usize),
    Column(usize),
    Loop,
    Housing,
    Cross(usize),
}

/// Looks for the place at the point from which a standing starts to fail.
///
/// # Errors
/// [`DiagnoseError`] when a model cannot be assembled.
pub fn localise(search: &Search, standing: &Standing) -> Result<Localisation, DiagnoseError> {
    let (model, machine) = (search.model, &search.model.machine);
    let planes = &machine.spindle.planes;
    let (from, to) = model.span_m();
    let ports = [
        ("tool", Port::Station(machine.tool_plane_m())),
        ("nose", Port::Station(0.0)),
        ("front actuator", Port::Station(planes.front_actuator_m)),
        (
            "middle",
            Port::Station(0.5 * (planes.front_actuator_m + planes.rear_actuator_m)),
        ),
        ("rear actuator", Port::Station(planes.rear_actuator_m)),
        ("tail", Port::Station(to.max(from))),
        ("front sensor", Port::Row(0)),
        ("rear sensor", Port::Row(1)),
        ("front current", Port::Column(0)),
        ("rear current", Port::Column(1)),
        ("loop (all currents)", Port::Loop),
        ("housing", Port::Housing),
        ("front axes (x to y)", Port::Cross(0)),
        ("rear axes (x to y)", Port::Cross(1)),
    ];
    let at = &standing.from;
    let named: Vec<Effect> = vec![];
    let mut scores = vec![];
    for (name, port) in ports {
        let mut score = PortScore {
            port: name.into(),
            chi2_before: 0.0,
            chi2_after: 0.0,
            frequency_hz: vec![],
            line_chi2: vec![],
            law: vec![],
            shape: "",
            size: 0.0,
            relative: !matches!(port, Port::Station(_) | Port::Housing),
        };
        let (mut before, mut after, mut count) = (0.0, 0.0, 0.0f64);
        for (s, sweep) in search.evidence.sweeps.iter().enumerate() {
            let assemble = |extra: Option<Effect>| -> Result<Assembled, DiagnoseError> {
                let effects: Vec<Effect> = named.iter().cloned().chain(extra).collect();
                model.assemble(&at.p, &effects, sweep.speed_rad_s, false)
            };
            let base = assemble(None)?;
            let probes: Vec<Assembled> = match port {
                Port::Station(z) => PROBES_N_PER_M
                    .iter()
                    .map(|k| {
                        assemble(Some(Effect {
                            kind: EffectKind::AddedStiffness,
                            location: Location::Position(z),
                            values: vec![*k],
                        }))
                    })
                    .collect::<Result<_, _>>()?,
                // A stator of 1e9 and 1e6 kg that hangs free: its flexibility −1/(mω²) is known at every line.
                Port::Housing => [1e9, 1e6]
                    .iter()
                    .map(|m| {
                        assemble(Some(Effect {
                            kind: EffectKind::HousingMode,
                            location: Location::None,
                            values: vec![*m, 1e-3, 0.0],
                        }))
                    })
                    .collect::<Result<_, _>>()?,
                _ => vec![],
            };
            for (line, omega) in sweep.omega_rad_s.iter().enumerate() {
                let f = base.line(*omega, None).response;
                let rows = sweep.whitening(line, FLOOR, true);
                let gain = |i: usize| 1.0 + at.p[model.layout.axis(s, i)];
                let white = |value: &dyn Fn(usize, usize) -> c64| {
                    let mut all = [ZERO; 16];
                    for i in 0..4 {
                        let mut d: [c64; 4] = std::array::from_fn(|j| value(i, j));
                        whiten(&rows[i], &mut d);
                        all[4 * i..4 * i + 4].copy_from_slice(&d);
                    }
                    all
                };
                let residual =
                    white(&|i, j| sweep.response[line][4 * i + j] - f[SIDE * i + j] * gain(i));
                let moved: Vec<Square> = probes
                    .iter()
                    .map(|p| p.line(*omega, None).response)
                    .collect();
                // Unit of the probe: force per displacement, or flexibility of the housing.
                let unit = |k: usize| match port {
                    Port::Housing => c64::new(-1.0 / ([1e9, 1e6][k] * omega * omega), 0.0),
                    _ => c64::new(-PROBES_N_PER_M[k], 0.0),
                };
                let direction = white(&|i, j| {
                    let own = f[SIDE * i + j];
                    match port {
                        Port::Row(b) if i / 2 == b => own,
                        Port::Column(b) if j / 2 == b => own,
                        Port::Loop => own,
                        Port::Cross(b) if i / 2 == b => {
                            if i % 2 == 0 {
                                f[SIDE * (i + 1) + j]
                            } else {
                                -f[SIDE * (i - 1) + j]
                            }
                        }
                        Port::Station(_) | Port::Housing => moved
                            .first()
                            .map_or(ZERO, |m| (m[SIDE * i + j] - own) / unit(0)),
                        _ => ZERO,
                    }
                });
                let power: f64 = direction.iter().map(|b| b.norm_sqr()).sum();
                let overlap = (0..16).fold(ZERO, |sum, n| sum + direction[n].conj() * residual[n]);
                let total: f64 = residual.iter().map(|r| r.norm_sqr()).sum();
                let x = if power > 0.0 { overlap / power } else { ZERO };
                let rest = (total - x.norm_sqr() * power).max(0.0);
                before += 2.0 * total;
                after += 2.0 * rest;
                count += 32.0;
                // (F(Δ₂) − F)/Δ₂ = B/(1 − g Δ₂): g from the entry that moves most.
                let own = match &moved[..] {
                    [small, large] => {
                        let best = (0..SIDE * SIDE)
                            .max_by(|a, b| {
                                (small[*a] - f[*a])
                                    .norm()
                                    .total_cmp(&(small[*b] - f[*b]).norm())
                            })
                            .unwrap_or_default();
                        let (b, c) = (
                            (small[best] - f[best]) / unit(0),
                            (large[best] - f[best]) / unit(1),
                        );
                        if c.norm() > 0.0 {
                            (c64::new(1.0, 0.0) - b / c) / unit(1)
                        } else {
                            ZERO
                        }
                    }
                    _ => ZERO,
                };
                score.frequency_hz.push(omega / TAU);
                score.line_chi2.push(2.0 * rest / 30.0);
                score.law.push(x / (c64::new(1.0, 0.0) + own * x));
            }
        }
        score.chi2_before = before / count.max(1.0);
        // One complex number per line is fitted.
        score.chi2_after = after / (count * 30.0 / 32.0).max(1.0);
        score.shape = shape(&score);
        let n = score.law.len().max(1) as f64;
        score.size = (score.law.iter().map(|x| x.norm_sqr()).sum::<f64>() / n).sqrt();
        scores.push(score);
    }
    scores.sort_by(|a, b| a.chi2_after.total_cmp(&b.chi2_after));
    Ok(Localisation { ports: scores })
}

/// The law that leaves the least of Δ, relative to its size; weights fall with |Δ| so that one resonance does not decide.
fn shape(score: &PortScore) -> &'static str {
    let omega: Vec<f64> = score.frequency_hz.iter().map(|f| TAU * f).collect();
    let laws: [(&str, &str, fn(f64) -> c64); 4] = [
        ("constant stiffness", "constant gain", |_| {
            c64::new(1.0, 0.0)
        }),
        ("mass (falls with −ω²)", "second order (ω²)", |w| {
            c64::new(-w * w, 0.0)
        }),
        (
            "damper (grows with jω)",
            "pure delay or fast lag (jω)",
            |w| c64::new(0.0, w),
        ),
        ("half-order loss (√jω)", "half order (√jω)", |w| {
            c64::new(0.0, w).sqrt()
        }),
    ];
    let norm: f64 = score.law.iter().map(|x| x.norm()).sum::<f64>() / score.law.len().max(1) as f64;
    let weight = |x: c64| (x.norm_sqr() + norm * norm).recip();
    let total: f64 = score.law.iter().map(|x| weight(*x) * x.norm_sqr()).sum();
    let mut best = (
        1.0,
        if score.relative {
            "a resonance, notch or step in frequency"
        } else {
            "a resonance"
        },
    );
    for (stiff, relative, law) in laws {
        let (mut top, mut bottom) = (0.0, f64::MIN_POSITIVE);
        for (x, w) in score.law.iter().zip(&omega) {
            let l = law(*w);
            top += weight(*x) * (l.conj() * x).re;
            bottom += weight(*x) * l.norm_sqr();
        }
        let left = if total > 0.0 {
            1.0 - top * top / bottom / total
        } else {
            1.0
        };
        // A simple law must carry two thirds of Δ.
        if left < 0.33 && left < best.0 {
            best = (left, if score.relative { relative } else { stiff });
        }
    }
    best.1
}
