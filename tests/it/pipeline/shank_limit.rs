//! What no controller can change of a tool that gives.

use muspin::controller::Controller;
use muspin::input::{load_machine, load_weights, read_controller};
use muspin::pipeline::shank_limit::ShankLimit;
use muspin::prelude::*;
use muspin::rotor::supported::supported_compliance;

#[test]
fn a_tool_is_refused_where_its_shank_alone_gives_more_than_allowed() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let mut weights = load_weights("benchmark").unwrap();
    assert_eq!(ShankLimit::of(&machine, &weights).unwrap(), None);
    // With nothing allowed at the bearings the tool moves by its bend.
    let planes = &machine.spindle.planes;
    let supports = [planes.front_actuator_m, planes.rear_actuator_m];
    let bend_m = weights.tool.max_dc_load_n
        * supported_compliance(&machine.rotor().unwrap(), machine.tool_plane_m(), supports).unwrap();
    for limits in [&mut weights.front, &mut weights.rear] {
        limits.max_dc_displacement_m = 0.0;
    }
    weights.tool.max_dc_displacement_m = 1.01 * bend_m;
    assert_eq!(ShankLimit::of(&machine, &weights).unwrap(), None);
    weights.tool.max_dc_displacement_m = 0.99 * bend_m;
    let found = ShankLimit::of(&machine, &weights).unwrap().expect("a limit");
    assert!((found.least_m / bend_m - 1.0).abs() < 1e-12, "{found:?}");
    assert!(found.sentence().starts_with("No controller can"), "{}", found.sentence());
}

/// The displacement at the tool under a slow force is the bend and the motion of the two magnets' planes, in the loop
/// of the whole machine that shares nothing with the bend but the elements.
#[test]
fn a_closed_loop_moves_the_tool_by_bend_and_rigid_motion() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let text = include_str!("../../data/anti_windup/pid.json");
    let controller: Controller = read_controller("pid.json", text).unwrap();
    let plant = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
    // Force at the tool to the displacements of tool, front and rear actuator, in x.
    let omega = 0.01;
    let g = plant.at(omega);
    let k = muspin::lti::HeldResponse::held_at(&controller, omega);
    let loop_gain = muspin::linalg::Mat::from_fn(4, 4, |i, j| {
        let own = (0..4).map(|l| k[(i, l)] * g[(l, j)]).sum::<c64>();
        c64::new(f64::from(u8::from(i == j)), 0.0) - own
    });
    let forced = muspin::linalg::Mat::from_fn(4, 1, |i, _| (0..4).map(|l| k[(i, l)] * g[(l, 4)]).sum::<c64>());
    let current = muspin::linalg::solve_complex(&loop_gain, &forced);
    let moved = |row: usize| (g[(row, 4)] + (0..4).map(|l| g[(row, l)] * current[(l, 0)]).sum::<c64>()).re;
    let planes = &machine.spindle.planes;
    let (at, front, rear) = (machine.tool_plane_m(), planes.front_actuator_m, planes.rear_actuator_m);
    let share = (at - rear) / (front - rear);
    let bend = supported_compliance(&machine.rotor().unwrap(), at, [front, rear]).unwrap();
    let expected = bend + share * moved(6) + (1.0 - share) * moved(8);
    assert!((moved(4) / expected - 1.0).abs() < 1e-4, "{} {expected}", moved(4));
}
