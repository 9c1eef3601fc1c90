#!/usr/bin/env python3
"""No dead link in the documents: files, pictures and headings that they point to are there. Usage: links_test.py SOURCE_DIR

Links to other hosts, and to the runs of a workflow (../../actions/), are not followed.
"""
import pathlib
import re
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from blanks import without
from tracked import tracked

FENCE = re.compile(r"^(```|~~~).*?^\1[^\n]*$", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"`[^`\n]*`")
LINK = re.compile(r"\[(?:[^\[\]]|\[[^\]]*\])*\]\(\s*<?([^()\s>]+(?:\([^()\s]*\))?)>?(?:\s+\"[^\"]*\")?\s*\)")
REFERENCE = re.compile(r"^\[[^\]]+\]:\s*(\S+)", re.MULTILINE)
SOURCE = re.compile(r"""(?:src|href)=["']([^"']+)["']""")
HEADING = re.compile(r"^#{1,6}\s+(.*?)\s*#*$", re.MULTILINE)
ANCHOR = re.compile(r"""<a\s+(?:name|id)=["']([^"']+)["']""")


def slug(heading):
    """The anchor that a heading gets: as code hosts make it."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").replace("*", "").lower()
    return re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", text))


def anchors(text):
    found, seen = set(ANCHOR.findall(text)), {}
    for heading in HEADING.findall(without(FENCE, text)):
        name = slug(heading)
        found.add(name if name not in seen else f"{name}-{seen[name]}")
        seen[name] = seen.get(name, 0) + 1
    return found


def violations(root):
    known = {}
    for path in tracked(root, "*.md"):
        text = without(CODE, without(FENCE, path.read_text()))
        for pattern in (LINK, REFERENCE, SOURCE):
            for match in pattern.finditer(text):
                target = match.group(1)
                if re.match(r"[a-z][a-z0-9+.-]*:|\.\./\.\./actions/", target):
                    continue
                where = f"{path.relative_to(root)}:{text.count(chr(10), 0, match.start()) + 1}: {target}"
                name, _, anchor = target.partition("#")
                aim = (path.parent / name).resolve() if name else path
                if not aim.exists():
                    yield f"{where}: no such file"
                elif root.resolve() not in (aim.resolve(), *aim.resolve().parents):
                    yield f"{where}: outside the project"
                elif anchor and aim.suffix == ".md":
                    known.setdefault(aim, anchors(aim.read_text()))
                    if anchor not in known[aim]:
                        yield f"{where}: no such heading"


def main():
    found = list(violations(pathlib.Path(sys.argv[1])))
    print("\n".join(found))
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
