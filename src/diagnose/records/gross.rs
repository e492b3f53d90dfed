//! Mistakes that need no fit: a record against the nominal machine, as [`crate::identify::plausibility`] does it.

use super::super::DiagnoseError;
use super::super::data::measurement::{ControlAxis, RecordId, RecordSet};
use super::finding::FoundFault;
use crate::identify::{hammer_plausibility, open_loop, sweep_plausibility};
use crate::spindle::Machine;
use rayon::prelude::*;

/// The gross mistakes of all records, and the measurement without them.
pub(crate) fn without_gross_faults<'a>(
    machine: &Machine,
    measurement: &RecordSet<'a>,
) -> Result<(Vec<FoundFault>, RecordSet<'a>), DiagnoseError> {
    let (mut found, mut right) = (vec![], measurement.clone());
    let records: Vec<RecordId> = measurement.records().collect();
    let each = records.par_iter().map(|record| {
        Ok(match *record {
            RecordId::Sweep(s) => {
                let sweep = &measurement.sweeps[s];
                let frf = open_loop(sweep)?;
                sweep_plausibility(&sweep.name, &frf, machine, None)?.faults
            }
            RecordId::Hammer(t) => {
                let tap = &measurement.taps[t];
                let axis = usize::from(tap.axis == ControlAxis::Y);
                hammer_plausibility("", &tap.frf, axis, machine, tap.controller)?.faults
            }
        })
    });
    let each: Vec<_> = each.collect::<Result<_, DiagnoseError>>()?;
    for (record, faults) in records.into_iter().zip(each) {
        for fault in faults {
            right = right.correct_record(record, fault);
            found.push(FoundFault { record, fault, name: None });
        }
    }
    Ok((found, right))
}
