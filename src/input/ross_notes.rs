//! Notes on elements of a ROSS file: elements with the same note share one sentence.

/// Notes in the order in which they were first made.
#[derive(Clone, Debug, Default)]
pub(super) struct GroupedNotes {
    groups: Vec<(String, Vec<String>)>,
}

impl GroupedNotes {
    /// Adds `words` on the element `name`.
    pub(super) fn add(&mut self, name: impl Into<String>, words: impl Into<String>) {
        let (name, words) = (name.into(), words.into());
        match self.groups.iter_mut().find(|(known, _)| *known == words) {
            Some((_, names)) => names.push(name),
            None => self.groups.push((words, vec![name])),
        }
    }

    /// One sentence for every note; several elements are counted, the first and the last of them named.
    pub(super) fn sentences(&self) -> Vec<String> {
        let sentence = |(words, names): &(String, Vec<String>)| match names.as_slice() {
            [one] => format!("{one}: {words}"),
            [one, other] => format!("{one} and {other}: {words}"),
            [first, .., last] => format!("{} elements, {first} to {last}: {words}", names.len()),
            [] => words.clone(),
        };
        self.groups.iter().map(sentence).collect()
    }
}
