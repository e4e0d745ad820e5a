#!/usr/bin/env python3
"""Recordings as columns: messages that Python's own protobuf has written, and the program's own tables beside them."""
import csv
import math
import os
import pathlib
import struct
import subprocess
import tempfile
import unittest

import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

import palpate

PROGRAM = os.environ["PALPATE"]
PROTO = pathlib.Path(__file__).parents[2] / "proto"
START_NS = 1_700_000_000_000_000_000


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


class Writer:
    """A recording in MCAP without chunks or summary (https://mcap.dev/spec)."""

    def __init__(self, descriptors):
        self.parts = [b"\x89MCAP0\r\n", record(1, text("") + text("test"))]
        self.descriptors, self.channels = descriptors, {}

    def write(self, topic, message, ms):
        if topic not in self.channels:
            number = len(self.channels) + 1
            self.channels[topic] = number
            self.parts.append(record(3, struct.pack("<H", number) + text(message.DESCRIPTOR.full_name) + text("protobuf")
                                     + struct.pack("<I", len(self.descriptors)) + self.descriptors))
            self.parts.append(record(4, struct.pack("<HH", number, number) + text(topic) + text("protobuf") + struct.pack("<I", 0)))
        when = START_NS + 1_000_000 * ms
        self.parts.append(record(5, struct.pack("<HIQQ", self.channels[topic], ms, when, when) + message.SerializeToString()))

    def end(self, path, cut=0):
        tail = record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + b"\x89MCAP0\r\n"
        content = b"".join(self.parts) + tail
        path.write_bytes(content[:len(content) - cut])


class RecordingColumns(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        described = cls.folder / "descriptors"
        subprocess.run(["protoc", "-I", str(PROTO), "--include_imports", f"--descriptor_set_out={described}", "palpate_recording.proto"], check=True)
        cls.descriptors = described.read_bytes()
        pool = descriptor_pool.DescriptorPool()
        for file in descriptor_pb2.FileDescriptorSet.FromString(cls.descriptors).file:
            pool.Add(file)
        factory = message_factory.MessageFactory(pool)
        cls.message = staticmethod(lambda name: factory.GetPrototype(pool.FindMessageTypeByName(name))())
        writer = Writer(cls.descriptors)
        cls.samples, cls.states = [], []
        for ms in range(200):
            sample = cls.message("palpate.recording.ArmSample")
            sample.tick, sample.stamp_ns, sample.connected = ms + 1, -5 + ms, ms % 2 == 0
            sample.joints_rad.extend([0.1 * ms, -math.pi, 1e-300][: 3 if ms != 7 else 2])
            sample.inputs.extend(range(ms % 4))
            if ms >= 3:
                sample.gimbal_rad.x, sample.gimbal_rad.z = 1.0 / (ms + 1), -2.5
            writer.write("/arm/sample", sample, ms)
            cls.samples.append(sample)
            if ms % 10 == 0:
                condition = cls.message("palpate.recording.Condition")
                condition.code, condition.holds, condition.words = 2, ms > 50, f"the tracker lost sight: {ms} \u00b5s"
                writer.write("/condition", condition, ms)
            frame = cls.message("palpate.recording.Frame")
            frame.number = 2**63 + ms
            if ms % 3 == 0:
                frame.expected_world_px = 0.25 * ms
            writer.write("/frame", frame, ms)
        cls.path, cls.torn = cls.folder / "whole.mcap", cls.folder / "torn.mcap"
        writer.end(cls.path)
        writer.end(cls.torn, cut=100)

    def test_numbers_lists_and_messages_within(self):
        topic = palpate.Recording(self.path)["/arm/sample"]
        self.assertEqual((len(topic), topic.schema, topic.unread), (200, "palpate.recording.ArmSample", 0))
        np.testing.assert_array_equal(topic["tick"], np.arange(1, 201, dtype=np.uint64))
        self.assertEqual((topic["tick"].dtype, topic["stamp_ns"].dtype, topic["connected"].dtype), (np.uint64, np.int64, np.bool_))
        np.testing.assert_array_equal(topic["stamp_ns"], [sample.stamp_ns for sample in self.samples])
        np.testing.assert_array_equal(topic["connected"], [sample.connected for sample in self.samples])
        joints = np.full((200, 3), np.nan)
        inputs = np.zeros((200, 3))
        for i, sample in enumerate(self.samples):
            joints[i, :len(sample.joints_rad)] = sample.joints_rad
            inputs[i, :len(sample.inputs)] = sample.inputs
        np.testing.assert_array_equal(topic["joints_rad"], joints)
        np.testing.assert_array_equal(topic["inputs"], inputs)
        gimbal = topic["gimbal_rad"]
        self.assertTrue(np.isnan(gimbal[:3]).all())
        np.testing.assert_array_equal(gimbal[3:], [(s.gimbal_rad.x, s.gimbal_rad.y, s.gimbal_rad.z) for s in self.samples[3:]])
        np.testing.assert_allclose(topic.time, np.arange(200) / 1e3, atol=1e-12)
        with self.assertRaises(ValueError):
            topic["tick"][0] = 0

    def test_words_enumerations_and_what_is_absent(self):
        recording = palpate.Recording(self.path)
        conditions = recording["/condition"]
        self.assertEqual(conditions["words"][2], "the tracker lost sight: 20 \u00b5s")
        np.testing.assert_array_equal(conditions["code"], np.full(20, 2))
        frames = recording["/frame"]
        self.assertEqual(int(frames["number"][5]), 2**63 + 5)
        expected = np.where(np.arange(200) % 3 == 0, 0.25 * np.arange(200), np.nan)
        np.testing.assert_array_equal(frames["expected_world_px"], expected)

    def test_the_program_writes_the_same_numbers(self):
        subprocess.run([PROGRAM, "recording", "export", str(self.path), "--csv", str(self.folder / "tables")], check=True, capture_output=True)
        topic = palpate.Recording(self.path)["/arm/sample"]
        with (self.folder / "tables" / "arm_sample.csv").open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), len(topic))
        np.testing.assert_array_equal([int(row["log_time_ns"]) for row in rows], topic.log_time_ns)
        for k in range(2):
            np.testing.assert_array_equal([float(row[f"joints_rad.{k}"]) for row in rows], topic["joints_rad"][:, k])

    def test_a_part_of_it(self):
        part = palpate.Recording(self.path).topic("/arm/sample", from_s=0.0495, to_s=0.0605)
        np.testing.assert_array_equal(part["tick"], np.arange(51, 62))
        self.assertAlmostEqual(part.time[0], 0.05, 9)

    def test_what_is_torn_is_read_as_far_as_it_is_sound(self):
        recording = palpate.Recording(self.torn)
        self.assertTrue(recording.faults)
        self.assertEqual(palpate.Recording(self.path).faults, ())
        self.assertGreaterEqual(len(recording["/arm/sample"]), 198)

    def test_what_is_not_there(self):
        recording = palpate.Recording(self.path)
        with self.assertRaisesRegex(KeyError, "/arm/sample"):
            recording["/nothing"]
        with self.assertRaisesRegex(KeyError, "joints_rad"):
            recording["/arm/sample"]["speed"]
        none = self.folder / "none.mcap"
        none.write_bytes(b"no recording")
        with self.assertRaises((palpate.Refused, ValueError)):
            palpate.Recording(none)

    def test_a_table_of_pandas(self):
        """With pandas; without it the words name what is missing."""
        topic = palpate.Recording(self.path)["/arm/sample"]
        try:
            import pandas  # noqa: F401
        except ImportError:
            with self.assertRaisesRegex(ImportError, "pandas"):
                topic.to_dataframe()
            return
        table = topic.to_dataframe()
        self.assertEqual(len(table), 200)
        np.testing.assert_array_equal(table["joints_rad.0"], topic["joints_rad"][:, 0])


if __name__ == "__main__":
    unittest.main()
