use moment_problem::*;
use std::time::Instant;
fn main() {
    for (what, mk) in [("both", 0), ("clarabel", 1), ("microlp", 2)] {
        let mut reader = csv::Reader::from_path("/work/shared/vectors/bounds.csv").unwrap();
        let (mut n, mut bad, mut worst, mut rej, mut time) = (0, 0, 0f64, 0, 0.0);
        for r in reader.records() {
            let r = r.unwrap();
            let b = &r[1];
            let d: Vec<f64> = serde_json::from_str(&r[2]).unwrap();
            let w: Vec<f64> = serde_json::from_str(&r[3]).unwrap();
            let z_f: f64 = r[4].parse().unwrap();
            let lower: f64 = r[7].parse().unwrap();
            let upper: f64 = r[8].parse().unwrap();
            let gap: f64 = r[9].parse().unwrap();
            let basis: Basis = match b {
                "hausdorff4" => Basis::power(4),
                "trig4" => Basis::trigonometric(2),
                b if b.contains(';') => b.replace(';', ",").parse().unwrap(),
                _ => continue,
            };
            let z = DepthDistribution::new(&d, &w).unwrap();
            let s = match mk {
                0 => LinearProgram::new(&basis),
                1 => LinearProgram::with_solver(&basis, LpSolver::Clarabel),
                _ => LinearProgram::with_solver(&basis, LpSolver::Microlp),
            }
            .unwrap();
            let t = Instant::now();
            let out = s.bounds_of(&z, z_f);
            time += t.elapsed().as_secs_f64();
            n += 1;
            match out {
                Ok(o) => {
                    let err = (o.lower - lower).abs().max((o.upper - upper).abs());
                    worst = worst.max(err);
                    if err > gap + 1e-8 {
                        bad += 1;
                    }
                }
                Err(e) => {
                    rej += 1;
                    if mk == 0 {
                        println!("{} {b} {} {e}", &r[0], &r[11])
                    }
                }
            }
        }
        println!("{what}: {n} rows, {bad} wrong, {rej} rejected, worst {worst:e}, {time} s");
    }
}
