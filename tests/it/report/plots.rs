//! Pictures: every builder draws, the same figure gives the same bytes, and the table holds what is drawn.

use muspin::linalg::c64;
use muspin::pipeline::certificates::DScaleCurve;
use muspin::pipeline::loop_curves::WhirlLine;
use muspin::report::plot::diagnosis::{impedance, localisation, ranking, residual};
use muspin::report::plot::figure::{Axis, Figure, Panel, Series};
use muspin::report::plot::loops::{MarkedFrequency, bode, dynamic_stiffness, nyquist, sensitivity};
use muspin::report::plot::machining::{ToolQuantity, chatter_lobes, tools};
use muspin::report::plot::motion::{orbits, time_panel, time_responses};
use muspin::report::plot::robustness::{d_fits, mu_against_order, mu_over_frequency, mu_per_iteration};
use muspin::report::plot::shaft::{OutlinePiece, Station, StationKind, campbell, mode_shapes};
use muspin::report::plot::updating::{determinability, frequency_errors, modulus_factors};
use muspin::report::plot::{Color, Curve, Dash, Look, PlotError, Role, picture};
use muspin::update::PeakKind;

fn log_grid(low: f64, high: f64, points: usize) -> Vec<f64> {
    (0..points).map(|k| low * (high / low).powf(k as f64 / (points - 1) as f64)).collect()
}

/// Sum of modes with alternating residues: resonances and antiresonances to look at.
fn modal(f: f64, scale: f64) -> c64 {
    let modes = [(1069.0, 1.0), (1955.0, -0.7), (3210.0, 0.5)];
    let mut h = c64::new(-1e-5, 0.0);
    for (fr, residue) in modes {
        let fr = fr * scale;
        h += c64::new(residue, 0.0) / c64::new(fr * fr - f * f, 2.0 * 0.004 * fr * f);
    }
    h
}

/// All builders with plausible values.
fn gallery() -> Vec<(&'static str, Figure)> {
    let f = log_grid(1.0, 4000.0, 1500);
    let nominal: Vec<c64> = f.iter().map(|f| modal(*f, 1.06)).collect();
    let updated: Vec<c64> = f.iter().map(|f| modal(*f, 1.0)).collect();
    let response = |name, role, response| Curve { name, role, x: &f, y: response };
    let marked: Vec<MarkedFrequency> = [
        (1069.0, PeakKind::Resonance),
        (1955.0, PeakKind::Resonance),
        (3210.0, PeakKind::Resonance),
        (1109.0, PeakKind::Antiresonance),
        (1767.0, PeakKind::Antiresonance),
        (3429.0, PeakKind::Antiresonance),
    ]
    .into_iter()
    .map(|(frequency_hz, peak)| MarkedFrequency { frequency_hz, peak })
    .collect();
    let bodes = [response("nominal", Role::Nominal, &nominal), response("updated", Role::Updated, &updated)];
    let stiff: Vec<f64> = updated.iter().map(|h| 2e1 / h.norm()).collect();
    let softer: Vec<f64> = nominal.iter().map(|h| 7e0 / h.norm()).collect();
    let curve = |name, role, y| Curve { name, role, x: &f, y };
    let stiffness = vec![curve("µ", Role::Mu, &stiff), curve("PID", Role::Pid, &softer)];
    let s_mu: Vec<f64> = f
        .iter()
        .map(|f| (f / 90.0).powi(2) / (1.0 + (f / 90.0).powi(2)) * (1.0 + 1.2 / (1.0 + (f / 400.0 - 1.5).powi(2))))
        .collect();
    let s_pid: Vec<f64> = f
        .iter()
        .map(|f| (f / 60.0).powi(2) / (1.0 + (f / 60.0).powi(2)) * (1.0 + 3.4 / (1.0 + (f / 200.0 - 1.5).powi(2))))
        .collect();
    let s = vec![curve("µ", Role::Mu, &s_mu), curve("PID", Role::Pid, &s_pid)];
    let nyq: Vec<c64> =
        f.iter().map(|f| c64::new(3.0, 0.0) / (c64::new(1.0, f / 50.0) * c64::new(1.0, f / 300.0))).collect();
    let upper: Vec<f64> = f.iter().map(|f| 0.3 + 0.6 / (1.0 + ((f / 900.0).ln() * 2.0).powi(2))).collect();
    let bounds = |factor: f64| -> Vec<(f64, f64, f64)> {
        f.iter().zip(&upper).map(|(f, u)| (*f, factor * u, 0.93 * factor * u)).collect()
    };
    let (first, second) = (bounds(1.9), bounds(1.0));
    let d: Vec<f64> = f.iter().map(|f| 1e-3 * (1.0 + f / 200.0)).collect();
    let d_data: Vec<f64> = d.iter().zip(&f).map(|(d, f)| d * (1.0 + 0.1 * (f.ln() * 4.0).sin())).collect();
    let scale = DScaleCurve { frequency_hz: f.clone(), asked: d_data, used: d };
    let scale_names = ["mode 1, order 3", "mode 2, order 2", "mode 3, order 4"].map(String::from);
    let z: Vec<f64> = (0..60).map(|k| -0.1005 + 0.008 * f64::from(k)).collect();
    let shape = |n: f64| z.iter().map(|z| ((z + 0.1) / 0.48 * std::f64::consts::PI * n).cos()).collect::<Vec<f64>>();
    let (m1, m2, m3) = (shape(1.9), shape(2.8), shape(3.7));
    let measured_z = [-0.1, 0.0, 0.12, 0.25, 0.37];
    let measured_a: Vec<f64> =
        measured_z.iter().map(|z| -((z + 0.1) / 0.48 * std::f64::consts::PI * 1.9).cos()).collect();
    let on = |name, role, a| Curve { name, role, x: &z, y: a };
    let measured = Curve { name: "measured", role: Role::Measured, x: &measured_z, y: &measured_a };
    let modes = vec![
        ("mode 1: 1069 Hz".to_owned(), vec![on("updated", Role::Updated, &m1), measured]),
        ("mode 2: 1955 Hz".to_owned(), vec![on("updated", Role::Updated, &m2), on("nominal", Role::Nominal, &m3)]),
        ("mode 3: 3210 Hz".to_owned(), vec![on("updated", Role::Updated, &m3)]),
    ];
    let piece = |from_m, to_m, diameter_m| OutlinePiece { from_m, to_m, diameter_m };
    let outline = [
        piece(-0.1005, -0.05, 0.0188),
        piece(-0.05, 0.0, 0.0332),
        piece(0.0, 0.033, 0.048),
        piece(0.033, 0.094, 0.059),
        piece(0.094, 0.31, 0.05),
        piece(0.31, 0.37, 0.03),
    ];
    let station = |name, position_m, kind| Station { name, position_m, kind };
    let stations = [
        station("tool", -0.1005, StationKind::Other),
        station("front sensor", 0.064, StationKind::Sensor),
        station("front AMB", 0.1315, StationKind::Actuator),
        station("rear sensor", 0.303, StationKind::Sensor),
        station("rear AMB", 0.325, StationKind::Actuator),
    ];
    let speeds: Vec<f64> = (0..=10).map(|k| 5000.0 * f64::from(k)).collect();
    let lines: Vec<WhirlLine> = [(1069.0, 1i8), (1069.0, -1), (1955.0, 1), (1955.0, -1), (3210.0, 1), (3210.0, -1)]
        .into_iter()
        .map(|(f0, whirl)| WhirlLine {
            whirl,
            speed_rpm: speeds.clone(),
            frequency_hz: speeds.iter().map(|s| f0 * (1.0 + f64::from(whirl) * 0.025 * s / 5e4)).collect(),
        })
        .collect();
    let regions: Vec<String> = (1..=15).map(|k| format!("e{k}")).collect();
    let factors: Vec<f64> = (0..15).map(|k| 1.0 + 0.25 * f64::from(k).sin()).collect();
    let deviations: Vec<f64> = (0..15).map(|k| 0.03 + 0.02 * f64::from(k % 5)).collect();
    let singular: Vec<f64> = (0..8).map(|k| 10f64.powf(0.4 - 0.5 * f64::from(k))).collect();
    let share: Vec<f64> = (0..15).map(|k| (0.5 + 0.5 * f64::from(k).cos()).clamp(0.0, 1.0)).collect();
    let peaks: Vec<String> =
        ["R1", "R2", "R3", "front A1", "front A2", "front A3", "rear A1", "rear A2"].map(String::from).to_vec();
    let f_lin: Vec<f64> = (0..480).map(|k| 50.0 + 8.0 * f64::from(k)).collect();
    let ports: Vec<String> = [
        "tool",
        "joint",
        "nose",
        "front sensor",
        "front actuator",
        "motor",
        "rear actuator",
        "rear sensor",
        "housing",
        "sensor rows",
        "actuator columns",
        "x–y",
    ]
    .map(String::from)
    .to_vec();
    let scores: Vec<Vec<f64>> = (0..12)
        .map(|p| {
            f_lin
                .iter()
                .map(|f| 9.0 * (-((f / 1500.0).ln().powi(2)) * 3.0 - (f64::from(p) - 4.0).powi(2) / 4.0).exp())
                .collect()
        })
        .collect();
    let before: Vec<f64> = f_lin.iter().map(|f| 1.0 + 12.0 / (1.0 + ((f - 1000.0) / 90.0).powi(2))).collect();
    let after: Vec<f64> = f_lin.iter().enumerate().map(|(k, _)| 0.7 + 0.5 * (k as f64 * 1.7).sin().abs()).collect();
    let z_fit: Vec<c64> = f_lin.iter().map(|f| c64::new(0.0, f * 2e3)).collect();
    let z_data: Vec<c64> = z_fit
        .iter()
        .enumerate()
        .map(|(k, z)| z * c64::new(1.0 + 0.1 * (k as f64).sin(), 0.1 * (k as f64 * 1.3).cos()))
        .collect();
    let names: Vec<String> =
        ["loop_delay", "sensor_lowpass front", "amplifier_bandwidth both", "eddy_currents both", "tool_joint"]
            .map(String::from)
            .to_vec();
    let t: Vec<f64> = (0..2000).map(|k| 1e-5 * f64::from(k)).collect();
    let ring: Vec<f64> = t.iter().map(|t| 40.0 * (-t * 300.0).exp() * (t * 6000.0).sin()).collect();
    let current: Vec<f64> = t.iter().map(|t| 1.4 * (-t * 300.0).exp() * (t * 6000.0).cos()).collect();
    let spiral_x: Vec<f64> = t.iter().map(|t| 6e-5 * (1.0 + 0.2 * (t * 800.0).sin()) * (t * 5236.0).cos()).collect();
    let spiral_y: Vec<f64> = t.iter().map(|t| 5e-5 * (1.0 + 0.2 * (t * 800.0).sin()) * (t * 5236.0).sin()).collect();
    let rpm: Vec<f64> = (1..=400).map(|k| 125.0 * f64::from(k)).collect();
    let lobes: Vec<f64> = rpm
        .iter()
        .map(|r| 1e-3 * (1.0 + 2.5 * ((30.0 * 1069.0 / r * std::f64::consts::PI).sin().abs().powi(6)) * r / 2e4))
        .collect();
    let orders: Vec<f64> = (6..=40).step_by(2).map(f64::from).collect();
    let mus: Vec<f64> = orders.iter().map(|n| 0.82 + 6.0 * (-0.28 * n).exp()).collect();
    let ms: Vec<f64> = t.iter().map(|t| 1e3 * t).collect();
    let in_time = |y: &[f64]| vec![Series::curve("µ", &ms, y, Look::line(Color::Blue, Dash::Solid))];
    vec![
        (
            "bode",
            bode(
                "Open loop front x: model and published frequencies",
                "|displacement / current|",
                "m/A",
                &bodes,
                &marked,
            ),
        ),
        (
            "stiffness",
            dynamic_stiffness(
                "Dynamic stiffness at the tool",
                &[("x axis, 0 rpm", stiffness)],
                &[(10.0, "10 Hz"), (833.3, "833 Hz")],
            ),
        ),
        (
            "sensitivity",
            sensitivity(
                "Sensitivity",
                &[("front x", s.clone()), ("front y", s.clone()), ("rear x", s.clone()), ("rear y", s)],
            ),
        ),
        ("nyquist", nyquist("Nyquist, front x", &[response("L", Role::Mu, &nyq)])),
        ("mu", mu_over_frequency("µ over frequency", &[("step 1", &first), ("step 2", &second)])),
        ("mu-iteration", mu_per_iteration("D-K iteration", &[1.9, 1.1, 0.93, 0.91], &[1.6, 1.0, 0.92, 0.905])),
        ("d-fits", d_fits("D scales", &scale_names, &[scale.clone(), scale.clone(), scale])),
        (
            "mu-order",
            mu_against_order(
                "Reduction",
                &[Curve { name: "reduced, discrete", role: Role::Mu, x: &orders, y: &mus }],
                1.0,
                (22.0, mus[8]),
            ),
        ),
        ("modes", mode_shapes("Mode shapes", &outline, &stations, &modes)),
        ("campbell", campbell("Campbell diagram", &lines, &[1.0, 2.0])),
        ("moduli", modulus_factors("Moduli", &regions, &factors, &deviations)),
        ("determinability", determinability("What the data determine", &singular, &regions, &share)),
        (
            "errors",
            frequency_errors(
                "Errors",
                &peaks,
                &[
                    ("nominal", vec![9.0, 6.0, 5.0, 4.0, -3.0, 2.0, 5.0, 4.0]),
                    ("resonances only", vec![0.0, 0.1, 0.0, 3.5, -6.7, 4.0, 5.0, -4.0]),
                    ("all", vec![0.05, 0.1, 0.0, 0.05, -0.07, 0.04, 0.05, -0.04]),
                ],
            ),
        ),
        (
            "residual",
            residual(
                "Residual",
                &[
                    (
                        "front x → front x",
                        vec![
                            Curve { name: "before", role: Role::Pid, x: &f_lin, y: &before },
                            Curve { name: "after", role: Role::Mu, x: &f_lin, y: &after },
                        ],
                    ),
                    ("rear x → rear x", vec![Curve { name: "before", role: Role::Pid, x: &f_lin, y: &after }]),
                ],
            ),
        ),
        ("localisation", localisation("Where the model is wrong", &ports, &f_lin, &scores, "Score (σ)")),
        ("impedance", impedance("Missing impedance at the front actuator", "N/m", &f_lin, &z_data, &z_fit, "jω")),
        ("ranking", ranking("Hypotheses", &names, &[420.0, 380.0, 120.0, 60.0, 3.0], "Gain in log likelihood")),
        (
            "time",
            time_responses(
                "Impulse at the tool",
                vec![
                    time_panel(
                        "tool plane",
                        ["Displacement", "µm"],
                        in_time(&ring),
                        &[(50.0, "limit"), (-50.0, "limit")],
                    ),
                    time_panel("front x", ["Current", "A"], in_time(&current), &[]),
                ],
            ),
        ),
        (
            "orbits",
            orbits(
                "Orbits at 50 000 rpm",
                &[("front sensor", &spiral_x, &spiral_y), ("rear sensor", &spiral_y, &spiral_x)],
                2.54e-4,
            ),
        ),
        (
            "lobes",
            chatter_lobes("Stability lobes", &[Curve { name: "µ", role: Role::Mu, x: &rpm, y: &lobes }], 50000.0),
        ),
        (
            "tools",
            tools(
                "Tools",
                &["endmill-10".to_owned(), "face-mill-40".to_owned(), "drill-8".to_owned()],
                &[
                    ToolQuantity {
                        label: "Minimum stiffness",
                        unit: "N/µm",
                        references: vec![],
                        bars: vec![("µ", vec![2.0, 1.4, 0.8]), ("PID", vec![0.7, 0.6, 0.3])],
                    },
                    ToolQuantity {
                        label: "Peak of µ",
                        unit: "",
                        references: vec![(1.0, "1")],
                        bars: vec![("µ of the delivered controller", vec![0.8, 0.93, 1.1])],
                    },
                ],
            ),
        ),
    ]
}

#[test]
fn every_builder_draws_and_the_same_figure_gives_the_same_bytes() {
    for ((name, figure), (_, again)) in gallery().iter().zip(&gallery()) {
        let drawn = picture(figure).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(drawn, picture(again).unwrap(), "{name}");
        assert!(drawn.svg.starts_with("<svg ") && drawn.svg.trim_end().ends_with("</svg>"), "{name}");
        assert!(!drawn.svg.contains("NaN") && !drawn.svg.contains("0.984375"), "{name}");
        assert!(drawn.svg.len() < 400_000, "{name}: {} bytes", drawn.svg.len());
        assert!(drawn.csv.lines().count() > 1, "{name}");
        let columns = drawn.csv.lines().next().map_or(0, |h| h.split(',').count());
        assert!(columns >= 2, "{name}");
    }
}

/// `MUSPIN_GALLERY=/tmp/gallery cargo test --release --test it gallery -- --ignored` writes all pictures for a look.
#[test]
#[ignore = "writes pictures to look at"]
fn gallery_is_written() {
    let folder = std::env::var("MUSPIN_GALLERY").expect("set MUSPIN_GALLERY to a folder");
    std::fs::create_dir_all(&folder).unwrap();
    for (name, figure) in gallery() {
        let drawn = picture(&figure).unwrap();
        std::fs::write(format!("{folder}/{name}.svg"), drawn.svg).unwrap();
        std::fs::write(format!("{folder}/{name}.csv"), drawn.csv).unwrap();
    }
}

fn two_curves(second_x: &[f64]) -> Figure {
    let mut panel = Panel::new("", Axis::log("Frequency", "Hz"), Axis::log("Dynamic stiffness", "N/µm"));
    let look = Look::line(Color::Blue, Dash::Solid);
    panel.series.push(Series::curve("µ", &[1.0, 10.0, 100.0], &[0.1, 0.2, 1.0 / 3.0], look));
    panel.series.push(Series::curve("PID", second_x, &[3.0, 4e-7], look));
    Figure::new("t", "d", vec![panel])
}

#[test]
fn table_of_shared_abscissae_is_wide_and_exact() {
    let csv = picture(&two_curves(&[1.0, 50.0])).unwrap().csv;
    let expected = "frequency_hz,mu_dynamic_stiffness_n_per_um,pid_dynamic_stiffness_n_per_um\n\
                    1,0.1,3\n10,0.2,\n50,,4e-7\n100,0.3333333333333333,\n";
    assert_eq!(csv, expected);
}

#[test]
fn table_of_a_path_is_long() {
    let csv = picture(&two_curves(&[1.0, 0.5])).unwrap().csv;
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("panel,series,frequency_hz,dynamic_stiffness_n_per_um"));
    assert_eq!(lines.next(), Some(",µ,1,0.1"));
    assert_eq!(lines.last(), Some(",PID,0.5,4e-7"));
}

/// Labels of the horizontal axis, read back from the picture.
fn texts(svg: &str) -> Vec<&str> {
    svg.lines().filter(|l| !l.starts_with('<')).collect()
}

#[test]
fn a_log_axis_that_starts_on_a_power_of_ten_keeps_its_first_label_and_minor_lines() {
    let svg = picture(&two_curves(&[1.0, 50.0])).unwrap().svg;
    let texts = texts(&svg);
    for label in ["1", "10", "100"] {
        assert!(texts.contains(&label), "{label} missing in {texts:?}");
    }
    // Two decades of x: 2 … 9 twice are minor lines or labels, at a full 900 px width.
    let minor = svg.matches("stroke=\"#ECECEC\"").count();
    assert!(minor >= 12, "{minor} minor lines");
}

#[test]
fn lists_of_different_lengths_are_refused() {
    let mut figure = two_curves(&[1.0, 50.0]);
    figure.panels[0].series[0].y.pop();
    let expected = PlotError::Lengths { series: "µ".to_owned(), x: 3, y: 2 };
    assert_eq!(picture(&figure), Err(expected));
    figure.panels.clear();
    assert!(matches!(picture(&figure), Err(PlotError::Empty { .. })));
}

#[test]
fn values_that_no_log_axis_can_show_are_gaps() {
    let mut figure = two_curves(&[1.0, 50.0]);
    figure.panels[0].series[0].y = vec![f64::NAN, 0.0, -1.0];
    figure.panels[0].series[1].y = vec![f64::INFINITY, f64::NAN];
    let svg = picture(&figure).unwrap().svg;
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}
