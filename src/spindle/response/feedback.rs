//! Force laws at ports of the shaft, and the receptance with these loops closed.
//!
//! With H the open receptance between all ports and κ the force per displacement of the laws at the ports f, the closed
//! one is X = H + H_f κ (I − H_ff κ)⁻¹ H_f·.  Sources: magnets (negative stiffness), springs, circulatory laws,
//! dashpots, added masses.

use super::channels::ZERO;
use crate::linalg::c64;
use crate::linalg::small::eliminate;
use crate::spindle::effective::{Attachment, Effective, FeedbackLaw};
use crate::spindle::effects::Plane;

/// A law at a port: `value` units of it (N/m, N s/m, kg).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Feedback {
    /// Port that the law reads and acts at.
    pub port: usize,
    pub law: FeedbackLaw,
    /// Units of it.
    pub value: f64,
}

impl Feedback {
    /// Force per displacement at a signed frequency, rad/s.
    pub(crate) fn gain(&self, w: f64) -> c64 {
        // A gyroscopic law stands in the modes, not at a port.
        self.law.gain(w, 0.0) * self.value
    }
}

/// A spring or damper to ground at a port that acts in one plane only. In r = x + jy it joins the response at ω with
/// that at −ω, so it is closed where x and y stand apart, round the loops of [`Feedback`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneLaw {
    /// Port that the law reads and acts at.
    pub port: usize,
    pub plane: Plane,
    /// The law.
    pub law: FeedbackLaw,
    /// Units of it.
    pub value: f64,
}

impl PlaneLaw {
    /// The law as feedback round a response with x and y apart, `row` that of its port counted in pairs of channels.
    pub(crate) fn beside(&self, row: usize) -> Feedback {
        Feedback { port: 2 * row + self.plane as usize, law: self.law, value: self.value }
    }
}

/// The laws of a machine in one plane; the row of each, `row` of its position in m, becomes a port behind `rows`.
pub(crate) fn laws_in_one_plane<E>(
    effective: &Effective,
    rows: &mut Vec<Vec<f64>>,
    row: impl Fn(f64) -> Result<Vec<f64>, E>,
) -> Result<Vec<PlaneLaw>, E> {
    let mut laws = vec![];
    for attachment in &effective.attachments {
        let Some(plane) = attachment.plane else {
            continue;
        };
        if attachment.value != 0.0 {
            let Attachment { law, value, .. } = *attachment;
            laws.push(PlaneLaw { port: rows.len(), plane, law, value });
            rows.push(row(attachment.position_m)?);
        }
    }
    Ok(laws)
}

/// Closes laws in one plane round a response with x and y in pairs, `side`×`side` row-major, in which the rows of
/// their ports begin with pair `first`; `w` is the angular frequency, rad/s.
pub(crate) fn close_in_planes(
    open: &[c64],
    side: usize,
    first: usize,
    laws: &[PlaneLaw],
    w: f64,
) -> (Vec<Feedback>, Vec<c64>) {
    let pairs = (first..).zip(laws);
    let loops: Vec<Feedback> = pairs.map(|(pair, law)| law.beside(pair)).collect();
    let ports: Vec<usize> = loops.iter().map(|f| f.port).collect();
    let gains: Vec<c64> = loops.iter().map(|f| f.gain(w)).collect();
    let closed = close(open, side, &ports, &gains);
    (loops, closed)
}

/// The attachments of a machine that act in both planes alike.
pub(crate) fn list_attached(effective: &Effective) -> impl Iterator<Item = &Attachment> {
    effective.attachments.iter().filter(|a| a.plane.is_none() && a.value != 0.0)
}

/// Closes loops at `ports` with their `gains` round an open receptance. That has a row for every port and a column
/// for each of the first `driven` ports, at which forces act; the ports of the loops are among these.
pub(crate) fn close(open: &[c64], driven: usize, ports: &[usize], gains: &[c64]) -> Vec<c64> {
    let (p, m) = (driven, ports.len());
    let mut unit = vec![ZERO; m * m];
    let mut rows = vec![ZERO; m * p];
    for (a, f) in ports.iter().enumerate() {
        for (b, g) in ports.iter().enumerate() {
            let own = c64::new(f64::from(u8::from(a == b)), 0.0);
            unit[a * m + b] = own - open[f * p + g] * gains[b];
        }
        rows[a * p..(a + 1) * p].copy_from_slice(&open[f * p..(f + 1) * p]);
    }
    eliminate(&mut unit, &mut rows, m, p);
    let mut closed = open.to_vec();
    for (closed, open) in closed.chunks_mut(p).zip(open.chunks(p)) {
        for ((f, gain), row) in ports.iter().zip(gains).zip(rows.chunks(p)) {
            let through = open[*f] * gain;
            for (closed, row) in closed.iter_mut().zip(row) {
                *closed += through * row;
            }
        }
    }
    closed
}
