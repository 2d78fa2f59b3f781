//! WGSL constants that hold a value of Rust exactly, as single floats where they are real.

/// `const NAME: f32`.
pub fn constant(name: &str, value: f64) -> String {
    format!("const {name}: f32 = {};\n", number(value))
}

/// `const NAME: u32`.
pub fn count(name: &str, value: usize) -> String {
    format!("const {name}: u32 = {value}u;\n")
}

/// `const NAME: bool`.
pub fn flag(name: &str, value: bool) -> String {
    format!("const {name}: bool = {value};\n")
}

/// `const NAME: array<f32, COUNT>`.
pub fn array(name: &str, values: &[f64]) -> String {
    let count = values.len();
    let values = values.iter().map(|&value| number(value)).collect::<Vec<_>>().join(", ");
    format!("const {name}: array<f32, {count}> = array<f32, {count}>({values});\n")
}

/// `const NAME: array<i32, COUNT>`.
pub fn whole_numbers(name: &str, values: &[i32]) -> String {
    let count = values.len();
    let values = values.iter().map(|&value| format!("i32({value})")).collect::<Vec<_>>().join(", ");
    format!("const {name}: array<i32, {count}> = array<i32, {count}>({values});\n")
}

/// The nearest single float, as WGSL reads it back exactly.
fn number(value: f64) -> String {
    format!("{:?}f", value as f32)
}
