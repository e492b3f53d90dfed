//! Names that become names of files and folders, on any system, and words of a command line.

/// Longest name, bytes of UTF-8: file systems take 255, and endings and what differs of a variant stand behind it.
pub const LONGEST_BYTES: usize = 128;
/// What names may hold besides letters and digits.
const MARKS: &str = " ._+-";
/// Names that Windows keeps for devices, with any extension.
const DEVICES: [&str; 6] = ["con", "prn", "aux", "nul", "conin$", "conout$"];
/// The same before a digit.
const NUMBERED_DEVICES: [&str; 2] = ["com", "lpt"];

/// Whether a name can be that of a file or folder and a word of a command line.
///
/// # Errors
/// The rule that it breaks, to be put behind the name.
pub fn check_name(name: &str) -> Result<(), String> {
    if name.is_empty() {
        return Err("is empty".to_owned());
    }
    if name.len() > LONGEST_BYTES {
        return Err(format!("has {} bytes, {LONGEST_BYTES} at most are possible", name.len()));
    }
    let is_allowed = |c: char| c.is_alphanumeric() || is_accent(c) || MARKS.contains(c);
    if let Some(other) = name.chars().find(|c| !is_allowed(*c)) {
        return Err(format!("has {other:?} in it; letters, digits, spaces and . _ + - are possible"));
    }
    if name.starts_with([' ', '.', '-']) || name.ends_with([' ', '.']) || name.starts_with(is_accent) {
        return Err("begins or ends with a mark that file systems or command lines take for something else".to_owned());
    }
    if is_device(name) {
        return Err("is kept for a device by Windows".to_owned());
    }
    Ok(())
}

/// Marks that stand above or below the letter before (Unicode, Combining Diacritical Marks).
fn is_accent(c: char) -> bool {
    ('\u{300}'..='\u{36f}').contains(&c)
}

fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_lowercase();
    let numbered = |device: &str| {
        let rest = stem.strip_prefix(device).unwrap_or_default();
        // Windows takes the raised digits for digits as well.
        let mut digits = rest.chars();
        digits.next().is_some_and(|c| c.is_ascii_digit() || "¹²³".contains(c)) && digits.next().is_none()
    };
    DEVICES.contains(&stem.as_str()) || NUMBERED_DEVICES.iter().any(|device| numbered(device))
}
