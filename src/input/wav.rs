//! Samples of a RIFF WAVE file: whole numbers of 16, 24 and 32 bit as shares of full scale, floating-point numbers of
//! 32 and 64 bit as they are (Microsoft, Multiple channel audio data and WAVE files, 2007).

use super::error::InputError;

/// Codes of whole and of floating-point samples, and of those whose code stands in the extension.
const WHOLE: u16 = 1;
const FLOATING: u16 = 3;
const EXTENSIBLE: u16 = 0xFFFE;
/// Where the extension has the code.
const EXTENDED_CODE: usize = 24;

/// Sample rate, Hz, and the samples of every channel.
///
/// # Errors
/// [`InputError`] for what is no such file.
pub fn read_wav(file: &str, bytes: &[u8]) -> Result<(f64, Vec<Vec<f64>>), InputError> {
    let fail = |rule: &str| {
        InputError::new(file, rule)
            .with_hint("write it as WAV with whole samples of 16, 24 or 32 bit, or floating point")
    };
    let half = |at: &[u8], k: usize| at.get(k..k + 2).map(|b| u16::from_le_bytes([b[0], b[1]]));
    let word = |at: &[u8], k: usize| at.get(k..k + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if !(bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WAVE")) {
        return Err(fail("is no RIFF WAVE file"));
    }
    let (mut format, mut rest) = (None, &bytes[12..]);
    while let (Some(name), Some(length)) = (rest.get(..4), word(rest, 4)) {
        let length = length as usize;
        let body = &rest[8..];
        let own = &body[..length.min(body.len())];
        if name == b"fmt " {
            let extended = half(own, EXTENDED_CODE).unwrap_or(0);
            let code = half(own, 0).map(|code| if code == EXTENSIBLE { extended } else { code });
            format = code.zip(half(own, 2)).zip(word(own, 4)).zip(half(own, 14));
        } else if name == b"data" {
            let Some((((code, channels), rate), bits)) = format else {
                return Err(fail("has samples before their format"));
            };
            let size = usize::from(bits / 8);
            let read: fn(&[u8]) -> f64 = match (code, bits) {
                (WHOLE, 16) => |b| f64::from(i16::from_le_bytes([b[0], b[1]])) / 2f64.powi(15),
                (WHOLE, 24) => |b| f64::from(i32::from_le_bytes([0, b[0], b[1], b[2]])) / 2f64.powi(31),
                (WHOLE, 32) => |b| f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])) / 2f64.powi(31),
                (FLOATING, 32) => |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
                (FLOATING, 64) => |b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]),
                _ => return Err(fail(&format!("has samples of code {code} with {bits} bit"))),
            };
            if channels == 0 || rate == 0 {
                return Err(fail("has no channel or no sample rate"));
            }
            let channels = usize::from(channels);
            let channel = |k: usize| own.chunks_exact(size).skip(k).step_by(channels).map(read).collect();
            let mut all: Vec<Vec<f64>> = (0..channels).map(channel).collect();
            let shortest = all.iter().map(Vec::len).min().unwrap_or(0);
            all.iter_mut().for_each(|samples| samples.truncate(shortest));
            let finite = all.iter().flatten().all(|x| x.is_finite());
            return if finite { Ok((f64::from(rate), all)) } else { Err(fail("has a sample that is not a number")) };
        }
        // Chunks begin at even bytes.
        rest = body.get(length.saturating_add(length % 2)..).unwrap_or_default();
    }
    Err(fail("has no samples"))
}
