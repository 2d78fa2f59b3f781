//! Experiments as data: trials, records, provenance.
