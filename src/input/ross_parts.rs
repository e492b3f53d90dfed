//! The rotor of a ROSS file on either side of the nose face: spindle and tool.

use super::ross::RossRotor;
use crate::rotor::{Disc, Section};
use crate::spindle::Tool;

/// Distance within which a node counts as the nose face, m: printed positions have a micrometre.
const NODE_M: f64 = 1e-6;

/// The shaft with its parts on either side of the nose face.
pub(crate) struct Parts {
    /// What lies before the nose face, from there outwards.
    pub tool: Option<Tool>,
    pub sections: Vec<Section>,
    /// Its discs, positions from the nose face.
    pub discs: Vec<Disc>,
    /// What was changed or left out, one sentence each.
    pub told: Vec<String>,
}

/// Splits the rotor at the nose face, m from the left end.
pub(crate) fn parts(rotor: &RossRotor, nose_m: f64) -> Result<Parts, f64> {
    let mut split = 0;
    let mut position_m = 0.0;
    while split < rotor.sections.len() && position_m < nose_m - NODE_M {
        position_m += rotor.sections[split].length_m;
        split += 1;
    }
    if !nose_m.is_finite() || (position_m - nose_m).abs() > NODE_M || split == rotor.sections.len() {
        return Err(position_m);
    }
    let side = |sections: &[Section]| {
        let part = RossRotor { sections: sections.to_vec(), ..rotor.clone() };
        part.cylinders()
    };
    let (sections, mut told) = side(&rotor.sections[split..]);
    let moved = |d: &Disc| Disc { position_m: d.position_m - nose_m, ..*d };
    let discs: Vec<Disc> = rotor.discs.iter().map(moved).collect();
    let (front, own): (Vec<Disc>, Vec<Disc>) = discs.into_iter().partition(|d| d.position_m < -NODE_M);
    let mut tool = None;
    if split > 0 {
        let (mut outwards, more) = side(&rotor.sections[..split]);
        told.extend(more.into_iter().map(|words| format!("tool, {words}")));
        outwards = outwards.iter().rev().map(Section::reverse_ends).collect();
        tool = Some(Tool {
            name: "tool".to_owned(),
            sections: outwards,
            discs: front.iter().rev().map(Disc::mirror_ends).collect(),
            tool_plane_m: nose_m,
            teeth: None,
        });
    }
    let left_out = rotor.left_out.iter();
    told.extend(left_out.map(|words| format!("left out: {words}")));
    Ok(Parts { tool, sections, discs: own, told })
}
