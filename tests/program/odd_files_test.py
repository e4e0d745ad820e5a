#!/usr/bin/env python3
"""Files that are none: pipes, devices, folders, links in a circle, files without an end, settings made to break their reader, pictures whose heads
lie, names that steer a terminal. Each is answered with a line of words, at once, and nobody waits."""
import os
import socket
import struct
import subprocess
import time
import unittest
import zlib

from program import PROGRAM, ProgramTest

POSES = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
AT_ONCE_S = 20.0  # what takes a fraction of a second, on a busy machine and under sanitizers; a hang takes for ever
# C0 without line end, DEL, C1, marks and overrides of direction, separators, invisible ones.
CONTROLS = {*range(0x20), *range(0x7F, 0xA0), 0x061C, 0x200B, 0x200E, 0x200F, *range(0x2028, 0x202F), *range(0x2060, 0x2070), 0xFEFF} - {0x0A}
NAME = "Rig\u202egnihton\u2066\u009b31m\u200f\ufeff"
READERS = {
    "rig": ["rig", "check", "FILE"],
    "world": ["world", "show", "FILE"],
    "board": ["calibrate", "camera", "--images", "absent.png", "--board", "FILE"],
    "arm model": ["calibrate", "arm", "--samples", "good.csv", "--arm", "FILE"],
    "settings": ["picture", "--out", "x.png", "--settings", "FILE"],
    "poses": ["calibrate", "pivot", "--poses", "FILE"],
    "points": ["calibrate", "points", "--from", "FILE", "--to", "good.csv"],
    "samples": ["calibrate", "arm", "--samples", "FILE", "--arm", "phantom-premium-1.5"],
    "corners": ["calibrate", "camera", "--corners", "FILE"],
    "image": ["calibrate", "camera", "--images", "FILE", "--board", "9x6"],
    "mesh": ["picture", "--app", "touch", "--mesh", "FILE", "--out", "x.png"],
    "replay": ["tracker", "replay", "FILE"],
}


def png(width, height):
    """A black picture whose rows are all there."""
    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    packer = zlib.compressobj(1)
    rows = b"".join(packer.compress(bytes(1 + width)) for _ in range(height)) + packer.flush()
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


class OddFiles(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("good.csv", "x_mm,y_mm,z_mm\n1,2,3\n")

    def answer(self, reader, file, **how):
        """The one line in which the reader refuses the file."""
        command = [file if word == "FILE" else word for word in READERS[reader]]
        begun = time.monotonic()
        done = subprocess.run([PROGRAM, *command], stdin=subprocess.DEVNULL, capture_output=True, timeout=AT_ONCE_S, check=False,
                              env=self.environment, cwd=self.folder, **how)
        lines = done.stderr.decode().splitlines()
        self.assertIn(done.returncode, (1, 2), f"{command}: {done}")
        self.assertEqual(len(lines), 1, f"{command}: {done}")
        self.assertFalse(CONTROLS & {ord(c) for c in lines[0]}, lines)
        self.assertLess(time.monotonic() - begun, AT_ONCE_S)
        return lines[0]

    def test_what_is_no_plain_file_is_refused_by_every_reader(self):
        os.mkfifo(self.path("pipe.toml"))
        os.symlink("/dev/zero", self.path("zero.toml"))
        for reader in READERS:
            for file, words in (("pipe.toml", "is a pipe"), ("zero.toml", "is a device")):
                with self.subTest(reader=reader, file=file):
                    self.assertIn(words, self.answer(reader, file))

    def test_folders_circles_sockets_and_files_without_an_end_too(self):
        os.mkdir(self.path("folder"))
        os.symlink("circle", self.path("circle"))
        os.symlink("/dev/urandom", self.path("noise"))
        self.write("empty", "")
        with open(self.path("sparse"), "wb") as file:
            file.truncate(1 << 30)
        listening = socket.socket(socket.AF_UNIX)
        self.addCleanup(listening.close)
        listening.bind(self.path("socket"))
        for reader in ("rig", "poses", "mesh", "image"):
            for file in ("folder", "circle", "noise", "empty", "sparse", "socket"):
                with self.subTest(reader=reader, file=file):
                    line = self.answer(reader, file)
                    if file in ("noise", "socket"):
                        self.assertIn("is a ", line)
                    if file == "sparse":
                        self.assertRegex(line, "holds 1073741824 bytes; at most [0-9]+ are expected")

    def test_settings_made_to_break_their_reader_are_refused_with_their_line(self):
        deep = ".".join("a" * 60000)
        odd = {
            "[" + deep + "]\n": "odd.toml:1: has a key of more than 33 parts", "x = 1\n" + deep + " = 1\n": "odd.toml:2: ", "x = {" + deep + " = 1}\n": "odd.toml:1: ",
            "x = " + "[" * 100000 + "\n": "odd.toml:1: has more than 32 brackets", "x = " + "{a=" * 100000 + "\n": "odd.toml:1: ",
            "".join(f"[[a{i}]]\n[[a{i}]]\n" for i in range(100000)): "more than 20000 tables",
            "# nothing but words\n" * 250000: "at most 4000000",
        }
        for reader in ("rig", "world", "arm model", "settings"):
            for content, words in list(odd.items())[:None if reader == "rig" else 1]:  # all go through one parser
                with self.subTest(reader=reader, content=content[:20]):
                    self.write("odd.toml", content)
                    self.assertIn(words, self.answer(reader, "odd.toml"))
        self.write("odd.toml", "a = 1\n\0")
        self.assertIn("odd.toml:2: holds a zero byte", self.answer("settings", "odd.toml"))
        self.assertIn("odd.toml: is not a text file; a rig file is expected", self.answer("rig", "odd.toml"))

    def test_a_board_is_settings_too(self):
        self.write("odd.toml", "[" + ".".join("a" * 60000) + "]\n")
        self.assertIn("odd.toml:1: has a key of more than 33 parts", self.answer("board", "odd.toml"))

    def test_dots_in_texts_are_no_keys(self):
        self.runs("rig", "new", "rig.toml")
        rig = self.read("rig.toml").decode().replace('name = "rig"', "name = '''" + "." * 500 + "'''")
        self.assertIn("." * 500, rig)
        self.write("rig.toml", rig)
        self.runs("rig", "show", "rig.toml")

    def test_a_picture_is_measured_before_it_is_unpacked(self):
        self.write("large.png", png(16384, 16384))
        self.assertIn("large.png: is a picture of 16384x16384 px; at most 64 million pixels", self.answer("image", "large.png"))

    def test_a_table_is_read_in_time_or_refused(self):
        self.write("long.csv", POSES + "0,1,2,3,1,0,0,0\n" * 4000001)
        self.assertIn("at most 4000000 rows", self.answer("poses", "long.csv"))

    def test_a_pipe_that_nobody_reads_is_refused_and_one_that_somebody_reads_later_is_not(self):
        os.mkfifo(self.path("pipe.png"))
        self.runs("world", "sample", "pivot", "--points", "20", "--out", "samples")
        pivot = ["calibrate", "pivot", "--poses", "samples/pivot.csv"]
        for command in ([*pivot, "--json", "pipe.png"], [*pivot, "--out", "pipe.png"], ["picture", "--out", "pipe.png"], ["--log", "pipe.png", "apps"]):
            with self.subTest(command=command):
                self.says_no(self.run_program(*command), 2, "pipe.png", "nobody reads")
        # A reader that is started at the same time gets everything, also what no pipe holds at once.
        self.runs("picture", "--out", "whole.png")
        with open(self.path("got.png"), "wb") as got:
            reader = subprocess.Popen(["cat", self.path("pipe.png")], stdout=got)
        self.addCleanup(reader.wait)
        self.addCleanup(reader.kill)
        self.runs("picture", "--out", "pipe.png")
        reader.wait()
        self.assertEqual(self.read("got.png"), self.read("whole.png"))

    def test_names_of_rigs_and_worlds_steer_no_terminal(self):
        self.runs("rig", "new", "rig.toml")
        escaped = "".join(f"\\u{ord(c):04x}" for c in NAME)
        for name in (f'"{escaped}\\u001b[31m"', f"'{NAME}'"):
            rig = self.read("rig.toml").decode()
            at = rig.index("name = ")
            self.write("odd.toml", rig[:at] + f"name = {name}" + rig[rig.index("\n", at):])
            self.shows_nothing_odd("rig", "show", "odd.toml")
            self.shows_nothing_odd("rig", "check", "odd.toml")
        self.write("odd.toml", f'[scene]\n"{escaped}" = 1\n')
        for command in (["world", "show", "odd.toml"], ["rig", "show", "odd.toml"]):
            self.shows_nothing_odd(*command)
        self.write("odd.csv", f"label,x_mm,y_mm,z_mm\n{NAME},1,2,3\n")
        self.shows_nothing_odd("calibrate", "points", "--from", "odd.csv", "--to", "odd.csv")

    def test_paths_and_words_of_the_command_line_steer_no_terminal(self):
        name = f"a\x1b[31m{NAME}.toml"
        self.write(name, "x")
        for command in (["rig", "show", name], ["rig", "check", "absent" + name], ["calibrate", "pivot", "--poses", name], [name], ["demo", "--" + name],
                        ["picture", "--out", name], ["calibrate", "camera", "--images", name], ["status", "--connect", name]):
            self.shows_nothing_odd(*command)
        self.runs("rig", "new", name + "2")
        self.shows_nothing_odd("rig", "new", name + "2")

    def shows_nothing_odd(self, *command):
        done = self.run_program(*command)
        with self.subTest(command=command):
            self.assertFalse(CONTROLS & {ord(c) for c in done.out + done.err}, (done.out, done.err))
            self.assertTrue(done.out + done.err)


if __name__ == "__main__":
    unittest.main()
