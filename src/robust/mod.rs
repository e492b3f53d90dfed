//! Synthesis and analysis: H∞, μ bounds, D-scales and their fits, the D-K loop.
