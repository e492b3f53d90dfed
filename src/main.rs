//! The command-line program: parse, run, exit with the documented code.

/// Designs and diagnoses allocate millions of small matrices: they take about a tenth less time with this allocator
/// than with that of glibc.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Error on a processor that would stop at an instruction that it does not know.
const TOO_OLD: &str = "error: this program was built for processors with AVX2, FMA and BMI2, which this one lacks\n\n\
    hint: build it with RUSTFLAGS=\"-C target-cpu=x86-64\" in the environment";

fn main() -> std::process::ExitCode {
    if !processor_suffices() {
        eprintln!("{TOO_OLD}");
        return std::process::ExitCode::from(2);
    }
    muspin::cli::main()
}

/// Whether the processor knows the instructions of `.cargo/config.toml`. The standard library takes those that a
/// program is built with for granted, so the processor itself is asked (Intel 64 manual, volume 2A, CPUID).
#[inline(never)]
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
fn processor_suffices() -> bool {
    use std::arch::x86_64::__cpuid_count;
    const LAST_LEAF: u32 = 7;
    const FMA: u32 = 1 << 12;
    const AVX2: u32 = 1 << 5;
    const BMI2: u32 = 1 << 8;
    if __cpuid_count(0, 0).eax < LAST_LEAF {
        return false;
    }
    let extended = __cpuid_count(LAST_LEAF, 0).ebx;
    __cpuid_count(1, 0).ecx & FMA != 0 && extended & AVX2 != 0 && extended & BMI2 != 0
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
fn processor_suffices() -> bool {
    true
}
