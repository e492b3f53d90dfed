//! No circle of files: what a file imports does not import the file, over any number of steps.
//!
//! A path resolves to the file of its longest prefix that is a module, through the re-exports of `mod.rs`. Files named
//! `mod.rs` list their modules and hold what these share: they import nobody here.

use super::architecture::{Source, none, sources};
use std::collections::{BTreeMap, BTreeSet};

type Path = Vec<String>;

struct Module {
    source: Source,
    /// Paths that the file names.
    uses: Vec<Path>,
    /// What it re-exports: name and path.
    exports: BTreeMap<String, Path>,
}

/// Modules by their path below the crate.
struct Modules(BTreeMap<Path, Module>);

fn module_path(file: &str) -> Option<Path> {
    let mut path: Path = file.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if path.last().is_some_and(|l| l == "mod") {
        path.pop();
    }
    (!matches!(path.first().map(String::as_str), Some("lib" | "main"))).then_some(path)
}

/// The paths of a use tree.
fn expanded(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap_or_default();
        return vec![path.trim().to_owned()];
    };
    let prefix = &tree[..open];
    let close = tree.rfind('}').unwrap_or(tree.len());
    let (mut depth, mut item, mut all) = (0, String::new(), vec![]);
    let inside = format!("{},", &tree[open + 1..close]);
    for c in inside.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if c == ',' && depth == 0 {
            let entry = std::mem::take(&mut item);
            if !entry.trim().is_empty() {
                all.extend(expanded(&entry).into_iter().map(|p| format!("{prefix}{p}")));
            }
        } else {
            item.push(c);
        }
    }
    all
}

impl Modules {
    fn read() -> Self {
        let mut modules = BTreeMap::new();
        for source in sources() {
            if let Some(path) = module_path(&source.path) {
                let (uses, exports) = (vec![], BTreeMap::new());
                modules.insert(path, Module { source, uses, exports });
            }
        }
        let mut all = Self(modules);
        let paths: Vec<Path> = all.0.keys().cloned().collect();
        for path in paths {
            let (uses, exports) = all.named_in(&path);
            if let Some(module) = all.0.get_mut(&path) {
                (module.uses, module.exports) = (uses, exports);
            }
        }
        all
    }

    /// A path as seen in a module, from the root of the crate.
    fn absolute(&self, module: &[String], path: &str) -> Option<Path> {
        let mut segments: Vec<&str> = path.split("::").collect();
        let mut from: Path = match segments.first()? {
            &"crate" => vec![],
            &"self" | &"super" => module.to_vec(),
            first => {
                let child: Path = module.iter().cloned().chain([(*first).to_owned()]).collect();
                return self
                    .0
                    .contains_key(&child)
                    .then(|| module.iter().cloned().chain(segments.iter().map(|s| (*s).to_owned())).collect());
            }
        };
        while let Some(first) = segments.first().filter(|s| ["crate", "self", "super"].contains(s)) {
            if *first == "super" {
                from.pop();
            }
            segments.remove(0);
        }
        from.extend(segments.into_iter().map(str::to_owned));
        Some(from)
    }

    fn named_in(&self, path: &[String]) -> (Vec<Path>, BTreeMap<String, Path>) {
        let (mut uses, mut exports) = (vec![], BTreeMap::new());
        let Some(module) = self.0.get(path) else {
            return (uses, exports);
        };
        let code: String = module.source.code().iter().map(|(_, l)| format!("{l}\n")).collect();
        let mut rest = String::new();
        for statement in code.split_inclusive(';') {
            let use_at = statement
                .rfind("use ")
                .filter(|at| statement[..*at].ends_with(|c: char| c.is_whitespace()) || *at == 0)
                .filter(|at| statement[*at..].ends_with(';'));
            let Some(at) = use_at else {
                rest.push_str(statement);
                continue;
            };
            rest.push_str(&statement[..at]);
            let public = statement[..at].trim_end().ends_with("pub");
            for tree in expanded(&statement[at + 4..statement.len() - 1]) {
                if let Some(absolute) = self.absolute(path, &tree) {
                    if let (true, Some(name)) = (public, absolute.last()) {
                        exports.insert(name.clone(), absolute.clone());
                    }
                    uses.push(absolute);
                }
            }
        }
        for start in ["crate::", "super::", "self::"] {
            for (at, _) in rest.match_indices(start) {
                let before = rest[..at].chars().next_back().unwrap_or(' ');
                if before.is_alphanumeric() || before == '_' || before == ':' {
                    continue;
                }
                let named: String =
                    rest[at..].chars().take_while(|c| c.is_alphanumeric() || *c == '_' || *c == ':').collect();
                uses.extend(self.absolute(path, named.trim_end_matches(':')));
            }
        }
        (uses, exports)
    }

    /// The module that a path leads to.
    fn home(&self, path: &[String], depth: usize) -> Option<Path> {
        let found = (1..=path.len()).rev().map(|k| &path[..k]).find(|p| self.0.contains_key(*p))?;
        let module = self.0.get(found)?;
        let next = path.get(found.len()).and_then(|name| module.exports.get(name));
        match next {
            Some(onward) if depth < 6 => {
                let rest = path[found.len() + 1..].iter();
                let onward: Path = onward.iter().chain(rest).cloned().collect();
                self.home(&onward, depth + 1)
            }
            _ => Some(found.to_vec()),
        }
    }

    fn is_list(&self, path: &[String]) -> bool {
        self.0.get(path).is_some_and(|m| m.source.path.ends_with("mod.rs"))
    }

    /// Files that a file imports.
    fn imports(&self, path: &[String]) -> BTreeSet<Path> {
        if self.is_list(path) {
            return BTreeSet::new();
        }
        let uses = self.0.get(path).map_or(&[][..], |m| m.uses.as_slice());
        uses.iter().filter_map(|u| self.home(u, 0)).filter(|h| h.as_slice() != path && !self.is_list(h)).collect()
    }
}

/// Vertices that reach themselves.
fn on_circles(edges: &BTreeMap<Path, BTreeSet<Path>>) -> Vec<Path> {
    let reaches_itself = |from: &Path| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(at) = open.pop() {
            for next in edges.get(at).into_iter().flatten() {
                if next == from {
                    return true;
                }
                if seen.insert(next) {
                    open.push(next);
                }
            }
        }
        false
    };
    edges.keys().filter(|v| reaches_itself(v)).cloned().collect()
}

#[test]
fn no_file_imports_itself_over_others() {
    let modules = Modules::read();
    let edges: BTreeMap<Path, BTreeSet<Path>> = modules.0.keys().map(|p| (p.clone(), modules.imports(p))).collect();
    assert!(edges.values().map(BTreeSet::len).sum::<usize>() > 300, "imports are not seen");
    let found = on_circles(&edges).iter().map(|p| p.join("/")).collect();
    none(found, "files import each other in a circle: move the shared type to a file of its own");
}

#[test]
fn circles_and_use_trees_are_recognised() {
    let path = |s: &str| s.split('/').map(str::to_owned).collect::<Path>();
    let edge = |a: &str, b: &[&str]| (path(a), b.iter().map(|b| path(b)).collect::<BTreeSet<_>>());
    let edges = BTreeMap::from([edge("a", &["b"]), edge("b", &["c"]), edge("c", &["a"]), edge("d", &["a"])]);
    assert_eq!(on_circles(&edges), [path("a"), path("b"), path("c")]);
    assert_eq!(expanded("super::{a::{B, c::D}, e as f}"), ["super::a::B", "super::a::c::D", "super::e"]);
}
