//! Rotors in groups of four, whose loops with the same direction of whirl are closed together.

use super::packed_loops::PackedLoops;
use super::responses::{LoopResponse, ServedRotor};
use crate::linalg::lanes::WIDTH;
use std::ops::Range;

/// Rotors with the same number of directions of whirl.
pub(super) struct RotorGroup {
    pub rotors: Vec<usize>,
    /// Packs of a line, one for each direction.
    pub packs: Range<usize>,
    /// One of the rotors is asked for its noise or for the specification.
    pub is_nominal: bool,
}

/// All rotors in their groups, the nominal groups first.
pub(super) struct RotorGroups {
    pub list: Vec<RotorGroup>,
    /// Flat indices of the loops of each rotor, rotors × directions.
    sides: Vec<Range<usize>>,
}

impl RotorGroups {
    /// The groups of some rotors; the specification is that of the first `specified` loops.
    pub(super) fn new(rotors: &[ServedRotor], specified: usize) -> Self {
        let mut end = 0;
        let sides = rotors.iter().map(|rotor| {
            let first = end;
            end += rotor.directions.len();
            first..end
        });
        let sides: Vec<Range<usize>> = sides.collect();
        let is_asked = |k: &usize| rotors[*k].role.is_nominal() || sides[*k].start < specified;
        let mut counts: Vec<usize> = sides.iter().map(Range::len).collect();
        counts.sort_unstable();
        counts.dedup();
        let mut groups: Vec<Vec<usize>> = vec![];
        for count in counts {
            let alike = (0..rotors.len()).filter(|k| sides[*k].len() == count);
            let mut alike: Vec<usize> = alike.collect();
            alike.sort_by_key(|k| !is_asked(k));
            groups.extend(alike.chunks(WIDTH).map(<[usize]>::to_vec));
        }
        groups.sort_by_key(|rotors| !rotors.iter().any(is_asked));
        let mut end = 0;
        let list = groups.into_iter().map(|rotors| {
            let first = end;
            end += rotors.first().map_or(0, |k| sides[*k].len());
            RotorGroup { packs: first..end, is_nominal: rotors.iter().any(is_asked), rotors }
        });
        Self { list: list.collect(), sides }
    }

    /// Flat indices of the loops of a rotor.
    pub(super) fn sides(&self, rotor: usize) -> Range<usize> {
        self.sides[rotor].clone()
    }

    /// Packs of a line.
    pub(super) fn packs(&self) -> usize {
        self.list.last().map_or(0, |group| group.packs.end)
    }

    pub(super) fn pack(&self, rotors: &[ServedRotor], line: usize) -> Vec<PackedLoops> {
        let packs = self.list.iter().flat_map(|group| {
            (0..group.packs.len()).map(|direction| {
                let side = |k: &usize| &rotors[*k].directions[direction][line];
                let four: Vec<&LoopResponse> = group.rotors.iter().map(side).collect();
                PackedLoops::new(&four)
            })
        });
        packs.collect()
    }

    /// Pack and place in it of the loop with a flat index.
    pub(super) fn place(&self, side: usize) -> Option<(usize, usize)> {
        self.list.iter().find_map(|group| {
            let at = |k: &usize| self.sides[*k].contains(&side);
            let lane = group.rotors.iter().position(at)?;
            let direction = side - self.sides[group.rotors[lane]].start;
            Some((group.packs.start + direction, lane))
        })
    }
}
