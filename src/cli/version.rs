//! What `muspin --version` says: version, commit where the build knows it, kind of build, system.

/// Version, commit and build. The commit is that of `build.rs`; a debug build and a build outside the repository have
/// none.
pub(super) fn text() -> String {
    let commit = option_env!("MUSPIN_COMMIT").map(|commit| format!("commit {commit}, ")).unwrap_or_default();
    let build = if cfg!(debug_assertions) { "debug" } else { "release" };
    let (version, system) = (env!("CARGO_PKG_VERSION"), std::env::consts::OS);
    format!("{version} ({commit}{build} build, {system} {})", std::env::consts::ARCH)
}
