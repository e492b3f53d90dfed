//! A drawing as PDF: one page of the size of the picture, curves as vectors, texts as text.
//!
//! The embedded font is written with the glyphs that occur and the characters that they stand for, so that texts can be
//! searched and copied (ISO 32000-1, 9.7 composite fonts, 9.10 extraction). No clock and no identifier: same drawing,
//! same bytes.

use super::PlotError;
use super::canvas::{Anchor, DROP, FINE, Ink, STROKE, Shape, Type, pattern};
use super::png::compress;
use super::render::Drawing;
use ab_glyph::{Font, FontRef};
use pdf_writer::types::{CidFontType, FontFlags, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use std::collections::BTreeMap;
use subsetter::GlyphRemapper;

/// Points of a pixel: 72 an inch, 96 for the pixels of a page.
const POINTS: f32 = 0.75;
const IDENTITY: SystemInfo = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };
/// Box round all glyphs of the two faces, thousandths of an em: `head` tables of DejaVu Sans 2.37, book and bold.
const GLYPH_BOX: Rect = Rect { x1: -1069.0, y1: -463.0, x2: 1975.0, y2: 1232.0 };
/// Height of capitals, thousandths of an em: `OS/2` table of DejaVu Sans 2.37.
const CAPITALS: f32 = 729.0;
/// Widths of the stems of the two faces, thousandths of an em; a hint for programs without the font.
const STEMS: [f32; 2] = [80.0, 140.0];

pub(super) fn pdf(drawing: &Drawing) -> Result<Vec<u8>, PlotError> {
    let [catalog, pages, page, contents, info] = [1, 2, 3, 4, 5].map(Ref::new);
    let mut faces = [EmbeddedFace::of(false)?, EmbeddedFace::of(true)?];
    let (width, height) = (drawing.width_px as f32 * POINTS, drawing.height_px as f32 * POINTS);
    let mut content = Content::new();
    content.transform([POINTS, 0.0, 0.0, -POINTS, 0.0, height]).set_line_join(LineJoinStyle::RoundJoin);
    drawing.shapes.iter().for_each(|shape| draw(&mut content, &mut faces, shape));

    let mut file = Pdf::new();
    file.catalog(catalog).pages(pages);
    file.pages(pages).kids([page]).count(1);
    file.document_info(info).title(TextStr(&drawing.title)).subject(TextStr(&drawing.description));
    let mut one = file.page(page);
    one.media_box(Rect::new(0.0, 0.0, width, height)).parent(pages).contents(contents);
    let mut resources = one.resources();
    let mut fonts = resources.fonts();
    for face in &faces {
        fonts.pair(Name(face.name()), face.reference(0));
    }
    fonts.finish();
    let mut states = resources.ext_g_states();
    for percent in 0..=100 {
        if drawing.shapes.iter().any(|shape| percent_opaque(shape.ink()) == percent) {
            let name = opacity_name(percent);
            states
                .insert(Name(name.as_bytes()))
                .start::<pdf_writer::writers::ExtGraphicsState>()
                .non_stroking_alpha(percent as f32 / 100.0);
        }
    }
    states.finish();
    resources.finish();
    one.finish();
    file.stream(contents, &compress(&content.finish())?).filter(Filter::FlateDecode);
    faces.iter().try_for_each(|face| face.write(&mut file))?;
    Ok(file.finish())
}

fn draw(content: &mut Content, faces: &mut [EmbeddedFace; 2], shape: &Shape) {
    let [red, green, blue] = <[u8; 3]>::from(shape.ink().rgb).map(|level| f32::from(level) / 255.0);
    content.set_stroke_rgb(red, green, blue).set_fill_rgb(red, green, blue);
    content.set_parameters(Name(opacity_name(percent_opaque(shape.ink())).as_bytes()));
    match shape {
        Shape::Line { points, dash, width_px, .. } => {
            let lengths = pattern(*dash).iter().map(|third| f32::from(*third) / FINE as f32);
            content.set_line_width(*width_px as f32).set_dash_pattern(lengths, 0.0);
            trace(content, points);
            content.stroke();
        }
        Shape::Area { corners, .. } => {
            trace(content, corners);
            content.fill_nonzero();
        }
        Shape::Rectangle { corners: [(x0, y0), (x1, y1)], .. } => {
            let [x, y, width, height] = [x0.min(*x1), y0.min(*y1), (x1 - x0).abs(), (y1 - y0).abs()];
            content.rect(x as f32, y as f32, width as f32, height as f32).fill_nonzero();
        }
        Shape::Circle { centre, radius_px, is_filled, .. } => {
            circle(content, *centre, *radius_px);
            if *is_filled {
                content.fill_nonzero();
            } else {
                content.set_line_width(STROKE as f32).set_dash_pattern([], 0.0).stroke();
            }
        }
        Shape::Text { text, at, anchor, face } => {
            faces[usize::from(face.bold)].show(content, text, *at, *anchor, *face)
        }
    }
}

fn trace(content: &mut Content, points: &[(f64, f64)]) {
    for (k, (x, y)) in points.iter().enumerate() {
        let (x, y) = (*x as f32, *y as f32);
        if k == 0 {
            content.move_to(x, y)
        } else {
            content.line_to(x, y)
        };
    }
}

/// A circle of four cubic curves, true to 3e-4 of the radius.
fn circle(content: &mut Content, centre: (f64, f64), radius: f64) {
    let (x, y) = centre;
    const HANDLE: f64 = 0.552_284_75;
    let at = |u: f64, v: f64| ((x + radius * u) as f32, (y + radius * v) as f32);
    let start = at(1.0, 0.0);
    content.move_to(start.0, start.1);
    for (u, v) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)] {
        // A quarter from (u, v) to (-v, u).
        let (a, b, end) = (at(u - HANDLE * v, v + HANDLE * u), at(HANDLE * u - v, HANDLE * v + u), at(-v, u));
        content.cubic_to(a.0, a.1, b.0, b.1, end.0, end.1);
    }
    content.close_path();
}

/// A face of the embedded font with the glyphs that were shown.
struct EmbeddedFace {
    is_bold: bool,
    bytes: &'static [u8],
    font: FontRef<'static>,
    glyphs: GlyphRemapper,
    /// Character and advance in thousandths of an em of each glyph, by its number in the subset.
    shown: BTreeMap<u16, (char, f32)>,
}

impl EmbeddedFace {
    fn of(is_bold: bool) -> Result<Self, PlotError> {
        let bytes = if is_bold { dejavu::sans::bold() } else { dejavu::sans::regular() };
        let font = FontRef::try_from_slice(bytes).map_err(PlotError::drawing)?;
        Ok(Self { is_bold, bytes, font, glyphs: GlyphRemapper::new(), shown: BTreeMap::new() })
    }

    fn name(&self) -> &'static [u8] {
        if self.is_bold { b"Bold" } else { b"Book" }
    }

    /// Objects of the face: font, its glyphs, their descriptor, file and characters.
    fn reference(&self, part: i32) -> Ref {
        Ref::new(if self.is_bold { 20 } else { 10 } + part)
    }

    fn per_em(&self, units: f32) -> f32 {
        1000.0 * units / self.font.units_per_em().unwrap_or(2048.0)
    }

    fn show(&mut self, content: &mut Content, text: &str, at: (f64, f64), anchor: Anchor, face: Type) {
        let (x, y) = at;
        let (mut numbers, mut width) = (vec![], 0.0);
        for character in text.chars() {
            let glyph = self.font.glyph_id(character);
            let advance = self.per_em(self.font.h_advance_unscaled(glyph));
            let number = self.glyphs.remap(glyph.0);
            self.shown.entry(number).or_insert((character, advance));
            numbers.extend(number.to_be_bytes());
            width += f64::from(advance) / 1000.0 * face.size_px;
        }
        let back = match anchor {
            Anchor::Left => 0.0,
            Anchor::Middle => 0.5 * width,
            Anchor::Right => width,
        };
        let drop = DROP * face.size_px;
        let matrix = if face.upright {
            [0.0, -1.0, -1.0, 0.0, (x + drop) as f32, (y + back) as f32]
        } else {
            [1.0, 0.0, 0.0, -1.0, (x - back) as f32, (y + drop) as f32]
        };
        content.begin_text().set_font(Name(self.name()), face.size_px as f32).set_text_matrix(matrix);
        content.show(Str(&numbers)).end_text();
    }

    fn write(&self, file: &mut Pdf) -> Result<(), PlotError> {
        let [font, glyphs, descriptor, program, characters] = [0, 1, 2, 3, 4].map(|part| self.reference(part));
        let name: &[u8] = if self.is_bold { b"MUSPIN+DejaVuSans-Bold" } else { b"MUSPIN+DejaVuSans" };
        file.type0_font(font)
            .base_font(Name(name))
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(glyphs)
            .to_unicode(characters);
        let mut own = file.cid_font(glyphs);
        own.subtype(CidFontType::Type2).base_font(Name(name)).system_info(IDENTITY).font_descriptor(descriptor);
        own.default_width(0.0).cid_to_gid_map_predefined(Name(b"Identity"));
        let mut widths = own.widths();
        for (number, (_, advance)) in &self.shown {
            widths.consecutive(*number, [*advance]);
        }
        widths.finish();
        own.finish();
        let [ascent, descent] = [self.font.ascent_unscaled(), self.font.descent_unscaled()].map(|u| self.per_em(u));
        file.font_descriptor(descriptor)
            .name(Name(name))
            .flags(FontFlags::SYMBOLIC)
            .bbox(GLYPH_BOX)
            .italic_angle(0.0)
            .ascent(ascent)
            .descent(descent)
            .cap_height(CAPITALS)
            .stem_v(STEMS[usize::from(self.is_bold)])
            .font_file2(program);
        let subset = subsetter::subset(self.bytes, 0, &self.glyphs);
        let subset = subset.map_err(PlotError::drawing)?;
        let packed = compress(&subset)?;
        file.stream(program, &packed).filter(Filter::FlateDecode).pair(Name(b"Length1"), subset.len() as i32);
        let mut map = UnicodeCmap::new(Name(b"Characters"), IDENTITY);
        self.shown.iter().for_each(|(number, (character, _))| map.pair(*number, *character));
        file.stream(characters, &compress(&map.finish())?).filter(Filter::FlateDecode);
        Ok(())
    }
}

fn percent_opaque(ink: Ink) -> u32 {
    (100.0 * ink.opacity).round().clamp(0.0, 100.0) as u32
}

fn opacity_name(percent: u32) -> String {
    format!("Opacity{percent}")
}
