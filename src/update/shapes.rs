//! Measured points of mode shapes beside the model's: scale by least squares, agreement by the modal assurance
//! criterion MAC = (aᵀb)²/(aᵀa · bᵀb) over the measured points (Allemang and Brown 1982). The scale of a measurement is
//! arbitrary.

use super::UpdateError;
use super::targets::MeasuredShape;
use crate::rotor::Rotor;
use crate::rotor::chain_assembly;
use crate::rotor::spectrum::ModalSpectrum;

/// One measured shape and the model's shape it belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeComparison {
    /// Measured mode, from 1.
    pub mode: usize,
    /// Flexible mode of the model with the highest MAC, from 1.
    pub model_mode: usize,
    /// MAC with that mode.
    pub mac: f64,
    /// MAC with every flexible mode of the model.
    pub mac_all: Vec<f64>,
    /// Measured points scaled to the model: (position m, scaled amplitude, model amplitude); model mass-normalised.
    pub points: Vec<(f64, f64, f64)>,
}

/// Modal assurance criterion of two amplitude lists; 0 when one of them vanishes.
pub(crate) fn mac(a: &[f64], b: &[f64]) -> f64 {
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let size = dot(a, a) * dot(b, b);
    if size > 0.0 { dot(a, b).powi(2) / size } else { 0.0 }
}

pub(super) fn compare(
    rotor: &Rotor,
    spectrum: &ModalSpectrum,
    measured: &[MeasuredShape],
) -> Result<Vec<ShapeComparison>, UpdateError> {
    measured
        .iter()
        .map(|shape| {
            let ports = shape
                .points
                .iter()
                .map(|(z, _)| chain_assembly::port(rotor, "point of a mode shape", *z))
                .collect::<Result<Vec<_>, _>>()?;
            let amplitude: Vec<f64> = shape.points.iter().map(|(_, a)| *a).collect();
            let of_model: Vec<Vec<f64>> =
                spectrum.shapes.iter().map(|s| ports.iter().map(|p| p.read(s)).collect()).collect();
            let mac_all: Vec<f64> = of_model.iter().map(|m| mac(&amplitude, m)).collect();
            let best = mac_all.iter().enumerate().fold(0, |b, (k, v)| if *v > mac_all[b] { k } else { b });
            let empty = vec![];
            let shown = of_model.get(best).unwrap_or(&empty);
            let (mut ab, mut aa) = (0.0, 0.0);
            for (a, m) in amplitude.iter().zip(shown) {
                (ab, aa) = (ab + a * m, aa + a * a);
            }
            let scale = if aa > 0.0 { ab / aa } else { 0.0 };
            let points = shape.points.iter().zip(shown).map(|((z, a), m)| (*z, scale * a, *m)).collect();
            Ok(ShapeComparison {
                mode: shape.mode,
                model_mode: best + 1,
                mac: mac_all.get(best).copied().unwrap_or(0.0),
                mac_all,
                points,
            })
        })
        .collect()
}
