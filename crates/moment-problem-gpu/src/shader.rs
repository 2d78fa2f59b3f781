//! The stages of the solver in WGSL, written out for four functions: no loop over rows is left, so that everything stays in
//! registers.
//!
//! All indices into workgroup memory are columns of the support, kept in range where they arise; indices into buffers are below
//! the sizes in `size`. The module may therefore be compiled without run-time checks; with them it is its own test twin.

use std::fmt::Write;

/// Invocations of a workgroup of the stages that walk through programs.
pub(crate) const INVOCATIONS: u32 = 128;

/// Programs of a workgroup of the stages that sum up.
pub(crate) const GROUP: u32 = 256;

/// Candidates whose moments are computed together.
pub(crate) const TOGETHER: u32 = 4;

/// Products that are summed before the sum is added to the others.
pub(crate) const CHAIN: u32 = 8;

/// Every so many columns are priced first.
const COARSE: u32 = 8;

/// How the module is to be written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// Depths of the support.
    pub(crate) depths: u32,
    /// Dimensions of the span.
    pub(crate) dimensions: u32,
    /// Whether invocations of a subgroup may count each other.
    pub(crate) subgroups: bool,
}

/// Repeats lines for rows; `#` is the number, `+` the next one.
fn rows(text: &mut String, numbers: std::ops::Range<usize>, line: &str) {
    for i in numbers {
        let filled = line.replace('#', &i.to_string()).replace('@', &(i + 1).to_string());
        let _ = writeln!(text, "{filled}");
    }
}

/// The module.
pub(crate) fn source(options: Options) -> String {
    let Options { depths, dimensions, subgroups } = options;
    let coarse = depths.div_ceil(COARSE);
    let last = depths - 1;
    let mut text = format!(
        "struct Size {{ programs: u32, stride: u32, candidates: u32, share: u32, round: u32, capacity: u32, groups: u32, unused: u32 }}
const DEPTHS: i32 = {depths}i;
const LAST: i32 = {last}i;
const DIMENSIONS: u32 = {dimensions}u;
const CANDIDATE: u32 = {candidate}u;
@group(0) @binding(0) var<uniform> size: Size;
@group(0) @binding(1) var<storage, read> columns: array<vec2<f64>>;
@group(0) @binding(2) var<storage, read> transform: array<vec4<f64>>;
@group(0) @binding(3) var<storage, read> coordinates: array<f64>;
@group(0) @binding(4) var<storage, read> guesses: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> steps: array<i32>;
@group(0) @binding(6) var<storage, read> masses: array<vec2<f64>>;
@group(0) @binding(7) var<storage, read> weighting: array<vec4<f64>>;
@group(0) @binding(8) var<storage, read_write> moments: array<f64>;
@group(0) @binding(9) var<storage, read_write> supports: array<vec2<u32>>;
@group(0) @binding(10) var<storage, read_write> bounds: array<f64>;
@group(0) @binding(11) var<storage, read_write> queues: array<u32>;
@group(0) @binding(12) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(13) var<storage, read_write> rest: array<vec4<u32>>;
@group(0) @binding(15) var<storage, read> kernels: array<vec2<u32>>;
@group(0) @binding(14) var<storage, read_write> sums: array<vec4<f64>>;
var<workgroup> a01: array<vec2<f64>, {depths}>;
var<workgroup> a23: array<vec2<f64>, {depths}>;
var<workgroup> coarse: array<vec4<f32>, {coarse}>;
var<workgroup> next: atomic<u32>;
struct Support {{ x0: i32, x1: i32, x2: i32, x3: i32, x4: i32 }}
struct Five {{ v0: f64, v1: f64, v2: f64, v3: f64, v4: f64 }}
",
        candidate = 2 * depths + 4,
    );
    text += if subgroups { COUNTED } else { ALONE };
    text += &factors();
    text += &shift();
    text += &sort();
    text += STAGES;
    text += &pivots(coarse);
    text
}

/// Lanes wait until a quarter of the subgroup has nothing to do, and share one access to a counter.
const COUNTED: &str = "
fn is_time(idle: bool) -> bool {
    let waiting = subgroupAdd(select(0u, 1u, idle));
    let all = subgroupAdd(1u);
    return waiting * 4u >= all;
}
fn place(counter: u32, wanted: bool) -> u32 {
    let one = select(0u, 1u, wanted);
    let before = subgroupExclusiveAdd(one);
    let all = subgroupAdd(one);
    var start = 0u;
    if (subgroupExclusiveAdd(1u) == 0u && all > 0u) { start = atomicAdd(&counts[counter], all); }
    return subgroupBroadcastFirst(start) + before;
}
fn least_step(step: i32) -> i32 { return subgroupMin(step); }
fn largest_step(step: i32) -> i32 { return subgroupMax(step); }
";

/// Each lane for itself.
const ALONE: &str = "
fn is_time(idle: bool) -> bool { return idle; }
fn place(counter: u32, wanted: bool) -> u32 {
    if (wanted) { return atomicAdd(&counts[counter], 1u); }
    return 0u;
}
fn least_step(step: i32) -> i32 { return 0i; }
fn largest_step(step: i32) -> i32 { return DEPTHS; }
";

/// L U factors with row exchanges, and what is solved with them.
fn factors() -> String {
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
fn shift() -> String {
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

fn sort() -> String {
    let mut text = String::from("fn ascending(given: Support) -> Support {\nvar x = given;\n");
    for _ in 0..4 {
        rows(&mut text, 0..4, "{ let a = x.x#; let b = x.x@; x.x# = min(a, b); x.x@ = max(a, b); }");
    }
    text += "return x;\n}\n";
    text
}

const STAGES: &str = include_str!("stages.wgsl");

/// The primal simplex method with an explicit inverse.
fn pivots(coarse: u32) -> String {
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
