//! Loops over arrays in the widest vectors that the processor has, found at run time.

/// Runs `work` compiled for the widest vectors of the processor. What it calls has to be inlined into it. Sums keep their
/// order and no product is contracted with a sum, so that no digit depends on the processor.
#[inline]
pub(crate) fn wide<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
