"""C++ by its tokens: where the functions and classes of a header are, and where a sequence of
tokens stands in them.

No compiler takes part, and whitespace, line breaks and comments do not matter.
"""

import dataclasses
import re

TOKEN = re.compile(
    r"""(?P<skip>\s+|//[^\n]*|/\*.*?\*/|^[ \t]*\#(?:[^\n\\]|\\.)*)
      |(?P<token>R"\((?:.|\n)*?\)"|"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)+'
        |\.?\d(?:'?[\w.]|(?<=[eEpP])[+-])*|[A-Za-z_]\w*
        |<=>|<<=|->\*|\.\.\.|::|->|\+\+|--|&&|\|\||<<|[-+*/%&|^=!<>]=|.)""",
    re.VERBOSE | re.DOTALL | re.MULTILINE)


@dataclasses.dataclass
class Token:
    text: str
    start: int  # in characters
    end: int


def tokens_of(text):
    return [Token(found["token"], found.start(), found.end()) for found in TOKEN.finditer(text) if found["token"] is not None]


@dataclasses.dataclass
class Scope:
    path: tuple  # names of the classes around it and its own
    first: int  # index of its first token
    last: int  # of its last
    body: tuple = None  # of the braces of a function

    def is_called(self, name):
        names = tuple(name.split("::"))
        return self.path[-len(names):] == names


OPEN, CLOSE = {"(": ")", "[": "]", "{": "}"}, {")", "]", "}"}
NOT_A_FUNCTION = {"decltype", "noexcept", "alignas", "explicit", "requires", "sizeof", "if", "__attribute__"}


class Scopes:
    """The scopes of a header, in the order of their beginning."""

    def __init__(self, tokens):
        self.words = [token.text for token in tokens]
        self.found = []
        self.declarations(0, len(self.words), ())
        self.found.sort(key=lambda scope: (scope.first, -scope.last))

    def word(self, i):
        return self.words[i] if i < len(self.words) else ""

    def closing(self, i):
        """The index of the bracket that closes the one at i."""
        depth = 0
        for k in range(i, len(self.words)):
            if self.words[k] in OPEN:
                depth += 1
            elif self.words[k] in CLOSE:
                depth -= 1
                if depth == 0:
                    return k
        return len(self.words) - 1

    def after_angles(self, i):
        """The index behind the > that closes the < at i."""
        depth = 0
        while i < len(self.words):
            word = self.words[i]
            if word in ("(", "[", "{"):
                i = self.closing(i)
            elif word == "<":
                depth += 1
            elif word in (">", ">="):
                depth -= 1
                if depth == 0:
                    return i + 1
            elif word == ";":
                return i
            i += 1
        return i

    def after_requires(self, i):
        """The index behind a requires-clause at i."""
        i += 1
        while i < len(self.words):
            if self.word(i) == "!":
                i += 1
            if self.word(i) == "requires":  # an expression
                i += 1
                if self.word(i) == "(":
                    i = self.closing(i) + 1
                i = self.closing(i) + 1
            elif self.word(i) == "(":
                i = self.closing(i) + 1
            else:
                while True:
                    i += 1
                    if self.word(i) == "<":
                        i = self.after_angles(i)
                    if self.word(i) != "::":
                        break
                    i += 1
            if self.word(i) not in ("&&", "||"):
                return i
            i += 1
        return i

    def declarations(self, i, end, path):
        while i < end:
            word = self.word(i)
            if word == ";" or word == "}":
                i += 1
            elif word in ("public", "private", "protected") and self.word(i + 1) == ":":
                i += 2
            elif word == "namespace" or (word == "inline" and self.word(i + 1) == "namespace") or (word == "extern" and self.word(i + 2) == "{"):
                while self.word(i) not in ("{", ";", "="):
                    i += 1
                if self.word(i) == "{":
                    close = self.closing(i)
                    self.declarations(i + 1, close, path)
                    i = close + 1
            else:
                i = self.declaration(i, end, path)

    def declaration(self, first, end, path):
        """One declaration or definition; returns the index behind it."""
        i, name, in_initialisers = first, None, False
        while i < end:
            word = self.word(i)
            previous = self.word(i - 1) if i > first else ""
            if word == "template" and self.word(i + 1) == "<":
                i = self.after_angles(i + 1)
                continue
            if word == "[" and self.word(i + 1) == "[":
                i = self.closing(i) + 1
                continue
            if word == "requires":
                i = self.after_requires(i)
                continue
            if word in ("class", "struct", "union", "enum") and name is None:
                return self.type(first, i, end, path)
            if word == "operator":
                k = i + 1
                if self.word(k) == "(":
                    k += 2
                while self.word(k) != "(":
                    k += 1
                name = "operator" + "".join(self.words[i + 1:k])
                i = self.closing(k) + 1
                continue
            if word == "(":
                if name is None and previous not in NOT_A_FUNCTION:
                    name = ("~" if self.word(i - 2) == "~" else "") + previous
                i = self.closing(i) + 1
                continue
            if word == "[":
                i = self.closing(i) + 1
                continue
            if word == "<" and re.match(r"[A-Za-z_]", previous):
                i = self.after_angles(i)
                continue
            if word == ":" and name is not None:
                in_initialisers = True
            if word == "{":
                close = self.closing(i)
                is_body = name is not None and not (in_initialisers and (re.match(r"[A-Za-z_]", previous) or previous == ">"))
                if is_body:
                    self.found.append(Scope(path + (name,), first, close, (i, close)))
                    return close + 1
                if name is None:
                    name = previous
                i = close + 1
                continue
            if word == "=":
                name = name or previous
                while i < end and self.word(i) != ";":
                    i = self.closing(i) + 1 if self.word(i) in OPEN else i + 1
                continue
            if word == ";":
                self.found.append(Scope(path + (name or previous,), first, i))
                return i + 1
            i += 1
        return end

    def type(self, first, i, end, path):
        i += 1
        while self.word(i) in ("class", "struct") or self.word(i) == "[" or self.word(i) == "alignas":
            i = self.closing(i) + 1 if self.word(i) == "[" else i + 1
        name = self.word(i)
        while i < end and self.word(i) not in ("{", ";"):
            i = self.after_angles(i) if self.word(i) == "<" else self.closing(i) + 1 if self.word(i) == "(" else i + 1
        if self.word(i) != "{":
            return i + 1
        close = self.closing(i)
        self.declarations(i + 1, close, path + (name,))
        after = close + 1
        while after < end and self.word(after) != ";":
            after += 1
        self.found.append(Scope(path + (name,), first, after))
        return after + 1


class Header:
    def __init__(self, path, name):
        self.name = name  # below include/gmis
        self.text = path.read_text(encoding="utf-8")
        self.tokens = tokens_of(self.text)
        self.words = [token.text for token in self.tokens]
        self.scopes = Scopes(self.tokens).found

    def scopes_called(self, symbol):
        return [scope for scope in self.scopes if scope.is_called(symbol)]

    def positions(self, words, symbol=None):
        """Where a sequence of tokens stands within the scopes of a name: indices of its first
        token."""
        if not words:
            return []
        found = set()
        for scope in self.scopes_called(symbol) if symbol else [Scope((), 0, len(self.words) - 1)]:
            for i in range(scope.first, scope.last + 2 - len(words)):
                if self.words[i] == words[0] and self.words[i:i + len(words)] == words:
                    found.add(i)
        return sorted(found)

    def function_around(self, first, last):
        """The innermost function whose body has these tokens."""
        around = [s for s in self.scopes if s.body and s.body[0] < first and last < s.body[1]]
        return min(around, key=lambda s: s.last - s.first, default=None)


def headers_in(folder):
    """All headers below a folder, by their path there."""
    paths = sorted(folder.rglob("*.hpp"))
    return {str(path.relative_to(folder)): Header(path, str(path.relative_to(folder))) for path in paths}
