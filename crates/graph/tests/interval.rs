//! Ranges of expressions: that they hold whatever the expressions give.

use csg_graph::{Binary, Expr, Function, GraphBuilder, Interval, ParamId, Unary};
use proptest::prelude::*;

const PARAMS: usize = 4;

/// Numbers where functions turn, jump or have no value, and some others.
fn numbers() -> impl Strategy<Value = f64> {
    let special =
        vec![0.0, 1.0, -1.0, 0.5, 2.0, 3.0, 8.0, 45.0, 90.0, 180.0, -90.0, 360.0, 1e-300, 1e17, -1e17, 1e308];
    prop_oneof![2 => prop::sample::select(special), 2 => -4.0..4.0, 1 => -1000.0..1000.0]
}

fn expressions() -> impl Strategy<Value = Expr> {
    let leaf = prop_oneof![
        1 => numbers().prop_map(Expr::from),
        2 => (0..PARAMS).prop_map(|index| Expr::from(ParamId::from_index(index))),
    ];
    leaf.prop_recursive(5, 40, 3, |below| {
        let operators = vec![
            Binary::Add,
            Binary::Subtract,
            Binary::Multiply,
            Binary::Divide,
            Binary::Remainder,
            Binary::Power,
            Binary::Less,
            Binary::LessEqual,
            Binary::Greater,
            Binary::GreaterEqual,
            Binary::Equal,
            Binary::NotEqual,
            Binary::And,
            Binary::Or,
        ];
        let unary = prop::sample::select(vec![Unary::Negate, Unary::Not]);
        let args = || prop::collection::vec(below.clone(), 3);
        prop_oneof![
            1 => (unary, below.clone()).prop_map(|(operator, a)| Expr::unary(operator, a)),
            4 => (prop::sample::select(operators), below.clone(), below.clone())
                .prop_map(|(operator, a, b)| Expr::binary(operator, a, b)),
            5 => (prop::sample::select(Function::ALL), 0..9_u32, args()).prop_map(|(function, site, args)| {
                let count = (*function.arity().start()).max(if *function.arity().end() > 3 { 3 } else { 0 });
                let args = args.into_iter().take(count);
                if function.is_random() {
                    Expr::draw(function, ParamId::from_index(0), site, args)
                } else {
                    Expr::call(function, args)
                }
            }),
        ]
    })
}

/// An interval, and shares of its length at which to look into it.
fn intervals() -> impl Strategy<Value = (Interval, [f64; 6])> {
    let narrow = (numbers(), 0.0..1e-9).prop_map(|(min, length)| (min, min + length));
    let wide = (numbers(), numbers()).prop_map(|(a, b)| (a.min(b), a.max(b)));
    let point = numbers().prop_map(|value| (value, value));
    let ends = prop_oneof![1 => point, 1 => narrow, 3 => wide];
    (ends, prop::array::uniform6(0.0..=1.0)).prop_map(|((min, max), mut shares)| {
        (shares[0], shares[1]) = (0.0, 1.0);
        (Interval::new(min, max), shares)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn ranges_hold_values(
        expr in expressions(),
        intervals in prop::array::uniform4(intervals()),
        looks in prop::collection::vec(prop::array::uniform4(0..8_usize), 24),
    ) {
        let mut builder = GraphBuilder::new();
        let params: Vec<ParamId> = (0..PARAMS).map(|index| builder.param(&format!("p{index}"), 0.0)).collect();
        let mut env = builder.initial().clone();
        let range = expr.range(&intervals.map(|(interval, _)| interval));
        for look in looks {
            for ((param, (interval, shares)), share) in params.iter().zip(&intervals).zip(look) {
                let inside = |share: f64| {
                    (interval.min + share * (interval.max - interval.min)).clamp(interval.min, interval.max)
                };
                // Integers are where much happens.
                let value = match shares.get(share) {
                    Some(share) => inside(*share),
                    None => inside(0.5).round().clamp(interval.min, interval.max),
                };
                env.set(*param, value);
            }
            let value = expr.evaluate(&env);
            prop_assert!(value.is_nan() || range.contains(value), "{value} is not in {range:?}");
        }
    }

    /// Whatever is known beforehand.
    #[test]
    fn residuals_have_the_same_ranges(
        expr in expressions(),
        intervals in prop::array::uniform4(intervals()),
        given in prop::array::uniform4(any::<bool>()),
    ) {
        let intervals = intervals.map(|(interval, _)| interval);
        let places: Vec<usize> = (0..PARAMS).filter(|index| given[*index]).collect();
        let known: Vec<Interval> =
            (0..PARAMS).map(|index| if given[index] { Interval::EMPTY } else { intervals[index] }).collect();
        let residual = expr.residual(&known, |param| places.iter().position(|index| *index == param.index()));
        let given: Vec<Interval> = places.iter().map(|index| intervals[*index]).collect();
        prop_assert_eq!(residual.range(&given), expr.range(&intervals));
    }

    #[test]
    fn points_stay_points(expr in expressions(), values in prop::array::uniform4(numbers())) {
        let mut builder = GraphBuilder::new();
        for (index, value) in values.iter().enumerate() {
            builder.param(&format!("p{index}"), *value);
        }
        let value = expr.evaluate(builder.initial());
        let range = expr.range(&values.map(Interval::point));
        prop_assert_eq!(range, Interval::point(value));
    }
}

/// Ranges of the language's functions that nobody would want larger.
#[test]
fn ranges_are_tight() {
    let x = || Expr::from(ParamId::from_index(0));
    let unary = |function| Expr::call(function, [x()]);
    let about = |expr: Expr, min: f64, max: f64, low: f64, high: f64| {
        let found = expr.range(&[Interval::new(min, max)]);
        let expected = Interval::new(low - 1e-12, high + 1e-12);
        assert!(
            expected.encloses(found) && found.contains(low) && found.contains(high),
            "{expr:?} {found:?}"
        );
    };
    about(unary(Function::Sin), 30.0, 60.0, 0.5, 0.75_f64.sqrt());
    about(unary(Function::Sin), 30.0, 120.0, 0.5, 1.0);
    about(unary(Function::Cos), -60.0, 60.0, 0.5, 1.0);
    about(unary(Function::Cos), 100.0, 1000.0, -1.0, 1.0);
    about(unary(Function::Sqrt), -4.0, 4.0, 0.0, 2.0);
    about(unary(Function::Abs), -3.0, 2.0, 0.0, 3.0);
    about(x() % 8.0, 9.0, 11.0, 1.0, 3.0);
    about(x() % 8.0, 7.0, 9.0, 0.0, 8.0);
    about(x() * x(), 1.0, 3.0, 1.0, 9.0);
    about(Expr::binary(Binary::Power, x(), 2.0), -3.0, 1.0, 0.0, 9.0);
    about(Expr::binary(Binary::Power, x(), 3.0), -3.0, 1.0, -27.0, 1.0);
    about(Expr::call(Function::Atan2, [x(), 1.0.into()]), -1.0, 1.0, -45.0, 45.0);
    about(Expr::call(Function::Mix, [10.0.into(), 20.0.into(), x()]), 0.0, 1.0, 10.0, 20.0);
    let draw = |function, args: [Expr; 2]| Expr::draw(function, x(), 1, args);
    about(draw(Function::Rand, [3.0.into(), (-1.0).into()]), 0.0, 1.0, -1.0, 3.0);
    about(draw(Function::Pick, [0.0.into(), 2.0.into()]), 0.0, 1.0, 2.0, 2.0);
    let undecided = Expr::choose(x().gt(0.0), 2.0, Expr::choose(x().gt(-9.0), 1.0, 7.0));
    about(undecided, -3.0, 3.0, 1.0, 2.0);
}

#[test]
fn what_has_no_value_has_no_range() {
    let x = Expr::from(ParamId::from_index(0));
    let root = Expr::call(Function::Sqrt, [x.clone()]);
    assert!(root.range(&[Interval::new(-2.0, -1.0)]).is_empty());
    assert!((root.clone() + 1.0).range(&[Interval::new(-2.0, -1.0)]).is_empty());
    let guarded = Expr::choose(x.clone().gt(0.0), root.clone(), 7.0);
    assert_eq!(guarded.range(&[Interval::new(-2.0, -1.0)]), Interval::point(7.0));
    let either = Expr::binary(Binary::Or, x, root);
    assert_eq!(either.range(&[Interval::new(-2.0, -1.0)]), Interval::point(1.0));
}

#[test]
fn seeds_do_not_matter_to_ranges() {
    let mut builder = GraphBuilder::new();
    let [seed, x, y] = ["seed", "x", "y"].map(|name| builder.param(name, 0.0));
    let hash = Expr::call(Function::Hash, [x.into(), y.into()]);
    let draw = Expr::draw(Function::Rand, seed, 1, [Expr::from(y), hash.clone() * 2.0 + x]);
    assert_eq!(draw.range_params(), [x, y]);
    assert!(draw.is_erratic() && hash.is_erratic() && !(Expr::from(x) + y).is_erratic());
    assert!(Expr::derive(seed, 1).range_params().is_empty());
}
