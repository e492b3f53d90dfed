//! From the assembled rotor to the chain of nodes whose spectrum is computed fast, and from positions to its ports.

use super::RotorError;
use super::assembly::Rotor;
use super::chain::{Blocks, Chain, ChainPort, Region};
use crate::linalg::Mat;

/// The chain of a rotor; regions in order of first appearance from the tool end. Factor 1 is the rotor as given.
///
/// # Errors
/// [`RotorError::Part`] when nodes couple that are not neighbours.
pub fn chain(rotor: &Rotor) -> Result<Chain, RotorError> {
    let matrices = rotor.plane_matrices();
    let mass = blocks(&matrices.mass)?;
    let mut stiffness = matrices.stiffness.clone();
    let mut regions: Vec<(Region, f64)> = vec![];
    for (i, section) in rotor.sections().iter().enumerate() {
        let Some(name) = &section.region else {
            continue;
        };
        let (k, dofs) = rotor.element_stiffness(i);
        let mut element = [[0.0; 4]; 4];
        for r in 0..4 {
            for c in 0..4 {
                element[r][c] = k[(r, c)];
                stiffness[(dofs[r], dofs[c])] -= k[(r, c)];
            }
        }
        let node = dofs[0] / 2;
        let z = rotor.node_positions_m();
        let centre = 0.5 * (z[node] + z[node + 1]);
        let known = regions.iter().position(|(r, _)| &r.name == name);
        let at = known.unwrap_or_else(|| {
            let region = Region { name: name.clone(), position_m: 0.0, elements: vec![] };
            regions.push((region, 0.0));
            regions.len() - 1
        });
        let (region, length) = &mut regions[at];
        region.position_m = (region.position_m * *length + centre * section.length_m) / (*length + section.length_m);
        *length += section.length_m;
        region.elements.push((node, element));
    }
    Ok(Chain {
        position_m: rotor.node_positions_m().to_vec(),
        mass,
        fixed: blocks(&stiffness)?,
        regions: regions.into_iter().map(|(r, _)| r).collect(),
    })
}

/// The port of a position on the rotor.
///
/// # Errors
/// [`RotorError::OffShaft`] for a position beyond the ends.
pub fn port(rotor: &Rotor, what: &str, position_m: f64) -> Result<ChainPort, RotorError> {
    let shape = rotor.shape_at(what, position_m)?;
    let node = shape.iter().map(|(dof, _)| dof / 2).min().unwrap_or(0);
    let mut weights = [0.0; 4];
    for (dof, coefficient) in shape {
        if let Some(w) = weights.get_mut(dof - 2 * node) {
            *w = coefficient;
        }
    }
    Ok(ChainPort { node, weights })
}

fn blocks(m: &Mat<f64>) -> Result<Blocks, RotorError> {
    let nodes = m.nrows() / 2;
    for r in 0..m.nrows() {
        for c in 0..r {
            if r / 2 - c / 2 > 1 && m[(r, c)] != 0.0 {
                return Err(RotorError::Part {
                    what: format!("coupling of nodes {} and {}", c / 2, r / 2),
                    value: m[(r, c)],
                    rule: "must be zero: a rotor is a chain of neighbouring nodes".into(),
                });
            }
        }
    }
    let mut b = Blocks::zeros(nodes);
    for i in 0..nodes {
        let k = 2 * i;
        b.diagonal[i] = [m[(k, k)], m[(k, k + 1)], m[(k + 1, k + 1)]];
        if i + 1 < nodes {
            b.off[i] = [m[(k, k + 2)], m[(k, k + 3)], m[(k + 1, k + 2)], m[(k + 1, k + 3)]];
        }
    }
    Ok(b)
}
