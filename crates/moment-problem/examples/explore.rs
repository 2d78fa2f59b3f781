use moment_problem::*;
use std::time::Instant;
fn main() {
    let mut reader = csv::Reader::from_path("/work/shared/vectors/bounds.csv").unwrap();
    let mut worst: std::collections::BTreeMap<String, (f64, f64, f64, usize, usize)> = Default::default();
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
            "hamburger4" => Basis::power(4),
            "hamburger6" => Basis::power(6),
            "hamburger8" => Basis::power(8),
            _ => continue,
        };
        let t = Instant::now();
        let s = closed_form(&basis, if b.starts_with("hamb") { Interval::Real } else { Interval::Unit })
            .unwrap()
            .unwrap();
        let t_prep = t.elapsed().as_secs_f64();
        let z = DepthDistribution::new(&d, &w).unwrap();
        let t = Instant::now();
        let out = s.bounds_of(&z, z_f);
        let t = t.elapsed().as_secs_f64();
        let key = if b.contains(';') { "gen".to_string() } else { b.to_string() };
        let e = worst.entry(key).or_default();
        e.3 += 1;
        match out.clone() {
            Ok(o) => {
                let err = (o.lower - lower).abs().max((o.upper - upper).abs());
                e.0 = e.0.max(err);
                e.1 += t;
                e.2 = e.2.max(o.gap());
                if err > gap + 1e-8 {
                    e.4 += 1;
                    println!(
                        "{} {b} err {:e} {:e} gap {gap:e} sens {} mygap {:e}",
                        &r[0],
                        o.lower - lower,
                        o.upper - upper,
                        &r[11],
                        o.gap()
                    );
                }
                if t > 0.04 {
                    println!(
                        "{} slow {t} prep {t_prep} {:?}",
                        &r[0],
                        out.as_ref().map(|o| o.certificate.clone())
                    );
                }
            }
            Err(x) => {
                e.4 += 1;
                println!("{} {b} {x} after {t} s", &r[0]);
            }
        }
    }
    println!("{worst:#?}");
}
