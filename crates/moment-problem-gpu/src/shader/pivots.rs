//! Pivots, and where the next column is looked for.

use super::{COARSE, INVOCATIONS, rows};
use std::fmt::Write;

/// The primal simplex method with an explicit inverse.
pub(super) fn pivots(coarse: u32) -> String {
    let mut text = String::from(
        "fn pivot(group: vec2<u32>, l: u32, full: bool) {
    let c = group.y;
    let count = min(atomicLoad(&counts[(size.round - 1u) * size.candidates + c]), size.programs);
    let begin = group.x * size.share;
    if (begin >= count) { return; }
    let end = min(begin + size.share, count);
    load(c, l);
",
    );
    let _ = writeln!(
        text,
        "    for (var k = l; k < {coarse}u; k += {INVOCATIONS}u) {{ let u = columns[c * CANDIDATE + k * {COARSE}u]; let v = columns[c * CANDIDATE + u32(DEPTHS) + k * {COARSE}u]; coarse[k] = vec4<f32>(f32(u.x), f32(u.y), f32(v.x), f32(v.y)); }}"
    );
    text += "    if (l == 0u) { atomicStore(&next, begin); }
    workgroupBarrier();
    let queue = ((size.round - 1u) * size.candidates + c) * size.stride;
    var f = -1i; var step = 0i; var pivots = 0i; var negative = 0u; var first = full;
    var x = Support(0i, 1i, 2i, 3i, 4i);
";
    for r in 0..5 {
        rows(&mut text, 0..5, &format!("var h{r}# = 0.0lf;"));
        let _ = writeln!(text, "var w{r} = 0.0lf;");
    }
    text += "    loop {
        if (is_time(f < 0i)) {
            if (f < 0i) {
                let mine = atomicAdd(&next, 1u);
                if (mine >= end) { break; }
                let at = queues[queue + mine];
                f = i32(at); step = steps[at]; x = unpacked(supports[c * size.stride + at]); pivots = 0i; first = full; negative = 0u;
                let b = moments_of(c, at);
                let lu = factor(x);
                let c0 = solve(lu, vec4<f64>(1.0lf, 0.0lf, 0.0lf, 0.0lf));
                let c1 = solve(lu, vec4<f64>(0.0lf, 1.0lf, 0.0lf, 0.0lf));
                let c2 = solve(lu, vec4<f64>(0.0lf, 0.0lf, 1.0lf, 0.0lf));
                let c3 = solve(lu, vec4<f64>(0.0lf, 0.0lf, 0.0lf, 1.0lf));
";
    for r in 0..5 {
        for i in 0..4 {
            let name = ["x", "y", "z", "w"];
            let value = match r {
                0 => format!("-c{i}.x"),
                4 => format!("c{i}.w"),
                _ => format!("c{i}.{} - c{i}.{}", name[r - 1], name[r]),
            };
            let _ = writeln!(text, "h{r}{} = {value};", i + 1);
        }
        let one = if r == 0 { "1.0lf" } else { "0.0lf" };
        let _ = writeln!(
            text,
            "h{r}0 = fma(-h{r}4, lu.b3, fma(-h{r}3, lu.b2, fma(-h{r}2, lu.b1, fma(-h{r}1, lu.b0, {one}))));
w{r} = fma(h{r}4, b.w, fma(h{r}3, b.z, fma(h{r}2, b.y, fma(h{r}1, b.x, h{r}0))));
if (w{r} < -3e-14lf * (abs(h{r}0) + abs(h{r}1) + abs(h{r}2) + abs(h{r}3) + abs(h{r}4))) {{ negative |= {}u; }} else {{ w{r} = max(w{r}, 0.0lf); }}",
            1 << r
        );
    }
    text += "            }
        }
        if (f < 0i) { continue; }
        let repairing = negative != 0u;
        let cost = select(1.0lf, -1.0lf, repairing);
        var any = false;
";
    rows(&mut text, 0..5, "var y# = 0.0lf;");
    for r in 0..5 {
        let _ = writeln!(
            text,
            "{{ let on = select(x.x{r} < step, (negative & {}u) != 0u, repairing); any = any || on; let k = select(0.0lf, cost, on);",
            1 << r
        );
        rows(&mut text, 0..5, &format!("y# = fma(k, h{r}#, y#);"));
        text += "}\n";
    }
    text += "        let y = Five(y0, y1, y2, y3, y4);
        let front = select(step, 0i, repairing);
        var is_done = !any; var at = 0i; var best = -1.0lf;
        if (!is_done) {
            if (first) {
                first = false; best = -1e300lf;
                for (var j = 0i; j < DEPTHS; j++) { let v = gain(y, j, front); if (v > best) { best = v; at = j; } }
            } else {
                let g0 = f32(y0); let g1 = f32(y0 - 1.0lf); let f1 = f32(y1); let f2 = f32(y2); let f3 = f32(y3); let f4 = f32(y4);
                var key = i32(-2147483647i);
";
    let _ = writeln!(
        text,
        "for (var k = 0i; k < {coarse}i; k++) {{ let q = coarse[k]; var s = select(g0, g1, k * {COARSE}i < front); s = fma(f1, q.x, s); s = fma(f2, q.y, s); s = fma(f3, q.z, s); s = fma(f4, q.w, s); key = max(key, (bitcast<i32>(s) & -64i) | k); }}
at = min(select((key & 63i) * {COARSE}i, 0i, key < 0i), LAST);
best = gain(y, at, front);
if (!repairing) {{
    let j0 = min(step, LAST); let v0 = gain(y, j0, front); if (v0 > best) {{ best = v0; at = j0; }}
    let j1 = max(step - 1i, 0i); let v1 = gain(y, j1, front); if (v1 > best) {{ best = v1; at = j1; }}
}}"
    );
    let mut half = COARSE / 2;
    while half > 0 {
        let _ = writeln!(
            text,
            "{{ let a = max(at - {half}i, 0i); let b = min(at + {half}i, LAST); let v = gain(y, a, front); let u = gain(y, b, front); var t = at; if (v > best) {{ best = v; t = a; }} if (u > best) {{ best = u; t = b; }} at = t; }}"
        );
        half /= 2;
    }
    text += "if (best < 1e-9lf && !repairing) {\n";
    rows(
        &mut text,
        0..5,
        "{ let a = max(x.x# - 1i, 0i); let b = min(x.x# + 1i, LAST); let v = gain(y, a, front); let u = gain(y, b, front); if (v > best) { best = v; at = a; } if (u > best) { best = u; at = b; } }",
    );
    text += "                }
            }
            is_done = !(best >= 1e-9lf);
        }
        if (!is_done) {
            let p = a01[at]; let q = a23[at];
            var largest = 0.0lf;
";
    rows(
        &mut text,
        0..5,
        "let d# = fma(h#4, q.y, fma(h#3, q.x, fma(h#2, p.y, fma(h#1, p.x, h#0)))); largest = max(largest, abs(d#));",
    );
    text += "            var numerator = 1e300lf; var divisor = 1.0lf; var far = -1.0lf; var far_divisor = 1.0lf; var leaving = -1i; var repaired = -1i;
            let floor = 1e-11lf * largest; let depth = -1e-9lf * largest;
";
    for r in 0..5 {
        let bit = 1 << r;
        let _ = writeln!(
            text,
            "if ((negative & {bit}u) != 0u) {{ if (d{r} < depth && w{r} * far_divisor < far * d{r}) {{ far = -w{r}; far_divisor = -d{r}; repaired = {r}i; }} }}
else if (d{r} > floor && w{r} * divisor < numerator * d{r}) {{ numerator = w{r}; divisor = d{r}; leaving = {r}i; }}"
        );
    }
    text += "            if (repaired >= 0i && far * divisor < numerator * far_divisor) { leaving = repaired; numerator = -far; divisor = -far_divisor; }
            pivots += 1i;
            if (leaving < 0i || pivots > 60i) { is_done = true; }
            else {
                let inverse = 1.0lf / divisor; let level = numerator * inverse;
                var o0 = h00; var o1 = h01; var o2 = h02; var o3 = h03; var o4 = h04;
";
    for r in 1..5 {
        let _ = write!(text, "{{ let s = leaving == {r}i;");
        rows(&mut text, 0..5, &format!("o# = select(o#, h{r}#, s);"));
        text += "}\n";
    }
    for r in 0..5 {
        let bit = 1 << r;
        let _ = writeln!(
            text,
            "{{ let s = leaving == {r}i; let k = select(d{r} * inverse, -inverse, s);
var v = fma(-level, d{r}, w{r});
if ((negative & {bit}u) == 0u) {{ v = max(v, 0.0lf); }} else if (v > -1e-13lf) {{ negative &= ~{bit}u; v = max(v, 0.0lf); }}
if (s) {{ negative &= ~{bit}u; x.x{r} = at; }}
w{r} = select(v, level, s);"
        );
        rows(&mut text, 0..5, &format!("h{r}# = fma(-k, o#, select(h{r}#, 0.0lf, s));"));
        text += "}\n";
    }
    text += "            }
        }
        if (is_done) { supports[c * size.stride + u32(f)] = packed(ascending(x)); f = -1i; }
    }
}
";
    text
}
