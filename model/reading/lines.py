"""The line of each key of a TOML document, which :mod:`tomllib` does not give.

The text is one that tomllib has accepted: nothing is checked again, only followed.
"""

from __future__ import annotations

import re
import tomllib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

KeyPath = tuple[str | int, ...]
"""The keys, and the indices in lists, that lead to a value."""

_SPACE = re.compile(r"[ \t]*")
_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_BARE = re.compile(r"[A-Za-z0-9_-]+")
_BASIC = re.compile(r'"(?:[^"\\]|\\.)*"')
_LITERAL = re.compile(r"'[^']*'")
_LONG_BASIC = re.compile(r'"""(?:[^\\]|\\.)*?"""(?:"{0,2})', re.DOTALL)
_LONG_LITERAL = re.compile(r"'''.*?'''(?:'{0,2})", re.DOTALL)
_TOKEN = re.compile(r""""(?:[^"\\]|\\.?)*(?:"|$)|'[^']*(?:'|$)|[A-Za-z0-9_-]+|[ \t]+|.""")
_OTHER = re.compile(r"[^,\]}#\n]*")


def each_key_line(text: str) -> Iterator[tuple[KeyPath, int]]:
    """Lines of keys and of elements of lists, one after the other, so that a reader can stop.

    Parameters
    ----------
    text : str
        Valid TOML.

    Yields
    ------
    path, line : tuple, int
        The path to the value, ``("nodes", "O1", "at", 0)``, and its line, counted from 1. A path
        may come again: its first line counts.
    """
    scanner = _Scanner(text)
    for _ in scanner.statements():
        yield from scanner.lines.items()
        scanner.lines.clear()


def twice_given(text: str) -> tuple[KeyPath, int, int] | None:
    """First key that is given twice, with both of its lines; None where none is found.

    Parameters
    ----------
    text : str
        Text that a parser refused because of a key; it is scanned up to there.
    """
    scanner = _DuplicateScanner(text)
    try:
        for _ in scanner.statements():
            if scanner.duplicate:
                break
    except (IndexError, KeyError, ValueError):  # the text has another fault, too
        return None
    return scanner.duplicate


def deep_key_line(text: str, most_parts: int) -> int:
    """First line with a key of more than `most_parts` parts between dots, 0 if there is none.

    It takes a time that grows linearly with the text, which need not be TOML.
    """
    for number, line in enumerate(text.split("\n"), 1):
        if line.count(".") >= most_parts and _longest_key(line) > most_parts:
            return number
    return 0


def _longest_key(line: str) -> int:
    longest = parts = 0
    follows_dot = False
    for token in _TOKEN.finditer(line):
        text = token.group()
        if text[0] in "\"'" or _BARE.match(text):
            parts = parts + 1 if follows_dot else 1
            longest = max(longest, parts)
        follows_dot = text == "." or (follows_dot and text.isspace())
    return longest


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text = text
        self.position = 0
        self.lines: dict[KeyPath, int] = {}
        self._counts: dict[KeyPath, int] = {}
        self._line, self._counted = 1, 0

    def statements(self) -> Iterator[None]:
        """Read the document statement by statement, a header or a key with its value."""
        table: KeyPath = ()
        self.skip(_BLANK)
        while self.position < len(self.text):
            if self.takes("[["):
                table = self.header(is_list=True)
                self.position += 2
            elif self.takes("["):
                table = self.header(is_list=False)
                self.position += 1
            else:
                self.value(self.assigned(table))
            yield
            self.skip(_BLANK)

    def header(self, *, is_list: bool) -> KeyPath:
        """Read the keys of a header; a list of tables stands for its last element."""
        path: KeyPath = ()
        line = self.line()
        keys = self.keys()
        for depth, key in enumerate(keys, 1):
            path = (*path, key)
            self.lines.setdefault(path, line)
            if is_list and depth == len(keys):
                self._counts[path] = self._counts.get(path, 0) + 1
            if path in self._counts:
                path = (*path, self._counts[path] - 1)
                self.lines.setdefault(path, line)
        return path

    def assigned(self, table: KeyPath) -> KeyPath:
        """Read ``key =``; return the path to the value that follows."""
        line = self.line()
        path = table
        for key in self.keys():
            path = (*path, key)
            self.lines.setdefault(path, line)
        self.position += 1
        self.skip(_SPACE)
        return path

    def keys(self) -> list[str]:
        """Read a key with its dots, and the space after it."""
        keys = [self.key()]
        while self.takes("."):
            keys.append(self.key())
        return keys

    def key(self) -> str:
        self.skip(_SPACE)
        start = self.text[self.position]
        quoted = {'"': _BASIC, "'": _LITERAL}.get(start)
        raw = self.skip(quoted or _BARE)
        self.skip(_SPACE)
        if quoted is None:
            return raw
        key: str = tomllib.loads(f"key = {raw}")["key"]
        return key

    def value(self, path: KeyPath) -> None:
        """Read a value and what is in it, without recursion: depth costs no stack."""
        opened: list[tuple[KeyPath, int | None]] = []
        self.begin(path, opened)
        while opened:
            self.skip(_BLANK)
            while self.takes(","):
                self.skip(_BLANK)
            if self.takes("]") or self.takes("}"):
                opened.pop()
                continue
            outer, count = opened.pop()
            if count is None:
                opened.append((outer, None))
                self.begin(self.assigned(outer), opened)
            else:
                opened.append((outer, count + 1))
                self.lines.setdefault((*outer, count), self.line())
                self.begin((*outer, count), opened)

    def begin(self, path: KeyPath, opened: list[tuple[KeyPath, int | None]]) -> None:
        """Read a plain value, or open a list, which counts its elements, or an inline table."""
        if self.takes("["):
            opened.append((path, 0))
        elif self.takes("{"):
            opened.append((path, None))
        elif self.text.startswith('"""', self.position):
            self.skip(_LONG_BASIC)
        elif self.text.startswith("'''", self.position):
            self.skip(_LONG_LITERAL)
        else:
            self.skip({'"': _BASIC, "'": _LITERAL}.get(self.text[self.position], _OTHER))

    def takes(self, mark: str) -> bool:
        if not self.text.startswith(mark, self.position):
            return False
        self.position += len(mark)
        return True

    def skip(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self.text, self.position)
        if match is None:
            return ""
        self.position = match.end()
        return match.group()

    def line(self) -> int:
        """Line of the position, counted from 1."""
        self._line += self.text.count("\n", self._counted, self.position)
        self._counted = self.position
        return self._line


class _DuplicateScanner(_Scanner):
    """Scanner that notes the first key that stands twice, with both lines."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.duplicate: tuple[KeyPath, int, int] | None = None
        self._first_lines: dict[KeyPath, int] = {}

    def header(self, *, is_list: bool) -> KeyPath:
        line, path = self.line(), super().header(is_list=is_list)
        self._note(path, line)
        return path

    def assigned(self, table: KeyPath) -> KeyPath:
        line, path = self.line(), super().assigned(table)
        self._note(path, line)
        return path

    def _note(self, path: KeyPath, line: int) -> None:
        if path not in self._first_lines:
            self._first_lines[path] = line
        elif self.duplicate is None:
            self.duplicate = path, self._first_lines[path], line
