//! What `muspin --version` says: version, commit where the build was told it, kind of build, system.

/// Version, commit and build. The commit is the variable `MUSPIN_COMMIT` of the build, which a release sets: cargo
/// would compile the whole crate anew after each commit if it were read from the repository.
pub(super) fn text() -> String {
    let commit = option_env!("MUSPIN_COMMIT").unwrap_or("not recorded");
    let build = if cfg!(debug_assertions) { "debug" } else { "release" };
    let (version, system) = (env!("CARGO_PKG_VERSION"), std::env::consts::OS);
    format!("{version} (commit {commit}, {build} build, {system} {})", std::env::consts::ARCH)
}
