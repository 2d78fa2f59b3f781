//! Charts and pages as a pure function of recorded files.
