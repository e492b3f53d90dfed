//! Machines that are alike: every length times s, the same materials, stresses and currents, and all times longer by
//! the same factor. Then forces grow with s², masses with s³, stiffnesses with s, and natural frequencies fall with 1/s.

use serde_yaml::Value;

/// Ends of keys, and the power of s with which their numbers grow; the first that fits counts.
const POWERS: [(&str, i32); 14] = [
    ("m_per_a_s", 2),
    ("_n_m_s_per_rad", 4),
    ("_n_m_per_rad", 3),
    ("_n_s_per_m", 2),
    ("_n_per_m", 1),
    ("_n_per_a", 2),
    ("_n", 2),
    ("_kg_m2", 5),
    ("_kg_m3", 0),
    ("mass_kg", 3),
    ("_hz", -1),
    ("_rpm", -1),
    ("_s", 1),
    ("_m", 1),
];

/// The power of s with which the number of a key grows.
pub fn power(key: &str) -> i32 {
    let unit = POWERS.iter().find(|(end, _)| key.ends_with(end));
    unit.map_or(0, |(_, power)| *power)
}

/// The spindle or tool of a file, `s` times as large.
pub fn alike(file: &str, s: f64) -> String {
    let mut all: Value = serde_yaml::from_str(file).unwrap();
    grow(&mut all, "", s);
    serde_yaml::to_string(&all).unwrap()
}

fn grow(value: &mut Value, key: &str, s: f64) {
    match value {
        Value::Mapping(all) => {
            for (key, value) in all.iter_mut() {
                grow(value, key.as_str().unwrap(), s);
            }
        }
        Value::Sequence(all) => all.iter_mut().for_each(|value| grow(value, key, s)),
        Value::Number(number) if power(key) != 0 => {
            let grown = number.as_f64().unwrap() * s.powi(power(key));
            *value = Value::from(grown);
        }
        _ => {}
    }
}
