use candle_core::{Device, Tensor};
use candle_nn::Optimizer;
use rand::{RngExt, SeedableRng};
use training::network::*;
fn main() {
    let mut r = rand_pcg::Pcg64Mcg::seed_from_u64(1);
    let net = Network::new(Architecture::default(), 8, &mut r).unwrap();
    println!("{} params", net.parameter_count());
    let mut opt = candle_nn::AdamW::new_lr(net.variables(), 1e-3).unwrap();
    let n: usize = std::env::args().nth(1).map_or(128, |s| s.parse().unwrap());
    let b = 64;
    let x: Vec<f32> = (0..b * n * 3).map(|_| r.random()).collect();
    let x = Tensor::from_vec(x, (b, n, 3), &Device::Cpu).unwrap();
    let y: Vec<u32> = (0..b).map(|i| i as u32 % 8).collect();
    let y = Tensor::from_vec(y, b, &Device::Cpu).unwrap();
    for _ in 0..3 {
        let t = std::time::Instant::now();
        let k = 20;
        for _ in 0..k {
            let l = candle_nn::loss::nll(&net.forward(&x).unwrap(), &y).unwrap();
            opt.backward_step(&l).unwrap();
        }
        let s = t.elapsed().as_secs_f64() / k as f64;
        let t = std::time::Instant::now();
        for _ in 0..k {
            net.forward(&x).unwrap();
        }
        let f = t.elapsed().as_secs_f64() / k as f64;
        println!(
            "step {:.2} ms, forward {:.2} ms; epoch of 12000: {:.1} s",
            s * 1e3,
            f * 1e3,
            s * 12000.0 / b as f64
        );
    }
}
