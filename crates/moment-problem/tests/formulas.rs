//! Formulas in every notation of their numbers: what is printed is read as the same function.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use moment_problem::{Basis, BasisFunction};
use proptest::prelude::*;

/// A formula with its value, which shares nothing with the parser.
#[derive(Clone, Debug)]
struct Formula {
    text: String,
    values: [f64; 3],
}

const DEPTHS: [f64; 3] = [0.0, 0.3, 1.0];

/// A number as people and programs write it.
fn number() -> impl Strategy<Value = Formula> {
    (-8i32..=-1, 1u32..1000, 0..6u8).prop_map(|(power, digits, notation)| {
        let value = f64::from(digits) * 10f64.powi(power);
        let text = match notation {
            0 => format!("{value}"),
            1 => format!("{value:e}"),
            2 => format!("{value:E}"),
            3 => format!("{digits}e{power}"),
            4 => format!("{digits}.0e{power:+}"),
            _ => format!("0.{digits:03}E{}", power + 3),
        };
        Formula { text, values: [value; 3] }
    })
}

fn leaf() -> impl Strategy<Value = Formula> {
    let variable = Formula { text: "z".to_owned(), values: DEPTHS };
    let euler = Formula { text: "e".to_owned(), values: [std::f64::consts::E; 3] };
    prop_oneof![3 => Just(variable), 1 => Just(euler), 4 => number()]
}

fn formula() -> impl Strategy<Value = Formula> {
    let apply = |text: String, f: &dyn Fn(usize) -> f64| Formula { text, values: [f(0), f(1), f(2)] };
    leaf().prop_recursive(4, 16, 2, move |inner| {
        (inner.clone(), inner, 0..8u8).prop_map(move |(a, b, kind)| {
            let (x, y) = (a.values, b.values);
            match kind {
                0 => apply(format!("({})+({})", a.text, b.text), &|i| x[i] + y[i]),
                1 => apply(format!("{} - ({})", a.text, b.text), &|i| x[i] - y[i]),
                2 => apply(format!("({})*({})", a.text, b.text), &|i| x[i] * y[i]),
                3 => apply(format!("({})({})", a.text, b.text), &|i| x[i] * y[i]),
                4 => apply(format!("({})/(1e1+sin({}))", a.text, b.text), &|i| x[i] / (10.0 + y[i].sin())),
                5 => apply(format!("sin({})", a.text), &|i| x[i].sin()),
                6 => apply(format!("exp(cos({}))", a.text), &|i| x[i].cos().exp()),
                _ => apply(format!("({})^2e0", a.text), &|i| x[i] * x[i]),
            }
        })
    })
}

proptest! {
    #[test]
    fn printed_formulas_are_read_as_the_same_function(formula in formula()) {
        // Constants, and what is longer than accepted, are refused.
        if let Ok(function) = formula.text.parse::<BasisFunction>() {
            for (z, expected) in DEPTHS.into_iter().zip(formula.values) {
                let value: f64 = function.evaluate(z);
                prop_assert!((value - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{} at {z}: {value} for {expected}", formula.text);
            }
            let again: BasisFunction = function.name().parse().unwrap();
            prop_assert_eq!(&again, &function);
            prop_assert_eq!(again.name(), function.name());
        }
    }

    #[test]
    fn a_factor_in_any_notation_is_that_number(factor in number()) {
        let text = format!("z, exp({} z)", factor.text.replace(' ', ""));
        let basis: Basis = text.parse().unwrap();
        let value: f64 = basis.functions()[1].evaluate(0.5f64);
        prop_assert!((value / (0.5 * factor.values[0]).exp() - 1.0).abs() < 1e-9, "{}", text);
        prop_assert_eq!(basis.to_string().parse::<Basis>().unwrap(), basis);
    }
}
