use moment_problem::*;
fn main() {
    let z = DepthDistribution::new(&[0.0, 1.0], &[0.8431032519630781, 0.15689674803692188]).unwrap();
    let b = Basis::trigonometric(2);
    println!("{:?}", ExchangeSimplex::new(&b).unwrap().bounds_of(&z, 0.0));
    println!("{:?}", Trigonometric4::new().unwrap().bounds_of(&z, 0.0));
}
