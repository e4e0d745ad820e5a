#!/usr/bin/env python3
"""Sessions of the servers are recorded, shown again, executed again, calibrated again; and a disk or a signal in between.

KILLED, PLAYED_S, APPLICATIONS, PICTURES_S, PICTURES, BURNERS: how often a server is killed, how long each application is played to be executed
again, which, how long pictures are recorded, by which graphics servers, how many processes keep the cores busy meanwhile."""
import csv
import json
import os
import random
import signal
import struct
import subprocess
import sys
import time
import unittest
import zlib

from laboratory import LaboratoryTest
from program import PATIENCE_S

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import check_mcap  # noqa: E402

PLAYED_S = float(os.environ.get("PLAYED_S", "3"))
APPLICATIONS = os.environ.get("APPLICATIONS", "pingpong touch").split()
KILLED = int(os.environ.get("KILLED", "4"))
BURNERS = int(os.environ.get("BURNERS", "0"))
PICTURES_S = float(os.environ.get("PICTURES_S", "4"))
PICTURES = os.environ.get("PICTURES", "lossless jpeg").split()


class RecordedSessions(LaboratoryTest):
    def play(self, application, seconds=3.0):
        """Both servers record; returns when they have ended."""
        world = self.start_world()
        physics = self.start_physics("--app", application, "--record", self.path("physics.mcap"), "--json", "physics.json")
        graphics = self.start("graphics", "--rig", self.rig, "--player", "--seconds", seconds, "--record", self.path("graphics.mcap"),
                              "--pictures", "jpeg", "--json", "graphics.json")
        ended = [graphics.ends(PATIENCE_S + seconds)]
        for process in (physics, world):
            process.send(signal.SIGINT)
            ended.append(process.ends())
        for done in ended:
            self.assertEqual(done.code, 0, done)
        return json.loads(self.read("physics.json")), json.loads(self.read("graphics.json"))

    def draw_pictures(self, count):
        """A folder as a camera of thirty pictures a second: eight pictures of noise, again and again; of the size that the rig's camera has."""
        os.mkdir(self.path("drawn"))
        noise = random.Random(7)

        def chunk(kind, content):
            return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        for i in range(8):
            rows = b"".join(b"\0" + bytes(noise.choices(range(100, 108), k=640)) for _ in range(480))  # 8 grey levels of noise
            self.write(os.path.join("drawn", f"{i}.png"), b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 640, 480, 8, 0, 0, 0, 0)) +
                       chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))
        self.write("drawn/stamps.csv", "image,time_s\n" + "".join(f"{i % 8}.png,{i / 30:.6f}\n" for i in range(count)))

    def test_a_thousand_ticks_and_thirty_pictures_a_second_are_recorded_without_a_drop(self):
        self.keep_busy()
        self.draw_pictures(int(30 * (PICTURES_S + 20)))
        world = self.start_world("--arm-only")
        physics = self.start_physics("--app", "pingpong", "--record", self.path("physics.mcap"), "--json", "physics.json")
        graphics = [self.start("graphics", "--rig", self.rig, "--camera", "images:" + self.path("drawn"), "--seconds", PICTURES_S, "--record",
                               self.path(f"{pictures}.mcap"), "--pictures", pictures, "--json", f"{pictures}.json") for pictures in PICTURES]
        ended = [server.ends(PATIENCE_S + PICTURES_S) for server in graphics]
        for process in (physics, world):
            process.send(signal.SIGINT)
            ended.append(process.ends())
        for done in ended:
            self.assertEqual(done.code, 0, done)
        told = {name: json.loads(self.read(f"{name}.json")) for name in ("physics", *PICTURES)}
        for name, result in told.items():
            print(name, json.dumps(result["recording"]), flush=True)
            self.assertEqual(result["recording"]["dropped"], {})
        self.assertEqual(told["physics"]["recording"]["missed"], 0)
        for pictures in PICTURES:
            info = json.loads(self.runs("recording", "info", f"{pictures}.mcap", "--json", "-").out)
            topics = {stream["name"]: stream["messages"] for stream in info["streams"]}
            self.assertEqual(topics["/camera/left/image"], topics["/camera/left/stamp"])
            print(pictures, f"{topics['/camera/left/image'] / PICTURES_S:.1f} pictures a second", flush=True)  # as many as these cores draw on
            self.assertGreater(topics["/camera/left/image"], PICTURES_S)

    def keep_busy(self):
        for _ in range(BURNERS):
            burner = subprocess.Popen([sys.executable, "-c", "while True: pass"])
            self.addCleanup(lambda process=burner: (process.kill(), process.wait()))

    def test_both_applications_are_executed_again_to_the_last_bit(self):
        self.keep_busy()
        for application in APPLICATIONS:
            with self.subTest(application):
                physics, _ = self.play(application, PLAYED_S)
                self.assertEqual(physics["recording"]["dropped"], {})
                self.assertEqual(physics["recording"]["missed"], 0)
                self.runs("replay", "physics.mcap", "--verify", "--json", "again.json")
                again = json.loads(self.read("again.json"))
                self.assertTrue(again["same"], again)
                self.assertGreater(again["ticks"], 150 * PLAYED_S)
                print(application, json.dumps({**again, "gaps": physics["haptic"]["jitter_us"]}), flush=True)
                self.assertEqual(again["ticks"], physics["haptic"]["ticks"])
                for name in ("physics.mcap", "graphics.mcap"):
                    os.remove(self.path(name))

    def test_what_both_wrote_becomes_one_recording(self):
        physics, graphics = self.play("pingpong")
        self.runs("recording", "merge", "both.mcap", "physics.mcap", "graphics.mcap")
        parts = [check_mcap.check(self.path(name)) for name in ("physics.mcap", "graphics.mcap")]
        both = check_mcap.check(self.path("both.mcap"))
        topics = {}
        for part in parts:
            for topic, count in part["topics"].items():
                topics[topic] = topics.get(topic, 0) + count
        self.assertEqual(both["topics"], topics)
        self.assertEqual(both["topics"]["/arm/sample"], physics["haptic"]["ticks"])
        self.assertEqual(both["topics"]["/frame"], graphics["exchange"]["frames"])
        for topic in ("/tracker/sample", "/camera/left/stamp", "/camera/left/image", "/clock/physics", "/tf", "/scene", "/plot", "/loop",
                      "/camera/left/calibration"):
            self.assertGreater(both["topics"].get(topic, 0), 0, topic)
        self.assertEqual(sorted(both["attachments"]), ["rig.toml", "scene.pb"])
        self.runs("replay", "both.mcap", "--verify")
        self.runs("recording", "merge", "twice.mcap", "physics.mcap", "both.mcap")
        self.says_no(self.run_program("replay", "twice.mcap", "--verify"), 1, "sessions of several physics servers", "each by itself")
        os.remove(self.path("twice.mcap"))
        for option in (["--from", "1"], ["--loop"]):
            self.says_no(self.run_program("replay", "both.mcap", "--verify", *option), 2, f"{option[0]}: goes without --verify")
        # A part that begins later cannot be executed, and what was cut off is not said to be equal.
        self.runs("recording", "cut", "both.mcap", "later.mcap", "--from", "1")
        self.says_no(self.run_program("replay", "later.mcap", "--verify"), 1, "cut out of a longer recording", "palpate recording cut --from 0")
        whole = self.read("physics.mcap")
        self.write("ended.mcap", whole[:len(whole) * 3 // 4])
        ended = self.run_program("replay", "ended.mcap", "--verify", "--json", "-")
        self.assertIn("it is not whole (byte ", json.loads(ended.out)["lost"])
        self.assertNotIn("not whole", self.runs("replay", "both.mcap", "--verify").out)
        # Without one kind of input it cannot be the same.
        for topic in ("/arm/sample", "/physics/step"):
            kept = [option for name in topics if name != topic for option in ("--topic", name)]
            self.runs("recording", "cut", "both.mcap", "less.mcap", *kept)
            done = self.run_program("replay", "less.mcap", "--verify")
            self.assertEqual(done.code, 1, done)
            os.remove(self.path("less.mcap"))
        self.tables()

    def tables(self):
        """Every stream as a table, and the tracker's poses as those of a pivot."""
        self.runs("recording", "export", "both.mcap", "--csv", "csv", "--tum", "tum", "--attachments", "files")
        with open(self.path("csv/arm_sample.csv"), encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([int(row["tick"]) for row in rows], list(range(1, len(rows) + 1)))
        self.assertEqual(self.read("files/rig.toml")[:100], self.read("rig.toml")[:100])
        with open(self.path("tum/camera_marker.tum"), encoding="utf-8") as file:
            times = [float(line.split()[0]) for line in file]
        self.assertEqual(times, sorted(times))

    def test_shown_again_it_is_a_physics_server(self):
        self.play("pingpong")
        world = self.start_world()
        replay = self.start("replay", self.path("physics.mcap"), "--loop")
        self.assertTrue(replay.says("shows "), replay.lines())
        graphics = self.start_graphics("--seconds", "2", "--json", "again.json")
        self.assertEqual(graphics.ends().code, 0)
        self.assertGreater(json.loads(self.read("again.json"))["exchange"]["frames"], 3)
        ups = []
        for more in ([], ["--reset"]):  # the wish is taken, and a recording does what it did
            status = self.runs("status", *more, "--json", "-")
            ups.append(json.loads(status.out)["uptime_s"])
        self.assertGreater(ups[0], 0)
        self.assertGreater(ups[1], ups[0])
        self.assertTrue(replay.says("somebody wishes something"), replay.lines())
        record = self.run_program("record", "--out", "beside.mcap", "--seconds", "1", "--tracker", "lab", "--json", "beside.json")
        self.assertEqual(record.code, 0, record)
        self.assertGreater(json.loads(self.read("beside.json"))["states"]["taken"], 10)
        replay.send(signal.SIGINT)
        self.assertEqual(replay.ends().code, 0)
        world.send(signal.SIGTERM)
        topics = check_mcap.check(self.path("beside.mcap"))["topics"]
        self.assertGreater(topics["/physics/state"], 10)
        self.assertGreater(topics["/tracker/sample"], 5)

    def test_killed_at_any_moment_it_can_be_mended(self):
        """At most one second is lost, and what is left is executed again without a difference until it is cut off."""
        world = self.start_world()
        chosen = random.Random(4)
        for i in range(KILLED):
            name = self.path(f"killed{i}.mcap")
            physics = self.start_physics("--app", "touch", "--record", name)
            begun = time.monotonic()
            time.sleep(chosen.uniform(0.3, 2.5))
            lived = time.monotonic() - begun
            physics.send(signal.SIGKILL)
            physics.ends()
            done = self.run_program("recording", "repair", name, self.path("whole.mcap"))
            self.assertEqual(done.code, 0, done)
            whole = check_mcap.check(self.path("whole.mcap"))
            self.assertGreater(whole["seconds"], lived - 1.0, f"{i}: it had run for {lived:.2f} s")
            done = self.run_program("replay", "whole.mcap", "--verify", "--json", "again.json")
            again = json.loads(self.read("again.json"))
            self.assertEqual((again["different_forces"], again["different_states"]), (0, 0), again)
            self.assertGreater(again["ticks"], 0.9 * again["recorded_ticks"] - 100)
            os.remove(self.path("whole.mcap"))
        world.send(signal.SIGTERM)

    def test_a_file_that_is_there_is_not_written_over(self):
        self.write("there.mcap", b"mine")
        world = self.start_world()
        done = self.run_program("physics", "--rig", self.rig, "--record", "there.mcap", "--seconds", "1")
        self.assertEqual(done.code, 2, done)
        self.assertEqual(self.read("there.mcap"), b"mine")
        done = self.run_program("demo", "--quick", "--headless", "--record", "there.mcap")
        self.assertEqual(done.code, 2, done)
        world.send(signal.SIGTERM)

    def test_calibrations_from_a_recording_are_those_from_tables(self):
        for kind in ("arm", "camera", "hand-eye", "surface", "pivot"):
            self.runs("world", "sample", kind, "--out", "samples")
        self.runs("recording", "import", "t.mcap", "arm=samples/arm.csv", "corners=samples/corners.csv", "hand=samples/hand.csv",
                  "eye=samples/eye.csv", "surface=samples/surface.csv", "pivot=samples/pivot.csv")
        for kind, tables in (("arm", ["--samples", "samples/arm.csv"]), ("camera", ["--corners", "samples/corners.csv"]),
                             ("hand-eye", ["--hand", "samples/hand.csv", "--eye", "samples/eye.csv"]),
                             ("surface", ["--points", "samples/surface.csv"]), ("pivot", ["--poses", "samples/pivot.csv"])):
            with self.subTest(kind):
                more = {"hand-eye": ["--estimate-delay"], "arm": ["--arm", "phantom-premium-1.5"]}.get(kind, [])
                self.runs("calibrate", kind, *tables, *more, "--json", "tables.json")
                self.runs("calibrate", kind, "--recording", "t.mcap", *more, "--json", "recording.json")
                results = [json.loads(self.read(name)) for name in ("tables.json", "recording.json")]
                for source in results[1]["data"].values():
                    self.assertNotIn(os.sep, source, "the recording is named, not a file in between")
                hashes = [{name: value for name, value in result.pop("data").items() if "hash" in name} for result in results]
                self.assertEqual(*results)
                self.assertEqual(*hashes)
        done = self.run_program("calibrate", "landmarks", "--recording", "t.mcap", "--rig", self.rig)
        self.assertEqual(done.code, 1, done)
        self.assertIn("landmarks", done.err)
        done = self.run_program("calibrate", "arm")
        self.assertEqual(done.code, 2, done)
        self.assertIn("--samples is required", done.err)
        self.runs("recording", "export", "t.mcap", "--attachments", "back")
        self.assertEqual(self.read("back/arm.csv"), self.read("samples/arm.csv"))


if __name__ == "__main__":
    unittest.main()
