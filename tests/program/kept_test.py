#!/usr/bin/env python3
"""Files that earlier versions wrote are read as those read them."""
import os
import re
import shutil
import unittest

from program import ProgramTest

KEPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "kept")


# Of each release: what its rig shows, and what its recording holds.
RIGS = {
    "0.1.0": ("tip pivot, mm 6.8114 -17.9188 -117.1796 ", "gains 0.9845 1.0057 0.9989 ", "fx fy cx cy, px 559.9588 561.4742 317.9718 242.0012 ",
              "camera in marker, mm 7.7997 -65.6463 35.3167 ", "tracker after arm 9.998 +- 0.031", "surface table 750.1 x 999.8 mm", "landmarks 12"),
    "0.2.0": ("tip pivot, mm 2.8668 -16.2579 -115.5944 ", "gains 0.9904 0.9991 1.0112 ", "fx fy cx cy, px 560.1393 561.5878 318.6072 242.3133 ",
              "camera in marker, mm 10.1812 -63.8123 26.7230 ", "camera before the eyes, mm 10.3102 -64.8577 32.2556 ", "delay, ms -29.950 +- 0.053",
              "tracker after arm 10.091 +- 0.081", "surface table 749.8 x 999.5 mm", "landmarks 12"),
}
RECORDINGS = {
    "0.1.0": ("sound: 3030 messages in 15 chunks", "written by palpate 0.1.0", "2.999 s, 3 streams", "2 attachments", "/arm/sample 3000 messages"),
    "0.2.0": ("sound: 1261 messages in 1 chunk", "written by palpate 0.2.0", "0.300 s, 9 streams", "2 attachments", "/physics/state 301 messages"),
}


class Kept(ProgramTest):
    def kept(self, release, name):
        return shutil.copy(os.path.join(KEPT, release, name), self.path(name))

    def test_each_release_has_its_files(self):
        self.assertEqual(sorted(name for name in os.listdir(KEPT) if name[0].isdigit()), sorted(RIGS))

    def test_rigs(self):
        for release, lines in RIGS.items():
            with self.subTest(release):
                rig = self.kept(release, "rig.toml")
                self.assertIn("complete", self.runs("rig", "check", rig).out)
                shown = re.sub(" +", " ", self.runs("rig", "show", rig).out)
                for line in lines:
                    self.assertIn(line, shown)

    def test_another_rig_version_is_refused_in_words(self):
        with open(self.kept("0.2.0", "rig.toml"), encoding="utf-8") as file:
            other = file.read().replace("rig_version = 1\n", "rig_version = 2\n")
        self.refuses(["rig", "check", self.write("other.toml", other)], 2, "rig_version", "is 2, this program reads 1")

    def test_recordings(self):
        for release, lines in RECORDINGS.items():
            with self.subTest(release):
                session = self.kept(release, "session.mcap")
                told = self.runs("recording", "check", session).out + re.sub(" +", " ", self.runs("recording", "info", session).out)
                for line in lines:
                    self.assertIn(line, told)
        self.runs("recording", "export", self.kept("0.2.0", "session.mcap"), "--csv", "tables")
        rows = self.read("tables", "physics_state.csv").decode().splitlines()
        self.assertEqual(len(rows), 302)
        self.assertIn("bodies.0.position_m.0", rows[0])


if __name__ == "__main__":
    unittest.main()
