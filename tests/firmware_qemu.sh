#!/usr/bin/env bash
# Compiles an exported controller for Cortex-M4F and M7 and runs its test vectors in QEMU, bit for bit; counts
# the instructions of a sample.
# usage: tests/firmware_qemu.sh [FOLDER]   a folder with controller.h, controller.c and test_vectors.csv;
#        default results/reference/controller. Debian packages: gcc-arm-none-eabi libnewlib-arm-none-eabi
#        qemu-system-arm. Exit 0 all equal; 1 a difference; 77 a program is missing.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
folder="$(cd "${1:-$here/../results/reference/controller}" && pwd)"
for program in arm-none-eabi-gcc qemu-system-arm; do
    if ! command -v "$program" >/dev/null; then
        echo "firmware in QEMU: skipped, $program is not installed"
        exit 77
    fi
done
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

# The vectors as C tables. Columns: sample, then y (m), u (A), y (Q31), u (Q31), four axes each.
awk -F, '
    NR == 1 { if (NF != 17) { print "test_vectors.csv: expected 17 columns" > "/dev/stderr"; exit 1 } next }
    { for (k = 0; k < 4; ++k) row[k] = row[k] "{" join(k) "}," ; ++count }
    function join(k,   text, j) {
        text = ""
        for (j = 2 + 4 * k; j < 6 + 4 * k; ++j) text = text $j (k < 2 ? ($j ~ /[.e]/ ? "f" : ".0f") : "") ","
        return text
    }
    END {
        print "#define VECTORS " count
        print "static const float vector_y[][4] = {" row[0] "};\nstatic const float vector_u[][4] = {" row[1] "};"
        print "static const int32_t vector_yq[][4] = {" row[2] "};\nstatic const int32_t vector_uq[][4] = {" row[3] "};"
    }' "$folder/test_vectors.csv" >"$work/vectors.h"

failed=0
run() { # cpu fpu board standard
    local flags=(-mcpu="$1" -mthumb -mfpu="$2" -mfloat-abi=hard -O2 -Wall -Wextra -Werror -I"$folder" -I"$work")
    [ -z "$4" ] || flags+=("$4")
    arm-none-eabi-gcc "${flags[@]}" -c "$folder/controller.c" -o "$work/controller.o"
    arm-none-eabi-gcc "${flags[@]}" -std=gnu11 -DCOUNT_INSTRUCTIONS --specs=rdimon.specs -nostartfiles \
        -T "$here/firmware/mps2.ld" "$here/firmware/boot.c" "$here/firmware/vectors.c" "$work/controller.o" -o "$work/run.elf"
    echo "$1, ${4:-default standard of the compiler}:"
    timeout 60 qemu-system-arm -M "$3" -nographic -semihosting -icount shift=0 -kernel "$work/run.elf" || failed=1
}
for standard in -std=c99 ""; do
    run cortex-m4 fpv4-sp-d16 mps2-an386 "$standard"
    run cortex-m7 fpv5-sp-d16 mps2-an500 "$standard"
done
exit "$failed"
