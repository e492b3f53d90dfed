//! The channels of a response: which signals, forces and ports stand where.

use crate::linalg::c64;

/// Outputs and inputs of a line: four axes, tool x, tool y.
pub const SIDE: usize = 6;
/// Row-major 6×6 response: sensor signals (m) and tool displacement (m) from commanded currents (A) and tool force (N).
pub type Square = [c64; SIDE * SIDE];
/// Zero.
pub const ZERO: c64 = c64::new(0.0, 0.0);

/// Port of the tool plane.
pub(crate) const TOOL: usize = 0;
/// Ports of the two magnets.
pub(crate) const MAGNETS: [usize; 2] = [1, 2];
/// Ports that are read: front sensor, rear sensor, tool.
pub(crate) const OUT: [usize; 3] = [3, 4, TOOL];
/// Ports at which forces act: front magnet, rear magnet, tool.
pub(crate) const IN: [usize; 3] = [1, 2, TOOL];
/// Ports that stand on the housing: magnets and sensors.
pub(crate) const ON_HOUSING: std::ops::Range<usize> = 1..5;

/// Entries x→x (and y→y) and x→y (−y→x) of a response in r = x + jy:  a = (H(ω) + H̄(−ω))/2, b = (H(ω) − H̄(−ω))/2j.
/// Without a backward response both planes are apart.
pub(crate) fn planar(forward: c64, backward: Option<c64>) -> (c64, c64) {
    match backward {
        None => (forward, ZERO),
        Some(backward) => {
            let back = backward.conj();
            ((forward + back) * 0.5, (forward - back) * c64::new(0.0, -0.5))
        }
    }
}

/// A response with x and y in pairs, 2n×2n, from the entries x→x and x→y of every pair of ports, row-major.
pub(crate) fn in_pairs(n: usize, of: impl Fn(usize) -> (c64, c64)) -> Vec<c64> {
    let side = 2 * n;
    let mut all = vec![ZERO; side * side];
    for k in 0..n * n {
        let (x, y) = (2 * (k / n) * side, (2 * (k / n) + 1) * side);
        let (same, x_to_y) = of(k);
        let column = 2 * (k % n);
        all[x + column] = same;
        all[y + column + 1] = same;
        all[y + column] = x_to_y;
        all[x + column + 1] = -x_to_y;
    }
    all
}
