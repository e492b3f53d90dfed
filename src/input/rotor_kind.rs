//! Whether a file of keys is a spindle or a rotor without magnets.

use super::shipped;
use super::yaml;
use serde_yaml::Value;

/// Keys of a spindle that a rotor has not.
const OF_MAGNETS: [&str; 4] = ["planes", "bearings", "electronics", "speed"];

/// Whether a file of keys is that of a rotor without magnets.
pub(super) fn is_rotor_tree(tree: &Value) -> bool {
    tree.get("rotor").is_some() && OF_MAGNETS.iter().all(|key| tree.get(*key).is_none())
}

/// Whether a path is that of a rotor without magnets; false for what cannot be read.
pub fn is_rotor(source: &str) -> bool {
    let text = shipped::text(source, "spindle", shipped::SPINDLES);
    text.and_then(|text| yaml::value(source, &text)).is_ok_and(|tree| is_rotor_tree(&tree))
}
