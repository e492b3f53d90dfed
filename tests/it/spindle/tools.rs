//! The shipped tools: all load, fit the nose, and are what a spindle of this size carries.

use muspin::input::shipped::TOOLS;
use muspin::input::{load_spindle, load_tool};

#[test]
fn every_shipped_tool_loads_and_fits_the_spindle() {
    let spindle = load_spindle("reference").unwrap();
    assert!(TOOLS.len() >= 9);
    for shipped in TOOLS {
        let tool = load_tool(shipped.name, &spindle).unwrap_or_else(|e| panic!("{}: {e}", shipped.name));
        assert_eq!(tool.name, shipped.name);
        let length: f64 = tool.sections.iter().map(|s| s.length_m).sum();
        let mass: f64 = tool
            .sections
            .iter()
            .map(|s| {
                // Sections taper linearly from one diameter to the other: volume of a cone frustum.
                let square = |[a, b]: [f64; 2]| (a * a + a * b + b * b) / 3.0;
                let area = square(s.mass_outer_diameter_m) - square(s.mass_inner_diameter_m);
                0.25 * std::f64::consts::PI * area * s.length_m * s.material.density_kg_m3
            })
            .sum();
        assert!((0.05..0.16).contains(&length), "{}: {length} m", shipped.name);
        assert!((0.2..0.8).contains(&mass), "{}: {mass} kg", shipped.name);
        assert!(tool.tool_plane_m > 0.0 && tool.tool_plane_m <= length + 1e-9, "{}", shipped.name);
        let nose = spindle.sections[0].outer_diameter_m[0];
        assert!(tool.sections[0].outer_diameter_m[0] <= nose, "{}: wider than the nose", shipped.name);
    }
}
