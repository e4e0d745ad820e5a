#!/usr/bin/env python3
"""A picture for each eye: two cameras of a laboratory, two recordings, and what goes with two cameras only."""
import json
import os
import signal
import struct
import unittest
import zlib

from laboratory import LaboratoryTest
from program import wait_until


def png(width, height):
    """A black picture."""
    def chunk(name, content):
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
    rows = height * (b"\0" + bytes(3 * width))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


class TwoEyes(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.world = self.write("world.toml", "[camera]\ncount = 2\n")

    def calibrate_right_camera(self):
        for kind in (["camera", "--corners", "samples/corners.csv"],
                     ["hand-eye", "--estimate-delay", "--hand", "samples/hand.csv", "--eye", "samples/eye.csv"]):
            self.runs("calibrate", *kind, "--camera", "right", "--rig", "rig.toml")

    def figures_of(self, graphics):
        graphics.send(signal.SIGTERM)
        self.assertEqual(graphics.ends().code, 0)
        return json.loads(self.read("figures.json"))

    def sample(self):
        for kind in ("camera", "hand-eye"):
            self.runs("world", "sample", kind, "--out", "samples")

    def test_a_laboratory_with_two_cameras_is_seen_with_both_eyes(self):
        self.sample()
        self.calibrate_right_camera()
        self.start_world("--world", self.world)
        self.start_physics()
        graphics = self.start_graphics("--json", "figures.json")

        def frames():
            status = json.loads(self.runs("status", "--json", "-").out)
            return sum(client["frames"] for client in status["clients"])
        wait_until(lambda: frames() >= 10, "ten frames have been drawn")
        figures = self.figures_of(graphics)
        self.assertEqual(figures["graphics"]["eyes"], 2)
        self.assertGreaterEqual(figures["exchange"]["frames"], 10)

    def test_recordings_of_two_cameras_are_paired_by_their_stamps_and_one_that_ends_is_told(self):
        self.sample()
        self.calibrate_right_camera()
        # The right one lacks every fourth image, and ends first. On a busy machine images are lost beside.
        for side, times in (("left", range(1, 90)), ("right", [i for i in range(1, 50) if i % 4])):
            os.mkdir(self.path(side))
            self.write(f"{side}/0.png", png(640, 480))
            self.write(f"{side}/stamps.csv", "image,time_s\n" + "".join(f"0.png,{i / 15:.3f}\n" for i in times))
        self.start_world()
        self.start_physics()
        graphics = self.start_graphics("--camera", "images:" + self.path("left"), "--right-camera", "images:" + self.path("right"), "--json", "figures.json")
        self.assertTrue(graphics.says("right camera images:"), graphics.lines())
        self.assertTrue(graphics.says("right camera: no image that was taken together with the left one's"), graphics.lines())
        self.assertTrue(graphics.says("the recording has ended"), graphics.lines())
        figures = self.figures_of(graphics)
        self.assertEqual(figures["graphics"]["eyes"], 2)
        self.assertGreaterEqual(figures["graphics"]["conditions"]["right_eye_lost"], 1)
        self.assertGreaterEqual(figures["graphics"]["unpaired"], 1)  # one in four where all came

    def test_what_a_second_camera_needs_is_named(self):
        graphics = ("graphics", "--rig", self.rig)
        self.start_world()
        self.says_no(self.run_program(*graphics, "--right-camera", "v4l2:1"), 2, "--right-camera", "--camera")
        self.says_no(self.run_program(*graphics, "--camera", "v4l2:0", "--right-camera", "nonsense"), 2, "nonsense")
        self.says_no(self.run_program(*graphics, "--camera", "v4l2:0", "--right-camera", "v4l2:1"), 1,
                     "right camera is not calibrated", "--camera right")
        self.says_no(self.run_program("world", "run", "--world", self.write("three.toml", "[camera]\ncount = 3\n")), 2, "count", "3")


if __name__ == "__main__":
    unittest.main()
