//! The joint that counts as rigid.

/// Joint that counts as rigid, N/m and N m/rad: a hundred times stiffer than collets. A stiffer one would hide the
/// joint behind the damping that its own mode has, 2ζω√(K m).
pub(super) const STIFFEST_JOINT: [f64; 2] = [2e10, 2e7];
