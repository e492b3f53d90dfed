//! Records to frequency responses with covariance; resonances and antiresonances; hammer tests.
