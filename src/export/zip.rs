//! A zip archive of stored (uncompressed) files, as APPNOTE 6.3 sections 4.3.7, 4.3.12 and 4.3.16 have it: the same
//! files give the same bytes.

use flate2::Crc;

/// Signatures of a file, of its entry in the directory, and of the end.
const FILE: u32 = 0x0403_4b50;
const ENTRY: u32 = 0x0201_4b50;
const END: u32 = 0x0605_4b50;
/// Version that an unpacker needs.
const VERSION: u16 = 10;
/// The first day that the format knows, 1980-01-01: an archive has no clock.
const DAY: u16 = 0x21;

/// The bytes of an archive of files, each a path with `/` and its bytes; none where it is larger than the format's
/// 32-bit sizes or has more than 65 535 files.
pub(crate) fn zip(files: &[(String, Vec<u8>)]) -> Option<Vec<u8>> {
    let (mut archive, mut directory) = (Vec::new(), Vec::new());
    for (name, bytes) in files {
        let mut crc = Crc::new();
        crc.update(bytes);
        let offset = u32::try_from(archive.len()).ok()?;
        let size = u32::try_from(bytes.len()).ok()?;
        let mut fields = Vec::new();
        // Version, flags, method (stored), time, day; checksum; both sizes; lengths of name and further fields.
        [VERSION, 0, 0, 0, DAY].iter().for_each(|n| fields.extend(n.to_le_bytes()));
        [crc.sum(), size, size].iter().for_each(|n| fields.extend(n.to_le_bytes()));
        [u16::try_from(name.len()).ok()?, 0].iter().for_each(|n| fields.extend(n.to_le_bytes()));
        archive.extend(FILE.to_le_bytes());
        archive.extend(&fields);
        archive.extend(name.as_bytes());
        archive.extend(bytes);
        directory.extend(ENTRY.to_le_bytes());
        directory.extend(VERSION.to_le_bytes());
        directory.extend(&fields);
        // No comment, first disk, no attributes.
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let count = u16::try_from(files.len()).ok()?.to_le_bytes();
    let (at, size) = (u32::try_from(archive.len()).ok()?, u32::try_from(directory.len()).ok()?);
    archive.extend(directory);
    archive.extend(END.to_le_bytes());
    archive.extend([0; 4]);
    archive.extend(count);
    archive.extend(count);
    archive.extend(size.to_le_bytes());
    archive.extend(at.to_le_bytes());
    archive.extend([0; 2]);
    Some(archive)
}
