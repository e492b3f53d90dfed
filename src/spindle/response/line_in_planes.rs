//! The response of a line where springs act in one plane only, with its derivatives.
//!
//! Such a spring joins forward and backward whirl. The receptances of both are brought to x and y, the ports of the
//! springs among them, and the springs are closed there:  X = H + H_f κ (I − H_ff κ)⁻¹ H_f, and a change dH of the open
//! one gives  dX = L dH R,  L = I + X_f κ E_fᵀ,  R = I + E_f κ X_f.

use super::assembled::{Assembled, PlanarLine, Receptance};
use super::channels::{IN, OUT, SIDE, Square, ZERO, in_pairs, planar};
use super::electronics::ElectronicsLine;
use super::feedback::{Feedback, close_in_planes};
use super::parameters::MachineParameters;
use super::sensitivity::{Between, WhirlLine};
use super::term::{Number, Sum, Term};
use crate::linalg::c64;
use crate::spindle::effects::Plane;

/// The shaft at one line, both ways round.
pub(super) struct Whirl {
    /// At ω.
    pub forward: PlanarLine,
    /// At −ω, where that differs.
    pub backward: Option<PlanarLine>,
    /// ω, rad/s.
    pub omega_rad_s: f64,
    /// Port of the first probe.
    pub first: usize,
}

/// Loops round a response with x and y apart, and that response with these loops closed.
struct ClosedPlanes {
    side: usize,
    loops: Vec<Feedback>,
    gains: Vec<c64>,
    response: Vec<c64>,
}

impl Receptance {
    /// F with the electronics round it.
    pub(super) fn behind(&self, electronics: &ElectronicsLine) -> Square {
        match &self.planes {
            None => electronics.apply(&self.plus, self.minus.as_ref()),
            Some(planes) => {
                let mut f = **planes;
                electronics.apply_with_pickup(&mut f, SIDE);
                f
            }
        }
    }
}

/// Derivative, without electronics, to a number of a law in one plane. `x` is the closed response from an input to an
/// output, each a port and a plane; `first` is the port of the first probe.
pub(super) fn in_plane(
    sum: &Sum,
    plane: Plane,
    first: usize,
    omega_rad_s: f64,
    x: impl Fn((usize, usize), (usize, usize)) -> c64,
) -> Square {
    let at = |probe: usize| (first + probe, plane as usize);
    std::array::from_fn(|n| {
        let (o, i) = ((OUT[n / SIDE / 2], n / SIDE % 2), (IN[n % SIDE / 2], n % SIDE % 2));
        sum.iter().fold(ZERO, |all, (factor, term)| {
            let own = match *term {
                Term::Bond(q, law) => x(o, at(q)) * x(at(q), i) * law.gain(omega_rad_s, 0.0),
                Term::Shift(q, slope, law) => {
                    let moved = x(o, at(slope)) * x(at(q), i) + x(o, at(q)) * x(at(slope), i);
                    moved * law.gain(omega_rad_s, 0.0)
                }
                _ => ZERO,
            };
            all + own * *factor
        })
    })
}

impl Whirl {
    /// Entry between two ports of the response in a plane and from one plane to the other, springs in one plane open.
    fn both(&self, out: usize, input: usize) -> (c64, c64) {
        let back = self.backward.as_ref().map(|b| b.entry(out, input));
        planar(self.forward.entry(out, input), back)
    }

    /// Entry of the response from one port and plane to another, springs in one plane open.
    pub(super) fn apart(&self, out: (usize, usize), input: (usize, usize)) -> c64 {
        let (same, x_to_y) = self.both(out.0, input.0);
        match (out.1, input.1) {
            (0, 1) => -x_to_y,
            (1, 0) => x_to_y,
            _ => same,
        }
    }
}

impl Assembled {
    /// The receptance with springs in one plane closed, the response, and its derivatives to moduli, ks, ln ζ and mesh
    /// when there are parameters, then to numbers.
    pub(super) fn line_in_planes(
        &self,
        whirl: &Whirl,
        parameters: Option<&MachineParameters>,
        numbers: &[Number],
    ) -> (Receptance, Square, Vec<Square>) {
        let acting: Vec<usize> = self.plane_laws.iter().map(|s| s.port).collect();
        let seen = [acting.clone(), seen_in_planes(numbers, whirl.first)].concat();
        let outs = [OUT.as_slice(), &seen].concat();
        let ins = [IN.as_slice(), &seen].concat();
        let closed = self.closed_in_planes(whirl, &outs, &ins);
        let planes: Square = std::array::from_fn(|n| closed.response[n / SIDE * closed.side + n % SIDE]);
        let receptance = Receptance {
            plus: self.pick(&whirl.forward),
            minus: whirl.backward.as_ref().map(|b| self.pick(b)),
            planes: Some(Box::new(planes)),
        };
        let electronics = ElectronicsLine::new(&self.effective, whirl.omega_rad_s);
        let response = receptance.behind(&electronics);
        let mut derivatives = vec![];
        if parameters.is_some() || !numbers.is_empty() {
            let inner = OUT.len() + acting.len();
            let between = Between { outs: &outs[..inner], ins: &ins[..inner] };
            let w = whirl.omega_rad_s;
            let first = whirl.first;
            let slopes = |at: &PlanarLine, omega_rad_s: f64| {
                self.slopes(&WhirlLine { at, omega_rad_s, first }, between, parameters, numbers)
            };
            let plus = slopes(&whirl.forward, w);
            let minus = whirl.backward.as_ref().map(|b| slopes(b, -w));
            let x = |out: (usize, usize), input: (usize, usize)| {
                let row = |all: &[usize], port| all.iter().position(|p| *p == port);
                match (row(&outs, out.0), row(&ins, input.0)) {
                    (Some(o), Some(i)) => closed.response[(2 * o + out.1) * closed.side + 2 * i + input.1],
                    _ => ZERO,
                }
            };
            let size = inner * inner;
            let count = plus.len() / size;
            let small = count - numbers.len();
            derivatives.extend((0..count).map(|k| {
                let mut own = match k.checked_sub(small).map(|n| &numbers[n]) {
                    Some(Number::Electronics(change)) => {
                        return change.slope(&self.effective, &response, w);
                    }
                    Some(Number::InPlane(sum, plane)) => in_plane(sum, *plane, whirl.first, w, x),
                    _ => {
                        let open =
                            in_pairs(inner, |n| planar(plus[k * size + n], minus.as_ref().map(|m| m[k * size + n])));
                        closed.change(&open, 2 * inner)
                    }
                };
                electronics.apply_to(&mut own, SIDE);
                own
            }));
        }
        (receptance, response, derivatives)
    }

    fn closed_in_planes(&self, whirl: &Whirl, outs: &[usize], ins: &[usize]) -> ClosedPlanes {
        let side = 2 * outs.len();
        let open = in_pairs(outs.len(), |n| whirl.both(outs[n / ins.len()], ins[n % ins.len()]));
        let springs = (OUT.len(), self.plane_laws.as_slice());
        let (loops, response) = close_in_planes(&open, side, springs.0, springs.1, whirl.omega_rad_s);
        let gains = loops.iter().map(|f| f.gain(whirl.omega_rad_s));
        ClosedPlanes { gains: gains.collect(), response, side, loops }
    }
}

impl ClosedPlanes {
    /// L dH R between the six outer channels, of a change `open` of the open response, `side` × `side`.
    fn change(&self, open: &[c64], side: usize) -> Square {
        let one = c64::new(1.0, 0.0);
        std::array::from_fn(|n| {
            let (o, i) = (n / SIDE, n % SIDE);
            let loops = || self.loops.iter().map(|f| f.port).zip(&self.gains);
            let left = loops().map(|(f, gain)| (f, self.response[o * self.side + f] * gain));
            let mut sum = ZERO;
            for (a, l) in left.chain([(o, one)]) {
                let right = loops().map(|(f, gain)| (f, self.response[f * self.side + i] * gain));
                for (b, r) in right.chain([(i, one)]) {
                    sum += l * open[a * side + b] * r;
                }
            }
            sum
        })
    }
}

/// Ports of the probes that numbers of laws in one plane look at.
fn seen_in_planes(numbers: &[Number], first: usize) -> Vec<usize> {
    let mut all = vec![];
    let sums = numbers.iter().filter_map(|number| match number {
        Number::InPlane(sum, _) => Some(sum),
        _ => None,
    });
    for (_, term) in sums.flatten() {
        let (at, along) = match *term {
            Term::Bond(q, _) => (q, q),
            Term::Shift(q, slope, _) => (q, slope),
            _ => continue,
        };
        for port in [first + at, first + along] {
            if !all.contains(&port) {
                all.push(port);
            }
        }
    }
    all
}
