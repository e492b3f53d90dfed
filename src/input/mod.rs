//! Files in: YAML, CSV, JSON, UFF to validated domain values. The only home of parsing.
