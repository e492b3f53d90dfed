//! The flexible shaft: sections, Timoshenko elements, assembly, modes, reduction with static correction.
