//! Peak of μ over frequency against the dense reference sweeps.

use crate::control_cases::{Case, block_list, system};
use muspin::robust::mu_system::{CERTIFICATE_SLACK, MuSystem};

#[test]
fn certified_peaks_match_the_dense_sweeps() {
    for case in Case::all("musys") {
        let n = system(&case.data);
        let start = std::time::Instant::now();
        let mu = MuSystem::new(&n, &block_list(&case.data["blocks"])).unwrap();
        let peak = mu.peak(CERTIFICATE_SLACK).unwrap();
        let reference = case.reference["mu_peak"].as_f64().unwrap();
        eprintln!(
            "{} upper {:.9} attained {:.9} ref {reference:.9} lower {:.9} at {} ref {} scalings {} {:?}",
            case.id,
            peak.upper,
            peak.attained,
            peak.bounds.lower,
            peak.omega_rad_s,
            case.reference["w_peak"],
            peak.scalings,
            start.elapsed()
        );
        assert!(
            peak.upper >= reference * (1.0 - 1e-4),
            "{}: {}",
            case.id,
            peak.upper
        );
        assert!(
            peak.upper <= reference * (1.0 + 1e-3),
            "{}: {}",
            case.id,
            peak.upper
        );
        assert!(
            peak.bounds.lower >= 0.95 * peak.upper,
            "{}: {}",
            case.id,
            peak.bounds.lower
        );
        assert!(peak.bounds.lower <= peak.upper);
    }
}
