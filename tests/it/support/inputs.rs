//! Inputs that several tests give to the program.

use muspin::input::load_machine;
use muspin::pid::certificate::TunedPid;
use muspin::pid::settings::TuneSettings;
use muspin::pid::tune::tune;
use muspin::rotor::Section;
use std::sync::OnceLock;

/// A PID search of a second, for tests that need some stable law.
pub fn short_search() -> TuneSettings {
    TuneSettings { starts: 400, basins: 1, steps: 12, speeds: 2, ..TuneSettings::quick() }
}

/// What that search finds for the reference machine; tests share it.
pub fn short_search_found() -> &'static TunedPid {
    static FOUND: OnceLock<TunedPid> = OnceLock::new();
    FOUND.get_or_init(|| {
        let machine = load_machine("reference", "paper-tool").unwrap();
        tune(&machine, &short_search(), &mut |_, _| {}).unwrap()
    })
}

/// A section cut into parts of equal length; cones stay cones.
pub fn cut(section: &Section, parts: usize) -> Vec<Section> {
    let at = |d: [f64; 2], k: usize| d[0] + k as f64 / parts as f64 * (d[1] - d[0]);
    let part = |k: usize| {
        let ends = |d: [f64; 2]| [at(d, k), at(d, k + 1)];
        Section {
            length_m: section.length_m / parts as f64,
            outer_diameter_m: ends(section.outer_diameter_m),
            inner_diameter_m: ends(section.inner_diameter_m),
            mass_outer_diameter_m: ends(section.mass_outer_diameter_m),
            mass_inner_diameter_m: ends(section.mass_inner_diameter_m),
            ..section.clone()
        }
    };
    (0..parts).map(part).collect()
}
