#!/usr/bin/env python3
"""Plain English: no sentence of the pages, docs/ and headers has more than 25 words. Usage: sentences_test.py SOURCE_DIR

Of a page, code, tables, pictures and headings are no sentences; of the generated reference the cells are. Of a header the
comments are read, without formulas, which are indented by three blanks. A word is what stands between blanks and has a letter.
`Code`, the text of a link and a citation count as what the reader sees of them: one word, its words, none.
"""
import pathlib
import re
import sys

MAX_WORDS = 25
PAGES = ("README.md", "CONTRIBUTING.md", "SECURITY.md", "docs/*.md")
REFERENCE = "docs/reference.md"  # its texts are cells of tables
HEADERS = ("include/**/*.hpp", "core/**/*.hpp", "sim/**/*.hpp")

COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
FENCE = re.compile(r"^ *(```|~~~).*?^ *\1[^\n]*$", re.MULTILINE | re.DOTALL)
NO_TEXT = re.compile(r"\s*(#|\||<|!\[|---)| {6,}\S")
ITEM = re.compile(r"\s*([-*]|\d+\.)\s+")
CODE = re.compile(r"`[^`]*`")
LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")
CITATION = re.compile(r"\[(Vrba|Kamler|Pritzl|Orsulic)[^\]]*\]")
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|al|approx|cf|ch|eqs?|figs?|no|refs?|sec|vs)\.", re.IGNORECASE)
END = re.compile(r"(?<=[.!?])[\")*]*\s+")


SAID = re.compile(r"(^ *|\s)//(?:/<?)?( .*|$)")  # what a comment says, on a line of its own or behind code


def blanked(match):
    return re.sub(r"[^\n]", "", match.group(0))


def paragraphs(text):
    """Number of its first line, and text, of each paragraph and of each item of a list."""
    gathered, first = [], 0
    for number, line in enumerate(FENCE.sub(blanked, COMMENT.sub(blanked, text)).splitlines() + [""], 1):
        is_text = line.strip() and not NO_TEXT.match(line)
        item = ITEM.match(line)
        if gathered and (item or not is_text):
            yield first, " ".join(gathered)
            gathered = []
        if is_text:
            first = first if gathered else number
            gathered.append(line[item.end():] if item else line.strip())


def cells(text):
    """Paragraphs, and each cell of a table."""
    yield from paragraphs(text)
    for number, line in enumerate(text.splitlines(), 1):
        for cell in line.split("|")[1:-1]:
            yield number, cell


def comments(text):
    """Number of its first line, and text, of each paragraph and of each item of a list in a comment."""
    gathered, first, column, in_item = [], 0, 0, False
    for number, line in enumerate(text.splitlines() + [""], 1):
        said = SAID.search(line)
        words = said.group(2)[1:] if said else ""
        item = ITEM.match(words)
        is_item = bool(item) or words.startswith("@")
        is_formula = words.startswith("  ") and not in_item
        behind_code = bool(said and line[:said.end(1)].strip())
        goes_on = words.strip() and said.end(1) == column and not (behind_code or is_item or is_formula)
        if gathered and not goes_on:
            yield first, " ".join(gathered)
            gathered = []
        in_item = is_item or (in_item and words.startswith("  "))
        if words.strip() and not is_formula:
            first, column = first if gathered else number, said.end(1)
            gathered.append(words[item.end():] if item else words.strip())


def sentences(paragraph):
    text = CITATION.sub("", LINK.sub(r"\1", CODE.sub("CODE", paragraph)))
    return END.split(ABBREVIATION.sub(r"\1", text))


def texts(root):
    """Path, number of its first line, and text of every paragraph, item and cell."""
    for path in sorted(path for pattern in PAGES + HEADERS for path in root.glob(pattern)):
        is_reference = path == root / REFERENCE
        parts = comments if path.suffix == ".hpp" else cells if is_reference else paragraphs
        for line, text in parts(path.read_text()):
            yield path.relative_to(root), line, text


def violations(root):
    for path, line, text in texts(root):
        for sentence in sentences(text):
            words = sum(1 for word in sentence.split() if re.search("[A-Za-z]", word))
            if words > MAX_WORDS:
                yield f"{path}:{line}: {words} words, write at most {MAX_WORDS}: {sentence}"


def main():
    found = list(violations(pathlib.Path(sys.argv[1])))
    print("\n".join(found))
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
