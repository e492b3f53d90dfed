//! Closed loops of several rotors at one line, four at a time: what the loss asks of every rotor, without what only
//! the nominal ones are asked.

use super::matrix2::{Matrix2, ONE};
use super::responses::LoopResponse;
use crate::linalg::c64;
use crate::linalg::lanes::Lanes;

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

impl PackedLoops {
    /// Some loops at a line, in groups; what fills up the last one is zero.
    pub(super) fn pack(list: &[&LoopResponse]) -> Vec<Self> {
        let column =
            |at: &dyn Fn(&LoopResponse) -> c64| Lanes::columns(list.len(), 1, |i, _| at(list[i]));
        let pairs =
            |at: &dyn Fn(&LoopResponse, usize) -> c64| [0, 1].map(|k| column(&|l| at(l, k)));
        let loops = [0, 1].map(|i| pairs(&|l, j| l.loops[i][j]));
        let (read, drive) = (pairs(&|l, k| l.read[k]), pairs(&|l, k| l.drive[k]));
        let tool = column(&|l| l.tool);
        (0..tool.len())
            .map(|g| Self {
                loops: [0, 1].map(|i| [0, 1].map(|j| loops[i][j][g])),
                read: [0, 1].map(|k| read[k][g]),
                drive: [0, 1].map(|k| drive[k][g]),
                tool: tool[g],
            })
            .collect()
    }

    /// The loops closed by K = `gain`, of which `free` leaves out the integrators.
    #[inline]
    pub(super) fn closed(&self, gain: &Matrix2, free: c64) -> PackedState {
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
        let current = |i: usize| {
            Lanes::ZERO
                .plus(gain[i][0], &signals[0])
                .plus(gain[i][1], &signals[1])
        };
        let through = |k: usize| self.drive[k].product(&current(k));
        PackedState {
            determinant: Lanes::ZERO.plus(free, &determinant),
            sensitivity: [d.product(&inverse), a.product(&inverse)],
            compliance: self.tool.plus(ONE, &through(0)).plus(ONE, &through(1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::loop_state::LoopState;
    use super::super::matrix2::entry;
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
        let (gain, free) = (
            [[entry(1, 0), entry(2, 3)], [entry(4, 2), entry(9, 1)]],
            entry(5, 1),
        );
        let packed = PackedLoops::pack(&list.iter().collect::<Vec<_>>());
        let closed: Vec<PackedState> = packed.iter().map(|g| g.closed(&gain, free)).collect();
        for (k, one) in list.iter().enumerate() {
            let exact = LoopState::new(one, &gain, free);
            let group = |of: &dyn Fn(&PackedState) -> Lanes| {
                Lanes::at(&closed.iter().map(of).collect::<Vec<_>>(), k)
            };
            let pairs = [
                (group(&|g| g.determinant), exact.determinant),
                (group(&|g| g.sensitivity[0]), exact.s[0][0]),
                (group(&|g| g.sensitivity[1]), exact.s[1][1]),
                (group(&|g| g.compliance), exact.compliance),
            ];
            for (found, exact) in pairs {
                assert!((found - exact).norm() < 1e-13 * exact.norm());
            }
        }
    }
}
