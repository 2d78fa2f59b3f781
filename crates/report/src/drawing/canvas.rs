//! An SVG canvas: text, axes, lines and legends.

use super::family::Family;
use super::hover;
use super::palette::{BLACK, CURVE_COLOURS, GRID};
use super::texels;
use crate::error::ReportError;
use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::{
    Cartesian2d, ChartContext, DashedLineSeries, DrawingArea, FontDesc, FontFamily, FontStyle,
    IntoDrawingArea, PathElement, RGBColor, Ranged, SVGBackend, ShapeStyle, TRANSPARENT, Text, TextStyle,
    WHITE,
};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A rectangle of the canvas.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Whether drawing went well; the library has many error types.
pub(crate) type Drawn = Result<(), Box<dyn std::error::Error + Send + Sync>>;

/// The drawing library rounds to whole units: draw with finer ones.
pub(crate) const FINE: u32 = 4;

/// Draws `width` x `height` pixels.
pub(crate) fn svg(
    figure: &str,
    (width, height): (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> Drawn,
) -> Result<String, ReportError> {
    // What a drawing that failed may have left.
    hover::take();
    texels::forget();
    let mut text = String::new();
    let fine = (width * FINE, height * FINE);
    {
        let root = SVGBackend::with_string(&mut text, fine).into_drawing_area();
        let drawn = root.fill(&WHITE).map_err(Into::into).and_then(|()| draw(&root));
        let presented = drawn.and_then(|()| root.present().map_err(Into::into));
        presented
            .map_err(|error| ReportError::Drawing { figure: figure.to_owned(), reason: error.to_string() })?;
    }
    let size = |(width, height)| format!("width=\"{width}\" height=\"{height}\" viewBox");
    let text = text.replacen(&size(fine), &size((width, height)), 1);
    let text = texels::placed(text);
    Ok(text.replacen("</svg>", &format!("{}</svg>", hover::take()), 1))
}

/// Sans-serif text of so many pixels.
pub(crate) fn font(pixels: u32) -> TextStyle<'static> {
    /// The SVG backend divides by this.
    const BACKEND: f64 = 1.24;
    FontDesc::new(FontFamily::SansSerif, BACKEND * f64::from(pixels * FINE), FontStyle::Normal).into()
}

/// Text with its anchor in the middle of the given side.
pub(crate) fn anchored(pixels: u32, horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    font(pixels).pos(Pos::new(horizontal, vertical))
}

/// How a curve looks, in the chart and in the legend.
#[derive(Clone, Copy)]
pub(crate) struct Stroke {
    pub(crate) colour: RGBColor,
    /// In units of the finer canvas.
    pub(crate) width: u32,
    pub(crate) dashed: bool,
}

/// A chart with two axes on the canvas.
type Axes<'a, 'b, X, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>;

/// Grid lines at labelled values only; labels of so many pixels, and descriptions of one more.
pub(crate) fn mesh<'a, 'b, 'c, X, Y>(
    chart: &'c mut Axes<'a, 'b, X, Y>,
    pixels: u32,
) -> MeshStyle<'a, 'c, X, Y, SVGBackend<'b>>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT).bold_line_style(GRID.stroke_width(2));
    mesh.label_style(font(pixels)).axis_desc_style(font(pixels + 1)).set_all_tick_mark_size(4 * FINE);
    mesh
}

/// A polyline of a chart.
pub(crate) fn line<X, Y>(chart: &mut Axes<'_, '_, X, Y>, points: Vec<(f64, f64)>, stroke: Stroke) -> Drawn
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    if stroke.dashed {
        chart.draw_series(DashedLineSeries::new(points, 5 * FINE, 4 * FINE, stroke.style()))?;
    } else {
        chart.draw_series([PathElement::new(points, stroke.style())])?;
    }
    Ok(())
}

/// A label of a logarithmic axis: powers of ten have one.
pub(crate) fn power_of_ten(value: &f64) -> String {
    let exponent = value.log10().round();
    if (value.log10() - exponent).abs() < 1e-6 { format!("1e{exponent:.0}") } else { String::new() }
}

impl Stroke {
    /// Of the n-th of many curves: dashed where the colours come again.
    pub(crate) fn nth(n: usize) -> Self {
        let dashed = n >= CURVE_COLOURS.len();
        Self { colour: CURVE_COLOURS[n % CURVE_COLOURS.len()], width: 6, dashed }
    }

    /// Of techniques that share a chart: each in the colour of its family, dashed for the second of a family. Where a family
    /// has more, colours tell curves apart and no families.
    pub(crate) fn of_techniques<'n>(names: impl IntoIterator<Item = &'n str>) -> Vec<Self> {
        let families: Vec<&Family> = names.into_iter().map(Family::of).collect();
        let before = |i: usize| families[..i].iter().filter(|family| family.name == families[i].name).count();
        let places = 0..families.len();
        if places.clone().any(|i| before(i) > 1) {
            return places.map(Self::nth).collect();
        }
        places.map(|i| Self { colour: families[i].colour, width: 6, dashed: before(i) > 0 }).collect()
    }

    pub(crate) fn style(self) -> ShapeStyle {
        ShapeStyle { color: self.colour.to_rgba(), filled: false, stroke_width: self.width }
    }
}

pub(crate) const F_STROKE: Stroke = Stroke { colour: BLACK, width: 7, dashed: false };

/// Draws samples of strokes with their names in columns of equal width.
pub(crate) fn legend(area: &Area<'_>, entries: &[(Stroke, String)], columns: usize) -> Drawn {
    let fine = FINE as i32;
    let column_width = area.dim_in_pixel().0 as i32 / columns as i32;
    for (i, (stroke, name)) in entries.iter().enumerate() {
        let x = column_width * (i % columns) as i32 + 14 * fine;
        let y = (i / columns) as i32 * LEGEND_ROW as i32 * fine + 10 * fine;
        let pieces: &[(i32, i32)] = if stroke.dashed { &[(0, 5), (9, 14), (18, 23)] } else { &[(0, 24)] };
        for &(from, to) in pieces {
            area.draw(&PathElement::new([(x + from * fine, y), (x + to * fine, y)], stroke.style()))?;
        }
        area.draw(&Text::new(name.clone(), (x + 30 * fine, y), anchored(12, HPos::Left, VPos::Center)))?;
    }
    Ok(())
}

/// Height of one row of a legend in pixels.
pub(crate) const LEGEND_ROW: u32 = 18;
