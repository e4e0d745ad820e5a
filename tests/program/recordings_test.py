#!/usr/bin/env python3
"""palpate recording: what it says of a session's recording, beside a checker that shares no code with it."""
import json
import os
import struct
import subprocess
import sys
import unittest

from full_disk_test import room_for
from program import ProgramTest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import check_mcap  # noqa: E402

MESSAGES = {"/arm/sample": 3000, "/camera/left/image": 30}


def record(opcode, content):
    return bytes([opcode]) + struct.pack("<Q", len(content)) + content


def text(words):
    return struct.pack("<I", len(words)) + words


def of_others(messages):
    """Without chunks, summary and CRCs, as the format allows."""
    data = check_mcap.MAGIC + record(1, text(b"") + text(b"others 3"))
    data += record(4, struct.pack("<HH", 5, 0) + text(b"/t") + text(b"raw") + struct.pack("<I", 0))
    for i in range(messages):
        data += record(5, struct.pack("<HIQQ", 5, i, 10**9 * i, 0) + b"data")
    return data + record(15, bytes(4)) + record(2, bytes(20)) + check_mcap.MAGIC


class Recordings(ProgramTest):
    def setUp(self):
        super().setUp()
        self.sample = self.path("s.mcap")
        subprocess.run([os.environ["SAMPLE_RECORDING"], self.sample], check=True)

    def test_info_counts_what_the_checker_counts(self):
        seen = check_mcap.check(self.sample)
        told = json.loads(self.runs("recording", "info", "s.mcap", "--json", "-").out)
        self.assertEqual({s["name"]: s["messages"] for s in told["streams"] if s["messages"]}, seen["topics"])
        self.assertEqual(seen["topics"], MESSAGES)
        self.assertEqual(seen["attachments"], ["rig.toml", "world.toml"])
        self.assertEqual(seen["metadata"], ["palpate.drops", "session"])
        self.assertAlmostEqual(told["seconds"], 2.999, 9)
        self.assertAlmostEqual(seen["seconds"], 2.999, 6)
        self.assertTrue(told["complete"])
        self.assertEqual("palpate " + told["version"], seen["library"])
        rates = {s["name"]: (s["rate_hz"], s["dropped"]) for s in told["streams"]}
        self.assertEqual(rates.keys(), MESSAGES.keys() | {"/trip"})
        self.assertAlmostEqual(rates["/arm/sample"][0], 1000.0, 6)
        self.assertAlmostEqual(rates["/camera/left/image"][0], 10.0, 6)
        self.assertEqual({dropped for _, dropped in rates.values()}, {0})
        words = self.runs("recording", "info", "s.mcap").out
        for expected in ("2.999 s", "/arm/sample", "1000.00 Hz", "whole        yes"):
            self.assertIn(expected, words)

    def test_check_names_the_first_fault(self):
        self.assertIn("3030 messages", self.runs("recording", "check", "s.mcap").out)
        good = self.read("s.mcap")
        bad = bytearray(good)
        bad[len(bad) // 2] ^= 1
        self.write("bad.mcap", bytes(bad))
        with self.assertRaises(Exception):
            check_mcap.check(self.path("bad.mcap"))
        done = self.run_program("recording", "check", "bad.mcap", "--json", "bad.json")
        self.says_no(done, 1, "bad.mcap: is not sound (byte ", "palpate recording repair")
        report = json.loads(self.read("bad.json"))
        self.assertFalse(report["sound"])
        self.assertIn(f"byte {report['faults'][0]['byte']}: {report['faults'][0]['what']}", done.err)
        self.write("cut.mcap", good[:-100])
        self.says_no(self.run_program("recording", "check", "cut.mcap"), 1, "byte ")
        self.assertFalse(json.loads(self.runs("recording", "info", "cut.mcap", "--json", "-").out)["complete"])

    def test_repair_gives_a_whole_recording(self):
        good = self.read("s.mcap")
        for size in (len(good) // 3, len(good) // 2, len(good) - 1):
            with self.subTest(size):
                self.write("cut.mcap", good[:size])
                told = self.runs("recording", "repair", "cut.mcap", "out.mcap").out
                seen = check_mcap.check(self.path("out.mcap"))
                self.assertIn(f"kept         {seen['messages']} messages", told)
                self.assertIn("fault        byte ", told)
                self.assertIn("palpate.repair", seen["metadata"])
                self.runs("recording", "check", "out.mcap")
        self.assertEqual(seen["topics"], MESSAGES)

    def test_cut_takes_times_and_topics(self):
        self.runs("recording", "cut", "s.mcap", "out.mcap", "--from", "1", "--to", "1.5", "--topic", "/arm/sample")
        self.assertEqual(check_mcap.check(self.path("out.mcap"))["topics"], {"/arm/sample": 501})
        again = self.runs("recording", "cut", "--topic", "/arm/sample", "--topic", "/camera/left/image", "s.mcap", "out.mcap", "--from", "2.5")
        self.assertIn("out.mcap: replaced the file of that name", again.err)
        self.assertEqual(check_mcap.check(self.path("out.mcap"))["topics"], {"/arm/sample": 500, "/camera/left/image": 5})
        with open(self.path("piped.mcap"), "wb") as out:
            done = self.run_program("recording", "cut", "s.mcap", "-", "--to", "0.1", stdout=out)
        self.assertEqual(done.code, 0, done)
        self.assertEqual(check_mcap.check(self.path("piped.mcap"))["messages"], 101 + 2)
        for arguments, words in ((["--from", "7"], "it lasts 2.999 s"), (["--topic", "/none"], "no message of /none from 0 s to its end"), (["--topic", "/none"], "info lists them")):
            self.refuses(["recording", "cut", "s.mcap", "new.mcap", *arguments], 1, "s.mcap", words)
        self.refuses(["recording", "cut", "s.mcap", "new.mcap", "--from", "2", "--to", "1"], 2, "--from 2")
        self.refuses(["recording", "cut", "s.mcap", "new.mcap", "--from", "-1"], 2, "--from")

    def test_files_of_others_are_read_and_become_ours(self):
        self.write("others.mcap", of_others(11))
        self.runs("recording", "check", "others.mcap")
        told = json.loads(self.runs("recording", "info", "others.mcap", "--json", "-").out)
        self.assertEqual((told["seconds"], told["version"], told["streams"]),
                         (10.0, "others 3", [{"name": "/t", "messages": 11, "dropped": 0, "rate_hz": 1.0}]))
        self.runs("recording", "repair", "others.mcap", "out.mcap")
        self.assertEqual(check_mcap.check(self.path("out.mcap"))["topics"], {"/t": 11})

    def test_what_is_no_recording_is_refused(self):
        self.write("poses.csv", "time_s,x_mm\n" * 100)
        self.write("empty.mcap", "")
        os.mkdir(self.path("folder"))
        os.mkfifo(self.path("pipe"))
        for command in (["info"], ["check"], ["repair", "new.mcap"], ["cut", "new.mcap"]):
            for name in ("missing.mcap", "folder", "pipe", "/dev/zero"):
                with self.subTest(command=command, name=name):
                    self.refuses(["recording", command[0], name, *command[1:]], 2, name)
            for name in ("poses.csv", "empty.mcap"):
                with self.subTest(command=command, name=name):
                    self.refuses(["recording", command[0], name, *command[1:]], 2 if command == ["info"] else 1, name)
        self.refuses(["recording", "repair", "s.mcap", "s.mcap"], 2, "a file of its own")
        # OUT comes first: forgotten, it would be a recording that is there.
        for command in (["merge", "new.mcap", "s.mcap"], ["import", "new.mcap", "poses.csv"]):
            self.write("new.mcap", "mine")
            self.refuses(["recording", *command], 2, "new.mcap: exists already", "comes first")
            self.assertEqual(self.read("new.mcap"), b"mine")
        self.refuses(["recording", "repair", "s.mcap", "nowhere/s.mcap"], 2, "create it first")
        self.refuses(["recording", "repair", "s.mcap", "/dev/full"], 2, "/dev/full")

    def test_a_copy_that_does_not_fit_is_not_begun(self):
        for command in ("repair", "cut"):
            self.refuses(["recording", command, "s.mcap", "new.mcap"], 1, "new.mcap", "nothing was changed", before=room_for(4096))
        with open("/dev/full", "wb") as full:
            done = self.run_program("recording", "repair", "s.mcap", "-", stdout=full)
        self.assertEqual(done.code, 1, done)
        self.assertIn("standard output", done.lines[-1])


if __name__ == "__main__":
    unittest.main()
