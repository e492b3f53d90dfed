//! The weights of a specification as magnitudes over true frequency, each made once from the numbers of its file.

use super::channels::{Channel, ChannelWeight, channels};
use super::plane::{LOADS, LOOPS};
use super::shape::Shape;
use super::weighting::integral_section;
use super::weights::Weights;
use crate::linalg::NumericError;

/// Weights of one plane. Places: 0 tool, 1 front, 2 rear.
pub(crate) struct WeightShapes {
    /// Further uncertainty, each channel with its weights.
    pub channels: Vec<Channel>,
    /// Loads, N.
    pub loads: [Shape; LOADS],
    /// One over the displacements allowed, 1/m.
    pub displacements: [Shape; LOADS],
    /// One over the control current allowed, 1/A.
    pub current: Shape,
    /// Sensor noise, m; none where it is constant.
    pub noise: Option<Shape>,
    /// On the signals of front and rear, where the specification regulates them as by an integrator.
    pub integral: Option<[Shape; LOOPS]>,
}

impl WeightShapes {
    /// Of a specification.
    pub(crate) fn of(weights: &Weights) -> Result<Self, NumericError> {
        let integral = |corner_hz: f64, allowed_m: f64| {
            Ok::<Shape, NumericError>(Shape::section(integral_section(allowed_m, corner_hz)?))
        };
        let [load, displacement] = [Weights::load_weight, Weights::displacement_weight];
        Ok(Self {
            channels: channels(weights)?,
            loads: [load(weights, 0)?, load(weights, 1)?, load(weights, 2)?],
            displacements: [displacement(weights, 0)?, displacement(weights, 1)?, displacement(weights, 2)?],
            current: weights.current_weight()?,
            noise: weights.curves.noise.clone(),
            integral: match weights.integral_corner_hz {
                Some(corner) => Some([
                    integral(corner, weights.front.max_dc_displacement_m)?,
                    integral(corner, weights.rear.max_dc_displacement_m)?,
                ]),
                None => None,
            },
        })
    }

    /// Every magnitude that changes over frequency; both integral weights are one magnitude but for their size.
    pub(super) fn over_frequency(&self) -> impl Iterator<Item = &Shape> {
        let channels = self.channels.iter().filter_map(|c| match &c.output {
            ChannelWeight::OverFrequency(shape) => Some(shape),
            ChannelWeight::Constant(_) => None,
        });
        let integral = self.integral.iter().map(|[front, _]| front);
        std::iter::once(&self.current)
            .chain(&self.loads)
            .chain(&self.displacements)
            .chain(&self.noise)
            .chain(integral)
            .chain(channels)
    }
}
