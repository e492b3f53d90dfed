//! The modes of a shaft whose moduli, mesh, joint and added masses have moved, each computed once.
//!
//! Records at several speeds, places that are tried from one point, and residuals next to derivatives ask for the same
//! shaft: the last few are kept.

use super::finer_mesh::FinerMesh;
use super::ritz::ReducedShaft;
use super::shaft_modes::{Modes, modes};
use crate::linalg::Mat;
use crate::linalg::gram::mirror_lower;
use crate::spindle::{Effect, EffectKind, Location, SpindleError};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Shafts that are kept: those that threads work on at a time, and the point that all of them start from.
const KEPT: usize = 16;

/// A shaft with its parameters, without anything round it.
#[derive(Debug)]
pub(super) struct MovedShaft {
    pub modes: Modes,
    /// The change of coordinates of another mesh, if there is one.
    pub finer: Option<FinerMesh>,
}

/// What a shaft depends on.
#[derive(Clone, Copy)]
pub(super) struct Move<'a> {
    /// Factor of the modulus of every group.
    pub scale: &'a [f64],
    /// The fitted joint, if there is one.
    pub joint: Option<&'a Effect>,
    /// Steps to a finer mesh.
    pub mesh: f64,
    /// Effects, of which masses count.
    pub effects: &'a [Effect],
}

/// The shafts that were asked for last, by what they depend on.
#[derive(Clone, Debug, Default)]
pub(super) struct Recent(Arc<Mutex<VecDeque<Entry>>>);

/// Bits of all numbers of a [`Move`], and its shaft.
type Entry = (Vec<u64>, Arc<MovedShaft>);

impl Recent {
    /// The shaft of a move, computed where it is not among the last.
    pub(super) fn shaft(&self, shaft: &ReducedShaft, by: Move) -> Result<Arc<MovedShaft>, SpindleError> {
        let key = by.key(shaft);
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = {
            let mut all = lock();
            let at = all.iter().position(|(other, _)| *other == key);
            let entry = at.and_then(|at| all.remove(at));
            all.extend(entry.clone());
            entry
        };
        if let Some((_, found)) = known {
            return Ok(found);
        }
        let made = Arc::new(MovedShaft::new(shaft, by)?);
        let mut all = lock();
        all.push_back((key, made.clone()));
        if all.len() > KEPT {
            all.pop_front();
        }
        Ok(made)
    }
}

/// A mass that an effect adds.
pub(super) struct MovedMass {
    position_m: f64,
    /// Whether the slope of the shaft moves it.
    along: bool,
    /// kg, or kg m² where the slope moves it.
    pub value: f64,
}

impl MovedMass {
    /// What moves it, over the coordinates of the shaft.
    pub(super) fn row(&self, shaft: &ReducedShaft) -> Result<Vec<f64>, SpindleError> {
        if self.along { Ok(shaft.rotation_rows(self.position_m)?[0].clone()) } else { shaft.row(self.position_m) }
    }
}

impl Move<'_> {
    /// What the effects add.
    pub(super) fn masses(&self, shaft: &ReducedShaft) -> Vec<MovedMass> {
        let mut all = vec![];
        let mut add = |position_m: f64, along: bool, value: f64| all.push(MovedMass { position_m, along, value });
        for effect in self.effects {
            let at = |i: usize| effect.values.get(i).copied().unwrap_or_default();
            match (effect.kind, &effect.location) {
                (EffectKind::ToolMass, _) => add(shaft.span_m().0, false, at(0)),
                (EffectKind::AddedMass, Location::Position(z)) => add(*z, false, at(0)),
                (EffectKind::AddedDisc, Location::Position(z)) => {
                    add(*z, false, at(0));
                    add(*z, true, at(2));
                }
                _ => {}
            }
        }
        // No mass has no place: its derivative to the place is exactly none, not rounding.
        all.retain(|mass| mass.value != 0.0);
        all
    }

    fn key(&self, shaft: &ReducedShaft) -> Vec<u64> {
        let joint = self.joint.map_or(&[][..], |joint| &joint.values);
        let lengths = [self.joint.is_some() as u64, joint.len() as u64];
        let masses = self.masses(shaft).into_iter().flat_map(|m| [m.position_m, f64::from(u8::from(m.along)), m.value]);
        let numbers = [self.mesh].into_iter().chain(self.scale.iter().copied());
        let numbers = numbers.chain(joint.iter().copied()).chain(masses);
        lengths.into_iter().chain(numbers.map(f64::to_bits)).collect()
    }
}

impl MovedShaft {
    fn new(shaft: &ReducedShaft, by: Move) -> Result<Self, SpindleError> {
        let mut k = stiffness(shaft, by.scale, by.joint);
        let finer = FinerMesh::new(shaft, &mut k, by.mesh)?;
        let mut masses = vec![];
        for mass in by.masses(shaft) {
            let mut row = [mass.row(shaft)?];
            if let Some(finer) = &finer {
                finer.move_ports(shaft, &mut row)?;
            }
            let [row] = row;
            masses.push((row, mass.value));
        }
        // Near an added mass its inertia bends the shaft, which the fast coordinates do not follow.
        let condensed = match &shaft.condensation {
            Some(condensation) if masses.is_empty() => condensation.modes(&k)?,
            _ => None,
        };
        let modes = condensed.map_or_else(|| modes(&k, &masses), Ok)?;
        Ok(Self { modes, finer })
    }
}

/// Stiffness with moduli `scale` times their own, and with the fitted joint, n×n.
fn stiffness(shaft: &ReducedShaft, scale: &[f64], joint: Option<&Effect>) -> Mat<f64> {
    let n = shaft.len();
    // Symmetric: the lower triangle says all.
    let mut lower = shaft.stiffness.clone();
    for (group, scale) in shaft.groups.iter().zip(scale).filter(|(_, s)| **s != 1.0) {
        for j in 0..n {
            let column = lower.col_as_slice_mut(j)[j..].iter_mut();
            for (k, own) in column.zip(&group.col_as_slice(j)[j..]) {
                *k += (scale - 1.0) * own;
            }
        }
    }
    let mut k = mirror_lower(lower);
    if let (Some(effect), Some(rows)) = (joint, &shaft.joint) {
        for (row, value) in rows.iter().zip(&effect.values) {
            k = Mat::from_fn(n, n, |i, j| k[(i, j)] + value * row[i] * row[j]);
        }
    }
    k
}
