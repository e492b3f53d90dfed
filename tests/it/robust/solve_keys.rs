//! What problem files may hold: keys that a kind has, sampled systems, vectors as MATLAB writes them; and the words for
//! what they may not.

use crate::robust::solve_cases::{number, refusal};
use assert_cmd::Command;
use serde_json::Value;

/// Standard output of `muspin solve` on the text of a problem.
pub fn answer_to(kind: &str, problem: &str) -> Value {
    let mut file = tempfile::Builder::new().suffix(".json").tempfile().unwrap();
    std::io::Write::write_all(&mut file, problem.as_bytes()).unwrap();
    let output = Command::cargo_bin("muspin").unwrap().args(["solve", kind]).arg(file.path()).output().unwrap();
    assert!(output.status.success(), "{problem}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

const SYSTEM: &str = r#""A": [[-0.8]], "B": [[1]], "C": [[1]], "D": [[0]]"#;
const PLANT: &str = r#""A": [[-1]], "B": [[1, 0, 1]], "C": [[1], [0], [1]], "D": [[0, 0, 0], [0, 0, 1], [0, 1, 0]],
    "m1": 2, "m2": 1, "p1": 2, "p2": 1"#;

fn problem(fields: &str, more: &str) -> String {
    format!("{{{fields},\n{more}}}")
}

#[test]
fn a_key_that_a_kind_does_not_have_is_refused_with_the_one_that_is_meant() {
    let care = r#""A": [[1]], "G": [[1]], "Q": [[1]]"#;
    let matrix = r#""M": [[1]], "blocks": [{"type": "real_scalar", "n": 1}]"#;
    let fit = r#""omega": [1, 2, 3], "magnitude": [1, 1, 1], "orders": [0]"#;
    let sampled = problem(SYSTEM, r#""Ts": 0.1"#);
    let sampled = sampled.trim_matches(['{', '}']).to_owned();
    for (kind, fields, key, word) in [
        ("care", care, r#""Gg": [[2]]"#, "`G`"),
        ("hinfnorm", SYSTEM, r#""sampling_time": 1"#, "`Ts`"),
        ("hinfnorm", SYSTEM, r#""InputDelay": 0.1"#, "Pade"),
        ("hinfsyn", PLANT, r#""gam": 2"#, "`gamma`"),
        ("care", care, r#""Ts": 1"#, "`solve dare`"),
        ("hinfsyn", PLANT, r#""fs": 1"#, "`Ts`"),
        ("hinfsyn", PLANT, r#""nmeas": 1"#, "`p2`"),
        ("dksyn", PLANT, r#""block_structure": []"#, "`blocks`"),
        ("mu", matrix, r#""block": []"#, "`blocks`"),
        ("dfit", fit, r#""weights": [1, 1, 2]"#, "`weight`"),
        ("reduce", SYSTEM, r#""order": [1]"#, "`orders`"),
        ("discretise", &sampled, r#""prewarp": 1"#, "`w_prewarp`"),
        ("discretise", &sampled, r#""sample_time_s": 1"#, "`Ts`"),
    ] {
        let name = key.split('"').nth(1).unwrap();
        for text in [problem(fields, key), format!("{{\"data\": {}}}", problem(fields, key))] {
            let told = refusal(kind, &text);
            assert!(told.contains(&format!("unknown key `{name}`")) && told.contains(word), "{kind} {key}: {told}");
            // The line of the key.
            let line = text.lines().position(|l| l.contains(&format!("\"{name}\""))).unwrap() + 1;
            assert!(told.contains(&format!(".json:{line}: ")), "{kind} {key}: {told}");
        }
        let beside = format!("{{\"data\": {{{fields}}}, {key}}}");
        if ["Ts", "InputDelay"].contains(&name) {
            assert!(refusal(kind, &beside).contains("beside `data`"), "{kind} {key}");
        }
    }
    // What only describes, and what changes nothing.
    for key in
        [r#""title": "a""#, r#""E": [[1]]"#, r#""E": []"#, r#""Ts": 0"#, r#""InputDelay": [0]"#, r#""Notes": []"#]
    {
        let found = answer_to("hinfnorm", &problem(SYSTEM, key));
        assert!((number(&found["norm"]) - 1.25).abs() < 1e-9, "{key}: {found}");
    }
    let told = refusal("mu", r#"{"M": [[1]], "blocks": [{"type": "real_scalar", "n": 1, "rows": 1}]}"#);
    assert!(told.contains("unknown key `blocks[0].rows`"), "{told}");
    let told = refusal("mu", r#"{"M": {"re": 1, "im": 0, "abs": 1}, "blocks": [{"type": "real_scalar", "n": 1}]}"#);
    assert!(told.contains("unknown key `M.abs`"), "{told}");
}

#[test]
fn the_norm_of_a_sampled_system_is_that_on_the_unit_circle() {
    // 1/(z + 0.8) is largest at z = −1: ω = π/T.
    for (key, period) in [("Ts", 1.0), ("sample_time_s", 0.25)] {
        let found = answer_to("hinfnorm", &problem(SYSTEM, &format!("\"{key}\": {period}")));
        assert!((number(&found["norm"]) - 5.0).abs() < 1e-8, "{found}");
        let place = number(&found["peak_freq_rad_s"]);
        assert!((place * period / std::f64::consts::PI - 1.0).abs() < 1e-6, "{found}");
    }
    // 1/(z − 0.5 ± 0.6j) as a pair: |z| = 1 against a dense sweep of the circle.
    let pair = r#""A": [[0.5, 0.6], [-0.6, 0.5]], "B": [[1], [0]], "C": [[1, 0]], "D": [[0]], "Ts": 0.1"#;
    let found = answer_to("hinfnorm", &format!("{{{pair}}}"));
    let gain = |angle: f64| {
        let (re, im) = (angle.cos() - 0.5, angle.sin());
        // C(zI − A)⁻¹B = (z − 0.5)/((z − 0.5)² + 0.36).
        let (sr, si) = (re * re - im * im + 0.36, 2.0 * re * im);
        re.hypot(im) / sr.hypot(si)
    };
    let largest = (0..=100_000).map(|k| gain(std::f64::consts::PI * f64::from(k) / 1e5)).fold(0.0, f64::max);
    assert!((number(&found["norm"]) / largest - 1.0).abs() < 1e-7, "{found} {largest}");
    let told = refusal("hinfnorm", &problem(SYSTEM, r#""Ts": 1, "sample_time_s": 2"#));
    assert!(told.contains("give one"), "{told}");
    assert!(refusal("hinfnorm", &problem(SYSTEM, r#""Ts": -1"#)).contains("must be positive"));
    assert!(refusal("hinfnorm", r#"{"A": 1.5, "B": 1, "C": 1, "D": 0, "Ts": 1}"#).contains("stable"));
}

#[test]
fn numbers_and_lists_are_matrices_where_the_other_sizes_tell() {
    let same = |kind: &str, short: &str, full: &str| {
        assert_eq!(answer_to(kind, short), answer_to(kind, full), "{kind}: {short}");
    };
    same("hinfnorm", r#"{"A": -2, "B": 3, "C": 1, "D": 0}"#, r#"{"A": [[-2]], "B": [[3]], "C": [[1]], "D": [[0]]}"#);
    // One input, one output, two states: B is a column, C a row.
    same(
        "hinfnorm",
        r#"{"A": [[-1, 0], [0, -2]], "B": [1, 2], "C": [3, 4], "D": 0}"#,
        r#"{"A": [[-1, 0], [0, -2]], "B": [[1], [2]], "C": [[3, 4]], "D": [[0]]}"#,
    );
    // One state: D is a row with two inputs and a column with two outputs.
    same(
        "hinfnorm",
        r#"{"A": -1, "B": [1, 2], "C": 3, "D": [0, 4]}"#,
        r#"{"A": [[-1]], "B": [[1, 2]], "C": [[3]], "D": [[0, 4]]}"#,
    );
    same(
        "hinfnorm",
        r#"{"A": -1, "B": 1, "C": [3, 5], "D": [0, 4]}"#,
        r#"{"A": [[-1]], "B": [[1]], "C": [[3], [5]], "D": [[0], [4]]}"#,
    );
    same("care", r#"{"A": 1, "G": 1, "Q": 3}"#, r#"{"A": [[1]], "G": [[1]], "Q": [[3]]}"#);
    same(
        "mu",
        r#"{"M": 2, "blocks": {"type": "real_scalar", "n": 1}}"#,
        r#"{"M": [[2]], "blocks": [{"type": "real_scalar", "n": 1}]}"#,
    );
    same(
        "mu",
        r#"{"M": {"re": [3, 4], "im": [0, 0]}, "blocks": {"type": "complex_full", "rows": 2, "cols": 1, "n": []}}"#,
        r#"{"M": [[3, 4]], "blocks": [{"type": "complex_full", "rows": 2, "cols": 1}]}"#,
    );
    same(
        "reduce",
        r#"{"A": [[-1, 0], [0, -2]], "B": [1, 2], "C": [3, 4], "D": 0, "orders": 1}"#,
        r#"{"A": [[-1, 0], [0, -2]], "B": [[1], [2]], "C": [[3, 4]], "D": [[0]], "orders": [1]}"#,
    );
    let told = refusal("hinfnorm", r#"{"A": [], "B": [], "C": [], "D": [1, 2]}"#);
    assert!(told.contains("a row or a column"), "{told}");
    let told = refusal("hinfnorm", r#"{"A": [1, 2], "B": 1, "C": 1, "D": 0}"#);
    assert!(told.contains("A: expected a square matrix, found a list of 2 numbers"), "{told}");
    let told = refusal("hinfnorm", r#"{"A": [[-1]], "B": [1, [2]], "C": 1, "D": 0}"#);
    assert!(told.contains("B[1]"), "{told}");
}

#[test]
fn the_condition_of_a_riccati_equation_that_fails_is_named() {
    // A rigid body: q̈ = u, no weight.
    let body = r#"{"A": [[0, 1], [0, 0]], "G": [[0, 0], [0, 1]], "Q": [[0, 0], [0, 0]]}"#;
    let told = refusal("care", body);
    assert!(told.contains("(Q, A) is not detectable") && !told.contains("stabilisable"), "{told}");
    // A weight on the position is enough.
    answer_to("care", r#"{"A": [[0, 1], [0, 0]], "G": [[0, 0], [0, 1]], "Q": [[1, 0], [0, 0]]}"#);
    let told = refusal("care", r#"{"A": [[2, 0], [0, -1]], "G": [[0, 0], [0, 1]], "Q": [[1, 0], [0, 1]]}"#);
    assert!(told.contains("(A, G) is not stabilisable") && told.contains("2.0"), "{told}");
    assert!(!told.contains("detectable"), "{told}");
    // Unstable and unseen: a solution exists, the closed loop mirrors the mode.
    let found = answer_to("care", r#"{"A": 2, "G": 1, "Q": 0}"#);
    assert!((number(&found["X"][0][0]) - 4.0).abs() < 1e-12, "{found}");
    // Neither fails: a level below the optimum.
    let told = refusal("care", r#"{"A": -1, "G": -4, "Q": 4}"#);
    assert!(!told.contains("is not"), "{told}");
}

#[test]
fn one_impossible_order_leaves_the_others() {
    let given = r#""A": [[-1, 0, 0], [0, -2, 1], [0, 0, 3]], "B": [1, 2, 1], "C": [3, 4, 1], "D": 0"#;
    let found = answer_to("reduce", &format!("{{{given}, \"orders\": [0, 2, 9]}}"));
    let solved: Vec<&String> = found["orders"].as_object().unwrap().keys().collect();
    assert_eq!(solved, ["2"]);
    assert!(found["left_out"]["0"].as_str().unwrap().contains("1 poles"), "{found}");
    assert!(found["left_out"]["9"].as_str().unwrap().contains("3 states"), "{found}");
    let told = refusal("reduce", &format!("{{{given}, \"orders\": [9, 10]}}"));
    assert!(told.contains("orders[0]") && told.contains("3 states"), "{told}");
    // Nothing left out, nothing said.
    assert!(answer_to("reduce", &format!("{{{given}, \"orders\": [2]}}")).get("left_out").is_none());
}

#[test]
fn a_plant_without_disturbances_or_errors_is_refused_in_words() {
    let part = |b: &str, c: &str, d: &str, sizes: [usize; 2]| {
        let [m1, p1] = sizes;
        format!(r#"{{"A": [[-1]], "B": {b}, "C": {c}, "D": {d}, "m1": {m1}, "m2": 1, "p1": {p1}, "p2": 1}}"#)
    };
    let (w, z) = ("no disturbance inputs w", "no error outputs z");
    for kind in ["hinfsyn", "dksyn"] {
        let told = refusal(kind, &part("[[1]]", "[[1]]", "[[0]]", [0, 0]));
        assert!(told.contains(w) && told.contains(z) && !told.contains("0 x"), "{told}");
        let told = refusal(kind, &part("[[1, 1]]", "[[1]]", "[[0, 0]]", [1, 0]));
        assert!(told.contains(z) && !told.contains(w) && !told.contains("0 x"), "{told}");
        let told = refusal(kind, &part("[[1]]", "[[1], [1]]", "[[0], [0]]", [0, 1]));
        assert!(told.contains(w) && !told.contains(z) && !told.contains("0 x"), "{told}");
    }
}
