//! Candidate search.
#![allow(dead_code)]
mod candidates;
mod judge;
mod settings;
mod statistics;
mod workload;

#[cfg(test)]
mod harness {
    use super::*;
    use moment_problem::fast_simplex::*;
    use std::time::Instant;
    fn cpu() -> f64 { std::fs::read_to_string("/proc/thread-self/schedstat").unwrap().split(' ').next().unwrap().parse::<f64>().unwrap()*1e-9 }
    #[test]
    #[ignore]
    fn speed() {
        let text = std::fs::read_to_string("/tmp/search.toml").unwrap();
        let e: settings::SearchExperiment = toml::from_str(&text).unwrap();
        e.check().unwrap();
        let t = Instant::now();
        let w = workload::Workload::prepare(&e).unwrap();
        println!("prepare {:?}", t.elapsed());
        for v in &w.views { println!("{} {} all {} sampled {} active {}", v.scene, v.view, v.fragments, v.sampled, v.active); }
        for b in &w.blocks { println!("block kernels {} fragments {} nnz {:.1}", b.kernels.len(), b.fragments.len(),
          b.kernels.iter().map(|k| k.indices().len()).sum::<usize>() as f64 / b.kernels.len() as f64); }
        let family = e.functions().unwrap();
        for order in [4usize] {
        let subsets = candidates::Subsets::new(family.len(), order);
        for (bn, block) in w.blocks.iter().enumerate() {
            let control_f = &w.powers[..order];
            let cc = SupportColumns::new(&w.table, control_f).unwrap(); let t0=cpu(); let sol = FastSimplex::new(&cc, 1e-6).thorough().solve(&block.kernels, &block.fragments); println!("control {:.3} M/s", sol.bounds.len() as f64/(cpu()-t0)/1e6); let csol = sol.clone();
            let control = judge::errors(block, &sol);
            let mut total = 0usize; let mut secs = 0.0; let mut exact = 0; let mut unc = 0; let mut piv = 0; let mut setup=0.0;
            let n = subsets.len();
            let tr = [29usize,30,33,34];
            let mut list: Vec<Vec<usize>> = (0..12).map(|i| subsets.subset((2*i+1)*n/24)).collect();
            list.push(control_f.to_vec()); list.push(tr.to_vec());
            for s in list {
                let t = Instant::now();
                let c = SupportColumns::new(&w.table, &s).unwrap();
                setup += t.elapsed().as_secs_f64();
                let t = cpu();
                let mut sol = FastSimplex::new(&c, 1e-6).solve_near(&block.kernels, &block.fragments, &csol);
                for _ in 0..2 { sol = FastSimplex::new(&c, 1e-6).solve_near(&block.kernels, &block.fragments, &csol); }
                let dt = (cpu() - t)/3.0;
                let v = judge::judge(&w, block, &sol, &control);
                secs += dt; total += sol.bounds.len(); exact += sol.exact; unc += sol.uncertified.len(); piv += sol.pivots;
                let sp = FastSimplex::new(&c, 1e-6).portable();
                let _ = sp;
                println!("{s:?} {:.3} M/s piv/lp {:.2} vert {} exact {} err {:.5} d {:.5} +- {:.6} unc {}", sol.bounds.len() as f64/dt/1e6, sol.pivots as f64/sol.bounds.len() as f64, sol.vertices.len(), sol.exact, v.error, v.difference.value, v.difference.variance.sqrt(), sol.exact);
            }
            println!("order {order} block {bn}: {:.3} M/s, setup {:.2} ms, exact {exact} unc {unc} piv {piv}", total as f64/secs/1e6, setup/14.0*1e3);
        }
        }
        for m in &w.marks {
          let all: Vec<usize> = w.views.iter().map(|v| v.fragments).collect();
          println!("{} exact {:?} moved {:?} diff {:?}", m.name, statistics::stratified(&m.exact,&all), statistics::stratified(&m.moved,&all), statistics::stratified(&m.difference,&all));
        }
    }
}
