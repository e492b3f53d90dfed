//! Resonances and antiresonances of a machine's free-free rotor with its full finite-element chain.

use muspin::rotor::chain_assembly;
use muspin::rotor::spectrum::{ModalSpectrum, Query, spectrum};
use muspin::spindle::Machine;

/// Of the responses from either actuator to the sensor beside it.
pub fn own_spectrum(machine: &Machine, from_hz: f64, to_hz: f64) -> ModalSpectrum {
    let rotor = machine.rotor().expect("rotor");
    let chain = chain_assembly::chain(&rotor).expect("chain");
    let port = |z| chain_assembly::port(&rotor, "plane", z).expect("on the rotor");
    let bearings = machine.effective().bearings;
    let query = Query { frfs: bearings.map(|b| (port(b.sensor_m), port(b.actuator_m))).to_vec(), from_hz, to_hz };
    spectrum(&chain, &vec![1.0; chain.regions.len()], &query)
}
