#!/usr/bin/env python3
"""Comments and pages that a reader of the field understands (docs/conventions.md#comments). Usage: language_test.py SOURCE_DIR

A comment, a cell of the reference or the message of an assertion does not begin with a word that leans on the text beside
it, no comment or page speaks of things as of people, and the name of a test has at most six words.
"""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "support"))
from tracked import tracked  # noqa: E402

HEADLESS = re.compile(r"(of|that|by|who|whom|whose|which|it|the same)\b", re.IGNORECASE)
HEADLESS_MESSAGE = re.compile(HEADLESS.pattern + r"|(and|so)\b", re.IGNORECASE)
PEOPLE = re.compile(r"\b(told|somebody|whoever|nobody)\b", re.IGNORECASE)
MESSAGE = re.compile(r'\b(?:EXPECT|ASSERT)_\w+\([^;]*?\)\s*<<\s*"((?:\\.|[^"\\])*)"')
COMMENT = re.compile(r'^((?:[^"/]|"(?:\\.|[^"\\])*"|/(?!/))*)//[/!]?<?\s?(.*)$')

TEST = re.compile(r"\b(?:TYPED_TEST_P|TYPED_TEST|TEST_P|TEST_F|TEST)\(\s*\w+,\s*(\w+)\s*\)")
WORD = re.compile(r"[A-Z][a-z0-9]*|[A-Z]+(?![a-z])|[0-9]+")
MOST_WORDS = 6  # of a test's name


def code_comments(text):
    """Line, text and whether it begins a comment, of each comment line."""
    after_comment = False
    for number, line in enumerate(text.splitlines(), 1):
        match = COMMENT.match(line)
        alone = bool(match) and not match.group(1).strip()
        if match:
            yield number, match.group(2), not (alone and after_comment)
        after_comment = alone


def cells(text):
    for number, line in enumerate(text.splitlines(), 1):
        for cell in line.split("|")[1:-1]:
            yield number, re.sub(r"^\[[^\]]*\]\s*", "", cell.strip())


def messages(text):
    """Line and first string of each message that is streamed into an assertion."""
    for match in MESSAGE.finditer(text):
        yield text.count("\n", 0, match.start(1)) + 1, match.group(1)


def faults(root):
    for path in tracked(root, "*.cpp", "*.hpp", "*.md"):
        name = str(path.relative_to(root))
        if path.suffix in (".cpp", ".hpp"):
            for number, comment, begins in code_comments(path.read_text()):
                if begins and HEADLESS.match(comment):
                    yield name, number, comment
                elif PEOPLE.search(comment):
                    yield name, number, comment
            for number, message in messages(path.read_text()):
                if HEADLESS_MESSAGE.match(message):
                    yield name, number, message
            for number, line in enumerate(path.read_text().splitlines(), 1):
                for test in TEST.findall(line):
                    if len(WORD.findall(test)) > MOST_WORDS:
                        yield name, number, f"{test}: expected at most {MOST_WORDS} words"
        elif path.suffix == ".md":
            text = path.read_text()
            if name == "docs/reference.md":
                for number, cell in cells(text):
                    if HEADLESS.match(cell):
                        yield name, number, cell
            for number, line in enumerate(text.splitlines(), 1):
                if PEOPLE.search(line):
                    yield name, number, line.strip()


def main():
    found = [f"{name}:{number}: {comment}" for name, number, comment in faults(pathlib.Path(sys.argv[1]).resolve())]
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
