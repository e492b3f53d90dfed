//! Closed loops of several rotors at one line, four at a time: what the loss asks of every rotor, and the rest, which
//! only the nominal ones are asked.

use super::loop_state::LoopState;
use super::matrix2::Matrix2;
use super::responses::LoopResponse;
use crate::linalg::c64;
use crate::linalg::lanes::{Lanes, Reals};

/// Responses of four loops at a line.
#[derive(Clone, Debug)]
pub(super) struct PackedLoops {
    loops: [[Lanes; 2]; 2],
    read: [Lanes; 2],
    drive: [Lanes; 2],
    tool: Lanes,
}

/// Four closed loops.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedState {
    /// det(I − G K) without integrators.
    pub determinant: Lanes,
    /// S₁₁ and S₂₂ of S = (I − G K)⁻¹.
    pub sensitivity: [Lanes; 2],
    /// Compliance of the tool, m/N.
    pub compliance: Lanes,
}

/// Four closed loops with what only nominal ones are asked.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedNominal {
    pub state: PackedState,
    /// S₁₂ and S₂₁.
    beside: [Lanes; 2],
    /// R = K S, A/m.
    r: [[Lanes; 2]; 2],
}

impl PackedNominal {
    /// One of the four.
    #[inline]
    pub(super) fn lane(&self, l: usize) -> LoopState {
        let ([front, rear], [first, second]) = (&self.state.sensitivity, &self.beside);
        LoopState {
            s: [[front.lane(l), first.lane(l)], [second.lane(l), rear.lane(l)]],
            r: [0, 1].map(|i| [0, 1].map(|j| self.r[i][j].lane(l))),
            compliance: self.state.compliance.lane(l),
        }
    }

    /// Σ_j |R_ij|² for both currents i, (A/m)².
    #[inline]
    pub(super) fn currents(&self) -> [Reals; 2] {
        self.r.map(|[first, second]| first.squares() + second.squares())
    }
}

impl PackedLoops {
    /// Up to four loops at a line; what is missing of four is zero.
    pub(super) fn new(list: &[&LoopResponse]) -> Self {
        let four = |at: &dyn Fn(&LoopResponse) -> c64| Lanes::of_list(list, |own| at(own));
        Self {
            loops: [0, 1].map(|i| [0, 1].map(|j| four(&|l| l.loops[i][j]))),
            read: [0, 1].map(|k| four(&|l| l.read[k])),
            drive: [0, 1].map(|k| four(&|l| l.drive[k])),
            tool: four(&|l| l.tool),
        }
    }

    /// The loops closed by K = `gain`, of which `free` leaves out the integrators.
    #[inline]
    pub(super) fn close_loops(&self, gain: &Matrix2, free: c64) -> PackedState {
        self.closed_with(gain, free).0
    }

    /// As [`Self::close_loops`], with the rest.
    #[inline]
    pub(super) fn closed_nominal(&self, gain: &Matrix2, free: c64) -> PackedNominal {
        let (state, [b, c], inverse) = self.closed_with(gain, free);
        let opposite = Lanes::ZERO.minus(&inverse);
        let beside = [b.product(&opposite), c.product(&opposite)];
        let ([front, rear], [first, second]) = (&state.sensitivity, &beside);
        let entry =
            |i: usize, above: &Lanes, below: &Lanes| Lanes::ZERO.plus(gain[i][0], above).plus(gain[i][1], below);
        PackedNominal { r: [0, 1].map(|i| [entry(i, front, second), entry(i, first, rear)]), beside, state }
    }

    /// The loops closed, the entries beside the diagonal of I − G K, and 1/det(I − G K).
    #[inline(always)]
    fn closed_with(&self, gain: &Matrix2, free: c64) -> (PackedState, [Lanes; 2], Lanes) {
        let g = &self.loops;
        // I − G K.
        let open = |i: usize, j: usize| {
            let unit = if i == j { Lanes::ONE } else { Lanes::ZERO };
            unit.plus(-gain[0][j], &g[i][0]).plus(-gain[1][j], &g[i][1])
        };
        let ([a, b], [c, d]) = ([open(0, 0), open(0, 1)], [open(1, 0), open(1, 1)]);
        let determinant = a.product(&d).minus(&b.product(&c));
        let inverse = determinant.reciprocal();
        // S r = (d r₁ − b r₂, a r₂ − c r₁)/det.
        let [first, second] = &self.read;
        let signals = [
            d.product(first).minus(&b.product(second)).product(&inverse),
            a.product(second).minus(&c.product(first)).product(&inverse),
        ];
        let current = |i: usize| Lanes::ZERO.plus(gain[i][0], &signals[0]).plus(gain[i][1], &signals[1]);
        let through = |k: usize| self.drive[k].product(&current(k));
        let state = PackedState {
            determinant: Lanes::ZERO.plus(free, &determinant),
            sensitivity: [d.product(&inverse), a.product(&inverse)],
            compliance: self.tool.sum(&through(0)).sum(&through(1)),
        };
        (state, [b, c], inverse)
    }
}

#[cfg(test)]
mod tests {
    use super::super::matrix2::{close_loop, entry, product};
    use super::*;

    #[test]
    fn four_loops_at_a_time_are_those_of_one() {
        let list: Vec<LoopResponse> = (0..6)
            .map(|k| LoopResponse {
                loops: [[entry(k, 1), entry(k, 2)], [entry(k, 3), entry(k, 4)]],
                read: [entry(k, 5), entry(k, 6)],
                drive: [entry(k, 7), entry(k, 8)],
                tool: entry(k, 9),
            })
            .collect();
        let (gain, free) = ([[entry(1, 0), entry(2, 3)], [entry(4, 2), entry(9, 1)]], entry(5, 1));
        for number in 0..2 {
            let four: Vec<&LoopResponse> = list.iter().skip(4 * number).take(4).collect();
            let packed = PackedLoops::new(&four);
            let (state, all) = (packed.close_loops(&gain, free), packed.closed_nominal(&gain, free));
            for (l, one) in four.into_iter().enumerate() {
                let exact = LoopState::new(one, &gain);
                let (determinant, _) = close_loop(&product(&one.loops, &gain));
                let whole = all.lane(l);
                let entries = |l: &LoopState| {
                    let matrices = [l.s, l.r].into_iter().flatten().flatten();
                    matrices.chain([l.compliance]).collect::<Vec<_>>()
                };
                let mut pairs = vec![
                    (state.determinant.lane(l), determinant * free),
                    (state.sensitivity[0].lane(l), exact.s[0][0]),
                    (state.sensitivity[1].lane(l), exact.s[1][1]),
                    (state.compliance.lane(l), exact.compliance),
                ];
                pairs.extend(entries(&whole).into_iter().zip(entries(&exact)));
                for (found, exact) in pairs {
                    assert!((found - exact).norm() < 1e-13 * exact.norm());
                }
                for (i, found) in all.currents().into_iter().enumerate() {
                    let exact = exact.r[i].iter().map(c64::norm_sqr).sum::<f64>();
                    assert!((found.as_array()[l] / exact - 1.0).abs() < 1e-13);
                }
            }
        }
    }
}
