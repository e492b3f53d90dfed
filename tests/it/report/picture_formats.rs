//! PNG and PDF of a picture hold what its SVG holds: read by the rules of the formats, not by what wrote them.

use crate::cli::program::muspin;
use flate2::Crc;
use flate2::read::ZlibDecoder;
use muspin::report::plot::figure::{Axis, Figure, Panel, Series, SeriesShape};
use muspin::report::plot::{Color, Dash, Drawing, Look, PictureFormat, picture};
use std::io::Read;

/// A bar over the whole plot area, and a dashed line through its middle height.
fn bar() -> Drawing {
    let mut panel = Panel::new("Panel of σ", Axis::linear("Position", "mm"), Axis::linear("Force", "N"));
    panel.x.range = Some([0.0, 1.0]);
    panel.y.range = Some([0.0, 2.0]);
    let look = Look::line(Color::Blue, Dash::Solid);
    let bar = Series { shape: SeriesShape::Bars { width: 1.0 }, ..Series::curve("bar", &[0.5], &[2.0], look) };
    let line = Series::curve("line", &[0.0, 1.0], &[1.0, 1.0], Look::line(Color::Vermillion, Dash::Dashed));
    panel.series = vec![bar, line];
    picture(&Figure::new("Bar of 2 N − µ", "A bar.", vec![panel])).unwrap().drawing.unwrap()
}

fn inflate(bytes: &[u8]) -> Vec<u8> {
    let mut out = vec![];
    ZlibDecoder::new(bytes).read_to_end(&mut out).unwrap();
    out
}

/// Width, height and pixels of a PNG of three bytes a pixel without filters; every checksum is checked.
fn read_png(file: &[u8]) -> (usize, usize, Vec<[u8; 3]>) {
    assert_eq!(&file[..8], b"\x89PNG\r\n\x1a\n");
    let number = |at: usize| u32::from_be_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    let (mut at, mut data, mut size) = (8, vec![], (0, 0));
    while at < file.len() {
        let (length, kind) = (number(at), &file[at + 4..at + 8]);
        let own = &file[at + 8..at + 8 + length];
        let mut sum = Crc::new();
        sum.update(&file[at + 4..at + 8 + length]);
        assert_eq!(sum.sum() as usize, number(at + 8 + length), "{kind:?}");
        match kind {
            b"IHDR" => {
                size = (number(at + 8), number(at + 12));
                assert_eq!(own[8..], [8, 2, 0, 0, 0]);
            }
            b"IDAT" => data.extend_from_slice(own),
            _ => {}
        }
        at += 12 + length;
    }
    let rows = inflate(&data);
    assert_eq!(rows.len(), size.1 * (1 + 3 * size.0));
    let row = |row: &[u8]| row[1..].chunks(3).map(|p| [p[0], p[1], p[2]]).collect::<Vec<_>>();
    (size.0, size.1, rows.chunks(1 + 3 * size.0).flat_map(row).collect())
}

#[test]
fn png_has_three_pixels_for_one_of_the_report_and_the_colours_of_what_is_drawn() {
    let file = bar().file(PictureFormat::Png).unwrap();
    assert_eq!(file, bar().file(PictureFormat::Png).unwrap());
    let (width, height, pixels) = read_png(&file);
    let svg = String::from_utf8(bar().file(PictureFormat::Svg).unwrap()).unwrap();
    let [svg_width, svg_height] = ["width=\"", "height=\""]
        .map(|key| svg.split(key).nth(1).unwrap().split('"').next().unwrap().parse::<f64>().unwrap());
    assert_eq!((width as f64, height as f64), (3.0 * svg_width, 3.0 * svg_height.ceil()));
    // The plot area by the axes in the SVG, in thirds of a pixel of the report: those of the PNG.
    let area = svg.split("\"r\":[").nth(1).unwrap().split(']').next().unwrap();
    let area: Vec<usize> = area.split(',').map(|px| px.parse::<f64>().unwrap() as usize).collect();
    let (left, top, right, bottom) = (area[0], area[1], area[2], area[3]);
    let at = |x: usize, y: usize| pixels[y * width + x];
    let (blue, vermillion) = ([0, 114, 178], [213, 94, 0]);
    assert_eq!(at((left + right) / 2, (3 * top + bottom) / 4), blue);
    assert_eq!(at((left + right) / 2, (top + 3 * bottom) / 4), blue);
    assert_eq!([at(2, 2), at(width - 3, height - 3)], [[255; 3]; 2]);
    // The pattern of a dashed line is 21 thirds of line and 10 of gap.
    let middle: Vec<[u8; 3]> = (left + 12..right - 12).map(|x| at(x, (top + bottom) / 2)).collect();
    let share = middle.iter().filter(|p| **p == vermillion).count() as f64 / middle.len() as f64;
    assert!((share - 21.0 / 31.0).abs() < 0.05, "{share}");
    // Bold type of the title: some pixels are as dark as it is.
    assert!(pixels[..34 * 3 * width].iter().filter(|p| p[0] < 60).count() > 500);
}

/// The streams of a PDF by object number, inflated.
fn streams(file: &[u8]) -> Vec<(usize, Vec<u8>)> {
    let find = |what: &[u8], from: usize| file[from..].windows(what.len()).position(|w| w == what).map(|k| from + k);
    let (mut at, mut found) = (0, vec![]);
    while let Some(begin) = find(b"\nstream\n", at).or_else(|| find(b"stream\r\n", at)) {
        let end = find(b"endstream", begin).unwrap();
        let head = String::from_utf8_lossy(&file[..begin]).into_owned();
        let number = head.rsplit(" 0 obj").nth(1).unwrap().rsplit('\n').next().unwrap().trim().parse().unwrap();
        found.push((number, inflate(&file[begin + 8..end])));
        at = end + 9;
    }
    found
}

/// Bytes of a content stream with the escapes of its literal strings replaced (ISO 32000-1, 7.3.4.2).
fn unescape(content: &[u8]) -> Vec<u8> {
    let (mut at, mut out) = (0, vec![]);
    while let Some(byte) = content.get(at) {
        let next = content.get(at + 1).copied().unwrap_or_default();
        let digits = content[at + 1..].iter().take(3).take_while(|c| (b'0'..=b'7').contains(c)).count();
        let (value, taken) = match (byte, next) {
            (b'\\', b'0'..=b'7') => {
                let octal = std::str::from_utf8(&content[at + 1..at + 1 + digits]).unwrap();
                (u8::from_str_radix(octal, 8).unwrap(), 1 + digits)
            }
            (b'\\', b'n') => (b'\n', 2),
            (b'\\', b'r') => (b'\r', 2),
            (b'\\', b't') => (b'\t', 2),
            (b'\\', b'b') => (8, 2),
            (b'\\', b'f') => (12, 2),
            (b'\\', other) => (other, 2),
            (plain, _) => (*plain, 1),
        };
        out.push(value);
        at += taken;
    }
    out
}

#[test]
fn pdf_has_its_cross_references_right_and_its_texts_as_characters() {
    let file = bar().file(PictureFormat::Pdf).unwrap();
    assert_eq!(file, bar().file(PictureFormat::Pdf).unwrap());
    let text = String::from_utf8_lossy(&file);
    assert!(text.starts_with("%PDF-1.") && text.trim_end().ends_with("%%EOF"));
    let bytes_at = |at: usize, what: &str| file[at..].starts_with(what.as_bytes());
    let start: usize = text.rsplit("startxref").next().unwrap().split_whitespace().next().unwrap().parse().unwrap();
    assert!(bytes_at(start, "xref"));
    let table = String::from_utf8_lossy(&file[start..]).into_owned();
    for (number, line) in table.lines().skip(2).take_while(|l| !l.starts_with("trailer")).enumerate() {
        let parts: Vec<&str> = line.split_whitespace().collect();
        if parts[2] == "n" {
            assert!(bytes_at(parts[0].parse().unwrap(), &format!("{number} 0 obj")), "{line}");
        }
    }
    let streams = streams(&file);
    let stream = |number: usize| &streams.iter().find(|(k, _)| *k == number).unwrap().1;
    // Glyph numbers to characters: the fourth object behind each font.
    let map = |number: usize| -> Vec<(u16, char)> {
        let text = String::from_utf8_lossy(stream(number)).into_owned();
        let hex = |word: &str| u32::from_str_radix(word.trim_matches(['<', '>']), 16).ok();
        let pairs = text.lines().filter_map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            (words.len() == 2 && words.iter().all(|w| w.starts_with('<'))).then(|| (hex(words[0]), hex(words[1])))
        });
        pairs.map(|(glyph, c)| (glyph.unwrap() as u16, char::from_u32(c.unwrap()).unwrap())).collect()
    };
    let of_bold = map(24);
    let glyphs: Vec<u16> =
        "Bar of 2 N − µ".chars().map(|c| of_bold.iter().find(|(_, own)| *own == c).unwrap().0).collect();
    let shown: Vec<u8> = glyphs.iter().flat_map(|glyph| glyph.to_be_bytes()).collect();
    let content = stream(4);
    assert!(unescape(content).windows(shown.len()).any(|w| w == shown), "the title is not shown by its glyphs");
    // Blue bar as a rectangle, dashed vermillion line.
    let content = String::from_utf8_lossy(content).into_owned();
    assert!(content.contains(" re\n") && content.contains("[7 3.3333333] 0 d"), "{content}");
}

#[test]
fn commands_write_the_formats_that_are_asked_for_and_their_manifest_lists_them() {
    let folder = tempfile::tempdir().unwrap();
    let names = |out: &str| -> Vec<String> {
        let entries = std::fs::read_dir(folder.path().join(out).join("plots")).unwrap();
        let mut all: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        all.sort();
        all
    };
    let modes = |more: &[&str]| {
        let plain = ["modes", "--spindle", "reference", "--speeds", "20000", "--out", "m", "--quiet"];
        let (code, _, err) = muspin(&[&plain, more].concat(), folder.path());
        assert_eq!(code, 0, "{err}");
    };
    modes(&["--format", "png,pdf"]);
    assert_eq!(names("m"), ["csv", "pdf", "png", "svg"].map(|end| format!("whirl_shapes.{end}")));
    let manifest = std::fs::read_to_string(folder.path().join("m/muspin-manifest.json")).unwrap();
    assert!(["pdf", "png"].iter().all(|end| manifest.contains(&format!("plots/whirl_shapes.{end}"))));
    // What is not asked for any more goes.
    modes(&[]);
    assert_eq!(names("m"), ["csv", "svg"].map(|end| format!("whirl_shapes.{end}")));
    let (code, _, err) = muspin(&["modes", "--format", "jpg"], folder.path());
    assert_eq!(code, 2);
    assert!(err.contains("svg, png, pdf"), "{err}");
    let (code, _, err) = muspin(&["modes", "--format", "png"], folder.path());
    assert_eq!(code, 2);
    assert!(err.contains("name a folder with --out"), "{err}");
}
