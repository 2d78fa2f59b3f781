//! Sharp bounds on a depth distribution from generalised moments, with evidence.
