//! Tests of the whole system.

mod golden;
