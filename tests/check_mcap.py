#!/usr/bin/env python3
"""Reads a recording in MCAP as its specification says, sharing no code with Palpate, and prints what it holds as JSON.

    check_mcap.py FILE

Compares every CRC, every index, every offset and the statistics with what is there; exit 1 with one line where something is wrong.
Needs python3-zstandard. Small enough to be read beside https://mcap.dev/spec; the whole file is kept in memory.
"""
import json
import struct
import sys
import zlib
from collections import Counter

import zstandard

MAGIC = b"\x89MCAP0\r\n"
(HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX, ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA,
 METADATA_INDEX, SUMMARY_OFFSET, DATA_END) = range(1, 16)


class Wrong(Exception):
    pass


def expect(right, what):
    if not right:
        raise Wrong(what)


class Fields:
    """Reads the fields of one record one after the other."""

    def __init__(self, content, what):
        self.content, self.at, self.what = content, 0, what

    def bytes(self, size):
        expect(self.at + size <= len(self.content), f"{self.what}: is too short")
        self.at += size
        return self.content[self.at - size:self.at]

    def number(self, size):
        return int.from_bytes(self.bytes(size), "little")

    def numbers(self, *sizes):
        return tuple(self.number(size) for size in sizes)

    def text(self):
        return self.bytes(self.number(4)).decode()

    def pairs(self, *read):
        """A list of pairs, whose length in bytes stands before them."""
        end = self.number(4) + self.at
        expect(end <= len(self.content), f"{self.what}: is too short")
        found = []
        while self.at < end:
            found.append(tuple(one() for one in read))
        expect(self.at == end, f"{self.what}: a list has no whole pairs")
        return found

    def words(self):
        return dict(self.pairs(self.text, self.text))

    def counts(self):
        return dict(self.pairs(lambda: self.number(2), lambda: self.number(8)))


def records(data, begin, end):
    """(offset, length with head, opcode, content) of each record."""
    at = begin
    while at < end:
        expect(at + 9 <= end, f"byte {at}: no whole record")
        opcode, size = data[at], struct.unpack_from("<Q", data, at + 1)[0]
        expect(opcode != 0 and at + 9 + size <= end, f"byte {at}: record {opcode} does not fit")
        yield at, 9 + size, opcode, data[at + 9:at + 9 + size]
        at += 9 + size


class Recording:
    def __init__(self, data):
        self.data = data
        self.schemas, self.channels = {}, {}
        self.messages, self.sequences = Counter(), {}
        self.times = []
        self.chunks, self.attachments, self.metadata = {}, {}, {}
        self.library = ""

    def define(self, known, number, value, what):
        expect(known.setdefault(number, value) == value, f"{what} {number} is told twice, differently")

    def schema(self, fields):
        number = fields.number(2)
        expect(number != 0, "schema 0")
        self.define(self.schemas, number, (fields.text(), fields.text(), fields.bytes(fields.number(4))), "schema")

    def channel(self, fields):
        number, schema = fields.numbers(2, 2)
        expect(schema == 0 or schema in self.schemas, f"channel {number}: schema {schema} is not known")
        self.define(self.channels, number, (schema, fields.text(), fields.text(), fields.words()), "channel")

    def message(self, fields):
        channel, sequence, log_time, _ = fields.numbers(2, 4, 8, 8)
        expect(channel in self.channels, f"a message of channel {channel}, which is not known")
        expect(sequence > self.sequences.get(channel, -1), f"channel {channel}: sequence {sequence} does not grow")
        self.sequences[channel] = sequence
        self.messages[channel] += 1
        self.times.append(log_time)
        return channel, log_time

    def chunk(self, offset, length, fields):
        start, end, size, crc = fields.numbers(8, 8, 8, 4)
        packing = fields.text()
        packed = fields.bytes(fields.number(8))
        what = f"chunk at byte {offset}"
        expect(packing in ("", "zstd"), f"{what}: packing '{packing}'")
        inside = packed if packing == "" else zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
        expect(len(inside) == size, f"{what}: holds {len(inside)} bytes, not {size}")
        expect(crc == zlib.crc32(inside), f"{what}: CRC")
        places = {}
        for at, _, opcode, content in records(inside, 0, len(inside)):
            inner = Fields(content, f"{what}, byte {at} of it")
            if opcode == SCHEMA:
                self.schema(inner)
            elif opcode == CHANNEL:
                self.channel(inner)
            elif opcode == MESSAGE:
                channel, log_time = self.message(inner)
                places.setdefault(channel, []).append((log_time, at))
            else:
                raise Wrong(f"{what}: record {opcode} in it")
        times = [time for list_ in places.values() for time, _ in list_]
        expect((start, end) == ((min(times), max(times)) if times else (0, 0)), f"{what}: its times")
        return {"start": start, "end": end, "length": length, "offsets": {}, "indexes": 0, "packing": packing,
                "packed": len(packed), "size": size, "places": places}

    def data_section(self):
        """Everything until DataEnd; returns where the summary begins."""
        data, chunk = self.data, None
        for offset, length, opcode, content in records(data, len(MAGIC), len(data) - len(MAGIC)):
            fields = Fields(content, f"record {opcode} at byte {offset}")
            expect((offset == len(MAGIC)) == (opcode == HEADER), f"{fields.what}: the header comes first, once")
            if opcode == HEADER:
                _, self.library = fields.text(), fields.text()
            elif opcode == SCHEMA:
                self.schema(fields)
            elif opcode == CHANNEL:
                self.channel(fields)
            elif opcode == CHUNK:
                chunk = self.chunks[offset] = self.chunk(offset, length, fields)
            elif opcode == MESSAGE_INDEX:
                channel = fields.number(2)
                places = fields.pairs(lambda f=fields: f.number(8), lambda f=fields: f.number(8))
                expect(chunk is not None and sorted(places) == sorted(chunk["places"].get(channel, [])), f"{fields.what}: differs from its chunk")
                chunk["offsets"][channel] = offset
                chunk["indexes"] += length
            elif opcode == ATTACHMENT:
                log_time, create_time = fields.numbers(8, 8)
                name, media_type = fields.text(), fields.text()
                size = len(fields.bytes(fields.number(8)))
                expect(fields.number(4) == zlib.crc32(content[:-4]), f"attachment '{name}': CRC")
                self.attachments[offset] = (length, log_time, create_time, size, name, media_type)
            elif opcode == METADATA:
                name, _ = fields.text(), fields.words()
                self.metadata[offset] = (length, name)
            elif opcode == DATA_END:
                expect(fields.number(4) == zlib.crc32(data[:offset]), "DataEnd: CRC")
                return offset + length
            else:
                raise Wrong(f"{fields.what}: has no place among the data")
        raise Wrong("no DataEnd")

    def statistics(self, fields):
        told = fields.numbers(8, 2, 4, 4, 4, 4, 8, 8)
        times = (min(self.times), max(self.times)) if self.times else (0, 0)
        expect(told == (len(self.times), len(self.schemas), len(self.channels), len(self.attachments), len(self.metadata),
                        len(self.chunks), *times), "statistics")
        expect(fields.counts() == dict(self.messages), "statistics: messages of channels")

    def chunk_index(self, fields):
        start, end, offset, length = fields.numbers(8, 8, 8, 8)
        offsets, indexes, packing = fields.counts(), fields.number(8), fields.text()
        packed, size = fields.numbers(8, 8)
        chunk = self.chunks.get(offset)
        expect(chunk is not None, f"chunk index: no chunk is at byte {offset}")
        expect({"start": start, "end": end, "length": length, "offsets": offsets, "indexes": indexes, "packing": packing,
                "packed": packed, "size": size, "places": chunk["places"]} == chunk, f"chunk index of byte {offset}")
        expect(set(offsets) == set(chunk["places"]), f"chunk at byte {offset}: its indexes")

    def summary(self, begin):
        data, end = self.data, len(self.data) - len(MAGIC)
        groups, counts = {}, Counter()
        for offset, length, opcode, content in records(data, begin, end):
            fields = Fields(content, f"record {opcode} at byte {offset}")
            counts[opcode] += 1
            first, size = groups.get(opcode, (offset, 0))
            expect(first + size == offset, f"{fields.what}: its group is not in one piece")
            groups[opcode] = (first, size + length)
            if opcode == SCHEMA:
                expect(fields.number(2) in self.schemas, f"{fields.what}: not in the data")
                self.schema(Fields(content, fields.what))
            elif opcode == CHANNEL:
                expect(fields.number(2) in self.channels, f"{fields.what}: not in the data")
                self.channel(Fields(content, fields.what))
            elif opcode == STATISTICS:
                self.statistics(fields)
            elif opcode == CHUNK_INDEX:
                self.chunk_index(fields)
            elif opcode == ATTACHMENT_INDEX:
                place, size_ = fields.numbers(8, 8)
                told = (size_, *fields.numbers(8, 8, 8), fields.text(), fields.text())
                expect(self.attachments.get(place) == told, f"{fields.what}: no such attachment")
            elif opcode == METADATA_INDEX:
                place, size_ = fields.numbers(8, 8)
                expect(self.metadata.get(place) == (size_, fields.text()), f"{fields.what}: no such metadata")
            elif opcode == SUMMARY_OFFSET:
                group, *told = fields.numbers(1, 8, 8)
                expect(groups.get(group) == tuple(told), f"{fields.what}: no such group")
            elif opcode == FOOTER:
                expect(offset + length == end, "something stands behind the footer")
                told, offsets_begin, crc = fields.numbers(8, 8, 4)
                expect(told == begin and offsets_begin == groups[SUMMARY_OFFSET][0], "footer: offsets")
                expect(crc == zlib.crc32(data[begin:end - 4]), "footer: CRC")
            else:
                raise Wrong(f"{fields.what}: has no place in the summary")
        expect(counts[FOOTER] == 1 and counts[STATISTICS] == 1, "footer or statistics")
        for opcode, there in ((SCHEMA, self.schemas), (CHANNEL, self.channels), (CHUNK_INDEX, self.chunks),
                              (ATTACHMENT_INDEX, self.attachments), (METADATA_INDEX, self.metadata)):
            expect(counts[opcode] == len(there), f"the summary has {counts[opcode]} records {opcode} for {len(there)}")
        expect(counts[SUMMARY_OFFSET] == len(groups) - 2, "the summary has not an offset for each group")

    def check(self):
        expect(self.data[:8] == MAGIC and self.data[-8:] == MAGIC and len(self.data) >= 16, "magic")
        self.summary(self.data_section())
        topics = Counter()
        for number, (_, topic, _, _) in self.channels.items():
            topics[topic] += self.messages[number]
        return {"library": self.library, "topics": dict(sorted(topics.items())), "messages": len(self.times),
                "seconds": (max(self.times) - min(self.times)) * 1e-9 if self.times else 0.0, "chunks": len(self.chunks),
                "attachments": sorted(entry[4] for entry in self.attachments.values()),
                "metadata": sorted(entry[1] for entry in self.metadata.values())}


def check(path):
    with open(path, "rb") as file:
        return Recording(file.read()).check()


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        print(json.dumps(check(sys.argv[1]), indent=2))
    except (Wrong, zstandard.ZstdError, UnicodeDecodeError) as error:
        print(f"{sys.argv[1]}: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
