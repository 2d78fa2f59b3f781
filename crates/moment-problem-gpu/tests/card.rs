//! The card against the CPU, program by program, with and without run-time checks, and with and without subgroups. Without an
//! adapter that has double precision the tests are reported as ignored.
#![allow(clippy::unwrap_used)]

use libtest_mimic::{Arguments, Failed, Trial};
use moment_problem::Basis;
use moment_problem::fast_simplex::{
    FastFragment, FastSimplex, FastStart, FunctionTable, SupportColumns, SupportDistribution,
};
use moment_problem::lane_simplex::{
    BatchSolution, ExactSimplex, FunctionSpan, LaneSimplex, LaneStarts, ProgramBatch, SpanColumns,
};
use moment_problem_gpu::{Answer, Card, CardError, GROUP, Programs, Weighting};
use std::process::ExitCode;

#[path = "../../moment-problem/tests/programs/mod.rs"]
mod programs;

const CELLS: usize = 256;
const TOLERANCE: f64 = 1e-6;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let has_card = Card::open(true).is_ok();
    let trial = |name: &str, run: fn() -> Result<(), Failed>| {
        Trial::test(name, run)
            .with_kind(if has_card { "" } else { "needs a card with double precision" })
            .with_ignored_flag(!has_card)
    };
    let trials = vec![
        trial("bounds_and_sums_are_those_of_the_cpu", bounds_and_sums),
        trial("run_time_checks_and_subgroups_change_nothing", variants),
        trial("narrow_kernels_are_left_rather_than_wrong", narrow),
        trial("what_does_not_fit_is_refused", refused),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

struct Case {
    kernels: Vec<SupportDistribution>,
    fragments: Vec<FastFragment>,
    table: FunctionTable,
    span: FunctionSpan,
    columns: Vec<SpanColumns>,
}

impl Case {
    fn new((kernels, fragments): (Vec<SupportDistribution>, Vec<FastFragment>)) -> Self {
        let table =
            FunctionTable::new(&Basis::default_family(), &FunctionTable::uniform_depths(CELLS)).unwrap();
        let span = FunctionSpan::new(&table);
        let mut bases: Vec<Vec<usize>> =
            (0..5).map(|i| programs::subset(37, 4, (2 * i + 1) * 66_045 / 10)).collect();
        bases.extend([programs::powers().to_vec(), programs::waves().to_vec()]);
        let columns = bases.iter().map(|basis| span.columns(basis).unwrap()).collect();
        Self { kernels, fragments, table, span, columns }
    }

    fn batch(&self) -> ProgramBatch<'_> {
        ProgramBatch::new(&self.span, &self.kernels, &self.fragments)
    }

    fn starts(&self, batch: &ProgramBatch<'_>) -> LaneStarts {
        let start = |functions: [usize; 4]| -> FastStart {
            let columns = SupportColumns::new(&self.table, &functions).unwrap();
            let solver = FastSimplex::new(&columns, TOLERANCE).thorough();
            solver.solve(&self.kernels, &self.fragments).start()
        };
        LaneStarts::new(batch, [&start(programs::powers()), &start(programs::waves())], 5)
    }

    fn cpu(&self, batch: &ProgramBatch<'_>, starts: &LaneStarts) -> Vec<BatchSolution> {
        let solve = |columns| LaneSimplex::new(columns, TOLERANCE).unwrap().solve(batch, starts);
        self.columns.iter().map(solve).collect()
    }
}

/// Programs in an order of their own, with a hole, so that places and programs differ.
fn order(count: usize) -> Vec<Option<u32>> {
    let mut order: Vec<Option<u32>> = (0..count as u32).rev().map(Some).collect();
    order.insert(count / 2, None);
    order
}

fn weighting(fragments: &[FastFragment]) -> Vec<Weighting> {
    let one = |(i, fragment): (usize, &FastFragment)| Weighting {
        reference: fragment.mass_before,
        control: 0.01 * (i % 7) as f64,
        count: (1 + i % 3) as f64,
    };
    fragments.iter().enumerate().map(one).collect()
}

/// All bounds by candidate and place, and the answer.
fn solved(card: &Card, case: &Case) -> Result<(Vec<Vec<f64>>, Answer), CardError> {
    let batch = case.batch();
    let starts = case.starts(&batch);
    let (order, weighting) = (order(case.fragments.len()), weighting(&case.fragments));
    let programs = Programs { batch: &batch, starts: &starts, weighting: &weighting, order: &order };
    let resident = card.upload(programs, case.columns.len() + 1, None)?;
    // A second one that borrows its room.
    let other = card.upload(programs, case.columns.len(), Some(&resident))?;
    let wanted: Vec<&SpanColumns> = case.columns.iter().collect();
    let submitted = resident.submit(&batch, &wanted, TOLERANCE)?;
    let behind = other.submit(&batch, &wanted, TOLERANCE)?;
    let answer = resident.finish(submitted)?.0;
    let again = other.finish(behind)?.0;
    assert_eq!(answer.left, again.left);
    assert_eq!(answer.groups, order.len().div_ceil(GROUP));
    let same = |a: &f64, b: &f64| a.to_bits() == b.to_bits();
    for (one, two) in answer.sums.iter().zip(&again.sums) {
        assert!(same(&one.difference, &two.difference) && same(&one.sample, &two.sample));
    }
    let bounds = (0..wanted.len()).map(|c| other.bounds(c)).collect::<Result<_, _>>()?;
    Ok((bounds, answer))
}

fn bounds_and_sums() -> Result<(), Failed> {
    let case = Case::new(programs::workload(CELLS, 1, 400));
    let (bounds, answer) = solved(&Card::open(true)?, &case)?;
    let batch = case.batch();
    let cpu = case.cpu(&batch, &case.starts(&batch));
    let (order, weighting) = (order(case.fragments.len()), weighting(&case.fragments));
    let mut left = 0;
    for (c, (bounds, cpu)) in bounds.iter().zip(&cpu).enumerate() {
        let exact = ExactSimplex::new(case.columns[c].columns());
        let (mut sum, mut square) = (0.0, 0.0);
        for (place, program) in order.iter().enumerate() {
            let Some(program) = *program else { continue };
            let at = program as usize;
            let bound = bounds[place];
            if bound < 0.0 {
                let key = (c as u32, place as u32);
                let own = answer.left.iter().find(|left| (left.candidate, left.program) == key).unwrap();
                let FastFragment { kernel, step, mass_before } = case.fragments[at];
                let found =
                    exact.bound(&case.kernels[kernel as usize], step, mass_before, &own.support).unwrap();
                assert!((found.lower - cpu.lower[at]).abs() <= 2.0 * TOLERANCE);
                left += 1;
                continue;
            }
            assert!((bound - cpu.lower[at]).abs() <= 2.0 * TOLERANCE, "{c} {at}: {bound} {}", cpu.lower[at]);
            let Weighting { reference, control, count } = weighting[at];
            let difference = (bound - reference).abs() - control;
            sum += count * difference;
            square += count * difference * difference;
        }
        let own = &answer.sums[c * answer.groups..][..answer.groups];
        let all: f64 = own.iter().map(|group| group.difference).sum();
        let squares: f64 = own.iter().map(|group| group.square).sum();
        assert!((all - sum).abs() < 1e-9 && (squares - square).abs() < 1e-9, "{c}: {all} {sum}");
        for (group, sums) in own.iter().enumerate() {
            assert_eq!(sums.sample.to_bits(), bounds[answer.sampled(c, group)].to_bits());
        }
    }
    assert_eq!(left, answer.left.len());
    assert!(left * 100 < bounds.len() * case.fragments.len(), "{left} are left");
    Ok(())
}

fn variants() -> Result<(), Failed> {
    let case = Case::new(programs::workload(CELLS, 2, 150));
    let (bounds, answer) = solved(&Card::open(true)?, &case)?;
    for (checked, subgroups) in [(false, true), (true, false), (false, false)] {
        let (others, other) = solved(&Card::with(checked, subgroups)?, &case)?;
        let bits = |bounds: &[Vec<f64>]| bounds.iter().flatten().map(|b| b.to_bits()).collect::<Vec<_>>();
        assert!(bits(&others) == bits(&bounds), "checked {checked}, subgroups {subgroups}");
        assert_eq!(other.left, answer.left);
    }
    Ok(())
}

fn narrow() -> Result<(), Failed> {
    let case = Case::new(programs::narrow(2000));
    let (bounds, answer) = solved(&Card::open(true)?, &case)?;
    let batch = case.batch();
    let cpu = case.cpu(&batch, &case.starts(&batch));
    for (bounds, cpu) in bounds.iter().zip(&cpu) {
        for (place, program) in order(case.fragments.len()).iter().enumerate() {
            let Some(program) = program.filter(|_| bounds[place] >= 0.0) else { continue };
            assert!((bounds[place] - cpu.lower[program as usize]).abs() <= 2.0 * TOLERANCE);
        }
    }
    assert!(!answer.left.is_empty());
    Ok(())
}

fn refused() -> Result<(), Failed> {
    let functions = Basis::default_family();
    let table = FunctionTable::new(&functions, &FunctionTable::uniform_depths(1000)).unwrap();
    let span = FunctionSpan::new(&table);
    let (kernels, fragments) = programs::workload(1000, 1, 4);
    let batch = ProgramBatch::new(&span, &kernels, &fragments);
    let columns = SupportColumns::new(&table, &programs::powers()).unwrap();
    let start = FastSimplex::new(&columns, TOLERANCE).thorough().solve(&kernels, &fragments).start();
    let starts = LaneStarts::new(&batch, [&start, &start], 5);
    let (order, weighting) = (order(fragments.len()), weighting(&fragments));
    let programs = Programs { batch: &batch, starts: &starts, weighting: &weighting, order: &order };
    let card = Card::open(true)?;
    let error = card.upload(programs, 1, None).err().unwrap();
    assert!(matches!(error, CardError::TooLarge { wanted: 1001, .. }), "{error}");
    Ok(())
}
