//! A transform and its inverse as code that can be pasted into a shader or a program.

use crate::interval::DepthInterval;
use crate::optimum::sizes;
use crate::storage::AffineTransform;
use moment_problem::Basis;
use std::fmt::Write as _;

/// The language of a snippet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// WebGPU shading language.
    Wgsl,
    /// Direct3D's.
    Hlsl,
    /// Rust.
    Rust,
}

/// Words of a language.
struct Syntax {
    signature: fn(&str, &str, usize) -> String,
    declare: fn(usize) -> String,
    end: &'static str,
}

impl Language {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Wgsl, Self::Hlsl, Self::Rust];

    fn syntax(self) -> Syntax {
        match self {
            Self::Wgsl => Syntax {
                signature: |name, argument, m| {
                    format!("fn {name}({argument}: array<f32, {m}>) -> array<f32, {m}> {{")
                },
                declare: |m| format!("    return array<f32, {m}>("),
                end: "    );\n}\n",
            },
            // A function cannot return an array, only a structure that holds one.
            Self::Hlsl => Syntax {
                signature: |name, argument, m| {
                    format!("void {name}(const float {argument}[{m}], out float result[{m}]) {{")
                },
                declare: |m| format!("    const float values[{m}] = {{"),
                end: "    };\n    result = values;\n}\n",
            },
            Self::Rust => Syntax {
                signature: |name, argument, m| format!("fn {name}({argument}: [f32; {m}]) -> [f32; {m}] {{"),
                declare: |_| "    [".to_owned(),
                end: "    ]\n}\n",
            },
        }
    }
}

/// Two functions: `quantise` from moments to stored values, `dequantise` back. Numbers have the digits that tell
/// single-precision numbers apart; stored values must be clamped to \[0, 1\] where the format does not do it. The
/// transform's functions run over `depths`; where these are not those of the `interval`, a comment maps them.
pub fn snippet(
    language: Language,
    basis: &Basis,
    interval: DepthInterval,
    depths: DepthInterval,
    transform: &AffineTransform,
) -> String {
    let m = transform.order();
    let syntax = language.syntax();
    let sizes = sizes(basis, depths);
    let mut text =
        format!("// b = ({basis}), z in {depths}: |det theta| = 2^{:.4}.\n", transform.log2_determinant());
    if depths != interval {
        let slope = depths.length() / interval.length();
        let shift = depths.start();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "// Depths d in {interval} are mapped first: z = (d - {}) * {slope} + {shift}.",
            interval.start()
        );
    }
    let mut function = |name: &str, argument: &str, line: &dyn Fn(usize) -> String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}\n{}", (syntax.signature)(name, argument, m), (syntax.declare)(m));
        for i in 0..m {
            let comma = if i + 1 < m || language == Language::Rust { "," } else { "" };
            let _ = writeln!(text, "        {}{comma}", line(i));
        }
        text.push_str(syntax.end);
    };
    function("quantise", "b", &|i| {
        let entries = transform.row(i).iter().zip(&sizes).enumerate();
        sum(entries.map(|(j, (&factor, &size))| (factor, size, format!("b[{j}]"))), transform.offset()[i])
    });
    function("dequantise", "s", &|i| {
        let row = &transform.inverse()[i * m..(i + 1) * m];
        // The offset is multiplied here, in double precision, and not in the shader.
        let constant = -row.iter().zip(transform.offset()).map(|(a, o)| a * o).sum::<f64>();
        sum(row.iter().enumerate().map(|(j, &factor)| (factor, 1.0, format!("s[{j}]"))), constant)
    });
    text
}

/// Terms below this share of the largest one of their sum say nothing in single precision.
const NEGLIGIBLE: f64 = 1e-12;

/// A sum of factors times names, whose largest values are given too.
fn sum(terms: impl Iterator<Item = (f64, f64, String)>, constant: f64) -> String {
    let terms: Vec<(f64, f64, String)> = terms.collect();
    let largest = terms.iter().fold(constant.abs(), |max, (factor, size, _)| max.max((factor * size).abs()));
    let mut text = String::new();
    let mut add = |value: f64, size: f64, name: Option<&str>| {
        if (value * size).abs() <= NEGLIGIBLE * largest {
            return;
        }
        let sign = match (text.is_empty(), value < 0.0) {
            (true, true) => "-",
            (true, false) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        };
        // Nine digits distinguish all single-precision numbers.
        let _ = write!(text, "{sign}{}", number(value.abs()));
        if let Some(name) = name {
            let _ = write!(text, " * {name}");
        }
    };
    terms.iter().for_each(|(factor, size, name)| add(*factor, *size, Some(name)));
    add(constant, 1.0, None);
    if text.is_empty() { "0.0".to_owned() } else { text }
}

/// Nine significant digits, always with a decimal point, as all three languages read it.
fn number(value: f64) -> String {
    if !(1e-7..1e15).contains(&value) {
        return format!("{value:.8e}");
    }
    let digits = (8 - value.log10().floor() as i32).clamp(1, 20) as usize;
    let text = format!("{value:.digits$}");
    let short = text.trim_end_matches('0');
    if short.ends_with('.') { format!("{short}0") } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published::Published;

    #[test]
    fn all_languages_write_the_same_numbers() {
        let published = Published::named("MSM15 theta_2").unwrap();
        let theta = published.transform().unwrap();
        for language in Language::ALL {
            let code =
                snippet(language, &Basis::power(2), published.interval(), published.interval(), &theta);
            assert!(code.contains("4.0 * b[0] - 4.0 * b[1]"), "{code}");
            assert!(code.contains("1.0 * s[0] - 0.25 * s[1]"), "{code}");
            assert_eq!(code.matches('{').count(), code.matches('}').count(), "{code}");
        }
        assert_eq!(number(0.018888946), "0.018888946");
        assert_eq!(number(39.3703274), "39.3703274");
        assert_eq!(number(4.0), "4.0");
        assert_eq!(number(123456789.5), "123456789.5");
    }

    /// The snippet is read back and evaluated: its numbers must be the transform's.
    #[test]
    fn a_snippet_computes_the_transform() {
        let published = Published::named("GDC16 six moments").unwrap();
        let theta = published.transform().unwrap();
        let code =
            snippet(Language::Rust, &Basis::power(6), published.interval(), published.interval(), &theta);
        let b: Vec<f64> = Basis::power(6).evaluate(0.37);
        let lines: Vec<&str> = code.lines().filter(|line| line.starts_with("        ")).collect();
        assert_eq!(lines.len(), 12);
        let evaluate = |line: &str, name: char, values: &[f64]| -> f64 {
            let line = line.trim().trim_end_matches(',').replace(" - ", " + -");
            let term = |text: &str| match text.split_once(" * ") {
                None => text.parse::<f64>().unwrap(),
                Some((factor, name_and_index)) => {
                    let index: usize = name_and_index[2..name_and_index.len() - 1].parse().unwrap();
                    assert!(name_and_index.starts_with(name));
                    factor.parse::<f64>().unwrap() * values[index]
                }
            };
            line.split(" + ").map(term).sum()
        };
        let mut stored = vec![0.0; 6];
        theta.apply(&b, &mut stored);
        for i in 0..6 {
            assert!((evaluate(lines[i], 'b', &b) - stored[i]).abs() < 1e-7, "{}", lines[i]);
            assert!((evaluate(lines[6 + i], 's', &stored) - b[i]).abs() < 1e-6, "{}", lines[6 + i]);
        }
    }
}
