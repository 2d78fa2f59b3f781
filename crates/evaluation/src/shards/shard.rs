//! `2/4`: which part of how many.

/// Part of what an experiment divides its work into: `index` of `count`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// 1 to `count`.
    pub index: usize,
    /// Number of parts.
    pub count: usize,
}

impl Shard {
    /// Everything.
    pub const WHOLE: Self = Self { index: 1, count: 1 };
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fail = || format!("`{text}` is no shard: write i/N with i from 1 to N, such as 2/4");
        let (index, count) = text.split_once('/').ok_or_else(fail)?;
        let (index, count) = (index.parse().map_err(|_| fail())?, count.parse().map_err(|_| fail())?);
        if !(1..=count).contains(&index) {
            return Err(fail());
        }
        Ok(Self { index, count })
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}
