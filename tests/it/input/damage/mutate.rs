//! Damage to files as it happens: cut off, bits flipped, lines lost or doubled, numbers and words exchanged.

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// What is put in place of a number.
const NUMBERS: [&str; 22] = [
    "0",
    "-0.0",
    "-1",
    "1e-320",
    "1e308",
    "-1e308",
    "1e400",
    ".nan",
    ".inf",
    "NaN",
    "Infinity",
    "null",
    "true",
    "1e",
    "0x1F",
    "1_000",
    "1,5",
    "\"1\"",
    "[]",
    "{}",
    "99999999999999999999",
    "4294967296",
];
/// What is put anywhere.
const PIECES: [&[u8]; 22] = [
    b"\0",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\"",
    b"{",
    b"}",
    b"[",
    b"]",
    b"&a ",
    b"*a",
    b"!!str ",
    b"%",
    b"\r",
    b"\t",
    b"#",
    b"---\n",
    b"...\n",
    b",",
    b": ",
    b"- ",
    b"? ",
    b"    -1\n",
];

/// The file with one to four damages.
pub fn damaged(file: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..random.random_range(1..5) {
        if bytes.is_empty() {
            break;
        }
        bytes = once(bytes, random);
    }
    bytes
}

fn once(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let at = random.random_range(0..bytes.len());
    match random.random_range(0..12) {
        0 => bytes.truncate(at),
        1 | 2 => bytes[at] ^= 1 << random.random_range(0..8),
        3 => bytes[at] = random.random(),
        4 => {
            let length = [1, 2, 5, 50, 500][random.random_range(0..5)];
            bytes.drain(at..bytes.len().min(at + length));
        }
        5 => {
            let piece = PIECES[random.random_range(0..PIECES.len())];
            let times = [1, 1, 1, 3, 200][random.random_range(0..5)];
            bytes.splice(at..at, piece.repeat(times));
        }
        6..=8 => number(&mut bytes, at, random),
        kind => bytes = lines(&bytes, kind, random),
    }
    bytes
}

/// The number behind a place becomes another one.
fn number(bytes: &mut Vec<u8>, at: usize, random: &mut ChaCha8Rng) {
    let is_part = |b: &u8| b.is_ascii_digit() || b"+-.e".contains(b);
    let Some(from) = bytes[at..].iter().position(u8::is_ascii_digit).map(|k| at + k) else {
        return;
    };
    let to = bytes[from..].iter().position(|b| !is_part(b)).map_or(bytes.len(), |k| from + k);
    let text = match random.random_range(0..3) {
        0 => format!("{:e}", 10f64.powf(random.random_range(-320.0..308.0))),
        _ => NUMBERS[random.random_range(0..NUMBERS.len())].to_owned(),
    };
    bytes.splice(from..to, text.into_bytes());
}

/// A line lost, doubled, or exchanged with another one.
fn lines(bytes: &[u8], kind: usize, random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut lines: Vec<&[u8]> = bytes.split(|b| *b == b'\n').collect();
    let (i, j) = (random.random_range(0..lines.len()), random.random_range(0..lines.len()));
    match kind {
        9 => {
            lines.remove(i);
        }
        10 => lines.insert(j, lines[i]),
        _ => lines.swap(i, j),
    }
    lines.join(&b'\n')
}
