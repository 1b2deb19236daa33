"""Reads Arnold's .ass text format: a file of nodes, each a type and a block of parameters.

    nodes = read("test_als_glass.ass")          # {name: Node}
    nodes["TARGET_SURFACE"].params["diffuseColor"]   # a Value: its words as written, and the line it stands on

Values are kept as words, because only the node's type tells what they mean. Base-85 arrays are passed over: the name stays, the
data does not. alShaders specification, section 13.2.
"""
import gzip
import re


class AssError(Exception):
    """The text does not follow the format; the message names file and line."""


class Word(str):
    """One word of a value; `quoted` tells "off" the text from off the switch."""

    def __new__(cls, text, quoted=False):
        word = super().__new__(cls, text)
        word.quoted = quoted
        return word


class Value:
    def __init__(self, words, line, skipped=False):
        self.words = words
        self.line = line
        self.skipped = skipped  # base-85 data that was passed over

    def numbers(self):
        """The words as numbers, or None if one is not a number."""
        try:
            return [float(w) for w in self.words] if self.words and not any(w.quoted for w in self.words) else None
        except ValueError:
            return None


class Node:
    def __init__(self, kind, line):
        self.kind = kind
        self.line = line
        self.name = ""
        self.params = {}
        self.declared = {}  # user data: name -> declaration

    def __repr__(self):
        return "%s %s" % (self.kind, self.name)


WORD = re.compile(r'"((?:[^"\\]|\\.)*)"|([^\s"{}]+)|([{}])')
NAME = re.compile(r"[A-Za-z_]")


def _words(line, place):
    """Words of one line; a comment ends it."""
    words, at = [], 0
    while at < len(line):
        if line[at].isspace():
            at += 1
            continue
        if line[at] == "#":
            break
        match = WORD.match(line, at)
        if not match:
            raise AssError("%s: a quotation mark without its end" % place)
        quoted, plain, brace = match.groups()
        words.append(Word(re.sub(r"\\(.)", r"\1", quoted), True) if quoted is not None else Word(plain or brace))
        at = match.end()
    return words


def read(path):
    with open(path, "rb") as f:
        data = f.read()
    if data[:2] == b"\x1f\x8b":
        data = gzip.decompress(data)
    return parse(data.decode("utf-8", "replace"), path)


def parse(text, path="<text>"):
    """All nodes by name, in order. `include` lines are listed in the result's .includes."""
    nodes = Nodes()
    lines = text.splitlines()
    node, kind, kind_line, current, skipping = None, None, 0, None, False

    def place(number):
        return "%s, line %d" % (path, number)

    for number, line in enumerate(lines, 1):
        if skipping:  # base-85 data runs to an empty line or the end of the block
            if line.strip() and line.strip() != "}":
                continue
            skipping = False
        words = _words(line, place(number))
        first = True
        while words:
            word = words.pop(0)
            plain = not word.quoted
            if node is None:
                if word == "include" and plain and kind is None:
                    if not words:
                        raise AssError("%s: include without a file" % place(number))
                    nodes.includes.append(str(words.pop(0)))
                elif word == "{" and plain:
                    if kind is None:
                        raise AssError("%s: a block without a node type" % place(number))
                    node, current = Node(kind, kind_line), None
                    first = True  # a parameter may follow on the same line
                    continue
                elif kind is None and plain and NAME.match(word):
                    kind, kind_line = str(word), number
                else:
                    raise AssError("%s: found %s, expected %s" % (place(number), word, "{" if kind else "a node type"))
            elif word == "}" and plain:
                _finish(nodes, node, place(node.line))
                node = kind = None
            elif word == "{" and plain:
                raise AssError("%s: a block inside the block of %s" % (place(number), node.kind))
            elif first and plain and NAME.match(word) and not _continues(current):
                if word == "declare":
                    if len(words) < 3:
                        raise AssError("%s: declare needs a name, a class and a type" % place(number))
                    node.declared[str(words[0])] = " ".join(words[1:])
                    words, current = [], None
                else:
                    current = Value([], number)
                    if str(word) in node.params:
                        raise AssError("%s: %s is given twice" % (place(number), word))
                    node.params[str(word)] = current
            elif current is None:
                raise AssError("%s: found %s, expected a parameter's name" % (place(number), word))
            else:
                current.words.append(word)
                if plain and word.startswith("b85"):
                    current.skipped = skipping = True
                    words = []
            first = False
    if node is not None or kind is not None:
        raise AssError("%s: the file ends inside %s" % (place(len(lines)), kind))
    return nodes


def _continues(value):
    """Whether an array is still short of its elements, so that a name on a new line belongs to it."""
    if value is None or len(value.words) < 3 or value.skipped:
        return False
    count, keys, kind = value.words[:3]
    if not (count.isdigit() and keys.isdigit() and kind in ("NODE", "STRING", "ENUM")) or kind.quoted:
        return False
    return len(value.words) - 3 < int(count) * int(keys)


class Nodes(dict):
    def __init__(self):
        super().__init__()
        self.includes = []


def _finish(nodes, node, place):
    name = node.params.pop("name", None)
    node.name = str(name.words[0]) if name and name.words else node.kind
    if node.name in nodes:
        raise AssError("%s: a second node called %s" % (place, node.name))
    nodes[node.name] = node
