use moment_problem::arithmetic::*;
use moment_problem::*;
fn main() {
    let cases: Vec<(Vec<f64>, Vec<f64>, f64)> = std::env::args()
        .skip(1)
        .collect::<Vec<_>>()
        .chunks(3)
        .map(|c| {
            (
                serde_json::from_str(&c[0]).unwrap(),
                serde_json::from_str(&c[1]).unwrap(),
                c[2].parse().unwrap(),
            )
        })
        .collect();
    for (d, w, zf) in cases {
        let z = DepthDistribution::new(&d, &w).unwrap();
        let b = Basis::trigonometric(2);
        let m: Vec<DoubleDouble> = z.moments(&b);
        println!("dd {:?}", trigonometric::trigonometric4(&[m[0], m[1], m[2], m[3]], DoubleDouble::from(zf)));
        let m: Vec<f64> = z.moments(&b);
        println!(
            "f64 {:?} F {} {}",
            trigonometric::trigonometric4(&[m[0], m[1], m[2], m[3]], zf),
            z.cdf(zf),
            z.cdf_inclusive(zf)
        );
        println!("{:?}", ExchangeSimplex::new(&b).unwrap().bounds_of(&z, zf));
    }
}
