//! Find where simulation and measurement disagree, name the missing effect, show the gap shrink.
