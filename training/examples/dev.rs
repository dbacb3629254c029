//! dev
use rand::SeedableRng;
use std::time::Instant;
use training::{dataset::*, metrics::*, network::*, samples, setup::*, trainer::*};
fn main() -> anyhow::Result<()> {
    let args: Vec<String> = std::env::args().collect();
    match args[1].as_str() {
        "raw" => {
            use rand::RngExt;
            use rayon::prelude::*;
            use std::io::Write;
            let per: usize = args[2].parse()?;
            let seed: u64 = args[3].parse()?;
            let p = ScanParameters::default();
            let p = if std::env::var("NOMINAL").is_ok() {
                ScanParameters {
                    mount_error_rad: 0.003,
                    mount_error_m: 0.001,
                    wrist_lean_rad: 0.01,
                    elevation_rad: [0.2, 0.3],
                    distance_m: [0.39, 0.42],
                    table_share: 0.0,
                    ..p
                }
            } else {
                p
            };
            let mut r = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
            let jobs: Vec<(usize, u64)> = (0..8)
                .flat_map(|l| (0..per).map(move |_| l))
                .map(|l| (l, r.random()))
                .collect();
            let f =
                std::sync::Mutex::new(std::io::BufWriter::new(std::fs::File::create(&args[4])?));
            let t = Instant::now();
            jobs.par_iter().enumerate().for_each(|(j, &(l, seed))| {
                let os = training::scan::scan_specimen(sim_objects::ObjectClass::ALL[l], &p, seed)
                    .unwrap();
                let mut b: Vec<u8> = vec![];
                for o in os {
                    b.extend((j as u32).to_le_bytes());
                    b.extend((l as u32).to_le_bytes());
                    b.extend((o.view_count as u32).to_le_bytes());
                    let flag: u32 = if o.up.z > 0.5 { 0 } else { 1 };
                    b.extend(flag.to_le_bytes());
                    b.extend((o.points.len() as u32).to_le_bytes());
                    for q in &o.points {
                        for a in 0..3 {
                            b.extend(q[a].to_le_bytes());
                        }
                    }
                }
                f.lock().unwrap().write_all(&b).unwrap();
            });
            println!("{:.1} s", t.elapsed().as_secs_f64());
        }
        "prep" => {
            use nalgebra::{Point3, Vector3};
            use rayon::prelude::*;
            let n: usize = args[4].parse()?;
            let c = args[5].parse().unwrap();
            let vox: f32 = args[6].parse()?;
            let meta = preprocessing(n, c);
            let load = |path: &str| -> anyhow::Result<samples::Samples> {
                let b = std::fs::read(path)?;
                let u = |k: usize| u32::from_le_bytes(b[k..k + 4].try_into().unwrap());
                let mut k = 0;
                let mut items = vec![];
                while k < b.len() {
                    let m = u(k + 16) as usize;
                    items.push((u(k), k));
                    k += 20 + 12 * m;
                }
                items.sort();
                let parts: Vec<_> = items
                    .par_iter()
                    .map(|&(_, k)| {
                        let m = u(k + 16) as usize;
                        let pts: Vec<Point3<f32>> = (0..m)
                            .map(|i| {
                                Point3::from(
                                    [0, 1, 2].map(|a| f32::from_bits(u(k + 20 + 12 * i + 4 * a))),
                                )
                            })
                            .collect();
                        let up = if u(k + 12) == 0 {
                            Vector3::z()
                        } else {
                            -Vector3::y()
                        };
                        let pts = if vox > 0.0 {
                            cloud::voxel::downsample(&pts, vox).unwrap()
                        } else {
                            pts
                        };
                        classifier::preprocess(&pts, &up, &meta)
                            .ok()
                            .map(|i| (i, u(k + 4), u(k + 8) + 10 * u(k + 12)))
                    })
                    .collect();
                let mut s = samples::Samples::new(n);
                let miss = parts.iter().filter(|p| p.is_none()).count();
                for (i, l, v) in parts.into_iter().flatten() {
                    s.push_input(&i, 0.1, l, v);
                }
                println!("{} clouds, {miss} too small", s.len());
                Ok(s)
            };
            samples::write_npz(
                std::path::Path::new(&args[7]),
                &load(&args[2])?,
                &load(&args[3])?,
            )?;
        }
        "make" => {
            let (n, c, per): (usize, _, usize) =
                (args[2].parse()?, args[3].parse().unwrap(), args[4].parse()?);
            let meta = preprocessing(n, c);
            let p = ScanParameters::default();
            let t = Instant::now();
            let train = simulate(per, &p, &meta, 1, || ())?;
            println!(
                "{} clouds in {:.1} s",
                train.len(),
                t.elapsed().as_secs_f64()
            );
            let val = simulate(per / 6 + 1, &p, &meta, 2, || ())?;
            samples::write_npz(std::path::Path::new(&args[5]), &train, &val)?;
        }
        "train" => {
            let (train_s, val) = samples::read_npz(std::path::Path::new(&args[2]))?;
            let keep = |s: samples::Samples| {
                if std::env::var("BALLS").is_err() {
                    return s;
                }
                let mut o = samples::Samples::new(s.point_count);
                for i in 0..s.len() {
                    if (5..7).contains(&s.labels[i]) && s.view_counts[i] < 10 {
                        o.points.extend(s.cloud(i));
                        o.labels.push(s.labels[i]);
                        o.view_counts.push(s.view_counts[i]);
                    }
                }
                o
            };
            let (train_s, val) = (keep(train_s), keep(val));
            let mut r = rand_pcg::Pcg64Mcg::seed_from_u64(7);
            let net = Network::new(Architecture::default(), 8, &mut r)?;
            let p = TrainingParameters {
                epochs: args[3].parse()?,
                ..Default::default()
            };
            let t = Instant::now();
            train(&net, [&train_s, &val], 0.1, &p, &mut r, |e| {
                if let Event::Epoch(e) = e {
                    println!("{:5.0}s {e:?}", t.elapsed().as_secs_f64());
                }
                Ok(())
            })?;
            let labels = preprocessing(1, classifier::Centring::Box).labels;
            for views in [0, 1, 2, 3, 4, 11, 12, 13, 14] {
                let mut c = Confusion::new(&labels);
                for ((a, &l), &v) in log_probabilities(&net, &val, 0.1)?
                    .iter()
                    .zip(&val.labels)
                    .zip(&val.view_counts)
                {
                    if views == 0 || v == views {
                        c.add(l as usize, most_probable(a));
                    }
                }
                println!(
                    "views {views}: {:.4}\n{}",
                    c.accuracy(),
                    if views == 0 || views == 3 {
                        c.table()
                    } else {
                        String::new()
                    }
                );
            }
            let meta = preprocessing(val.point_count, args[4].parse().unwrap());
            if std::env::var("LIFT").is_err() {
                training::export::write_model(std::path::Path::new(&args[5]), &net, &meta)?;
            }
        }
        _ => {}
    }
    Ok(())
}
