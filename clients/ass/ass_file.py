"""Reads Arnold's .ass text format: a file of nodes, each a type and a block of parameters.

    nodes = read("test_als_glass.ass")          # {name: Node}
    nodes["TARGET_SURFACE"].params["diffuseColor"]   # a Value: its words as written, and the line it stands on

Values are kept as words, because only the node's type tells what they mean. Base-85 data is kept as text beside them (Value.data);
array() decodes it. alShaders specification, section 13.2.
"""
import gzip
import os
import re
import struct


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
        self.skipped = skipped  # what follows the words is base-85 data
        self.data = []          # its lines

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


CELLS = {"UINT": 1, "INT": 1, "FLOAT": 1, "BYTE": 1, "POINT2": 2, "VECTOR2": 2, "POINT": 3, "VECTOR": 3, "RGB": 3, "RGBA": 4, "MATRIX": 16}
TOKEN = re.compile(r"z|y|!.{10}|.{5}", re.DOTALL)


def words85(text):
    """The 32-bit words of base-85 text: five digits, most significant first; z is 0, y the float 1, ! a run."""
    def digits(five):
        word = 0
        for c in five:
            digit = ord(c) - 36
            if not 0 <= digit < 85:
                raise AssError("'%s' is no base-85 digit" % c)
            word = word * 85 + digit
        if word > 0xFFFFFFFF:
            raise AssError("'%s' is more than 32 bits" % five)
        return word

    text = "".join(text.split())
    out, end = [], 0
    for match in TOKEN.finditer(text):
        if match.start() != end:
            break
        end, token = match.end(), match.group()
        if token == "z":
            out.append(0)
        elif token == "y":
            out.append(0x3F800000)
        elif token[0] == "!":
            count = digits(token[6:])
            if len(out) + count > 1 << 30:
                raise AssError("a run of %d words" % count)
            out.extend([digits(token[1:6])] * count)
        else:
            out.append(digits(token))
    if end != len(text):
        raise AssError("base-85 data ends within a word: '%s'" % text[end:end + 10])
    return out


def array(value):
    """Numbers of an array parameter, flat, as written or in base 85; None where the words are no array of numbers. The first key
    only: value.keys says how many there were."""
    words = value.words
    if len(words) < 3 or not (words[0].isdigit() and words[1].isdigit()):
        return None
    count, keys, kind = int(words[0]), int(words[1]), str(words[2])
    base85 = kind.startswith("b85")
    cells = CELLS.get(kind[3:] if base85 else kind)
    if cells is None:
        return None
    value.keys = keys
    wanted = count * cells
    if not base85:
        try:
            numbers = [float(w) for w in words[3:]]
        except ValueError as e:
            raise AssError("line %d: %s" % (value.line, e)) from None
    else:
        text = " ".join(list(words[3:]) + value.data).strip()
        whole = kind[3:] in ("UINT", "INT", "BYTE")
        packed = whole and text[:1] == "B"
        try:
            bits = words85(text[1:] if packed else text)
        except AssError as e:
            raise AssError("line %d: %s" % (value.line, e)) from None
        raw = struct.pack("<%dI" % len(bits), *bits)
        numbers = list(raw) if packed else bits if whole else list(struct.unpack("<%df" % len(bits), raw))
    if len(numbers) < wanted * keys:
        raise AssError("line %d: %d of %d numbers of an array" % (value.line, len(numbers), wanted * keys))
    return numbers[:wanted]


def read_all(path, report):
    """The file and what it includes, searched beside it; report(text) tells of what is not there."""
    nodes, seen = Nodes(), set()

    def add(name, by):
        real = os.path.realpath(name)
        if real in seen:
            return
        seen.add(real)
        part = read(name)
        for include in part.includes:
            found = [p for p in (include, os.path.join(os.path.dirname(name), include), os.path.join(os.path.dirname(name), os.path.basename(include)))
                     if os.path.isfile(p)]
            if found:
                add(found[0], name)
            else:
                report("include %s of %s is not there" % (include, os.path.basename(name)))
        for key, node in part.items():
            if key in nodes:
                report("%s is in several files; that of %s counts" % (key, os.path.basename(name)))
            nodes[key] = node
    add(path, None)
    return nodes


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
                current.data.append(line)
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
                    current.data.append(line.split(str(word), 1)[1])
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
