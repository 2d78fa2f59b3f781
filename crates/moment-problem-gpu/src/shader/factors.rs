//! Linear algebra of five columns, and Newton's method for points of contact.

use super::rows;
use std::fmt::Write;

/// L U factors with row exchanges, and what is solved with them.
pub(super) fn factors() -> String {
    let mut text = String::from("struct Factors {");
    for i in 0..4 {
        rows(&mut text, 0..4, &format!("m{i}#: f64,"));
    }
    rows(&mut text, 0..4, "i#: f64, b#: f64,");
    text += "exchanges: u32, is_sound: bool }\nfn factor(x: Support) -> Factors {\nvar p = a01[x.x0]; var q = a23[x.x0];\n";
    text += "let b0 = p.x; let b1 = p.y; let b2 = q.x; let b3 = q.y;\n";
    rows(
        &mut text,
        0..4,
        "let u# = a01[x.x@]; let v# = a23[x.x@]; var m0# = u#.x - p.x; var m1# = u#.y - p.y; var m2# = v#.x - q.x; var m3# = v#.y - q.y; p = u#; q = v#;",
    );
    text += "var exchanges = 0u; var is_sound = true;\n";
    let mut bit = 0;
    for k in 0..4 {
        for i in k + 1..4 {
            let _ = writeln!(
                text,
                "{{ let s = abs(m{i}{k}) > abs(m{k}{k}); exchanges |= select(0u, {}u, s);",
                1 << bit
            );
            for j in 0..4 {
                let _ = writeln!(
                    text,
                    "let t{j} = select(m{k}{j}, m{i}{j}, s); m{i}{j} = select(m{i}{j}, m{k}{j}, s); m{k}{j} = t{j};"
                );
            }
            text += "}\n";
            bit += 1;
        }
        let _ =
            writeln!(text, "is_sound = is_sound && abs(m{k}{k}) >= 1e-300lf; let i{k} = 1.0lf / m{k}{k};");
        for i in k + 1..4 {
            let _ = writeln!(text, "m{i}{k} = m{i}{k} * i{k};");
            for j in k + 1..4 {
                let _ = writeln!(text, "m{i}{j} = fma(-m{i}{k}, m{k}{j}, m{i}{j});");
            }
        }
    }
    text += "return Factors(";
    for i in 0..4 {
        for j in 0..4 {
            let _ = write!(text, "m{i}{j}, ");
        }
    }
    rows(&mut text, 0..4, "i#, b#,");
    text += "exchanges, is_sound);\n}\nfn solve(f: Factors, v: vec4<f64>) -> vec4<f64> {\nvar r0 = v.x; var r1 = v.y; var r2 = v.z; var r3 = v.w;\n";
    let exchange = |text: &mut String, k: usize, i: usize, bit: usize| {
        let _ = writeln!(
            text,
            "{{ let s = (f.exchanges & {}u) != 0u; let t = select(r{k}, r{i}, s); r{i} = select(r{i}, r{k}, s); r{k} = t; }}",
            1 << bit
        );
    };
    let mut bit = 0;
    for k in 0..4 {
        for i in k + 1..4 {
            exchange(&mut text, k, i, bit);
            bit += 1;
        }
    }
    for k in 0..4 {
        for i in k + 1..4 {
            let _ = writeln!(text, "r{i} = fma(-f.m{i}{k}, r{k}, r{i});");
        }
    }
    for k in (0..4).rev() {
        for j in k + 1..4 {
            let _ = writeln!(text, "r{k} = fma(-f.m{k}{j}, r{j}, r{k});");
        }
        let _ = writeln!(text, "r{k} = r{k} * f.i{k};");
    }
    text += "return vec4<f64>(r0, r1, r2, r3);\n}\nfn solve_transposed(f: Factors, v: vec4<f64>) -> vec4<f64> {\nvar r0 = v.x; var r1 = v.y; var r2 = v.z; var r3 = v.w;\n";
    for k in 0..4 {
        for j in 0..k {
            let _ = writeln!(text, "r{k} = fma(-f.m{j}{k}, r{j}, r{k});");
        }
        let _ = writeln!(text, "r{k} = r{k} * f.i{k};");
    }
    for k in (0..4).rev() {
        for i in k + 1..4 {
            let _ = writeln!(text, "r{k} = fma(-f.m{i}{k}, r{i}, r{k});");
        }
    }
    let mut bit = 6;
    for k in (0..4).rev() {
        for i in (k + 1..4).rev() {
            bit -= 1;
            exchange(&mut text, k, i, bit);
        }
    }
    text += "return vec4<f64>(r0, r1, r2, r3);\n}\n";
    text
}

/// Newton's method for pairs of neighbouring columns.
pub(super) fn shift() -> String {
    let mut text = String::from(
        "struct Shifted { x: Support, moved: bool }
fn shift(x: Support, w: Five, step: i32) -> Shifted {
let second0 = false;
",
    );
    rows(
        &mut text,
        0..4,
        "let first# = !second# && x.x@ == x.x# + 1i && x.x# != step && x.x# + 1i != step; let second@ = first#; var n# = x.x#;",
    );
    text += "var n4 = x.x4; let first4 = false; var moved = false; var failed = false; var wrong = -1i; var before = -1i;\n";
    for r in 0..5 {
        let _ = writeln!(
            text,
            "if (!second{r} && !first{r}) {{ failed = failed || x.x{r} <= before; before = x.x{r}; }}"
        );
        if r < 4 {
            let next = r + 1;
            let _ = writeln!(
                text,
                "if (first{r}) {{
    var to = x.x{r};
    if (w.v{r} < 0.0lf || w.v{next} < 0.0lf) {{
        let mass = w.v{r} + w.v{next};
        if (mass > 0.0lf) {{
            let left = x.x{r} < step;
            let low = select(step + 1i, 0i, left);
            let high = select(LAST - 1i, step - 2i, left);
            failed = failed || low > high;
            to = i32(min(max(f64(x.x{r}) + w.v{next} / mass, f64(low)), f64(high)));
            moved = moved || to != x.x{r};
        }} else {{ failed = failed || wrong >= 0i; wrong = {r}i; }}
    }}
    failed = failed || to <= before;
    n{r} = to; n{next} = to + 1i; before = to + 1i;
}}"
            );
        }
    }
    text += "if (wrong >= 0i) {
    failed = failed || n0 == 0i || n4 == LAST;
    let o0 = n0; let o1 = n1; let o2 = n2; let o3 = n3; let o4 = n4;
    n1 = select(o2, o0, wrong >= 1i); n2 = select(o3, o1, wrong >= 2i); n3 = select(o4, o2, wrong >= 3i);
    n0 = 0i; n4 = LAST; moved = true;
}
if (failed || !moved) { return Shifted(x, false); }
return Shifted(Support(n0, n1, n2, n3, n4), true);
}
";
    text
}

pub(super) fn sort() -> String {
    let mut text = String::from("fn ascending(given: Support) -> Support {\nvar x = given;\n");
    for _ in 0..4 {
        rows(&mut text, 0..4, "{ let a = x.x#; let b = x.x@; x.x# = min(a, b); x.x@ = max(a, b); }");
    }
    text += "return x;\n}\n";
    text
}
