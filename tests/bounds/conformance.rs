//! The suite that every `LowerBound` runs, and proof that it notices planted faults.

use crate::samples::{Sample, sample};
use moment_problem::arithmetic::DoubleDouble;
use moment_problem::{
    Basis, Bounds, Chebyshev, ExchangeSimplex, Hamburger, Hausdorff4, Interval, LinearProgram, LowerBound,
    Markov, MomentError, Trigonometric4,
};
use random_stream::Random;

/// Attained and proved values are certified to 1e-8; sampled checks add rounding of evaluating the functions.
const TOLERANCE: f64 = 2e-8;

/// What one solver must satisfy on one sample; the first violation in words.
fn violation(solver: &dyn LowerBound, Sample { z, z_f }: &Sample) -> Result<(), String> {
    let bounds = solver.bounds_of(z, *z_f).map_err(|error| format!("fails: {error}"))?;
    let (f, f_inclusive) = (z.cdf(*z_f), z.cdf_inclusive(*z_f));
    let check = |holds: bool, what: &str| {
        if holds { Ok(()) } else { Err(format!("{what}: {bounds:?}, F = {f}, F_le = {f_inclusive}")) }
    };
    check((0.0..=1.0).contains(&bounds.lower) && (0.0..=1.0).contains(&bounds.upper), "outside [0, 1]")?;
    check(bounds.lower <= f + TOLERANCE, "the lower bound exceeds F")?;
    check(bounds.upper >= f_inclusive - TOLERANCE, "the upper bound is below F")?;
    // What double-double moments can prove ends where the dual's terms are 1e28 times larger than its value.
    let size = |dual: &[f64]| dual.iter().map(|y| y.abs()).sum::<f64>() * 1e-28;
    let provable = TOLERANCE + size(&bounds.certificate.lower_dual) + size(&bounds.certificate.upper_dual);
    check(bounds.gap() <= provable && bounds.gap() >= -provable, "proved and attained values differ")?;
    check_support(solver, z, *z_f, &bounds).map_err(|what| format!("{what}: {bounds:?}"))?;
    check_duals(solver, z, *z_f, &bounds).map_err(|what| format!("{what}: {bounds:?}"))
}

/// The support is a distribution with the same moments that attains the lower bound.
fn check_support(
    solver: &dyn LowerBound,
    z: &moment_problem::DepthDistribution,
    z_f: f64,
    bounds: &Bounds,
) -> Result<(), String> {
    if solver.name() == "Markov" {
        return Ok(()); // attained in the limit only, with mass at minus infinity
    }
    let mut residuals: Vec<f64> = z.moments::<f64>(solver.basis()).iter().map(|b| -b).collect();
    let mut sizes: Vec<f64> = residuals.iter().map(|b| b.abs()).collect();
    let (mut mass, mut front) = (0.0, 0.0);
    for (&depth, &weight) in bounds.support.iter().zip(&bounds.weights) {
        if weight < 0.0 {
            return Err(format!("weight {weight} is negative"));
        }
        if solver.interval() == Interval::Unit && !(-1e-12..=1.0 + 1e-12).contains(&depth) {
            return Err(format!("support point {depth} outside [0, 1]"));
        }
        mass += weight;
        front += if depth < z_f { weight } else { 0.0 };
        for ((residual, size), value) in
            residuals.iter_mut().zip(&mut sizes).zip(solver.basis().evaluate::<f64>(depth))
        {
            *residual += weight * value;
            *size += (weight * value).abs();
        }
    }
    if (mass - 1.0).abs() > TOLERANCE {
        return Err(format!("the support's weights sum to {mass}"));
    }
    if (front - bounds.lower).abs() > 1e-6 {
        return Err(format!("the support has mass {front} in front of z_f"));
    }
    // A distant point of tiny weight may carry most of a high moment: compare relative to the terms.
    match residuals.iter().zip(&sizes).find(|(residual, size)| residual.abs() > 1e-6 * size.max(1.0)) {
        Some((residual, _)) => Err(format!("the support misses a moment by {residual}")),
        None => Ok(()),
    }
}

/// The duals stay below the steps and reach the proved values.
fn check_duals(
    solver: &dyn LowerBound,
    z: &moment_problem::DepthDistribution,
    z_f: f64,
    bounds: &Bounds,
) -> Result<(), String> {
    let certificate = &bounds.certificate;
    let value = |dual: &[f64], depth: f64| {
        let functions = solver.basis().evaluate::<f64>(depth);
        let terms = dual[1..].iter().zip(functions).map(|(y, b)| y * b);
        let size = dual[1..].iter().zip(solver.basis().evaluate::<f64>(depth)).map(|(y, b)| (y * b).abs());
        (dual[0] + terms.sum::<f64>(), 1.0 + dual[0].abs() + size.sum::<f64>())
    };
    let (low, high) = if solver.interval() == Interval::Unit { (0.0, 1.0) } else { (-1.0, 2.0) };
    for i in 0..=600 {
        let depth = low + (high - low) * f64::from(i) / 600.0;
        for (dual, step) in [(&certificate.lower_dual, depth < z_f), (&certificate.upper_dual, depth > z_f)] {
            let (value, size) = value(dual, depth);
            let step = f64::from(u8::from(step));
            // Coefficients are rounded to doubles, so the function is off by 1e-16 of its largest term.
            if value > step + TOLERANCE + 1e-14 * size {
                return Err(format!("a dual function is {value} at {depth}, above the step"));
            }
        }
    }
    let expectation = |dual: &[f64]| {
        let atoms = z.depths().iter().zip(z.weights());
        atoms.fold((0.0, 0.0), |(sum, size), (&depth, w)| {
            let (v, s) = value(dual, depth);
            (sum + w.to_f64() * v, size + w.to_f64() * s)
        })
    };
    let (lower, size) = expectation(&certificate.lower_dual);
    if certificate.lower_proved > lower.max(0.0) + TOLERANCE + 1e-14 * size {
        return Err(format!("the dual proves {lower} only"));
    }
    let (upper, size) = expectation(&certificate.upper_dual);
    if certificate.upper_proved < (1.0 - upper).min(1.0) - TOLERANCE - 1e-14 * size {
        return Err(format!("the dual proves an upper bound of {} only", 1.0 - upper));
    }
    Ok(())
}

fn solvers() -> Vec<(Box<dyn LowerBound>, usize)> {
    let list = |text: &str| text.parse::<Basis>().unwrap();
    vec![
        (Box::new(Chebyshev::default()), 3000),
        (Box::new(Hamburger::<4>::default()), 3000),
        (Box::new(Hamburger::<6>::default()), 3000),
        (Box::new(Hamburger::<8>::default()), 3000),
        (Box::new(Markov::new(20.0).unwrap()), 3000),
        (Box::new(Hausdorff4::new().unwrap()), 1500),
        (Box::new(Trigonometric4::new().unwrap()), 800),
        (Box::new(ExchangeSimplex::new(&Basis::power(3)).unwrap()), 300),
        (Box::new(ExchangeSimplex::new(&Basis::power(6)).unwrap()), 300),
        (Box::new(ExchangeSimplex::new(&list("z^2,exp(-4z),ln(1+4z),sin(6pi z)")).unwrap()), 300),
        (Box::new(ExchangeSimplex::new(&list("z,1/(1/4+z),1/(1+25(z-1/2)^2)")).unwrap()), 300),
        (Box::new(LinearProgram::new(&Basis::power(4)).unwrap()), 150),
        (Box::new(LinearProgram::new(&Basis::trigonometric(2)).unwrap()), 100),
        (Box::new(LinearProgram::new(&list("sqrt(z+1/16),exp(2z),cos(3pi z),z/(1+z^2)")).unwrap()), 100),
    ]
}

#[test]
fn every_solver_passes_the_suite() {
    for (solver, count) in solvers() {
        let mut random = Random::new(20150301);
        let mut refused = 0;
        for index in 0..count {
            let sample = sample(&mut random);
            // Six moments of depths within 1e-3 of each other need duals of 1e19, which double-double cannot prove;
            // and both LP solvers can give up. Then there is an error and no number.
            if let Err(MomentError::Uncertified { .. } | MomentError::Solver { .. }) =
                solver.bounds_of(&sample.z, sample.z_f)
            {
                refused += 1;
                continue;
            }
            if let Err(what) = violation(&*solver, &sample) {
                panic!("{} ({}), sample {index}: {what} {sample:?}", solver.name(), solver.basis());
            }
        }
        println!("{} ({}): {refused} of {count} refused", solver.name(), solver.basis());
        assert!(
            refused * 25 <= count,
            "{} ({}): {refused} of {count} refused",
            solver.name(),
            solver.basis()
        );
    }
}

/// Spoils bounds, given z_f.
type Fault = fn(&mut Bounds, f64);

/// A solver with one planted mistake.
struct Faulty {
    inner: Hamburger<4>,
    fault: Fault,
}

impl LowerBound for Faulty {
    fn name(&self) -> &'static str {
        "faulty"
    }
    fn basis(&self) -> &Basis {
        self.inner.basis()
    }
    fn interval(&self) -> Interval {
        Interval::Real
    }
    fn bounds_near(&self, moments: &[DoubleDouble], z_f: f64, depths: &[f64]) -> Result<Bounds, MomentError> {
        let mut bounds = self.inner.bounds_near(moments, z_f, depths)?;
        (self.fault)(&mut bounds, z_f);
        Ok(bounds)
    }
}

#[test]
fn the_suite_notices_planted_faults() {
    let faults: [(&str, Fault); 6] = [
        ("lower and upper swapped", |b, _| std::mem::swap(&mut b.lower, &mut b.upper)),
        ("a support point mirrored at z_f", |b, z_f| b.support[0] = 2.0 * z_f - b.support[0]),
        ("weights of two roots swapped", |b, _| b.weights.reverse()),
        ("sign of a dual coefficient", |b, _| b.certificate.lower_dual[2] *= -1.0),
        ("the bound of z_f's own mass included", |b, _| b.lower = b.upper),
        ("proved value too good", |b, _| b.certificate.lower_proved += 1e-3),
    ];
    for (name, fault) in faults {
        let faulty = Faulty { inner: Hamburger::default(), fault };
        let mut random = Random::new(7);
        let caught = (0..200).filter(|_| violation(&faulty, &sample(&mut random)).is_err()).count();
        assert!(caught > 20, "the fault `{name}` was noticed in {caught} of 200 samples");
    }
}
