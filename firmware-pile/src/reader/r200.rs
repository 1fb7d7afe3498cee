//! The R200 family.
