# SPDX-License-Identifier: BSD-2-Clause
"""The pages of the documentation as data: their blocks of code, links and headings."""
import dataclasses
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
WIDTH = 100


@dataclasses.dataclass
class Block:
    """A fenced block: the words behind the fence, and the lines with the number of the first, without the indentation
    that a block in a list has."""

    info: str
    line: int
    lines: list


@dataclasses.dataclass
class Page:
    path: pathlib.Path
    blocks: list
    text: list  # (number, line) outside of blocks

    @property
    def name(self):
        return str(self.path.relative_to(ROOT))


def read(path):
    page = Page(path, [], [])
    block = None
    indentation = ""
    for number, line in enumerate(path.read_text(encoding="utf-8").split("\n"), 1):
        if fence := re.match(r"( *)```(.*)", line):
            if block is None:
                indentation = fence[1]
                block = Block(fence[2].strip(), number + 1, [])
            else:
                page.blocks.append(block)
                block = None
        elif block is not None:
            block.lines.append(line.removeprefix(indentation))
        else:
            page.text.append((number, line))
    if block is not None:
        raise SystemExit(f"{page.name}:{block.line}: a block without an end")
    return page


def all_pages():
    examples = sorted((ROOT / "examples").glob("*/README.md"))
    docs = sorted((ROOT / "docs").rglob("*.md"))
    return [read(path) for path in [ROOT / "README.md", ROOT / "CHANGELOG.md", *docs, *examples]]


def anchors(page):
    """The names of the headings, as code hosts make them."""
    result = set()
    for _, line in page.text:
        if match := re.match(r"#+ (.*)", line):
            words = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", match[1])
            name = re.sub(r"[^\w\- ]", "", words.lower()).replace(" ", "-")
            while name in result:
                name += "-1"
            result.add(name)
    return result


def links(page):
    """(line, target) of each link to something in this tree."""
    for number, line in page.text:
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", line)):
            if not re.match(r"[a-z]+:", target):
                yield number, target


def named_paths(page):
    """(line, path) of each file or folder of the sources that a text names in back-ticks."""
    folders = ("base|bpf|control|core|daemon|debian|description|docs|include|proto|systemd|tests|"
               "tools")
    for number, line in page.text:
        for path in re.findall(rf"`((?:{folders})/[\w./*-]+)`", line):
            if "NAME" not in path:
                yield number, path.rstrip("/.")


def test_cases():
    """{suite: its cases} of all test programs, as their sources name them."""
    suites = {}
    for file in sorted((ROOT / "tests").rglob("*.cc")):
        text = file.read_text(encoding="utf-8", errors="replace")
        for suite, case in re.findall(r"^(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", text, re.M):
            suites.setdefault(suite, set()).add(case)
    return suites


def named_cases(page):
    """(line, suite, case) of each test that a text names as `PROGRAM: SUITE.CASE`; case may be *."""
    text = "\n".join(line for _, line in page.text)
    for found in re.finditer(r"`[a-z_0-9]+_test:\s+(\w+)\.(\w+|\*)`", text):
        yield page.text[text.count("\n", 0, found.start())][0], found[1], found[2]


def matches(expected, printed):
    """Whether `printed` is `expected`, in which '...' stands for lines and '…' for a text."""
    pattern = ""
    for line in expected:
        if line == "...":
            pattern += r"(?:.*\n)*?"
        else:
            pattern += ".*?".join(re.escape(part) for part in line.split("…")) + r"\n"
    return re.fullmatch(pattern, "".join(line + "\n" for line in printed)) is not None
