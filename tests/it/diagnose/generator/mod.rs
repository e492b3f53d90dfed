//! An independent simulator of sweeps and hammer tests, for hidden effects: own element matrices, a mesh three times as
//! fine as the file's, all modes of it, exact delay, the loop closed with the PID, noise and small errors drawn from a
//! seed.
//! It shares with the program only the domain values of the machine and the dense eigensolver.

pub mod site;

use muspin::controller::Controller;
use muspin::identify::{HammerFrf, SweepRecord};
use muspin::linalg::{Mat, c64, definite_eigen, solve_complex};
use muspin::lti::HeldResponse;
use muspin::rotor::Section;
use muspin::spindle::{Effect, EffectKind, Location, Machine};
use ndarray::Array4;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

const CUTS: usize = 3;
/// Modes coupled gyroscopically, and damped at random; the others stand alone.
const MODES: usize = 60;

/// What no catalogue holds.
#[derive(Clone, Copy, Debug)]
pub enum Outside {
    /// A notch in a bearing's sensors: Hz, damping of zero and pole.
    Notch(usize, f64, f64, f64),
    /// An absorber at a position: kg, Hz, damping.
    Absorber(f64, f64, f64, f64),
    /// Share of the front current that reaches the rear bearing.
    CrossTalk(f64),
    /// A resonance of the rear actuator: Hz, damping, height.
    ActuatorResonance(f64, f64, f64),
    /// A front sensor that reads backwards-moving tilt: rad to m.
    Tilt(f64),
}

/// A drawn measurement.
pub struct Drawn {
    pub sweep: SweepRecord,
    pub hammer: HammerFrf,
}

pub struct Draw {
    rng: ChaCha8Rng,
}

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self { rng: ChaCha8Rng::seed_from_u64(seed) }
    }
    pub fn normal(&mut self) -> f64 {
        let (a, b): (f64, f64) = (self.rng.random(), self.rng.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
    }
    pub fn uniform(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.rng.random::<f64>()
    }
    fn complex(&mut self, sd: f64) -> c64 {
        c64::new(self.normal() * sd / 2f64.sqrt(), self.normal() * sd / 2f64.sqrt())
    }
}

type Small = [[f64; 4]; 4];

/// Stiffness, mass with rotary inertia, gyroscopic matrix of a Timoshenko cylinder.
fn element(s: &Section, length: f64, scale: f64) -> (Small, Small, Small) {
    let (e, nu) = (s.material.youngs_modulus_pa * s.modulus_scale * scale, s.material.poisson_ratio);
    let (d, b) = (s.outer_diameter_m[0], s.inner_diameter_m[0]);
    let (dm, bm) = (s.mass_outer_diameter_m[0], s.mass_inner_diameter_m[0]);
    let (area, inertia) = (PI / 4.0 * (d * d - b * b), PI / 64.0 * (d.powi(4) - b.powi(4)));
    let m = b / d;
    let q = (1.0 + m * m).powi(2);
    let kappa = 6.0 * (1.0 + nu) * q / ((7.0 + 6.0 * nu) * q + (20.0 + 12.0 * nu) * m * m);
    let l = length;
    let f = 12.0 * e * inertia / (e / (2.0 * (1.0 + nu)) * area * kappa * l * l);
    let g = e * inertia / (l.powi(3) * (1.0 + f));
    let k = [
        [12.0, 6.0 * l, -12.0, 6.0 * l],
        [6.0 * l, (4.0 + f) * l * l, -6.0 * l, (2.0 - f) * l * l],
        [-12.0, -6.0 * l, 12.0, -6.0 * l],
        [6.0 * l, (2.0 - f) * l * l, -6.0 * l, (4.0 + f) * l * l],
    ]
    .map(|r| r.map(|x| x * g));
    let rho = s.material.density_kg_m3;
    let t = rho * PI / 4.0 * (dm * dm - bm * bm) * l / (840.0 * (1.0 + f).powi(2));
    let (m1, m2) = (312.0 + 588.0 * f + 280.0 * f * f, (44.0 + 77.0 * f + 35.0 * f * f) * l);
    let (m3, m4) = (108.0 + 252.0 * f + 140.0 * f * f, -(26.0 + 63.0 * f + 35.0 * f * f) * l);
    let (m5, m6) = ((8.0 + 14.0 * f + 7.0 * f * f) * l * l, -(6.0 + 14.0 * f + 7.0 * f * f) * l * l);
    let w = rho * PI / 64.0 * (dm.powi(4) - bm.powi(4)) / (30.0 * l * (1.0 + f).powi(2));
    let (a, c) = (36.0, (3.0 - 15.0 * f) * l);
    let (x, y) = ((4.0 + 5.0 * f + 10.0 * f * f) * l * l, (-1.0 - 5.0 * f + 5.0 * f * f) * l * l);
    let r = [[a, c, -a, c], [c, x, -c, y], [-a, -c, a, -c], [c, y, -c, x]].map(|r| r.map(|v| v * w));
    let shift = [[m1, m2, m3, m4], [m2, m5, -m4, m6], [m3, -m4, m1, -m2], [m4, m6, -m2, m5]];
    let mut mass = shift.map(|r| r.map(|v| v * t));
    for i in 0..4 {
        for j in 0..4 {
            mass[i][j] += r[i][j];
        }
    }
    (k, mass, r.map(|row| row.map(|v| 2.0 * v)))
}

/// Simulates a machine with hidden effects at a speed.
pub fn simulate(
    machine: &Machine,
    controller: &Controller,
    effects: &[Effect],
    outside: Option<Outside>,
    speed_rad_s: f64,
    frequency_hz: &[f64],
    draw: &mut Draw,
) -> Drawn {
    let of = |kind: EffectKind| effects.iter().filter(move |e| e.kind == kind);
    let at_bearing = |kind: EffectKind, b: usize| -> Option<f64> {
        of(kind).find_map(|e| match &e.location {
            Location::Bearing(w) if w.includes(b) => Some(e.values[0]),
            _ => None,
        })
    };
    // Mesh, tool tip first.
    let tool = machine.tool.sections.iter().rev().map(|s| (s, true));
    let sections: Vec<(&Section, bool)> = tool.chain(machine.spindle.sections.iter().map(|s| (s, false))).collect();
    let joint = of(EffectKind::ToolJoint).next();
    let mut z = vec![-machine.tool.length_m()];
    let mut spans = vec![];
    for (i, (s, is_tool)) in sections.iter().enumerate() {
        if joint.is_some() && !is_tool && sections[i - 1].1 {
            z.push(z[z.len() - 1]);
        }
        let factor: f64 = of(EffectKind::RegionStiffness)
            .filter(|e| matches!(&e.location, Location::Region(r) if Some(r) == s.region.as_ref()))
            .map(|e| e.values[0])
            .product();
        let scale = factor * (1.0 + 0.01 * draw.normal());
        for _ in 0..CUTS {
            z.push(z[z.len() - 1] + s.length_m / CUTS as f64);
            spans.push((z.len() - 2, s.length_m / CUTS as f64, *s, scale));
        }
    }
    let n = 2 * z.len();
    let (mut k, mut m, mut g) = (Mat::<f64>::zeros(n, n), Mat::<f64>::zeros(n, n), Mat::<f64>::zeros(n, n));
    for (left, length, s, scale) in &spans {
        let (ke, me, ge) = element(s, *length, *scale);
        for i in 0..4 {
            for j in 0..4 {
                k[(2 * left + i, 2 * left + j)] += ke[i][j];
                m[(2 * left + i, 2 * left + j)] += me[i][j];
                g[(2 * left + i, 2 * left + j)] += ge[i][j];
            }
        }
    }
    for d in &machine.spindle.discs {
        let node =
            (0..z.len()).min_by(|a, b| (z[*a] - d.position_m).abs().total_cmp(&(z[*b] - d.position_m).abs())).unwrap();
        m[(2 * node, 2 * node)] += d.mass_kg;
        m[(2 * node + 1, 2 * node + 1)] += d.diametral_inertia_kg_m2;
        g[(2 * node + 1, 2 * node + 1)] += d.polar_inertia_kg_m2;
    }
    let row = |p: f64| -> Vec<f64> {
        let (left, l, ..) = spans.iter().rev().find(|(a, ..)| z[*a] <= p + 1e-9).unwrap_or(&spans[0]);
        let s = (p - z[*left]) / l;
        let mut r = vec![0.0; n];
        r[2 * left] = 1.0 - 3.0 * s * s + 2.0 * s.powi(3);
        r[2 * left + 1] = l * (s - 2.0 * s * s + s.powi(3));
        r[2 * left + 2] = 3.0 * s * s - 2.0 * s.powi(3);
        r[2 * left + 3] = l * (s.powi(3) - s * s);
        r
    };
    let slope = |p: f64| -> Vec<f64> {
        let (ahead, behind) = (row(p + 1e-4), row(p - 1e-4));
        let both = ahead.iter().zip(&behind);
        both.map(|(a, b)| (a - b) / 2e-4).collect()
    };
    // Rotation of the section, linear between the nodes of this mesh.
    let turned = |p: f64| -> Vec<f64> {
        let (left, l, ..) = spans.iter().rev().find(|(a, ..)| z[*a] <= p + 1e-9).unwrap_or(&spans[0]);
        let mut r = vec![0.0; n];
        (r[2 * left + 1], r[2 * left + 3]) = (1.0 - (p - z[*left]) / l, (p - z[*left]) / l);
        r
    };
    for e in effects {
        let p = match (e.kind, &e.location) {
            (EffectKind::ToolMass, _) => z[0],
            (EffectKind::AddedMass, Location::Position(p)) => *p,
            _ => continue,
        };
        let r = row(p);
        m = Mat::from_fn(n, n, |i, j| m[(i, j)] + e.values[0] * r[i] * r[j]);
    }
    let mut relative = vec![0.0; n];
    if let Some(e) = joint {
        let a = 2 * CUTS * machine.tool.sections.len();
        for d in 0..2 {
            for (i, j, sign) in [(a, a, 1.0), (a + 2, a + 2, 1.0), (a, a + 2, -1.0), (a + 2, a, -1.0)] {
                k[(i + d, j + d)] += sign * e.values[d];
            }
        }
        (relative[a + 1], relative[a + 3]) = (1.0, -1.0);
    }
    // Modes; a spring of 1 N/m on every deflection keeps the rigid ones off zero.
    let lifted = Mat::from_fn(n, n, |i, j| k[(i, j)] + if i == j && i % 2 == 0 { 1.0 } else { 0.0 });
    let modes = definite_eigen(&lifted, &m).expect("modes");
    let count = n;
    let omega: Vec<f64> = modes.values.iter().take(count).map(|v| v.max(0.0).sqrt()).collect();
    let amplitude =
        |r: &[f64]| -> Vec<f64> { (0..count).map(|c| (0..n).map(|i| r[i] * modes.vectors[(i, c)]).sum()).collect() };
    let nominal = &machine.spindle.damping_ratio;
    let zeta: Vec<f64> = (0..count)
        .map(|c| {
            if c < 2 {
                return 0.0;
            }
            let factor: f64 = of(EffectKind::ModalDamping)
                .filter(|e| e.location == Location::Mode(c - 1))
                .map(|e| e.values[0])
                .product();
            let own = if c < MODES { draw.normal() } else { 0.0 };
            nominal[(c - 2).min(nominal.len() - 1)] * factor * (1.0 + 0.2 * own).max(0.1)
        })
        .collect();
    let loss = of(EffectKind::InternalDamping).map(|e| e.values[0]).sum::<f64>();
    let gyro =
        of(EffectKind::Gyroscopic).next().map_or(f64::from(u8::from(machine.spindle.gyroscopics)), |e| e.values[0]);
    let shapes = Mat::from_fn(n, MODES.min(n), |i, c| modes.vectors[(i, c)]);
    let gm = shapes.transpose() * (&g * &shapes);
    let planes = &machine.spindle.planes;
    let offset = |kind, b| at_bearing(kind, b).unwrap_or(0.0);
    let actuators = [planes.front_actuator_m, planes.rear_actuator_m];
    let sensors = [planes.front_sensor_m, planes.rear_sensor_m];
    let mut ports = vec![amplitude(&row(machine.tool_plane_m()))];
    for b in 0..2 {
        ports.push(amplitude(&row(actuators[b] + offset(EffectKind::ActuatorOffset, b))));
    }
    for b in 0..2 {
        let p = sensors[b] + offset(EffectKind::SensorOffset, b);
        let mut r = row(p);
        if let (Some(Outside::Tilt(arm)), 0) = (outside, b) {
            for (r, slope) in r.iter_mut().zip(slope(p)) {
                *r += arm * slope;
            }
        }
        ports.push(amplitude(&r));
    }
    let bearings = [&machine.spindle.front, &machine.spindle.rear];
    let drawn: Vec<[f64; 3]> =
        (0..2).map(|_| [1.0 + 0.02 * draw.normal(), 1.0 + 0.04 * draw.normal(), 1.0 + 0.01 * draw.normal()]).collect();
    let factor = |kind, b| at_bearing(kind, b).unwrap_or(1.0);
    let ki: Vec<f64> =
        (0..2).map(|b| bearings[b].ki_n_per_a * drawn[b][0] * factor(EffectKind::ForceConstant, b)).collect();
    let ks: Vec<f64> =
        (0..2).map(|b| bearings[b].ks_n_per_m * drawn[b][1] * factor(EffectKind::NegativeStiffness, b)).collect();
    let gain: Vec<f64> =
        (0..2).map(|b| bearings[b].sensor_gain * drawn[b][2] * factor(EffectKind::SensorGain, b)).collect();
    // Extra ports: springs, circulatory forces, absorber, joint damping. Those of laws in one plane, (port, plane, N/m,
    // N s/m), stay open in r = x + jy.
    let mut extra: Vec<Box<dyn Fn(f64) -> c64>> = vec![];
    let mut in_plane: Vec<(usize, usize, [f64; 2])> = vec![];
    for e in effects {
        let value = e.values[0];
        match (e.kind, &e.location) {
            (EffectKind::AddedStiffness, Location::Position(p)) => {
                ports.push(amplitude(&row(*p)));
                extra.push(Box::new(move |_| c64::new(-value, 0.0)));
            }
            (EffectKind::AddedDamper, Location::Position(p)) => {
                ports.push(amplitude(&row(*p)));
                extra.push(Box::new(move |w| c64::new(0.0, -w * value)));
            }
            (EffectKind::AddedDisc, Location::Position(p)) => {
                let (polar, diametral) = (e.values[1], e.values[2]);
                ports.push(amplitude(&row(*p)));
                extra.push(Box::new(move |w| c64::new(w * w * value, 0.0)));
                ports.push(amplitude(&turned(*p)));
                extra.push(Box::new(move |w| c64::new(w * w * diametral - w * speed_rad_s * gyro * polar, 0.0)));
            }
            (EffectKind::AddedStiffness | EffectKind::AddedDamper, Location::InPlane(p, plane)) => {
                let both = if e.kind == EffectKind::AddedDamper { [0.0, value] } else { [value, 0.0] };
                in_plane.push((ports.len(), *plane as usize, both));
                ports.push(amplitude(&row(*p)));
                extra.push(Box::new(|_| c64::new(0.0, 0.0)));
            }
            (EffectKind::CrossCoupling, Location::Position(p)) => {
                ports.push(amplitude(&row(*p)));
                extra.push(Box::new(move |_| c64::new(0.0, value)));
            }
            (EffectKind::TiltingStiffness, Location::Position(p)) => {
                ports.push(amplitude(&slope(*p)));
                extra.push(Box::new(move |_| c64::new(-value, 0.0)));
            }
            _ => {}
        }
    }
    if let Some(e) = joint {
        let c = e.values[2];
        ports.push(amplitude(&relative));
        extra.push(Box::new(move |w| c64::new(0.0, -w * c)));
    }
    if let Some(Outside::Absorber(p, mass, hz, damping)) = outside {
        ports.push(amplitude(&row(p)));
        extra.push(Box::new(move |w| {
            let own = TAU * hz;
            let path = c64::new(own * own, 2.0 * damping * own * w);
            mass * w * w * path / (path - w * w)
        }));
    }
    let housing = of(EffectKind::HousingMode).next().map(|e| e.values.clone());
    // Receptance with the magnets closed.
    let planar = |w: f64, ks: &[f64]| -> Mat<c64> {
        let p = ports.len();
        let diagonal = |c: usize| {
            let own = omega[c] * omega[c];
            c64::new(own - w * w, w * (2.0 * zeta[c] * omega[c] + loss * own) - speed_rad_s * loss * own)
        };
        let mut x = Mat::from_fn(count, p, |c, j| diagonal(c).inv() * ports[j][c]);
        if speed_rad_s != 0.0 && gyro != 0.0 {
            let coupled = MODES.min(count);
            let dynamic = Mat::from_fn(coupled, coupled, |i, j| {
                let own = if i == j { diagonal(i) } else { c64::new(0.0, 0.0) };
                own + w * speed_rad_s * gyro * gm[(i, j)]
            });
            let own = solve_complex(&dynamic, &Mat::from_fn(coupled, p, |c, j| c64::new(ports[j][c], 0.0)));
            for c in 0..coupled {
                for j in 0..p {
                    x[(c, j)] = own[(c, j)];
                }
            }
        }
        let mut h = Mat::from_fn(p, p, |i, j| {
            let mut sum = c64::new(0.0, 0.0);
            for c in 0..count {
                sum += x[(c, j)] * ports[i][c];
            }
            sum
        });
        if let Some(v) = &housing {
            let own = TAU * v[1];
            let flexibility = (c64::new(own * own - w * w, 2.0 * v[2] * own * w) * v[0]).inv();
            for i in 1..5 {
                for j in 1..5 {
                    h[(i, j)] += flexibility;
                }
            }
        }
        let kappa = |j: usize| match j {
            1 | 2 => c64::new(ks[j - 1], 0.0),
            j if j >= 5 => extra[j - 5](w),
            _ => c64::new(0.0, 0.0),
        };
        let loop_matrix = Mat::from_fn(p, p, |i, j| c64::new(f64::from(u8::from(i == j)), 0.0) - h[(i, j)] * kappa(j));
        solve_complex(&loop_matrix, &h)
    };
    let e = &machine.spindle.electronics;
    let everywhere = of(EffectKind::LoopDelay).filter(|e| e.location == Location::None);
    let delay = e.delay_s + everywhere.map(|e| e.values[0]).sum::<f64>();
    let at_axis = |kind: EffectKind, axis: usize| {
        let here = |e: &&Effect| match e.location {
            Location::Axis(own) => own == axis,
            Location::Bearing(which) => which.includes(axis / 2),
            _ => false,
        };
        of(kind).rfind(here).map(|e| e.values.clone())
    };
    let first = |values: Vec<f64>| values[0];
    // 6×6: sensors and tool from currents and tool force.
    let full = |hz: f64| -> Mat<c64> {
        let w = TAU * hz;
        let s = c64::new(0.0, w);
        let open: Vec<usize> = in_plane.iter().map(|s| s.0).collect();
        let outs = [&[3usize, 4, 0], open.as_slice()].concat();
        let ins = [&[1usize, 2, 0], open.as_slice()].concat();
        let mut f = Mat::<c64>::zeros(2 * outs.len(), 2 * ins.len());
        let (plus, minus) = (planar(w, &ks), planar(-w, &ks));
        for (o, out) in outs.iter().copied().enumerate() {
            for (i, input) in ins.iter().copied().enumerate() {
                let (a, b) = (plus[(out, input)], minus[(out, input)].conj());
                f[(2 * o, 2 * i)] = 0.5 * (a + b);
                f[(2 * o + 1, 2 * i + 1)] = 0.5 * (a + b);
                f[(2 * o + 1, 2 * i)] = (a - b) / c64::new(0.0, 2.0);
                f[(2 * o, 2 * i + 1)] = -(a - b) / c64::new(0.0, 2.0);
            }
        }
        // (1 + F K) X = F of the laws in one plane.
        let law = |j: usize| match j.checked_sub(6) {
            Some(k) if in_plane[k / 2].1 == k % 2 => c64::new(in_plane[k / 2].2[0], w * in_plane[k / 2].2[1]),
            _ => c64::new(0.0, 0.0),
        };
        let loop_matrix =
            Mat::from_fn(f.nrows(), f.nrows(), |i, j| c64::new(f64::from(u8::from(i == j)), 0.0) + f[(i, j)] * law(j));
        let f = solve_complex(&loop_matrix, &f).submatrix(0, 0, 6, 6).to_owned();
        let one = c64::new(1.0, 0.0);
        // Command to coil current.
        let coil_current = |axis: usize| {
            let later = of(EffectKind::LoopDelay).filter(|e| e.location == Location::Axis(axis));
            let delay = delay + later.map(|e| e.values[0]).sum::<f64>();
            let amplifier = match at_axis(EffectKind::AmplifierSecondOrder, axis) {
                Some(values) => {
                    let w0 = TAU * values[0];
                    c64::new(w0 * w0, 0.0) / (s * s + 2.0 * values[1] * w0 * s + w0 * w0)
                }
                None => {
                    let own = at_axis(EffectKind::AmplifierBandwidth, axis).map(first);
                    one / (one + s / (TAU * own.unwrap_or(e.amplifier_bandwidth_hz)))
                }
            };
            amplifier * (-s * delay).exp()
        };
        let mut inputs = Mat::<c64>::identity(6, 6);
        let mut outputs = Mat::<c64>::identity(6, 6);
        for b in 0..2 {
            let cross = offset(EffectKind::BearingCoupling, b);
            let mut sense = [c64::new(0.0, 0.0); 2];
            for x in 0..2 {
                let axis = 2 * b + x;
                let current = coil_current(axis);
                let mut act = ki[b] * current;
                if let Some(corner) = at_axis(EffectKind::EddyCurrents, axis).map(first) {
                    act /= one + (s / (TAU * corner)).sqrt();
                }
                if let Some(corner) = at_axis(EffectKind::LaminatedCore, axis).map(first) {
                    let x = (s / (TAU * corner)).sqrt();
                    act *= x.sinh() / x.cosh() / x;
                }
                if let (Some(Outside::ActuatorResonance(hz, damping, height)), 1) = (outside, b) {
                    let q = s / (TAU * hz);
                    act *= one + height * q * q / (one + 2.0 * damping * q + q * q);
                }
                inputs[(axis, axis)] = act;
                inputs[(2 * b + 1 - x, axis)] = act * cross;
                sense[x] = gain[b] / (one + s / (TAU * e.sensor_bandwidth_hz));
                if let Some(hz) = at_axis(EffectKind::SensorLowpass, axis).map(first) {
                    let q = s / (TAU * hz);
                    sense[x] /= one + 2.0 * 0.707 * q + q * q;
                }
            }
            if let Some(Outside::Notch(which, hz, zero, pole)) = outside
                && which == b
            {
                let q = s / (TAU * hz);
                sense = sense.map(|sense| sense * (one + 2.0 * zero * q + q * q) / (one + 2.0 * pole * q + q * q));
            }
            let (sin, cos) = offset(EffectKind::AxisMisalignment, b).to_radians().sin_cos();
            outputs[(2 * b, 2 * b)] = sense[0] * cos;
            outputs[(2 * b, 2 * b + 1)] = sense[0] * sin;
            outputs[(2 * b + 1, 2 * b)] = -sense[1] * sin;
            outputs[(2 * b + 1, 2 * b + 1)] = sense[1] * cos;
        }
        if let Some(Outside::CrossTalk(share)) = outside {
            inputs[(2, 0)] = inputs[(2, 2)] * share;
            inputs[(3, 1)] = inputs[(3, 3)] * share;
        }
        let unmixed = outputs.clone();
        for e in effects.iter().filter(|e| e.kind == EffectKind::SensorCrosstalk) {
            if let Location::Across { from, to } = e.location {
                for j in 0..outputs.ncols() {
                    outputs[(to, j)] += unmixed[(from, j)] * e.values[0];
                }
            }
        }
        let mut all = outputs * f * inputs;
        for e in effects.iter().filter(|e| e.kind == EffectKind::CurrentPickup) {
            if let Location::Across { from, to } = e.location {
                all[(to, from)] += s * coil_current(from) * e.values[0];
            }
        }
        all
    };
    // Four injections, three repeats: y = G u + n, u = K y + r, sensor noise 0.7 nm, an axis gain of 0.1 % at every
    // levitation.
    let (lines, repeats) = (frequency_hz.len(), 3);
    let zero = c64::new(0.0, 0.0);
    let mut current = Array4::from_elem((lines, 4, repeats, 4), zero);
    let mut signal = current.clone();
    let mut compliance = vec![];
    let gains: Vec<f64> = (0..4 * repeats).map(|_| 1.0 + 1e-3 * draw.normal()).collect();
    for (l, hz) in frequency_hz.iter().enumerate() {
        let (f, kc) = (full(*hz), controller.held_at(TAU * hz));
        let gyu = Mat::from_fn(4, 4, |i, j| f[(i, j)]);
        for p in 0..repeats {
            let own = Mat::from_fn(4, 4, |i, j| gyu[(i, j)] * gains[4 * p + i]);
            let unit = Mat::<c64>::identity(4, 4) - &own * &kc;
            for experiment in 0..4 {
                let r = Mat::from_fn(4, 1, |i, _| if i == experiment { c64::new(0.1, 0.0) } else { zero });
                let noise = Mat::from_fn(4, 1, |_, _| draw.complex(0.7e-9));
                let y = solve_complex(&unit, &(&own * &r + &noise));
                let u = &kc * &y + &r;
                for axis in 0..4 {
                    current[(l, experiment, p, axis)] = u[(axis, 0)];
                    signal[(l, experiment, p, axis)] = y[(axis, 0)];
                }
            }
        }
        let unit = Mat::<c64>::identity(4, 4) - &gyu * &kc;
        let y = solve_complex(&unit, &Mat::from_fn(4, 1, |i, _| f[(i, 4)]));
        let u = &kc * &y;
        let mut h = f[(4, 4)];
        for i in 0..4 {
            h += f[(4, i)] * u[(i, 0)];
        }
        compliance.push(h + draw.complex(4e-3 * h.norm()) + draw.complex(3e-10));
    }
    let coherence = compliance
        .iter()
        .map(|h| {
            // Inverse of σ² = |h|²(1−γ²)/(nγ²) at ten averages.
            let ratio = ((4e-3f64).powi(2) + (3e-10 / h.norm()).powi(2)) * 10.0;
            1.0 / (1.0 + ratio)
        })
        .collect();
    let speed_rpm = speed_rad_s * 60.0 / TAU;
    Drawn {
        sweep: SweepRecord {
            name: "drawn".into(),
            speed_rpm,
            frequency_hz: frequency_hz.to_vec(),
            current,
            signal,
            left_out: vec![],
            run_out: false,
        },
        hammer: HammerFrf {
            speed_rpm,
            frequency_hz: frequency_hz.to_vec(),
            compliance,
            coherence: Some(coherence),
            averages: Some(vec![10.0; lines]),
        },
    }
}
