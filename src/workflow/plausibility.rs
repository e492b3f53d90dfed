//! The plausibility of every record of a measurement, said before anything is done with them.

use super::failure::Failure;
use crate::controller::Controller;
use crate::identify::{
    IdentifyError, MeasuredFrf, Plausibility, hammer_plausibility, open_loop_columns, sweep_plausibility,
};
use crate::input::{Measurement, load_controller};
use crate::lti::HeldResponse;
use crate::spindle::Machine;

/// Sweeps in file order with their responses, then hammer tests that name their controller.
pub(crate) struct Records {
    /// Open-loop response of every sweep.
    pub(crate) frfs: Vec<MeasuredFrf>,
    /// One report a record: the sweeps first.
    pub(crate) reports: Vec<Plausibility>,
    /// Controllers of the hammer tests that name one, in their order.
    pub(crate) controllers: Vec<Controller>,
    /// What of the files is not used and what they do not determine, in words.
    notes: Vec<String>,
}

/// The controllers of the hammer tests that name one, in their order.
pub(crate) fn controllers(measurement: &Measurement) -> Result<Vec<Controller>, Failure> {
    let named = measurement.hammers.iter();
    let named = named.filter_map(|h| h.controller.as_ref());
    named.map(|path| Ok(load_controller(path)?)).collect()
}

impl Records {
    /// Estimates the responses of all sweeps and compares every record with the machine; without magnets there are
    /// neither sweeps nor controllers. `watch` is called before each record.
    pub(crate) fn of(measurement: &Measurement, machine: Option<&Machine>, watch: &dyn Fn()) -> Result<Self, Failure> {
        let (mut frfs, mut reports, mut notes) = (vec![], vec![], vec![]);
        for (sweep, machine) in measurement.sweeps.iter().zip(machine.into_iter().cycle()) {
            watch();
            let name = &sweep.record.name;
            let (frf, undetermined) = open_loop_columns(&sweep.record).map_err(|e| name_record(e, name))?;
            let said = sweep.record.left_out.iter().chain(&undetermined);
            notes.extend(said.map(|note| format!("{name}: {note}")));
            if !undetermined.is_empty() {
                notes.push(format!("{name}: without all four injections units, signs and channels are not checked"));
                reports.push(Plausibility { record: name.clone(), checks: vec![], faults: vec![] });
                frfs.push(frf);
                continue;
            }
            let controller = sweep.controller.as_ref().map(|path| load_controller(path));
            let controller = controller.transpose()?;
            let named = controller.as_ref().map(|k| k as &dyn HeldResponse);
            reports.push(sweep_plausibility(name, &frf, machine, named)?);
            frfs.push(frf);
        }
        let controllers = controllers(measurement)?;
        let known = measurement.hammers.iter();
        let known = known.filter(|hammer| hammer.controller.is_some());
        for ((hammer, controller), machine) in known.zip(&controllers).zip(machine.into_iter().cycle()) {
            watch();
            let (name, frf) = (&hammer.name, &hammer.frf);
            let report = hammer_plausibility(name, frf, hammer.axis, machine, controller)?;
            reports.push(report);
        }
        notes.extend(measurement.hammers.iter().flat_map(|hammer| hammer.notes.iter().cloned()));
        Ok(Self { frfs, reports, controllers, notes })
    }

    /// True when every record is plausible.
    pub(crate) fn plausible(&self) -> bool {
        self.reports.iter().all(Plausibility::plausible)
    }

    /// Lines for standard error: what is wrong, then the remarks.
    pub(crate) fn lines(&self) -> impl Iterator<Item = String> {
        let statements = self.reports.iter().filter_map(Plausibility::statement);
        let remarks = self.reports.iter().flat_map(Plausibility::remarks);
        let notes = self.notes.iter().cloned().chain(remarks);
        statements.chain(notes.map(|note| format!("note: {note}")))
    }

    /// The sweep that updating and identification use, with its report.
    pub(crate) fn standstill(&self) -> Option<(&MeasuredFrf, &Plausibility)> {
        let frf = standstill(&self.frfs)?;
        let at = self.frfs.iter().position(|f| std::ptr::eq(f, frf))?;
        Some((frf, self.reports.get(at)?))
    }

    /// An error when the sweep that moduli would be fitted to is implausible.
    pub(crate) fn refuse_for_updating(&self) -> Result<(), Failure> {
        match self.standstill().and_then(|(_, report)| report.statement()) {
            Some(statement) => Err(Failure::new(statement)
                .with_hint("moduli are not fitted to an implausible record; `muspin identify` shows all checks")),
            None => Ok(()),
        }
    }
}

/// A failure of identification with the record that it comes from.
pub(crate) fn name_record(error: IdentifyError, record: &str) -> Failure {
    Failure::from(error).naming(&[record.to_owned()])
}

/// The first sweep at standstill.
pub(crate) fn standstill(frfs: &[MeasuredFrf]) -> Option<&MeasuredFrf> {
    frfs.iter().find(|f| f.speed_rpm == 0.0)
}
