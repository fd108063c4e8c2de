# SPDX-License-Identifier: BSD-2-Clause
"""Single changes of a C or C++ source: what `tests/mutants/run` tries.

A mutation turns round a comparison, an arithmetic or a logical operator, negates a condition,
changes an integer constant by one, or deletes a statement. Comments, strings, preprocessor lines,
assertions and template arguments stay as they are.
"""
import re
from dataclasses import dataclass

BINARY = {
    '<': ('<=', '>='), '<=': ('<', '>'), '>': ('>=', '<='), '>=': ('>', '<'),
    '==': ('!=',), '!=': ('==',), '&&': ('||',), '||': ('&&',),
    '+': ('-',), '-': ('+',), '*': ('/',), '/': ('*',), '%': ('*',),
    '&': ('|',), '|': ('&',), '^': ('|',), '<<': ('>>',), '>>': ('<<',),
    '+=': ('-=',), '-=': ('+=',), '*=': ('/=',), '/=': ('*=',), '|=': ('&=',), '&=': ('|=',),
}
# Whole tokens between spaces: clang-format puts none around `<` of a template or `*` of a pointer.
OPERATOR = re.compile(r'(?<=\s)(<=>|[<>=!+\-*/%&|^]{1,3})(?=\s)')
NUMBER = re.compile(r"(?<![\w.'])(0x[0-9a-fA-F']+|\d[\d']*)([uUlL]*)(?![\w.'])")
WORD = re.compile(r'\b(true|false)\b')
STEP = re.compile(r'\+\+|--')
NOT = re.compile(r'!(?=[\w(])')
CONDITION = re.compile(r'\b(?:if|while) \(')
# A call, an assignment, a step or a jump that fills its line. A declaration has a space in front of
# its name.
STATEMENT = re.compile(
    r'^[ \t]+(?!return\b|using\b|else\b|delete\b|case\b|default\b|public\b|private\b)'
    r'((?:\+\+|--|\*)?[\w:.\->\[\]]+(?:\(.*\)| [+\-*/|&^]?= [^;]*|\+\+|--)?;)[ \t]*$', re.MULTILINE)
NOT_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"\(.*?\)"|"(?:\\.|[^"\\\n])*"'
    r"|(?<![\w'])'(?:\\.|[^'\\\n])+'"
    r'|^[ \t]*#(?:\\\n|[^\n])*', re.DOTALL | re.MULTILINE)
# An assertion says nothing that the program does; reserve() is of no effect but on time, and a step
# of progress is one of many.
NOT_TRIED = re.compile(
    r'\b(?:static_assert|assert|GATE_ASSERT)\(|\.reserve\(|\bProgress::(?:step|made)\('
    r'|\b__attribute__\(\(|\[\[')


@dataclass(frozen=True)
class Mutation:
    path: str
    start: int
    end: int
    replacement: str
    line: int
    before: str  # the line, without the space around it
    after: str
    above: str   # the line above it

    def applied_to(self, source):
        return source[:self.start] + self.replacement + source[self.end:]


def end_of_brackets(text, opening):
    """Behind the bracket that closes the one at `opening`; None if there is none."""
    depth = 0
    for at in range(opening, len(text)):
        if text[at] in '([{':
            depth += 1
        elif text[at] in ')]}':
            depth -= 1
            if depth == 0:
                return at + 1
    return None


def code_of(source):
    """The source with blanks for all that is not to be changed, each character in its place."""
    def blank(text):
        return re.sub(r'[^\n]', ' ', text)
    code = NOT_CODE.sub(lambda match: blank(match.group()), source)
    for match in reversed(list(NOT_TRIED.finditer(code))):
        opening = match.start() if match.group() == '[[' else match.end() - 1
        end = end_of_brackets(code, opening)
        if end is not None:
            code = code[:match.start()] + blank(code[match.start():end]) + code[end:]
    return code


def changed_numbers(digits):
    plain = digits.replace("'", '')
    is_hex = plain.startswith('0x')
    value = int(plain, 16 if is_hex else 10)
    write = hex if is_hex else str
    return [write(value + 1)] + ([write(value - 1)] if value > 0 else [])


def places_in(code):
    """Each place as (start, end, replacements)."""
    for match in OPERATOR.finditer(code):
        if match.group() in BINARY:
            yield match.start(), match.end(), BINARY[match.group()]
    for match in NUMBER.finditer(code):
        yield match.start(1), match.end(1), changed_numbers(match.group(1))
    for match in WORD.finditer(code):
        yield match.start(), match.end(), ('false' if match.group() == 'true' else 'true',)
    for match in STEP.finditer(code):
        yield match.start(), match.end(), ('--' if match.group() == '++' else '++',)
    for match in NOT.finditer(code):
        yield match.start(), match.end(), ('',)
    for match in CONDITION.finditer(code):
        end = end_of_brackets(code, match.end() - 1)
        if end is not None:
            yield match.end(), end - 1, ('!(' + code[match.end():end - 1] + ')',)
    for match in STATEMENT.finditer(code):
        yield match.start(1), match.end(1), ('{}',)


def mutations_of(path, source):
    """All mutations of a source, in groups that share a place."""
    code = code_of(source)
    for start, end, replacements in sorted(places_in(code)):
        first = source.rfind('\n', 0, start) + 1
        last = source.find('\n', end)
        before = source[first:last]
        above = ' '.join(source[source.rfind('\n', 0, max(first - 1, 0)) + 1:first].split())
        group = []
        for replacement in replacements:
            # A condition is copied from the code without strings: take the source's own text.
            if replacement.startswith('!('):
                replacement = '!(' + source[start:end] + ')'
            after = source[first:start] + replacement + source[end:last]
            group.append(Mutation(path, start, end, replacement, source.count('\n', 0, start) + 1,
                                  ' '.join(before.split()), ' '.join(after.split()), above))
        yield group
