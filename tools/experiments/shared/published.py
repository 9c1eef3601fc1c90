# SPDX-License-Identifier: BSD-3-Clause
"""The published figures of published.csv."""
import csv
import dataclasses
import math
import pathlib
import re

FILE = pathlib.Path(__file__).parent.parent / "published.csv"


@dataclasses.dataclass(frozen=True)
class Figure:
    """One published figure: `text` as printed, `value` and `deviation` as numbers, NaN where the text has none."""
    text: str
    source: str
    value: float
    deviation: float


def _number(text):
    match = re.match(r"\s*([-+]?[\d.]+(?:e[-+]?\d+)?)", text)
    return float(match[1]) if match else math.nan


def _figures():
    with FILE.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            value, _, deviation = row["published"].partition(" ± ")
            yield (row["experiment"], row["what"]), Figure(row["published"], row["source"], _number(value), _number(deviation))


FIGURES = dict(_figures())


def find(experiment, what):
    """The figure of a row, or None. A name that begins with a star in the file stands for any beginning."""
    exact = FIGURES.get((experiment, what))
    if exact is not None:
        return exact
    return next((figure for (name, pattern), figure in FIGURES.items()
                 if name == experiment and pattern.startswith("*") and what.endswith(pattern[1:])), None)
