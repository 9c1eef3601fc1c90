#!/usr/bin/env python3
"""Vectors name their frame: every vector that crosses a function of a header. Usage: frames_test.py SOURCE_DIR

What counts is a parameter, or a member of a class that is not private by its name (`x_`), whose type is a vector of two or
three numbers, or a list of them: its name has a word of FRAMES (`p_world_m`), or a frame of a transform in the same file
(`p_from_m` beside `T_to_from`). What needs none:
- a size, a standard deviation, a color, a geodetic datum, the value of a visitor: NO_FRAME;
- a member that a user sees by a key of its own name, whose text states the frame: `v.field("position_m", position_m, ...`;
- whatever follows a comment with one of PHRASES: a class or a function, or the whole file when it stands before the namespace.
"""
import functools
import pathlib
import re
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from blanks import blanked, without
from tracked import tracked

FRAMES = {"world", "local", "body", "lidar", "sensor", "mesh", "tree", "start", "agent", "ecef"}
NO_FRAME = {"sigma", "size", "scale", "extent", "datum", "rgb", "color", "rpy", "value"}
TOPS = ("include", "core", "sim")
PHRASES = ("any frame, the same for all arguments", "local frame between stages, world in Action")

ONE = r"(?:(?:Eigen::)?Vector[23][df]?)"
LIST = rf"(?:std::(?:span|vector|array|optional)<(?:const )?{ONE}(?:, \w+)?>)"
VECTOR = re.compile(rf"(?<![\w:<])(?:const )?(?:{LIST}|{ONE})[ &]+(\w+)\s*(?=[,)=;{{])")
MORE = re.compile(r"\s*(?:=[^,;]*)?,\s*(\w+)(?=\s*[,;=])")  # Vector3 a, b;
TRANSFORM = re.compile(r"\bT_([a-z]+)_([a-z]+)")
SCOPE = re.compile(r"\b(?:namespace|class|struct|union)\b")


def statement_before(code, brace):
    return code[max(code.rfind(mark, 0, brace) for mark in "{};") + 1:brace]


def end_of(code, brace):
    depth = 0
    for i in range(brace, len(code)):
        depth += {"{": 1, "}": -1}.get(code[i], 0)
        if depth == 0:
            return i + 1
    return len(code)


def declarations(code):
    """The code without comments, bodies of functions and values: what is left are declarations."""
    code = without(r"//[^\n]*|/\*.*?\*/|\"[^\"\n]*\"", code, re.DOTALL)
    code = without(r"^[ ]*#[^\n]*", code, re.MULTILINE)
    at = code.find("{")
    while at >= 0:
        before = statement_before(code, at)
        if not SCOPE.search(before) or "(" in before:
            end = end_of(code, at)
            code = code[:at] + ";" + blanked(code[at + 1:end]) + code[end:]
        at = code.find("{", at + 1)
    return code


def says_so(comment):
    text = " ".join(re.sub(r"^\s*///?", " ", comment, flags=re.MULTILINE).split()).lower()
    return any(phrase.lower() in text for phrase in PHRASES)


def agnostic(text):
    """Spans of the text, from a comment that says so to the end of what it speaks of."""
    for match in re.finditer(r"(?:^[ ]*//[^\n]*\n)+", text, re.MULTILINE):
        if not says_so(match.group(0)):
            continue
        code = without(r"//[^\n]*", text)
        marks = [i for i in (code.find(mark, match.end()) for mark in "{;") if i >= 0]
        first = min(marks, default=len(code))
        yield match.start(), end_of(code, first) if code[first:first + 1] == "{" else first


def violations(root):
    for path in tracked(root, "*.hpp"):
        if path.relative_to(root).parts[0] not in TOPS:
            continue
        text = path.read_text()
        free, code = list(agnostic(text)), declarations(text)
        frames = FRAMES | {frame for pair in TRANSFORM.findall(text) for frame in pair}
        visited = text + source(root, path)
        for match in VECTOR.finditer(code):
            is_parameter = code.count("(", 0, match.start()) > code.count(")", 0, match.start())
            names, more = [match.group(1)], MORE.match(code, match.end())
            while more and not is_parameter:
                names.append(more.group(1))
                more = MORE.match(code, more.end())
            for name in names:
                if set(name.split("_")) & (frames | NO_FRAME) or name.endswith("_"):
                    continue
                if any(start <= match.start() < end for start, end in free):
                    continue
                is_visited = re.search(rf'"{name}",\s*(?:\w+\.)?{name}\b', visited)
                if not is_parameter and is_visited and "visit(" in class_around(code, match.start()):
                    continue
                line = text.count("\n", 0, match.start(1)) + 1
                yield f"{path.relative_to(root)}:{line}: {name}"


@functools.cache
def sources(root):
    return tracked(root, "*.cpp")


def source(root, header):
    """The sources of a header's room, in which its configurations are visited."""
    room = header.parent
    if room.is_relative_to(root / "include"):
        room = root / room.relative_to(root / "include" / "swiftlet")
    return "".join(path.read_text() for path in sources(root) if path.is_relative_to(room))


def class_around(code, at):
    depth = 1
    while at > 0 and depth > 0:
        at -= 1
        depth += {"}": 1, "{": -1}.get(code[at], 0)
    return code[at:end_of(code, at)]


def main():
    found = list(violations(pathlib.Path(sys.argv[1])))
    for line in found:
        print(f"{line} names no frame, such as {line.split()[-1]} -> p_world_m")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
