#!/usr/bin/env python3
"""Real cameras from outside: a pretended GigE Vision camera, as a process that is killed and started again, shows the simulated
laboratory's table or a calibration board; its pictures are recorded, calibrated from and played back."""
import fcntl
import json
import os
import re
import signal
import struct
import subprocess
import time
import unittest
import zlib

from display import Desktop
from laboratory import LaboratoryTest
from program import wait_until

SERIAL = "Palpate8"
NAME = f"aravis:Aravis-Fake-{SERIAL}"
CAMERA = "aravis:127.0.0.1"  # by address: a machine of several networks answers to the name by way of any of them
TURN = "/tmp/palpate_network_camera.lock"
LENS = {"fx": 560, "fy": 561.5, "cx": 318.7, "cy": 242.1}  # of tests/rendered_views.h


class Cameras(LaboratoryTest):
    def setUp(self):
        super().setUp()
        # One at a time on a machine, as tests/fake_network_camera.h says.
        try:
            turn = os.open(TURN, os.O_RDONLY | os.O_CLOEXEC)
        except FileNotFoundError:
            turn = os.open(TURN, os.O_RDONLY | os.O_CREAT | os.O_CLOEXEC, 0o644)
        self.addCleanup(os.close, turn)
        fcntl.flock(turn, fcntl.LOCK_EX)

    def plug_in(self, shows):
        camera = subprocess.Popen([os.environ["FAKE_NETWORK_CAMERA"], SERIAL, shows], stdout=subprocess.PIPE, text=True)
        self.addCleanup(self.pull, camera)
        self.assertEqual(camera.stdout.readline(), "ready\n")
        return camera

    def pull(self, camera):
        camera.kill()
        camera.wait()
        camera.stdout.close()

    def tells(self, server, happens, words):
        """Makes something happen, after which the server says these words; prints how soon."""
        lines, begun = len(server.lines()), time.monotonic()
        happens()
        wait_until(lambda: server.ended() or any(words in line for line in server.lines()[lines:]), f"the server says '{words}'")
        self.assertFalse(server.ended(), server.lines())
        print(f"'{words}' after {time.monotonic() - begun:.2f} s")

    def sees_trouble(self, words):
        """Waits until `palpate status` tells of the camera in these words; None: until it tells of none."""
        def told():
            clients = json.loads(self.runs("status", "--json", "-").out)["clients"]
            conditions = [text for client in clients for text in client["conditions"] if text.startswith("camera")]
            return any(words in text for text in conditions) if words else not conditions
        wait_until(told, f"status tells of the camera: {words}")

    def test_a_lens_is_calibrated_from_pictures_that_came_over_the_network(self):
        self.plug_in("board")
        found = json.loads(self.runs("camera", "list", "--json", "-").out)["cameras"]
        self.assertIn(NAME, [camera["camera"] for camera in found])
        self.runs("camera", "record", CAMERA, "--out", "board", "--seconds", "4", "--every-s", "0.15", "--size-px", "640x480",
                  "--camera-rate-hz", "25")
        self.refuses(["camera", "record", CAMERA, "--out", "board"], 2, "holds a recording already")
        rows = [line.split(",") for line in self.read("board", "stamps.csv").decode().splitlines()]
        self.assertEqual(rows[0], ["image", "time_s", "frame"])
        for before, after in zip(rows[1:], rows[2:]):
            self.assertLess(float(before[1]), float(after[1]))
            self.assertLess(int(before[2]), int(after[2]))
        lens = json.loads(self.runs("calibrate", "camera", "--images", self.path("board", "*.png"), "--board", "9x6",
                                    "--square-mm", "25", "--corner-window-px", "0", "--json", "-").out)
        self.assertLess(lens["rms_px"], 0.5)
        for key, truth in LENS.items():  # 1 px: beyond what sharp pictures of 16 poses leave open, below any mistake of size or offset
            self.assertLess(abs(lens[key] - truth), max(1.0, 4 * lens["std"][key]), key)
        # The recording played back: as many pictures as rows, then the end is told.
        self.start_world()
        self.start_physics()
        graphics = self.start("graphics", "--rig", self.rig, "--camera", "images:" + self.path("board"), "--json", "figures.json")
        self.assertTrue(graphics.says("the recording has ended"), graphics.lines())
        graphics.send(signal.SIGTERM)
        self.assertEqual(graphics.ends().code, 0)
        self.assertEqual(json.loads(self.read("figures.json"))["camera"]["pictures"], len(rows) - 1)

    def test_a_camera_that_is_unplugged_is_told_and_comes_back_without_a_restart(self):
        camera = self.plug_in("laboratory")
        self.start_world()
        physics = self.start_physics()
        graphics = self.start_graphics("--camera", CAMERA, "--camera-rate-hz", "25", "--json", "figures.json")
        self.assertTrue(graphics.says(f"camera {CAMERA}: Aravis Fake (serial {SERIAL}), 640x480 px"), graphics.lines())
        self.sees_trouble(None)
        self.tells(graphics, lambda: self.pull(camera), "see to its cable")
        self.sees_trouble("see to its cable")
        self.assertIn("    ! camera", self.runs("status", "--once").out)
        cameras = []
        self.tells(graphics, lambda: cameras.append(self.plug_in("laboratory")), "camera: images come again")
        self.sees_trouble(None)
        # One that only stands still. A machine busy enough that the graphics server itself stood still first says so late, when
        # the camera has been asked anew in vain: in other words.
        self.tells(graphics, lambda: cameras[0].send_signal(signal.SIGSTOP), "see to its cable")
        self.tells(graphics, lambda: cameras[0].send_signal(signal.SIGCONT), "camera: images come again")
        graphics.send(signal.SIGTERM)
        done = graphics.ends()
        self.assertEqual(done.code, 0, done)
        figures = json.loads(self.read("figures.json"))
        self.assertGreaterEqual(figures["camera"]["times_opened"], 2)
        self.assertGreaterEqual(figures["graphics"]["conditions"]["camera_silent"], 1)
        self.assertEqual(self.stop_in_order(physics), [[]])  # forces have not heard of it

    def test_the_clock_strip_stands_over_the_window_and_goes_on(self):
        desktop = Desktop()
        self.addCleanup(desktop.close)
        self.environment["DISPLAY"] = desktop.name
        self.plug_in("laboratory")
        self.start_world()
        physics = self.start_physics()
        graphics = self.start_graphics("--camera", CAMERA, "--camera-rate-hz", "25", "--window", "--clock-strip")
        wait_until(lambda: graphics.ended() or desktop.window("Palpate"), "the window opens")
        window = desktop.window("Palpate")
        desktop.resize(window, 960, 720)
        block = 960 // 48
        left = (960 - 19 * block) // 2

        def blocks():
            """The strip's sixteen, 1 white and 0 black; None where the panel round them is not whole."""
            picture = desktop.picture(window)

            def light(x, y):  # in blocks from the panel's corner
                level = picture.at(round(left + x * block), round(y * block))
                return 1 if min(level) > 250 else 0 if max(level) < 5 else None
            border = [light(x, y) for x in (0.25, 18.75) for y in (0.25, 2, 3.75)]
            frame = [light(x, y) for x in (0.75, 18.25) for y in (0.75, 2, 3.25)]
            margin = [light(x, y) for x in (1.25, 17.75) for y in (1.25, 2, 2.75)]
            if border != 6 * [0] or frame != 6 * [1] or margin != 6 * [0]:
                return None
            return [light(2 + i, 2) for i in range(16)]
        wait_until(lambda: graphics.ended() or blocks(), "the strip's panel is there")
        self.assertFalse(graphics.ended(), graphics.lines())
        codes = set()

        def goes_on():
            shown = blocks()
            if shown:
                self.assertEqual((shown[:2], shown[-2:]), ([1, 0], [0, 1]))
                self.assertNotIn(None, shown)
                codes.add(tuple(shown))
            return len(codes) >= 5
        wait_until(goes_on, "five moments have been shown")
        self.assertEqual(self.stop_in_order(graphics, physics)[1], [])

    def test_pictures_of_another_size_than_the_lens_was_calibrated_at_are_told_with_both(self):
        os.mkdir(self.path("small"))
        row = b"\0" + bytes(3 * 320)  # black

        def chunk(name, content):
            return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
        self.write("small/0.png", b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 320, 240, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(240 * row)) + chunk(b"IEND", b""))
        self.write("small/stamps.csv", "image,time_s\n" + "".join(f"0.png,{0.1 * i:.1f}\n" for i in range(1, 600)))
        self.start_world()
        physics = self.start_physics()
        graphics = self.start_graphics("--camera", "images:" + self.path("small"))
        self.assertTrue(graphics.says("its pictures are 320x240 px and the lens was calibrated at 640x480"), graphics.lines())
        self.sees_trouble("its pictures are 320x240 px")
        self.assertEqual(self.stop_in_order(graphics, physics), [[], []])

    def test_what_cannot_be_had_is_named_with_its_remedy(self):
        self.refuses(["camera", "record", "aravis:Aravis-Fake-Nobody", "--out", "x"], 1, "no such camera answers")
        self.refuses(["camera", "record", "v4l2:99", "--out", "x", "--size-px", "big"], 2, "--size-px 'big'")
        self.refuses(["doctor", "--camera", "webcam"], 2, "--camera", "'webcam'")
        graphics = ("graphics", "--rig", self.rig, "--camera")
        self.start_world()
        self.says_no(self.run_program(*graphics, "webcam"), 2, "--camera", "'webcam'", "lab, aravis[:NAME]")
        self.says_no(self.run_program(*graphics, "v4l2:/dev/video99"), 1, "camera v4l2:/dev/video99", "no such device", "camera list")
        self.says_no(self.run_program(*graphics, "images:nowhere"), 2, "nowhere", "no such folder")
        self.says_no(self.run_program(*graphics, "video:nowhere.mp4"), 2, "nowhere.mp4", "no such file")
        self.write("film.mp4", "no film")
        self.says_no(self.run_program(*graphics, "video:film.mp4"), 1, "film.mp4", "cannot be read as a video")
        self.says_no(self.run_program(*graphics, "v4l2", "--camera-stamp", "noon"), 2, "--camera-stamp", "'noon'", "exposure-start")
        self.says_no(self.run_program(*graphics, "v4l2", "--camera-exposure-ms", "-5"), 2, "exposure -5 ms", "0.001 to 10000 ms")
        self.says_no(self.run_program(*graphics, "video:film.mp4", "--camera-gain", "3"), 2, "a recording has no exposure")

    def test_a_camera_that_cannot_be_opened_is_told_before_a_laboratory_is_missed(self):
        graphics = ("graphics", "--rig", self.rig, "--camera")
        self.says_no(self.run_program(*graphics, "v4l2:absent"), 1, "camera v4l2:absent: there is no such device; `palpate camera list` names those there are")
        self.says_no(self.run_program(*graphics, "aravis:Aravis-Fake-Nobody"), 1, "camera aravis:Aravis-Fake-Nobody: no such camera answers", "camera list")
        self.says_no(self.run_program(*graphics, "images:/none"), 2, "camera images: /none: there is no such folder", "stamps.csv is expected")
        self.says_no(self.run_program(*graphics, "video:/none.mp4"), 2, "camera video:/none.mp4: there is no such file", "is expected")
        # One that is there lacks the laboratory's tracker.
        self.runs("picture", "--out", "0.png")
        self.write("stamps.csv", "image,time_s\n0.png,0\n")
        self.says_no(self.run_program(*graphics, "images:."), 1, "laboratory 'lab' is not there", "palpate world run", "--tracker igtl://HOST:PORT")
        # And one whose tracker is elsewhere lacks its camera.
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--tracker", "igtl://127.0.0.1:1"), 1, "laboratory 'lab' is not there",
                     "palpate world run", "--camera names another camera than the laboratory's")

    def test_doctor_opens_the_camera_it_is_asked_about(self):
        def asked():
            done = self.run_program("doctor", "--keys", self.path("keys"), "--camera", CAMERA, "--json", "-")
            return {f["name"]: f for f in json.loads(done.out)["findings"] if f["area"] == "devices"}
        finding = asked()["camera asked for"]
        self.assertEqual(finding["verdict"], "in the way")
        self.assertIn("camera list", finding["remedy"])
        self.plug_in("laboratory")
        finding = asked()["camera asked for"]
        self.assertEqual(finding["verdict"], "ok", finding)
        self.assertTrue(re.search(r"serial Palpate8\), \d+x\d+ px, Bayer", finding["value"]), finding)


if __name__ == "__main__":
    unittest.main()
