//! Random numbers: that pictures stay what they were, that the numbers pass for random ones, and their ranges.
#![expect(clippy::float_cmp, reason = "the same bits on every machine is the promise")]

use csg_graph::{Expr, Function, GraphBuilder, NORMAL_REACH};

fn value(expr: Expr) -> f64 {
    expr.evaluate(GraphBuilder::new().initial())
}

fn call(function: Function, args: &[f64]) -> f64 {
    value(Expr::call(function, args.iter().map(|arg| Expr::from(*arg))))
}

fn draw(function: Function, seed: f64, site: u32, args: &[f64]) -> f64 {
    value(Expr::draw(function, seed, site, args.iter().map(|arg| Expr::from(*arg))))
}

fn uniform(seed: f64, site: u32) -> f64 {
    draw(Function::Rand, seed, site, &[0.0, 1.0])
}

fn derive(seed: f64, position: u32) -> f64 {
    value(Expr::derive(seed, position))
}

/// A change of any of these numbers changes every random picture.
#[test]
fn test_vectors() {
    assert_eq!(derive(0.0, 1), 2_166_493_706_568_706.0);
    assert_eq!(derive(0.0, 2), 5_532_521_037_753_784.0);
    assert_eq!(derive(9_007_199_254_740_991.0, 1), 8_941_052_891_096_373.0);
    assert_eq!(derive(0.5, 1), 1_465_929_994_022_371.0);
    assert_eq!(uniform(0.0, 4), 0.35006872440232395);
    assert_eq!(draw(Function::Rand, 7.0, 4, &[-3.0, 5.0]), -2.4257684998290747);
    assert_eq!(draw(Function::Normal, 7.0, 4, &[10.0, 2.0]), 13.068569135262294);
    assert_eq!(draw(Function::Pick, 7.0, 4, &[3.0, 1.0, 4.0]), 1.0);
    assert_eq!(call(Function::Hash, &[0.0]), 0.9302874638535357);
    assert_eq!(call(Function::Hash, &[1.0, -2.0, 0.5]), 0.7182376665362459);
    assert_eq!(call(Function::Noise, &[0.3, -1.6, 7.25]), 0.10915216348176393);
    assert_eq!(call(Function::Noise, &[-1e9 + 0.5, 0.25, 1e12 + 0.75]), 0.1244110658057451);
}

/// Moments, and the frequencies of 64 equal parts (63 degrees of freedom: 99.99 % are below 112).
fn assert_uniform(what: &str, numbers: impl Iterator<Item = f64>) {
    let mut bins = [0_u32; 64];
    let (mut count, mut sum, mut squares) = (0_u32, 0.0, 0.0);
    for number in numbers {
        assert!((0.0..1.0).contains(&number), "{what}: {number}");
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in [0, 64)")]
        let bin = (number * 64.0) as usize;
        bins[bin] += 1;
        count += 1;
        sum += number;
        squares += number * number;
    }
    let n = f64::from(count);
    let (mean, mean_square) = (sum / n, squares / n);
    // Four standard errors.
    assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12.0 / n).sqrt(), "{what}: mean {mean}");
    assert!((mean_square - 1.0 / 3.0).abs() < 4.0 * (4.0 / 45.0 / n).sqrt(), "{what}: square {mean_square}");
    let expected = n / 64.0;
    let chi_square: f64 = bins.iter().map(|bin| libm::pow(f64::from(*bin) - expected, 2.0) / expected).sum();
    assert!(chi_square < 112.0, "{what}: chi-square {chi_square}");
}

/// That pairs are not correlated: their correlation is within four standard errors of 0.
fn assert_unrelated(what: &str, pairs: impl Iterator<Item = (f64, f64)>) {
    let (mut count, mut product) = (0_u32, 0.0);
    for (a, b) in pairs {
        count += 1;
        product += (a - 0.5) * (b - 0.5);
    }
    let n = f64::from(count);
    let correlation = 12.0 * product / n;
    assert!(correlation.abs() < 4.0 / n.sqrt(), "{what}: {correlation}");
}

const COUNT: u32 = 40_000;

fn integers() -> impl Iterator<Item = f64> {
    (0..COUNT).map(f64::from)
}

#[test]
fn numbers_are_uniform() {
    assert_uniform("consecutive seeds", integers().map(|seed| uniform(seed, 4)));
    assert_uniform("large seeds", integers().map(|seed| uniform(9_007_199_254_740_991.0 - seed, 4)));
    assert_uniform("seeds that are fractions", integers().map(|seed| uniform(seed / 1024.0, 4)));
    assert_uniform("sites", (0..COUNT).map(|site| uniform(0.0, site)));
    assert_uniform("positions", (0..COUNT).map(|position| uniform(derive(0.0, position), 4)));
    assert_uniform("hash", integers().map(|x| call(Function::Hash, &[x])));
    assert_uniform(
        "hash of a plane",
        integers().map(|i| call(Function::Hash, &[i % 200.0, (i / 200.0).floor()])),
    );
    let chain = std::iter::successors(Some(0.0), |seed| Some(derive(*seed, 1)));
    assert_uniform("a chain of references", chain.take(COUNT as usize).map(|seed| uniform(seed, 4)));
}

#[test]
fn numbers_are_unrelated() {
    assert_unrelated("seeds", integers().map(|seed| (uniform(seed, 4), uniform(seed + 1.0, 4))));
    assert_unrelated("sites", integers().map(|seed| (uniform(seed, 4), uniform(seed, 8))));
    assert_unrelated("streams", integers().map(|seed| (uniform(seed, 4), uniform(seed, 5))));
    assert_unrelated(
        "siblings",
        integers().map(|seed| (uniform(derive(seed, 1), 4), uniform(derive(seed, 2), 4))),
    );
    assert_unrelated(
        "parent and child",
        integers().map(|seed| (uniform(seed, 4), uniform(derive(seed, 1), 4))),
    );
    assert_unrelated(
        "draws and hashes",
        integers().map(|seed| (uniform(seed, 4), call(Function::Hash, &[seed, 4.0]))),
    );
    assert_unrelated(
        "neighbours in a plane",
        integers().map(|i| {
            let (x, y) = (i % 200.0, (i / 200.0).floor());
            (call(Function::Hash, &[x, y]), call(Function::Hash, &[y, x + 1.0]))
        }),
    );
}

/// A change of one bit of a seed changes each bit of what is derived from it half of the time.
#[test]
fn every_bit_counts() {
    const SEEDS: u64 = 400;
    for bit in [0, 1, 20, 31, 32, 51, 52] {
        let mut flips = [0_u32; 53];
        for seed in 0..SEEDS {
            let bits = |seed: u64| {
                #[expect(clippy::cast_precision_loss, reason = "below 2^53")]
                let derived = derive(seed as f64, 1);
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 2^53")]
                let bits = derived as u64;
                bits
            };
            let changed = bits(seed * 7) ^ bits((seed * 7) ^ (1 << bit));
            (0..53).for_each(|at| flips[at] += u32::from(changed >> at & 1 != 0));
        }
        // Five standard errors of 400 throws.
        assert!(flips.iter().all(|count| (150..=250).contains(count)), "bit {bit}: {flips:?}");
    }
}

#[test]
fn seeds_do_not_collide() {
    // The references of a tree with three branches, eleven levels deep: 265,720 seeds.
    let mut level = vec![0.0];
    let mut all = Vec::new();
    for _ in 0..=11 {
        all.extend(level.iter().map(|seed: &f64| seed.to_bits()));
        level = level.iter().flat_map(|seed| [1, 2, 3].map(|position| derive(*seed, position))).collect();
    }
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count);
    assert!(level.iter().all(|seed| seed.fract() == 0.0 && (0.0..9_007_199_254_740_992.0).contains(seed)));
}

#[test]
fn rand_stays_in_its_interval() {
    let tight = [1.0, 1.0 + f64::EPSILON];
    for seed in 0..1000 {
        let rand = |low, high| draw(Function::Rand, f64::from(seed), 4, &[low, high]);
        assert_eq!(rand(tight[0], tight[1]), tight[0], "rounded to the end that does not belong");
        assert_eq!(rand(tight[1], tight[0]), tight[1], "the other way round");
        assert!((-3.0..5.0).contains(&rand(-3.0, 5.0)));
        assert_eq!(rand(2.5, 2.5), 2.5);
    }
    assert!(draw(Function::Rand, 0.0, 4, &[-f64::MAX, f64::MAX]).is_nan());
    assert_eq!(uniform(-0.0, 4), uniform(0.0, 4), "both zeros are one seed");
}

#[test]
fn normal_has_its_moments_and_its_reach() {
    let numbers: Vec<f64> = integers().map(|seed| draw(Function::Normal, seed, 4, &[0.0, 1.0])).collect();
    let n = f64::from(COUNT);
    let moment = |power: f64| numbers.iter().map(|x| libm::pow(*x, power)).sum::<f64>() / n;
    // Four standard errors; the variances of the powers are 1, 2, 15 and 96.
    for (power, expected, variance) in
        [(1.0, 0.0, 1.0), (2.0, 1.0, 2.0), (3.0, 0.0, 15.0), (4.0, 3.0, 96.0_f64)]
    {
        let off = moment(power) - expected;
        assert!(off.abs() < 4.0 * (variance / n).sqrt(), "moment {power} is off by {off}");
    }
    let within = numbers.iter().filter(|x| x.abs() < 1.0).count();
    assert!((27_000..27_620).contains(&within), "{within} within one deviation");
    let farthest = (-2.0 * libm::log(f64::EPSILON / 2.0)).sqrt();
    assert!(farthest <= NORMAL_REACH && NORMAL_REACH < farthest + 0.01);
    assert_eq!(draw(Function::Normal, 3.0, 4, &[2.0, 0.0]), 2.0);
}

#[test]
fn pick_keeps_to_its_weights() {
    let mut counts = [0_u32; 4];
    for seed in integers() {
        let picked = draw(Function::Pick, seed, 4, &[3.0, 0.0, 1.0, 4.0]);
        let index = [1.0, 2.0, 3.0, 4.0].iter().position(|number| *number == picked).expect("a rule");
        counts[index] += 1;
    }
    assert_eq!(counts[1], 0, "a weight of 0 is never picked");
    // Expected are 15,000, 5,000 and 20,000, with standard errors of at most 100.
    assert!((14_600..15_400).contains(&counts[0]) && (4_700..5_300).contains(&counts[2]), "{counts:?}");
    for weights in [&[0.0, 0.0][..], &[1.0, -1.0], &[-1.0, 3.0], &[f64::INFINITY, 1.0]] {
        assert!(draw(Function::Pick, 1.0, 4, weights).is_nan(), "{weights:?}");
    }
    assert_eq!(draw(Function::Pick, 1.0, 4, &[0.5]), 1.0);
}

#[test]
fn noise_is_smooth_and_bounded() {
    let noise = |x: f64, y: f64, z: f64| call(Function::Noise, &[x, y, z]);
    let (mut least, mut most, mut squares) = (0.0_f64, 0.0_f64, 0.0);
    for i in integers() {
        let at = |site| (uniform(i, site) - 0.5) * 2000.0;
        let [x, y, z] = [at(1), at(2), at(3)];
        let here = noise(x, y, z);
        (least, most, squares) = (least.min(here), most.max(here), squares + here * here);
        // The steepest slope of gradient noise is below 6.
        assert!((noise(x + 1e-6, y, z) - here).abs() < 6e-6 && (noise(x, y, z - 1e-6) - here).abs() < 6e-6);
        assert_eq!(noise(x.floor(), y.floor(), z.floor()), 0.0, "a lattice point");
    }
    assert!((-1.0..-0.75).contains(&least) && (0.75..=1.0).contains(&most), "{least} to {most}");
    assert!((0.05..0.1).contains(&(squares / f64::from(COUNT))), "{}", squares / f64::from(COUNT));
    // Across the sides of a cell, also where coordinates are negative and large.
    for side in [-3.0, 0.0, 7.0, -1e9, 1e12] {
        let step = 1e-3;
        let (before, after) = (noise(side - step, 0.4, 0.6), noise(side + step, 0.4, 0.6));
        assert!((before - after).abs() < 12.0 * step, "{side}: {before} and {after}");
    }
    assert_eq!(noise(1e300, 2.0, -1e18), 0.0);
    assert!(noise(1e300, 0.5, -0.5).abs() <= 1.0);
    assert!(noise(f64::INFINITY, 0.0, 0.0).is_nan());
}

#[test]
fn what_is_hidden_is_not_printed() {
    let mut builder = GraphBuilder::new();
    let (seed, n) = (builder.param("seed", 0.0), builder.param("n", 3.0));
    let text = |expr: Expr| expr.to_text(|param| if param == seed { "seed" } else { "n" });
    let width = Expr::draw(Function::Rand, seed, 12, [0.5.into(), Expr::from(n) / 2.0]);
    assert_eq!(text(width.clone() + 1.0), "rand(0.5, n / 2) + 1");
    assert_eq!(width.params().collect::<Vec<_>>(), [seed, n], "it is read all the same");
    assert_eq!(text(Expr::draw(Function::Pick, seed, 4, [3.0.into(), n.into()])), "pick(3, n)");
    assert_eq!(text(Expr::derive(seed, 2)), "derive(seed, 2)");
    assert_eq!(text(Expr::call(Function::Hash, [n.into(), 1.0.into(), 2.0.into()])), "hash(n, 1, 2)");
}

#[test]
fn arities() {
    let arity = |function: Function| function.arity().into_inner();
    assert_eq!(arity(Function::Abs), (1, 1));
    assert_eq!(arity(Function::If), (3, 3));
    assert_eq!(arity(Function::Rand), (2, 2));
    assert_eq!(arity(Function::Pick), (1, usize::MAX));
    assert_eq!(arity(Function::Hash), (1, usize::MAX));
}
