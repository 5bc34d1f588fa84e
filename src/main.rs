//! The `rvachev` command.
fn main() {}
