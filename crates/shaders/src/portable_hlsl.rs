//! HLSL that every compiler takes, from what the back end writes for one of them: zeros and constants as lists of values,
//! samplers in registers of their own.

use std::collections::HashMap;

/// Fields of each structure: type, and lengths of arrays.
type Structures<'a> = HashMap<&'a str, Vec<(&'a str, Vec<usize>)>>;

/// `register` gives the register of a sampler by its name.
pub(crate) fn portable(text: &str, register: impl Fn(&str) -> Option<u32>) -> String {
    let structures = structures(text);
    let mut written = String::with_capacity(text.len());
    for line in text.lines().filter(|line| !is_heap(line)) {
        let changed = sampler(line, &register)
            .or_else(|| constant(line))
            .or_else(|| zeroed(line, &structures))
            .or_else(|| zero_returned(line, &structures));
        written += changed.as_deref().unwrap_or(line);
        written.push('\n');
    }
    written
}

/// Samplers of the back end come from a heap by an index from a buffer, which an engine does not have.
fn is_heap(line: &str) -> bool {
    line.contains("SamplerHeap[2048]")
        || (line.starts_with("StructuredBuffer<uint> nagaGroup") && line.contains("SamplerIndexArray"))
}

fn sampler(line: &str, register: impl Fn(&str) -> Option<u32>) -> Option<String> {
    let (name, _) = line.strip_prefix("static const SamplerState ")?.split_once(" = ")?;
    let number = register(name).or_else(|| register(name.strip_suffix('_')?))?;
    Some(format!("SamplerState {name} : register(s{number});"))
}

/// `static const float A[2] = Construct..(1.0, 2.0);` without the function.
fn constant(line: &str) -> Option<String> {
    let (declared, value) = line.split_once(" = Construct").filter(|_| line.starts_with("static const "))?;
    let (_, values) = value.strip_suffix(");")?.split_once('(')?;
    (!values.contains("Construct")).then(|| format!("{declared} = {{ {values} }};"))
}

/// `T a[2] = (T[2])0;` with the zeros themselves.
fn zeroed(line: &str, structures: &Structures<'_>) -> Option<String> {
    let (declared, cast) = line.strip_suffix(")0;")?.split_once(" = (")?;
    let kind = parsed(cast)?;
    let value = zero(&kind, structures)?;
    let target = declared.trim_start();
    if target.contains(' ') || !value.starts_with('{') {
        return Some(format!("{declared} = {value};"));
    }
    // A list can only start a variable.
    let indent = &declared[..declared.len() - target.len()];
    Some(format!("{indent}{{ {} zero{} = {value}; {target} = zero; }}", kind.0, lengths(&kind.1)))
}

fn lengths(of: &[usize]) -> String {
    of.iter().map(|length| format!("[{length}]")).collect()
}

/// `return (T[2])0;` by a variable.
fn zero_returned(line: &str, structures: &Structures<'_>) -> Option<String> {
    let cast = line.strip_suffix(")0;")?.trim_start().strip_prefix("return (")?;
    let kind = parsed(cast)?;
    let value = zero(&kind, structures)?;
    Some(format!("    {} zero{} = {value};\n    return zero;", kind.0, lengths(&kind.1)))
}

/// `float[4][4]`.
fn parsed(kind: &str) -> Option<(&str, Vec<usize>)> {
    let (name, lengths) = kind.split_at(kind.find('[').unwrap_or(kind.len()));
    let lengths = lengths.split_terminator(']').map(|length| length.strip_prefix('[')?.parse().ok());
    Some((name, lengths.collect::<Option<_>>()?))
}

fn structures(text: &str) -> Structures<'_> {
    let mut all = HashMap::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let Some(name) = line.strip_prefix("struct ").and_then(|rest| rest.strip_suffix(" {")) else {
            continue;
        };
        let fields = lines.by_ref().take_while(|line| *line != "};").filter_map(field);
        all.insert(name, fields.collect());
    }
    all
}

/// `float w[3] : SV_Target0;`.
fn field(line: &str) -> Option<(&str, Vec<usize>)> {
    let declared = line.trim().strip_suffix(';')?;
    let declared = declared.split_once(" : ").map_or(declared, |(declared, _)| declared);
    let (kind, name) = declared.rsplit_once(' ')?;
    Some((kind, parsed(name)?.1))
}

fn zero((name, lengths): &(&str, Vec<usize>), structures: &Structures<'_>) -> Option<String> {
    let list = |values: Vec<String>| format!("{{ {} }}", values.join(", "));
    if let [length, inner @ ..] = &lengths[..] {
        let each = zero(&(name, inner.to_vec()), structures)?;
        return Some(list(vec![each; *length]));
    }
    if let Some(fields) = structures.get(name) {
        return Some(list(fields.iter().map(|field| zero(field, structures)).collect::<Option<_>>()?));
    }
    let (scalar, count) = name.split_at(name.find(|c: char| c.is_ascii_digit()).unwrap_or(name.len()));
    let value = match scalar {
        "float" => "0.0",
        "int" => "0",
        "uint" => "0u",
        "bool" => "false",
        _ => return None,
    };
    match count {
        "" => Some(value.to_owned()),
        count => Some(format!("{name}({})", vec![value; count.parse().ok()?].join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_are_written_out() {
        let text = "struct Pair {\n    float2 w : SV_Target0;\n    bool b[2];\n};\n    Pair p[2] = (Pair[2])0;\n    return (uint[3])0;\n    float x = (float)0;\n    part = (int[2])0;\n";
        let found = portable(text, |_| None);
        let pair = "{ float2(0.0, 0.0), { false, false } }";
        for line in [
            format!("    Pair p[2] = {{ {pair}, {pair} }};"),
            "    uint zero[3] = { 0u, 0u, 0u };\n    return zero;".to_owned(),
            "    float x = 0.0;".to_owned(),
            "    { int zero[2] = { 0, 0 }; part = zero; }".to_owned(),
        ] {
            assert!(found.contains(&line), "`{line}` in {found}");
        }
    }

    #[test]
    fn constants_and_samplers_need_no_function_and_no_heap() {
        let text = "static const int A[2] = Constructarray2_int_(int(1), int(2));\nstatic const SamplerState s_ = nagaSamplerHeap[nagaGroup0SamplerIndexArray[3]];\n";
        let found = portable(text, |name| (name == "s").then_some(3));
        assert_eq!(found, "static const int A[2] = { int(1), int(2) };\nSamplerState s_ : register(s3);\n");
    }
}
