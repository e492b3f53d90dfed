//! CSV tables: comma, one header line, numbers in shortest round-trip form, empty cells for what does not exist.

/// A table of text cells under one header line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table with these column names.
    pub fn new(header: Vec<String>) -> Self {
        Self { header, rows: Vec::new() }
    }

    /// An empty table with these column names.
    pub fn with_columns(header: &[&str]) -> Self {
        Self::new(header.iter().map(|h| (*h).to_owned()).collect())
    }

    /// Adds a row of texts.
    pub fn push(&mut self, row: Vec<String>) {
        self.rows.push(row);
    }

    /// Adds a row of numbers; what is not finite becomes an empty cell.
    pub fn push_numbers(&mut self, row: &[f64]) {
        self.push(row.iter().map(|x| Self::number(*x)).collect());
    }

    /// The shortest text that reads back as the same number; empty for what is not finite.
    pub fn number(x: f64) -> String {
        let size = x.abs();
        if !x.is_finite() {
            String::new()
        } else if size == 0.0 {
            // Without the sign of a negative zero.
            "0".to_owned()
        } else if (1e-4..1e15).contains(&size) {
            format!("{x}")
        } else {
            format!("{x:e}")
        }
    }

    /// The table as CSV text. Rows shorter than the header are filled, longer ones cut, so that every line has its
    /// columns.
    pub fn to_csv(&self) -> String {
        let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
        let empty = String::new();
        let mut complete = writer.write_record(&self.header).is_ok();
        for row in &self.rows {
            let cells = (0..self.header.len()).map(|k| row.get(k).unwrap_or(&empty));
            complete &= writer.write_record(cells).is_ok();
        }
        let bytes = writer.into_inner().unwrap_or_default();
        // Writing to memory does not fail, and the cells were text; the flag keeps that an assertion and not a hope.
        debug_assert!(complete);
        String::from_utf8(bytes).unwrap_or_default()
    }
}
