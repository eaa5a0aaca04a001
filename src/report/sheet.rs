//! A sheet to draw on: plotters' bitmap with the embedded font, drawn twice as large and averaged
//! down, so that lines of any width have soft edges. Pixels here are those of the finished figure.

use super::ReportError;
#[cfg(test)]
use super::drawn::{Mark, note};
use super::style::{FONT, INK, Pen, Stroke, WHITE};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::{
    BitMapBackend, Circle, DrawingArea, IntoDrawingArea, PathElement, Polygon, Rectangle, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color, FontStyle, FontTransform, IntoFont, IntoTextStyle, RGBAColor, RGBColor, ShapeStyle,
    TextStyle, register_font,
};
use std::sync::OnceLock;

/// How much larger the sheet is drawn.
pub(super) const FINER: u32 = 2;
/// Dots per metre written into the file: 1600 px are 17 cm of a page at 240 dots per inch.
const DOTS_PER_M: u32 = 9449;

/// Drawing may fail; why it did.
pub(super) type Drawn = Result<(), Box<dyn std::error::Error>>;

/// A point in px from the upper left corner.
pub(super) type At = (f64, f64);

/// Where a text stands relative to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    /// The point is its left end.
    Left,
    /// The point is its middle.
    Middle,
    /// The point is its right end.
    Right,
}

/// Size, weight and colour of a text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Type {
    pub size: f64,
    pub bold: bool,
    pub color: RGBColor,
}

impl Type {
    pub(super) const fn plain(size: f64) -> Self {
        Self { size, bold: false, color: INK }
    }

    pub(super) const fn bold(size: f64) -> Self {
        Self { size, bold: true, color: INK }
    }

    pub(super) const fn colored(self, color: RGBColor) -> Self {
        Self { color, ..self }
    }

    fn style(self, anchor: Anchor) -> TextStyle<'static> {
        let weight = if self.bold { FontStyle::Bold } else { FontStyle::Normal };
        let horizontal = match anchor {
            Anchor::Left => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::Right => HPos::Right,
        };
        (FONT, self.size * f64::from(FINER), weight)
            .into_font()
            .color(&self.color)
            .pos(Pos::new(horizontal, VPos::Center))
    }
}

/// A sheet of paper.
pub(super) struct Sheet<'a> {
    area: DrawingArea<BitMapBackend<'a>, Shift>,
}

/// Draws a figure and writes it as PNG.
pub(super) fn png(
    name: &str,
    (width, height): (u32, u32),
    paint: impl FnOnce(&Sheet) -> Drawn,
) -> Result<Vec<u8>, ReportError> {
    let white = vec![255_u8; (width * FINER * height * FINER * 3) as usize];
    png_over(name, (width, height), white, paint)
}

/// The same on a picture that is there already: red, green, blue of `FINER` times as many pixels
/// each way.
pub(super) fn png_over(
    name: &str,
    (width, height): (u32, u32),
    mut large: Vec<u8>,
    paint: impl FnOnce(&Sheet) -> Drawn,
) -> Result<Vec<u8>, ReportError> {
    let fault = |e: &dyn std::fmt::Display| ReportError::Figure {
        name: name.to_owned(),
        message: e.to_string(),
    };
    register_fonts().map_err(|e| fault(&e))?;
    {
        let fine = (width * FINER, height * FINER);
        let area = BitMapBackend::with_buffer(&mut large, fine).into_drawing_area();
        let sheet = Sheet { area };
        paint(&sheet).map_err(|e| fault(&e))?;
        sheet.area.present().map_err(|e| fault(&e))?;
    }
    encode(&averaged(&large, width, height), width, height).map_err(|e| fault(&e))
}

fn register_fonts() -> Result<(), &'static str> {
    static DONE: OnceLock<bool> = OnceLock::new();
    let regular = dejavu::sans::regular();
    let done = DONE.get_or_init(|| {
        register_font(FONT, FontStyle::Normal, regular).is_ok()
            && register_font(FONT, FontStyle::Bold, dejavu::sans::bold()).is_ok()
    });
    if *done { Ok(()) } else { Err("the embedded font cannot be read") }
}

/// The mean of every block of `FINER` x `FINER` pixels.
fn averaged(large: &[u8], width: u32, height: u32) -> Vec<u8> {
    let (width, height, finer) = (width as usize, height as usize, FINER as usize);
    let row = width * finer * 3;
    let mut small = Vec::with_capacity(width * height * 3);
    for y in 0..height {
        for x in 0..width {
            for channel in 0..3 {
                let mut sum = 0_usize;
                for i in 0..finer {
                    for j in 0..finer {
                        let at = (y * finer + i) * row + (x * finer + j) * 3 + channel;
                        sum += usize::from(large[at]);
                    }
                }
                small.push((sum / (finer * finer)) as u8);
            }
        }
    }
    small
}

fn encode(pixels: &[u8], width: u32, height: u32) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: DOTS_PER_M,
        yppu: DOTS_PER_M,
        unit: png::Unit::Meter,
    }));
    // By this a picture is known as one that may be replaced (`files::signature`).
    encoder.add_text_chunk("Software".to_owned(), "ergopath".to_owned())?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}

fn fine((x, y): At) -> (i32, i32) {
    let of = |v: f64| (v * f64::from(FINER)).round() as i32;
    (of(x), of(y))
}

fn stroke(color: RGBAColor, width: f64) -> ShapeStyle {
    ShapeStyle { color, filled: false, stroke_width: (width * f64::from(FINER)).round() as u32 }
}

impl Sheet<'_> {
    /// A filled rectangle between two corners.
    pub(super) fn fill(&self, a: At, b: At, color: RGBColor) -> Drawn {
        #[cfg(test)]
        note(Mark::Area(vec![a, (b.0, a.1), b, (a.0, b.1)], color));
        Ok(self.area.draw(&Rectangle::new([fine(a), fine(b)], color.filled()))?)
    }

    /// The outline of a rectangle.
    pub(super) fn outline(&self, a: At, b: At, color: RGBColor, width: f64) -> Drawn {
        let corners = [a, (b.0, a.1), b, (a.0, b.1), a];
        self.line(&corners, Pen { color, width, stroke: Stroke::Solid })
    }

    /// A filled shape, `opacity` 0 to 1.
    pub(super) fn shape(&self, corners: &[At], color: RGBColor, opacity: f64) -> Drawn {
        #[cfg(test)]
        note(Mark::Area(corners.to_vec(), color));
        let points: Vec<_> = corners.iter().map(|p| fine(*p)).collect();
        Ok(self.area.draw(&Polygon::new(points, color.mix(opacity)))?)
    }

    /// A line through points.
    pub(super) fn line(&self, points: &[At], pen: Pen) -> Drawn {
        #[cfg(test)]
        note(Mark::Line(points.to_vec(), pen));
        let points: Vec<_> = points.iter().map(|p| fine(*p)).collect();
        let style = stroke(pen.color.to_rgba(), pen.width);
        let (drawn, gap) = match pen.stroke {
            Stroke::Solid => return Ok(self.area.draw(&PathElement::new(points, style))?),
            Stroke::Dashed => (14 * FINER, 8 * FINER),
            Stroke::Dotted => (5 * FINER, 6 * FINER),
        };
        Ok(self.area.draw(&DashedPathElement::new(points, drawn, gap, style))?)
    }

    /// A filled disc with a white rim.
    pub(super) fn disc(&self, at: At, radius: f64, color: RGBColor) -> Drawn {
        #[cfg(test)]
        note(Mark::Disc(at, color));
        let radius = radius * f64::from(FINER);
        let rim = 1.5 * f64::from(FINER);
        self.area.draw(&Circle::new(fine(at), (radius + rim) as i32, WHITE.filled()))?;
        Ok(self.area.draw(&Circle::new(fine(at), radius as i32, color.filled()))?)
    }

    /// A text; its point is at half its height.
    pub(super) fn text(&self, text: &str, at: At, kind: Type, anchor: Anchor) -> Drawn {
        #[cfg(test)]
        note(Mark::Text(text.to_owned()));
        // The box of a text counts the room for descenders; its letters stand a little high in it.
        let at = (at.0, at.1 + 0.12 * kind.size);
        Ok(self.area.draw(&Text::new(text.to_owned(), fine(at), kind.style(anchor)))?)
    }

    /// A text in lines of at most `width`, the first one at the point (its left end).
    pub(super) fn paragraph(&self, text: &str, at: At, width: f64, kind: Type) -> Drawn {
        let mut lines = vec![String::new()];
        for word in text.split_whitespace() {
            let last = lines.last().map_or("", String::as_str);
            let longer = if last.is_empty() { word.to_owned() } else { format!("{last} {word}") };
            match lines.last_mut() {
                Some(last) if last.is_empty() || self.width(&longer, kind) <= width => {
                    *last = longer;
                }
                _ => lines.push(word.to_owned()),
            }
        }
        for (i, line) in lines.iter().enumerate() {
            let y = at.1 + 1.45 * kind.size * i as f64;
            self.text(&self.shortened(line, width, kind), (at.0, y), kind, Anchor::Left)?;
        }
        Ok(())
    }

    /// A text cut to a width.
    pub(super) fn shortened(&self, text: &str, width: f64, kind: Type) -> String {
        let mut text = text.to_owned();
        while self.width(&text, kind) > width && text.chars().count() > 4 {
            text = text.chars().take(text.chars().count() - 2).collect::<String>() + "…";
        }
        text
    }

    /// A text on a white ground, readable over lines.
    pub(super) fn label(&self, text: &str, at: At, kind: Type, anchor: Anchor) -> Drawn {
        let (w, h) = (self.width(text, kind), kind.size);
        let left = match anchor {
            Anchor::Left => at.0,
            Anchor::Middle => at.0 - 0.5 * w,
            Anchor::Right => at.0 - w,
        };
        let (a, b) = ((left - 4.0, at.1 - 0.6 * h), (left + w + 4.0, at.1 + 0.6 * h));
        self.shape(&[a, (b.0, a.1), b, (a.0, b.1)], WHITE, 0.85)?;
        self.text(text, at, kind, anchor)
    }

    /// A text that runs upwards, its middle at the point.
    pub(super) fn upward(&self, text: &str, at: At, kind: Type) -> Drawn {
        #[cfg(test)]
        note(Mark::Text(text.to_owned()));
        let style = kind.style(Anchor::Middle).transform(FontTransform::Rotate270);
        Ok(self.area.draw(&Text::new(text.to_owned(), fine(at), style))?)
    }

    /// Width of a text.
    pub(super) fn width(&self, text: &str, kind: Type) -> f64 {
        let style = kind.style(Anchor::Left).into_text_style(&self.area);
        self.area
            .estimate_text_size(text, &style)
            .map_or(0.0, |(w, _)| f64::from(w) / f64::from(FINER))
    }
}
