#!/usr/bin/env python3
"""One spelling: no word of words.txt stands in a file of the project. Usage: spelling_test.py SOURCE_DIR

Words are found within identifiers too, whether their parts are joined by capitals or by underscores.
"""
import pathlib
import re
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from tracked import tracked

TEXT = {".cpp", ".hpp", ".py", ".sh", ".md", ".yaml", ".yml", ".txt", ".cmake", ".in", ".json", ".cff", ".html", ".css", ".js",
        ".glsl", ""}
APART = {"tests/house/words.txt", "LICENSE"}  # the list itself, and the text of the license
GIVEN_UP_IN = {"CHANGELOG.md"}  # may name what was given up
WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")


def forbidden(root):
    words, names = [], []
    for line in (root / "tests/house/words.txt").read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        pattern, better = line.split(maxsplit=1)
        (names if "_" in pattern else words).append((re.compile(pattern), better))
    return words, names


def violations(root):
    words, names = forbidden(root)
    known = {}  # word -> what to write, or None

    def better_than(word):
        if word not in known:
            known[word] = next((better for pattern, better in words if pattern.fullmatch(word)), None)
        return known[word]

    for file in tracked(root):
        path = file.relative_to(root)
        if path.suffix not in TEXT or str(path) in APART:
            continue
        try:
            lines = file.read_text().splitlines()
        except UnicodeDecodeError:
            continue
        for number, line in enumerate(lines, 1):
            for word in {w.lower() for w in WORD.findall(line)}:
                if better := better_than(word):
                    yield f"{path}:{number}: '{word}': write '{better}'"
            for pattern, better in names:
                if pattern.search(line) and str(path) not in GIVEN_UP_IN:
                    yield f"{path}:{number}: '{pattern.pattern}': write '{better}'"


def main():
    found = list(violations(pathlib.Path(sys.argv[1])))
    print("\n".join(found))
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
