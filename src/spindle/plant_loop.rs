//! The plant between the axes of its loop and the tool, at few ports of the shaft: what a search over controllers asks
//! for at thousands of lines. It is [`Plant`] with fewer entries, but springs in one plane stand open.

use super::mechanics::{Mechanics, Port};
use super::plant::Plant;
use super::response::Square;
use super::response::ZERO;
use super::response::electronics::ElectronicsLine;
use crate::linalg::c64;
use crate::spindle::Effective;

/// A plant at the ports of its loop.
#[derive(Clone, Debug)]
pub struct PlantLoop {
    /// At [`AXES`] and the tool.
    with_tool: Mechanics,
    /// At [`AXES`].
    without_tool: Mechanics,
    effective: Effective,
}

/// Bearings, then sensors.
const AXES: [usize; 4] =
    [Port::FrontControl as usize, Port::RearControl as usize, Port::FrontSensor as usize, Port::RearSensor as usize];
/// Numbers of the ports of a response among those of the shaft: front and rear signal and tool, front and rear bearing
/// and tool.
const ENTRIES: [[usize; 3]; 2] = [[2, 3, 4], [0, 1, 4]];

impl PlantLoop {
    /// The loop of a plant.
    pub fn new(plant: &Plant) -> Self {
        let [a, b, c, d] = AXES;
        Self {
            with_tool: plant.mechanics.at_ports(&[a, b, c, d, Port::Tool as usize]),
            without_tool: plant.mechanics.at_ports(&AXES),
            effective: plant.effective.clone(),
        }
    }

    /// Signals and displacement of the tool from currents and a force at the tool.
    pub fn at(&self, omega_rad_s: f64) -> Square {
        self.of(&self.with_tool, 3, omega_rad_s)
    }

    /// The same without the tool, whose rows and columns are zero.
    pub fn axes_at(&self, omega_rad_s: f64) -> Square {
        self.of(&self.without_tool, 2, omega_rad_s)
    }

    fn of(&self, mechanics: &Mechanics, pairs: usize, omega_rad_s: f64) -> Square {
        let ports = mechanics.ports();
        let picked = |all: Vec<c64>| -> [c64; 9] {
            std::array::from_fn(|k| {
                let (i, j) = (k / 3, k % 3);
                if i < pairs && j < pairs { all[ENTRIES[0][i] * ports + ENTRIES[1][j]] } else { ZERO }
            })
        };
        let (forward, backward) = mechanics.both_ways(omega_rad_s);
        let backward = backward.map(picked);
        ElectronicsLine::new(&self.effective, omega_rad_s).apply(&picked(forward), backward.as_ref())
    }
}
