//! Element moduli from resonances and antiresonances.
