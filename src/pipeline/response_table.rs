//! Frequency responses of a machine as rows of a table: currents to signals, force to displacement at the tool.

use crate::controller::Controller;
use crate::linalg::{Mat, c64};
use crate::lti::Response;
use crate::predict::closed_loop::compliance;
use crate::spindle::Plant;
use crate::spindle::plant::AXES;
use std::f64::consts::TAU;
use std::ops::Range;

pub(crate) struct ResponseTable<'a> {
    pub plant: &'a Plant,
    /// With a controller the compliance at the tool is that of the closed loop, else that of the rotor on its magnets.
    pub controller: Option<&'a Controller>,
    /// Also the open-loop paths from currents to the tool and from forces at the tool to signals.
    pub tool_paths: bool,
}

impl ResponseTable<'_> {
    /// Names of the columns: the frequency, then real and imaginary part of every response.
    pub(crate) fn header(&self) -> Vec<String> {
        let mut entries: Vec<String> = vec![];
        for i in 1..=AXES {
            entries.extend((1..=AXES).map(|j| format!("g_{i}{j}")));
        }
        entries.extend(["t_xx", "t_xy", "t_yx", "t_yy"].map(str::to_owned));
        if self.tool_paths {
            for axis in ["x", "y"] {
                entries.extend((1..=AXES).map(|j| format!("tu_{axis}{j}")));
            }
            for i in 1..=AXES {
                entries.extend(["x", "y"].map(|axis| format!("yf_{i}{axis}")));
            }
        }
        let parts = entries.iter();
        let parts = parts.flat_map(|entry| [format!("{entry}_re"), format!("{entry}_im")]);
        std::iter::once("frequency_hz".to_owned()).chain(parts).collect()
    }

    /// The row of a frequency, Hz.
    pub(crate) fn row(&self, hz: f64) -> Vec<f64> {
        let omega = TAU * hz;
        let h = self.plant.at(omega);
        let at_tool = AXES..AXES + 2;
        let mut row = vec![hz];
        let mut block = |matrix: &Mat<c64>, rows: Range<usize>, columns: Range<usize>| {
            for i in rows {
                let entries = columns.clone().map(|j| matrix[(i, j)]);
                row.extend(entries.flat_map(|value| [value.re, value.im]));
            }
        };
        block(&h, 0..AXES, 0..AXES);
        match self.controller {
            None => block(&h, at_tool.clone(), at_tool.clone()),
            Some(controller) => block(&compliance(self.plant, controller, omega), 0..2, 0..2),
        }
        if self.tool_paths {
            block(&h, at_tool.clone(), 0..AXES);
            block(&h, 0..AXES, at_tool);
        }
        row
    }
}
