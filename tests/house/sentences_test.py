#!/usr/bin/env python3
"""Plain English: no sentence of the pages and docs/ has more than 25 words. Usage: sentences_test.py SOURCE_DIR

Code, tables, pictures and headings are no sentences. A word is what stands between blanks and has a letter. `Code`, the text
of a link and a citation count as what the reader sees of them: one word, its words, none.
"""
import pathlib
import re
import sys

MAX_WORDS = 25
PAGES = ("README.md", "CONTRIBUTING.md", "SECURITY.md", "docs/*.md")
GENERATED = {"docs/reference.md"}  # its texts are cells of tables

COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
FENCE = re.compile(r"^ *(```|~~~).*?^ *\1[^\n]*$", re.MULTILINE | re.DOTALL)
NO_TEXT = re.compile(r"\s*(#|\||<|!\[|---)| {6,}\S")
ITEM = re.compile(r"\s*([-*]|\d+\.)\s+")
CODE = re.compile(r"`[^`]*`")
LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")
CITATION = re.compile(r"\[(Vrba|Kamler|Pritzl|Orsulic)[^\]]*\]")
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|al|approx|cf|eqs?|figs?|no|refs?|sec|vs)\.", re.IGNORECASE)
END = re.compile(r"(?<=[.!?])[\")*]*\s+")


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


def sentences(paragraph):
    text = CITATION.sub("", LINK.sub(r"\1", CODE.sub("CODE", paragraph)))
    return END.split(ABBREVIATION.sub(r"\1", text))


def violations(root):
    for path in sorted(path for pattern in PAGES for path in root.glob(pattern)):
        if str(path.relative_to(root)) in GENERATED:
            continue
        for line, paragraph in paragraphs(path.read_text()):
            for sentence in sentences(paragraph):
                words = sum(1 for word in sentence.split() if re.search("[A-Za-z]", word))
                if words > MAX_WORDS:
                    yield f"{path.relative_to(root)}:{line}: {words} words, write at most {MAX_WORDS}: {sentence}"


def main():
    found = list(violations(pathlib.Path(sys.argv[1])))
    print("\n".join(found))
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
