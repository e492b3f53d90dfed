//! The joint that counts as rigid, and that of a collet.

use crate::spindle::Spindle;

/// Joint that counts as rigid, in E·d and E·d³ of the nose: a hundred times stiffer than collets. A stiffer one would
/// hide the joint behind the damping that its own mode has, 2ζω√(K m).
const STIFFEST: [f64; 2] = [2.0, 0.8];
/// Collets, as a share of that stiffness.
const COLLET: [f64; 2] = [0.01, 0.005];

/// Stiffness of the joint that counts as rigid, N/m and N m/rad.
pub(super) fn stiffest_joint(spindle: &Spindle) -> [f64; 2] {
    spindle.joint_at_nose(STIFFEST)
}

/// Flexibility of a collet, m/N and rad/(N m), where `rigid` is the joint that counts as rigid.
pub(super) fn collet(rigid: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| (COLLET[i] * rigid[i]).recip())
}
