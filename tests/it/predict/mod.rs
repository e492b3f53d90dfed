//! Stability lobes, time responses, worst cases.

mod cascade;
mod chatter;
mod loop_gain;
mod loop_sigma;
mod simulate;
mod step_and_unbalance;
mod worst_case;
