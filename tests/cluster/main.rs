//! Experiments on a cluster: the scripts that `msm cluster` writes, run by a real Slurm of two nodes on the loopback address, one
//! of which dies, and by GNU parallel.
//!
//! Where Slurm or GNU parallel is not installed its tests are reported as ignored, or fail if `MSM_REQUIRE_SLURM` is 1.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[cfg(unix)]
mod scripts;
#[cfg(unix)]
mod slurm;

#[cfg(unix)]
fn main() -> std::process::ExitCode {
    use libtest_mimic::{Arguments, Trial};
    let needs =
        |programs: &'static [&'static str], name: &str, test: fn() -> Result<(), libtest_mimic::Failed>| {
            let missing = programs.iter().find(|program| scripts::found(program).is_none());
            match missing {
                None => Trial::test(name, test),
                Some(program) if std::env::var("MSM_REQUIRE_SLURM").is_ok_and(|value| value == "1") => {
                    Trial::test(name, move || {
                        Err(format!("MSM_REQUIRE_SLURM is 1 but {program} is not installed").into())
                    })
                }
                Some(_) => Trial::test(name, || Ok(())).with_ignored_flag(true),
            }
        };
    let trials = vec![
        needs(&slurm::PROGRAMS, "a_node_that_dies_costs_time_and_nothing_else", slurm::a_node_dies),
        needs(&["parallel"], "gnu_parallel_runs_the_same_shards", scripts::gnu_parallel),
        Trial::test("mistakes_are_named_and_write_nothing", scripts::mistakes),
        Trial::test("a_forecast_names_the_limits_that_are_exceeded", scripts::forecast),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

#[cfg(not(unix))]
fn main() {}
