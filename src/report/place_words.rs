//! What the sentences of a machine without a tool call the place where stiffness counts: its output.

use super::summary::Summary;
use crate::spindle::Machine;
use serde_json::Value;

/// Words of a machine with a tool, and of one without; earlier ones win.
const WORDS: [(&str, &str); 6] = [
    (" with its tool", ""),
    (" with no tool", ""),
    ("the tool plane", "the output"),
    ("the tool", "the output"),
    ("its tool", "its output"),
    ("tool stiffness", "output stiffness"),
];

pub(crate) fn place_words(machine: &Machine, text: String) -> String {
    if machine.tool.is_absent() { at_output(&text) } else { text }
}

/// A text in the words of a machine without a tool.
pub(super) fn at_output(text: &str) -> String {
    // A name that stands alone in a picture.
    let text = text.replace(">tool<", ">output<").replace("'tool'", "'output'");
    WORDS.iter().fold(text, |text, (tool, output)| text.replace(tool, output))
}

/// The sentences of a summary in these words; its keys stay.
pub(super) fn summary_at_output(summary: &Summary) -> Summary {
    fn moved(value: Value) -> Value {
        match value {
            Value::String(text) => Value::String(at_output(&text)),
            Value::Array(items) => items.into_iter().map(moved).collect(),
            Value::Object(map) => map.into_iter().map(|(key, item)| (key, moved(item))).collect(),
            plain => plain,
        }
    }
    let mut all = Summary::new();
    if let Value::Object(topics) = summary.value() {
        topics.into_iter().for_each(|(key, topic)| all.set(&key, moved(topic)));
    }
    all
}
