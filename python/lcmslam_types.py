"""Message types of LCM as data: definitions (lcmtypes/*.lcm) are read when they are needed, so that nothing is generated
and a type of your own is one more file."""
import pathlib
import re
import types

import numpy as np

DEFINITIONS = pathlib.Path(__file__).resolve().parent.parent / "lcmtypes"

_KINDS = {"int8_t": ">i1", "int16_t": ">i2", "int32_t": ">i4", "int64_t": ">i8", "float": ">f4", "double": ">f8",
          "boolean": ">i1", "byte": ">u1"}
_INTEGERS = ("int8_t", "int16_t", "int32_t", "int64_t")
_MOST_NESTED = 16
# Of old logs (libs/messages/schema.cpp): the type, and how many of today's members it had, some by other names; those
# after them are numbers and arrays, and 0 means what their absence did.
_FORMER_FINGERPRINTS = {0x440EF967CE91C74A: ("graph_t", 9), 0x3E49193E24115FDC: ("graph_t", 9)}


class DecodeError(ValueError):
    """A message that is not what it claims to be; says what is wrong with it."""


class Field:
    """A member: `type name[dimension]...`; a dimension is a number or the name of a member before it."""

    def __init__(self, type_name, name, dimensions):
        self.type_name, self.name, self.dimensions = type_name, name, dimensions
        self.nested = None  # MessageType
        self.dtype = None   # of one element on the wire; None where its size varies
        self.native = None  # the same in this machine's byte order


class MessageType:
    def __init__(self, name, fields):
        self.name, self.fields = name, fields

    def fingerprint(self):
        return self._hash(()) & (2 ** 64 - 1)

    # LCM's: over names and dimensions of the members and the names of primitive types.
    def _hash(self, parents):
        if self in parents:
            return 0
        value = 0x12345678
        nested = 0
        for field in self.fields:
            value = _hash_text(value, field.name)
            if field.nested is None:
                value = _hash_text(value, field.type_name)
            else:
                nested += field.nested._hash(parents + (self,))
            value = _hash_byte(value, len(field.dimensions))
            for dimension in field.dimensions:
                value = _hash_byte(value, isinstance(dimension, str))
                value = _hash_text(value, str(dimension))
        total = (value + nested) & (2 ** 64 - 1)
        return (total << 1) + (total >> 63)

    def dtype(self, parents=()):
        """numpy's for one of these on the wire, None where the size varies."""
        if self in parents:
            return None
        members = []
        for field in self.fields:
            kind = _KINDS.get(field.type_name) if field.nested is None else field.nested.dtype(parents + (self,))
            if kind is None or any(isinstance(d, str) for d in field.dimensions):
                return None
            members.append((field.name, kind, tuple(field.dimensions)))
        return np.dtype(members)


def _hash_byte(value, byte):
    value = (((value << 8) ^ (value >> 55)) + int(byte)) & (2 ** 64 - 1)
    return value - (value >> 63 << 64)


def _hash_text(value, text):
    for byte in bytes([len(text)]) + text.encode():
        value = _hash_byte(value, byte)
    return value


class Types:
    """All types of a folder, found by name or by the fingerprint that a message begins with."""

    def __init__(self, folder=DEFINITIONS, files=()):
        """`folder` may be None; `files` are definitions besides. Raises ValueError, naming the file."""
        paths = list(files)
        if folder is not None:
            paths = sorted(pathlib.Path(folder).glob("*.lcm")) + paths
            if not paths:
                raise ValueError(f"{folder}: has no definitions of types (*.lcm)")
        self.by_name = {}
        for path in paths:
            try:
                for message_type in _parse(pathlib.Path(path).read_text()):
                    self.by_name[message_type.name] = message_type
            except ValueError as error:
                raise ValueError(f"{path}: {error}") from None
        for message_type in self.by_name.values():
            for field in message_type.fields:
                self._link(message_type, field)
        for message_type in self.by_name.values():
            for field in message_type.fields:
                kind = _KINDS.get(field.type_name) if field.nested is None else field.nested.dtype()
                field.dtype = None if kind is None else np.dtype(kind)
                field.native = None if kind is None else field.dtype.newbyteorder("=")
        self._by_fingerprint = {t.fingerprint(): t for t in self.by_name.values()}
        for fingerprint, (name, _) in _FORMER_FINGERPRINTS.items():
            if name in self.by_name:
                self._by_fingerprint[fingerprint] = self.by_name[name]

    def _link(self, message_type, field):
        if field.type_name in _KINDS or field.type_name == "string":
            return
        field.nested = self.by_name.get(field.type_name.split(".")[-1])
        if field.nested is None:
            raise ValueError(f"{message_type.name}: unknown type {field.type_name}")

    def of(self, data):
        """The type of a message's bytes, None for one that no definition fits."""
        return self._by_fingerprint.get(int.from_bytes(data[:8], "big")) if len(data) >= 8 else None

    def decode(self, data):
        """A message as an object with its members: numbers, texts, numpy arrays (structured ones for arrays of types of
        a fixed size), lists of the rest. Raises DecodeError unless the bytes are exactly one message."""
        message_type = self.of(data)
        if message_type is None:
            raise DecodeError(f"unknown type {bytes(data[:8]).hex()}")
        reader = _Reader(data)
        former = _FORMER_FINGERPRINTS.get(int.from_bytes(data[:8], "big"))
        message = reader.record(message_type, 0, former[1] if former else None)
        if reader.at != len(data):
            raise DecodeError(f"{message_type.name}: {len(data) - reader.at} bytes too many")
        return message


def _parse(text):
    tokens = [t for t in re.findall(r"//[^\n]*|/\*.*?\*/|[\w.+-]+|\S", text, re.S) if t[:2] not in ("//", "/*")]
    tokens.reverse()
    found = []

    def next_token(*expected):
        token = tokens.pop() if tokens else "the end"
        if expected and token not in expected:
            raise ValueError(f"expected '{expected[0]}', got '{token}'")
        return token

    while tokens:
        if next_token("struct", "package") == "package":
            next_token()
            next_token(";")
            continue
        name, fields = next_token(), []
        next_token("{")
        while (word := next_token()) != "}":
            if word == "the end":
                raise ValueError(f"{name} has no end")
            if word == "const":
                while next_token() not in (";", "the end"):
                    pass
                continue
            fields.append(_field(word, next_token, tokens, fields))
            while next_token(";", ",") == ",":
                fields.append(_field(word, next_token, tokens, fields))
        found.append(MessageType(name, fields))
    return found


def _field(type_name, next_token, tokens, before):
    name, dimensions = next_token(), []
    while tokens and tokens[-1] == "[":
        next_token("[")
        written = next_token()
        lengths = [f.name for f in before if f.type_name in _INTEGERS and not f.dimensions]
        if not written.isdigit() and written not in lengths:
            raise ValueError(f"{name}: array length '{written}' is no integer member before it")
        dimensions.append(int(written) if written.isdigit() else written)
        next_token("]")
    return Field(type_name, name, dimensions)


class _Reader:
    """LCM's wire format, never beyond the end."""

    def __init__(self, data):
        self.data, self.at = data, 8  # behind the fingerprint

    def record(self, message_type, depth, members=None):
        """`members`: how many of them there are; the rest are 0 and empty."""
        if depth > _MOST_NESTED:
            raise DecodeError(f"{message_type.name}: nested too deeply")
        record = types.SimpleNamespace()
        for field in message_type.fields[members:] if members else ():
            setattr(record, field.name, np.zeros(0, field.native) if field.dimensions else 0)
        for field in message_type.fields[:members]:
            shape = [getattr(record, d) if isinstance(d, str) else d for d in field.dimensions]
            for length in shape:
                # Every element takes at least one byte: a length beyond the rest of the message is a lie.
                if length < 0 or length > len(self.data) - self.at:
                    raise DecodeError(f"{field.name}: length {length} does not fit into the message")
            setattr(record, field.name, self._value(field, shape, depth))
        return record

    def _value(self, field, shape, depth):
        if field.dtype is not None and (shape or field.nested is None):
            array = self._numbers(field, shape)
            if shape:
                return array
            return bool(array) if field.type_name == "boolean" else array.item()
        if shape:
            return [self._value(field, shape[1:], depth) for _ in range(shape[0])]
        return self._text(field.name) if field.nested is None else self.record(field.nested, depth + 1)

    def _numbers(self, field, shape):
        count = 1
        for length in shape:
            count *= length
        begin = self.at
        self.at += count * field.dtype.itemsize
        if self.at > len(self.data):
            raise DecodeError(f"message ends before {field.name}")
        array = np.frombuffer(self.data, field.dtype, count, begin).reshape(shape)
        return array.astype(field.native)

    def _text(self, name):
        """Its length with the final NUL, then the bytes."""
        begin = self.at + 4
        length = int.from_bytes(self.data[self.at:begin], "big", signed=True)
        text = bytes(self.data[begin:begin + max(length, 0)])
        if length < 1 or len(text) != length or text.find(0) != length - 1:
            raise DecodeError(f"{name}: text of length {length} does not fit")
        self.at = begin + length
        return text[:-1].decode(errors="replace")
