//! Applications against reference numbers in a folder of CSV files.
//!
//! `MSM_VECTORS=DIR cargo test --release --test application_vectors` reads DIR, else `../shared/vectors/applications`
//! beside this repository. Each file has a reader; a file that is absent is reported as ignored by its name. A reader
//! prints how many rows were met and fails on the first that is not, with the accuracy that it was judged by.

// A test prints what it measured and panics where its input is damaged.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod area_lights;
mod blocker_search;
mod sampled_lights;
mod scattering;
mod small_formulas;
mod summed_area;
mod table;
mod translucency;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use libtest_mimic::{Arguments, Failed, Trial};

use crate::table::Table;

/// A file and what reads it: one check a row.
struct Reader {
    file: &'static str,
    check: fn(&Table) -> Result<(), Failed>,
}

const READERS: &[Reader] = &[
    Reader { file: "area_light.csv", check: area_lights::occluded_fractions },
    Reader { file: "blocker_search.csv", check: blocker_search::blockers },
    Reader { file: "halton.csv", check: small_formulas::halton },
    Reader { file: "pcss.csv", check: area_lights::percentage_closer },
    Reader { file: "penumbra_width.csv", check: small_formulas::penumbra_width },
    Reader { file: "sat_encode.csv", check: summed_area::encoding },
    Reader { file: "sat_integer.csv", check: summed_area::integer_queries },
    Reader { file: "sat_real.csv", check: summed_area::real_queries },
    Reader { file: "rectified.csv", check: scattering::rectified },
    Reader { file: "scatter_closed.csv", check: scattering::closed_forms },
    Reader { file: "scatter_lookup.csv", check: scattering::look_ups },
    Reader { file: "scatter_prefix.csv", check: scattering::prefix_sums },
    Reader { file: "scatter_rays.csv", check: scattering::rays },
    Reader { file: "scatter_resample.csv", check: scattering::resampled },
    Reader { file: "sssm_filter.csv", check: sampled_lights::stochastic_filter },
    Reader { file: "sssm_flatland.csv", check: sampled_lights::stochastic_flatland },
    Reader { file: "sssm_planes.csv", check: sampled_lights::stochastic_planes },
    Reader { file: "sssm_radius.csv", check: small_formulas::circle_of_confusion },
    Reader { file: "sssm_weight.csv", check: small_formulas::coarser_weight },
    Reader { file: "temporal_buffer.csv", check: sampled_lights::temporal_buffer },
    Reader { file: "temporal_counts.csv", check: small_formulas::temporal_counts },
    Reader { file: "temporal_statistics.csv", check: small_formulas::temporal_statistics },
    Reader { file: "translucent.csv", check: translucency::kernels },
    Reader { file: "two_depth.csv", check: small_formulas::two_depths },
];

fn folder() -> PathBuf {
    match std::env::var_os("MSM_VECTORS") {
        Some(folder) => PathBuf::from(folder),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/vectors/applications"),
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let folder = folder();
    // A folder that was asked for by name must be there.
    let named = std::env::var_os("MSM_VECTORS").is_some();
    let mut trials = Vec::new();
    if named {
        let asked = folder.clone();
        trials.push(Trial::test("folder", move || match asked.is_dir() {
            true => Ok(()),
            false => Err(format!("MSM_VECTORS names {}, which is no folder", asked.display()).into()),
        }));
    }
    for reader in READERS {
        let path = folder.join(reader.file);
        let is_there = path.is_file();
        let name = reader.file.trim_end_matches(".csv");
        let trial = Trial::test(name, move || {
            let table = Table::read(&path)?;
            (reader.check)(&table)?;
            println!("{}: {} rows of {} met", reader.file, table.rows().len(), table.rows().len());
            Ok(())
        });
        let reason = if is_there { "" } else { "needs application vectors, see MSM_VECTORS" };
        trials.push(trial.with_kind(reason).with_ignored_flag(!is_there));
    }
    trials.push(Trial::test("planted_faults_are_found", || Ok(table::finds_planted_faults()?)));
    libtest_mimic::run(&arguments, trials).exit_code()
}
