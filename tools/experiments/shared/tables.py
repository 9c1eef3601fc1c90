# SPDX-License-Identifier: BSD-3-Clause
"""Numbers, tables and files as text."""
import math
import os
import re


def short_number(value, digits):
    """`digits` significant digits, plain or in powers of ten; "-" for what is not finite."""
    if not math.isfinite(value):
        return "-"
    if value != 0.0 and not 1e-3 <= abs(value) < 1e6:
        return f"{value:.{max(digits - 1, 0)}e}"
    whole = math.floor(math.log10(abs(value))) + 1 if value else 1
    return f"{value:.{max(digits - whole, 0)}f}"


def write_file(path, text):
    """Writes a file as a whole: a reader never sees half of it."""
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)


def markdown(rows, notes=True):
    """The table of results as Markdown."""
    columns = ["what", "published", "tolerance", "ours", "verdict"] + (["note"] if notes else [])
    lines = [columns, ["---"] * len(columns)]
    lines += [[(row[column] or ("" if column in ("note", "tolerance") else "-")).replace("|", "\\|") for column in columns] for row in rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def read_markdown(text):
    """The tables of a page in Markdown: for each a list of rows, {column: cell}."""
    for block in re.findall(r"(?:^\|.*\n)+", text, re.M):
        columns, _, *rows = ([cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in block.splitlines())
        yield [dict(zip(columns, row)) for row in rows]
