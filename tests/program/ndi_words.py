"""Messages of NDI's combined API as bytes, from its published guides; nothing of the program."""
import struct

# The checksum, by a table of nibbles.
TABLE = [0x0000, 0xCC01, 0xD801, 0x1400, 0xF001, 0x3C00, 0x2800, 0xE401, 0xA001, 0x6C00, 0x7800, 0xB401, 0x5000, 0x9C01, 0x8801, 0x4400]


def checksum(data):
    crc = 0
    for byte in data:
        for nibble in (byte & 15, byte >> 4):
            crc = (crc >> 4) ^ TABLE[(crc ^ nibble) & 15]
    return crc


def text(words):
    """A command or a reply."""
    words = words.encode()
    return words + f"{checksum(words):04X}\r".encode()


def bare(line):
    """The words of a line without CR, whose checksum is right."""
    words, said = line[:-4], line[-4:]
    assert said == f"{checksum(words):04X}".encode(), line
    return words.decode()


def binary(body):
    head = struct.pack("<HH", 0xA5C4, len(body))
    return head + struct.pack("<H", checksum(head)) + body + struct.pack("<H", checksum(body))


def component(kind, count, items):
    return struct.pack("<HIHI", kind, 12 + len(items), 0, count) + items


def frame(number, ns, tools):
    """A body of BX2 with one frame; tools are (handle, w x y z, mm), or (handle, None, None) where missing."""
    items = b"".join(struct.pack("<HH", handle, 0x10D if turn is None else 0) + (b"" if turn is None else struct.pack("<8f", *turn, *place, 0.1)) for handle, turn, place in tools)
    head = struct.pack("<BBHIII", 2, 0, 0, number, ns // 10**9, ns % 10**9)
    return struct.pack("<HH", 1, 1) + component(1, 1, head + struct.pack("<HH", 1, 1) + component(2, len(tools), items))


def handles(number, tools):
    """A body of BX."""
    body = bytes([len(tools)])
    for handle, turn, place in tools:
        body += bytes([handle, 2 if turn is None else 1])
        if turn is not None:
            body += struct.pack("<8f", *turn, *place, 0.1)
        body += struct.pack("<II", 0x31, number)
    return body + b"\0\0"


def frames_of(body):
    """(number, ns, {handle: numbers or None}) of each frame in a body of BX2."""
    def components(at):
        _, count = struct.unpack_from("<HH", body, at)
        at += 4
        for _ in range(count):
            kind, size, _, items = struct.unpack_from("<HIHI", body, at)
            yield kind, items, at + 12
            at += size

    for kind, _, at in components(0):
        if kind != 1:
            continue
        _, _, _, number, s, ns = struct.unpack_from("<BBHIII", body, at)
        tools = {}
        for inner, count, place in components(at + 16):
            for _ in range(count if inner == 2 else 0):
                handle, status = struct.unpack_from("<HH", body, place)
                tools[handle] = None if status & 0x100 else struct.unpack_from("<8f", body, place + 4)
                place += 4 if status & 0x100 else 36
        yield number, s * 10**9 + ns, tools


def handles_of(body):
    """{handle: (numbers or None, frame)} of a body of BX."""
    at, tools = 1, {}
    for _ in range(body[0]):
        handle, state = body[at], body[at + 1]
        at += 2
        numbers = struct.unpack_from("<8f", body, at) if state == 1 else None
        at += 32 if state == 1 else 0
        tools[handle] = (numbers, struct.unpack_from("<I", body, at + 4)[0]) if state != 4 else (None, None)
        at += 8 if state != 4 else 0
    assert at + 2 == len(body)
    return tools


def columns_of(words):
    """The same of a reply to TX."""
    tools = {}
    for line in words.split("\n")[:-1]:
        line = line if tools else line[2:]  # how many, before the first
        handle, line = int(line[:2], 16), line[2:]
        if line.startswith("MISSING") or line.startswith("DISABLED"):
            tools[handle] = (None, int(line[-8:], 16))
            continue
        cuts = [0, 6, 12, 18, 24, 31, 38, 45, 51]
        numbers = [int(line[a:b]) for a, b in zip(cuts, cuts[1:])]
        tools[handle] = ([n / 1e4 for n in numbers[:4]] + [n / 100 for n in numbers[4:7]], int(line[59:67], 16))
    return tools
