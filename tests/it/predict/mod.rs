//! Stability lobes, time responses, worst cases.

mod chatter;
mod simulate;
mod worst_case;
