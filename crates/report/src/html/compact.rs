//! Drawings in fewer bytes for the page: the same shapes in the same order, with what is the default left out and neighbours
//! of one style joined.

use std::fmt::Write as _;

/// Attributes that say what holds without them, or what the page's style says of every figure.
const DEFAULTS: [&str; 6] = [
    " opacity=\"1\"",
    " stroke=\"none\"",
    " fill-opacity=\"0\"",
    " font-family=\"sans-serif\"",
    " text-anchor=\"start\"",
    " xmlns=\"http://www.w3.org/2000/svg\"",
];

/// The drawing, a shape a line, as [`svg`](crate::drawing::svg) writes it.
pub(super) fn compact(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len() / 2);
    let mut joined: Option<Outline> = None;
    for line in svg.lines() {
        let next = Outline::of(line);
        if let (Some(before), Some(next)) = (&mut joined, &next)
            && before.style == next.style
        {
            before.path += &next.path;
            continue;
        }
        out.extend(joined.take().map(Outline::element));
        match next {
            Some(outline) => joined = Some(outline),
            None => push_short(&mut out, line),
        }
    }
    out.extend(joined.map(Outline::element));
    out
}

/// A line without defaults, and without its end where a text goes on.
fn push_short(out: &mut String, line: &str) {
    let mut line = line.replace(DEFAULTS[0], "");
    for default in &DEFAULTS[1..] {
        line = line.replace(default, "");
    }
    if line.starts_with("<text") {
        // Black is the colour of texts; the page has its own in the dark.
        // The drawing library's sizes are whole ones, but for rounding.
        line = line.replace(" fill=\"#000000\"", "").replace(".00000000000001\"", "\"");
    }
    *out += &line;
    let is_text = !line.starts_with('<') || (line.starts_with("<text") && !line.ends_with("</text>"));
    if !is_text {
        out.push('\n');
    }
}

/// Shapes of one style as a path.
struct Outline {
    style: String,
    path: String,
}

impl Outline {
    /// Of a line that is an opaque shape with whole coordinates. Shapes that can be seen through must not be joined: where
    /// they overlap would look different.
    fn of(line: &str) -> Option<Self> {
        let (tag, rest) = line.strip_prefix('<')?.strip_suffix("/>")?.split_once(' ')?;
        let mut rest = rest.trim_end().strip_suffix('"')?;
        let mut attributes: Vec<(&str, &str)> = Vec::new();
        while !rest.is_empty() {
            let (name, after) = rest.split_once("=\"")?;
            let (value, after) = after.split_once('"').unwrap_or((after, ""));
            attributes.push((name.trim_start(), value));
            rest = after;
        }
        let of = |name: &str| attributes.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
        let number = |name: &str| of(name)?.parse::<i32>().ok();
        if of("opacity") != Some("1") {
            return None;
        }
        match tag {
            "rect" if of("stroke") == Some("none") => {
                let [x, y, width, height] = ["x", "y", "width", "height"].map(number);
                let (x, y, width, height) = (x?, y?, width?, height?);
                Some(Self {
                    style: format!("fill=\"{}\"", of("fill")?),
                    path: format!("M{x} {y}h{width}v{height}h{}z", -width),
                })
            }
            "polyline" if of("fill") == Some("none") => Self::line(&of, points(of("points")?)?),
            "line" => {
                let [x1, y1, x2, y2] = ["x1", "y1", "x2", "y2"].map(number);
                Self::line(&of, vec![(x1?, y1?), (x2?, y2?)])
            }
            _ => None,
        }
    }

    fn line<'a>(of: &impl Fn(&str) -> Option<&'a str>, points: Vec<(i32, i32)>) -> Option<Self> {
        let style =
            format!("fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"", of("stroke")?, of("stroke-width")?);
        let ((mut x, mut y), others) = points.split_first().map(|(first, others)| (*first, others))?;
        let mut path = format!("M{x} {y}l");
        for (i, &(to_x, to_y)) in others.iter().enumerate() {
            let gap = if i == 0 || to_x < x { "" } else { " " };
            let between = if to_y < y { "" } else { " " };
            // Writing to a string cannot fail.
            let _ = write!(path, "{gap}{}{between}{}", to_x - x, to_y - y);
            (x, y) = (to_x, to_y);
        }
        Some(Self { style, path })
    }

    fn element(self) -> String {
        format!("<path {} d=\"{}\"/>\n", self.style, self.path)
    }
}

/// Nothing for coordinates that are not whole, or for a line that has no second point.
fn points(text: &str) -> Option<Vec<(i32, i32)>> {
    let pairs = text.split_ascii_whitespace().map(|pair| {
        let (x, y) = pair.split_once(',')?;
        Some((x.parse().ok()?, y.parse().ok()?))
    });
    pairs.collect::<Option<Vec<_>>>().filter(|points| points.len() > 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_of_one_style_are_one_path_and_others_keep_their_order() {
        let line = |points: &str, colour: &str| {
            format!(
                "<polyline fill=\"none\" opacity=\"1\" stroke=\"{colour}\" stroke-width=\"2\" points=\"{points} \"/>\n"
            )
        };
        let rect = |x: i32, opacity: &str| {
            format!(
                "<rect x=\"{x}\" y=\"2\" width=\"3\" height=\"4\" opacity=\"{opacity}\" fill=\"#010203\" stroke=\"none\"/>\n"
            )
        };
        let drawn = [
            line("0,0 5,-3 2,7", "#aa0000"),
            line("9,9 8,9", "#aa0000"),
            line("1,1 2,2", "#00aa00"),
            rect(1, "1"),
            rect(8, "1"),
            rect(9, "0.5"),
        ];
        let expected = "<path fill=\"none\" stroke=\"#aa0000\" stroke-width=\"2\" d=\"M0 0l5-3-3 10M9 9l-1 0\"/>\n\
             <path fill=\"none\" stroke=\"#00aa00\" stroke-width=\"2\" d=\"M1 1l1 1\"/>\n\
             <path fill=\"#010203\" d=\"M1 2h3v4h-3zM8 2h3v4h-3z\"/>\n\
             <rect x=\"9\" y=\"2\" width=\"3\" height=\"4\" opacity=\"0.5\" fill=\"#010203\"/>\n";
        assert_eq!(compact(&drawn.concat()), expected);
    }

    #[test]
    fn texts_keep_their_words_and_lose_defaults() {
        let text = "<text x=\"4\" y=\"5\" dy=\"0.5ex\" text-anchor=\"start\" font-family=\"sans-serif\" font-size=\"52.00000000000001\" \
             opacity=\"1\" fill=\"#000000\">\nfour moments\n</text>\n";
        assert_eq!(
            compact(text),
            "<text x=\"4\" y=\"5\" dy=\"0.5ex\" font-size=\"52\">four moments</text>\n"
        );
    }
}
