//! A fault of a record, and what else could have been in the machine or in the loop.

use super::super::data::measurement::RecordId;
use crate::identify::plausibility::RecordFault;
use crate::lti::HeldResponse;
use crate::spindle::Machine;

/// A fault of one record.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundFault {
    /// The record.
    pub record: RecordId,
    /// What is wrong with it.
    pub fault: RecordFault,
    /// Name of the tool or controller that fits.
    pub name: Option<String>,
}

/// What may have been there in place of what the records name.
#[derive(Default)]
pub struct Alternatives<'a> {
    /// The spindle with other tools, by the tools' names.
    pub tools: Vec<(String, Machine)>,
    /// Other controllers, by name.
    pub controllers: Vec<(String, &'a dyn HeldResponse)>,
}
