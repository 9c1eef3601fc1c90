#!/usr/bin/env python3
"""No instruction of the program has a result that the maker of the processor chooses, or that rounds once for two.

    instructions_test.py SWIFTLET

Approximate reciprocals and roots (rcpps, rsqrtps) have other last bits by Intel and by AMD. Eigen takes them for the
square root of float arrays. Fused multiply-adds round once, where others round twice.
"""
import re
import shutil
import subprocess
import sys

CHOSEN = re.compile(r"\t(v?r(?:cp|sqrt)(?:ps|ss|14\w*|28\w*)|vfn?m(?:add|sub)\w*)\b")


def chosen_instructions(lines):
    """(function, instruction) of each that is not fixed to the last bit."""
    function = "?"
    for line in lines:
        if line.endswith(">:\n"):
            function = line[line.index("<") + 1 : -3]
        elif found := CHOSEN.search(line):
            yield function, found[1]


def main():
    if shutil.which("objdump") is None:
        print("objdump (binutils) is not installed")
        return 77
    sample = ["0000 <there>:\n", "  1:\tvrsqrtps %ymm0,%ymm1\n", "  2:\tvsqrtps %ymm0,%ymm1\n", "  3:\tvfmadd231ps %ymm0\n"]
    assert list(chosen_instructions(sample)) == [("there", "vrsqrtps"), ("there", "vfmadd231ps")]
    command = ["objdump", "--disassemble", "--demangle", "--no-show-raw-insn", sys.argv[1]]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as dump:
        found = sorted(set(chosen_instructions(dump.stdout)))
    if dump.returncode != 0:
        return f"objdump failed with {dump.returncode}"
    for function, instruction in found:
        print(f"{instruction} in {function}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
