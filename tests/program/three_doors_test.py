#!/usr/bin/env python3
"""One laboratory process behind three protocol doors - OpenIGTLink, GigE Vision, OpenHaptics' library at a socket - is calibrated by
`calibrate all`, its forces included, a script doing what it asks of a person; verified; a game is played. The same again through the laboratory's
own channel, and both beside the truth. Takes about ten minutes, in real time.

DOORS_SEED, DOORS_SECONDS, DOORS_KEEP: another laboratory, the length of the game, a folder for the files of both."""
import json
import os
import shutil
import signal
import subprocess
import tomllib
import unittest

from doors import Channel, Doors, close, write_world
from judged import figures
from laboratory import READY
from person_at_devices import Session
from program import PATIENCE_S, ProgramTest

SEED = os.environ.get("DOORS_SEED", "5")
POSES = os.environ.get("DOORS_POSES", "70")
SECONDS = os.environ.get("DOORS_SECONDS", "20")
BOUNDS = {"arm/error_to_truth_mean_mm": 0.2, "realtime/overlay/world_px_rms": 0.3, "realtime/overlay/tip_px_rms": 0.6}
RATIO = 1.5  # of what the channel gives


class ThreeDoors(ProgramTest):
    def calibrates(self, laboratory, devices, forces):
        self.runs("rig", "new", "rig.toml")
        repeated = []

        def once_again(step, ended):
            print(f"{'done' if ended['done'] else 'FAILED'} {step}: {ended['words']}", flush=True)
            if ended["done"]:
                return "\n"
            self.assertLess(repeated.count(step), 3, ended)
            repeated.append(step)
            return "r"
        session = Session(self, laboratory, *devices, "--rig", "rig.toml", "--poses", POSES, *(("--yes-held",) if forces else ()),
                          at_the_end=once_again)
        self.assertEqual(session.ends(PATIENCE_S * 10), 0, session.lines[-5:])
        self.assertIn("complete", self.runs("rig", "check", "rig.toml").out)
        if forces:
            self.assertIn("forces", tomllib.loads(self.read("rig.toml").decode()))
            laboratory.does({"gesture": "rest"})

    def verifies(self, way):
        """The person touches fresh places; nothing was knocked since the calibration."""
        session = Session(self, way.laboratory, *way.devices, "--rig", "rig.toml", "--json", "verified.json", "--record", "verified.mcap",
                          command=("verify",))
        code = session.ends(PATIENCE_S * 2)
        self.keeps("verified")
        print("verify:", *session.lines[-8:], sep="\n  ", flush=True)
        if code != 0:
            way.laboratory.ends()
            print("how late the laboratory was:", *way.laboratory.said[-3:], flush=True)
        self.assertEqual(code, 0, session.lines[-5:])
        self.assertTrue(json.loads(self.read("verified.json"))["holds"])
        way.laboratory.does({"gesture": "rest"})

    def plays(self, way):
        """A person who sees what the physics server shows and leads the laboratory's hand plays; the figures of both servers."""
        physics = self.start("physics", "--rig", "rig.toml", *way.physics, "--app", "pingpong", "--seed", SEED, "--out", "game", "--json", "physics.json")
        self.assertTrue(physics.says(READY["physics"]), physics.lines())
        endpoint = "ipc://" + os.path.join(self.meeting, "palpate", "physics.sock")
        person = subprocess.Popen([os.environ["SCRIPTED_PLAYER"], "lab", endpoint, self.path("rig.toml"), SEED], env=way.environment, stdout=subprocess.PIPE)
        self.addCleanup(close, person)
        graphics = self.start("graphics", "--rig", "rig.toml", *way.graphics, "--seconds", SECONDS, "--out", "game", "--json", "graphics.json")
        self.assertEqual(graphics.ends().code, 0, graphics.lines())
        self.assertIsNone(person.poll(), "who plays is still there")
        physics.send(signal.SIGTERM)
        self.assertEqual(physics.ends().code, 0, physics.lines())
        for server in (physics, graphics):
            print(server.arguments[0] + ":", *server.lines(), sep="\n  ", flush=True)

    def keeps(self, name):
        if folder := os.environ.get("DOORS_KEEP"):
            shutil.copytree(self.folder, os.path.join(folder, name), dirs_exist_ok=True, ignore=shutil.ignore_patterns("instructions"))

    def judged(self, name):
        found = figures(self, "rig.toml", "world.toml", SEED, (self.path("game", "realtime_poses.csv"), self.path("truth.csv")))
        self.keeps(name)
        return found

    def through(self, way, name):
        self.calibrates(way.laboratory, way.devices, forces=name == "doors")
        self.verifies(way)
        self.plays(way)
        way.laboratory.ends()
        found = self.judged(name)
        print(name, json.dumps(found, indent=2), flush=True)
        return found

    def world(self):
        return "--world", write_world(self), "--seed", SEED, "--exposures", self.path("truth.csv")

    def test_through_the_doors_everything_is_as_near_to_the_truth_as_through_the_channel(self):
        doors = self.through(Doors(self, *self.world()), "doors")
        self.doCleanups()
        self.setUp()
        channel = self.through(Channel(self, *self.world()), "channel")
        for key, bound in BOUNDS.items():
            with self.subTest(key):
                self.assertLess(doors[key], bound)
                self.assertLess(doors[key], RATIO * channel[key])


if __name__ == "__main__":
    unittest.main()
