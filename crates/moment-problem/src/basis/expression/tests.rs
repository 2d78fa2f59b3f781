use super::*;

fn value(formula: &str, z: f64) -> f64 {
    Expression::parse(formula).unwrap().evaluate(z)
}

#[test]
fn formulas_follow_the_usual_precedence() {
    let z: f64 = 0.3;
    for (formula, expected) in [
        ("z^3", z.powi(3)),
        ("-z^2", -z.powi(2)),
        ("2z", 0.6),
        ("exp(-2z)", (-2.0 * z).exp()),
        ("e^-z", (-z).exp()),
        ("e^(2z)", (2.0 * z).exp()),
        ("sin(3pi z)", (3.0 * std::f64::consts::PI * z).sin()),
        ("sin(3piz)", (3.0 * std::f64::consts::PI * z).sin()),
        ("1/(1/4+z)", 1.0 / (0.25 + z)),
        ("1/(1+25(z-1/2)^2)", 1.0 / (1.0 + 25.0 * (z - 0.5).powi(2))),
        ("z/(1+z^2)", z / (1.0 + z * z)),
        ("cbrt(z+1/16) - 0.5", (z + 0.0625).cbrt() - 0.5),
        ("1 - 2 - z", -1.3),
        ("(1+z)^-2", (1.0 + z).powi(-2)),
        ("exp(1e1z)", (10.0 * z).exp()),
        ("z + 1e-3", z + 1e-3),
        ("2.5E+1z - .5e0", 25.0 * z - 0.5),
        ("z^2e0", z * z),
        ("2e z", 2.0 * std::f64::consts::E * z),
        ("2e^z", 2.0 * z.exp()),
        ("2e - z", 2.0 * std::f64::consts::E - z),
        ("2*e-3 + z", 2.0 * std::f64::consts::E - 3.0 + z),
        ("z e1", std::f64::consts::E * z),
    ] {
        assert!((value(formula, z) - expected).abs() < 1e-15, "{formula}");
    }
}

#[test]
fn spaces_and_neutral_factors_do_not_matter() {
    let parse = |text| Expression::parse(text).unwrap();
    assert_eq!(parse("exp(1z)"), parse(" e^z "));
    assert_eq!(parse("ln(1+1z)"), parse("ln( 1 + z )"));
    assert_eq!(parse("sin(1pi z)"), parse("sin(pi*z)"));
}

#[test]
fn what_may_be_an_exponent_or_eulers_number_is_refused_with_both_readings() {
    for (formula, number, euler) in [
        ("2 e-3 + z", "2e-3", "2*e-3"),
        ("z + 1e - 3", "1e-3", "1*e-3"),
        ("2e 3z", "2e3", "2*e*3"),
        ("2 e3z", "2e3", "2*e*3"),
        ("2e+ 3z", "2e+3", "2*e+3"),
        ("2e3.5z", "2e3", "2*e*3"),
        ("1e1e1z", "1e1", "1*e*1"),
    ] {
        let error = Expression::parse(formula).unwrap_err().to_string();
        assert!(error.contains(number) && error.contains(euler), "{formula}: {error}");
    }
    for formula in ["1e201z", "1e-201z", "1e99999999999z"] {
        let error = Expression::parse(formula).unwrap_err().to_string();
        assert!(error.contains("-200 to 200"), "{formula}: {error}");
    }
}

#[test]
fn malformed_formulas_are_errors() {
    for formula in
        ["", "z^", "z^0.5", "exp z", "foo(z)", "(z", "z)", "1..2", "z $ 2", ".", "z^99", "é", "exp(é)"]
    {
        let error = Expression::parse(formula).unwrap_err().to_string();
        assert!(error.contains(formula), "{formula}: {error}");
    }
    assert!(Expression::parse(&"(".repeat(100_000)).is_err());
}
