#!/usr/bin/env python3
"""Files that earlier versions wrote are read as those read them."""
import os
import re
import shutil
import unittest

from program import ProgramTest

KEPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "kept")


class Kept(ProgramTest):
    def kept(self, name):
        return shutil.copy(os.path.join(KEPT, name), self.path(name))

    def test_a_rig(self):
        rig = self.kept("rig.toml")
        self.assertIn("complete", self.runs("rig", "check", rig).out)
        shown = re.sub(" +", " ", self.runs("rig", "show", rig).out)
        for line in ("tip pivot, mm 6.8114 -17.9188 -117.1796 ", "gains 0.9845 1.0057 0.9989 ",
                     "fx fy cx cy, px 559.9588 561.4742 317.9718 242.0012 ", "camera in marker, mm 7.7997 -65.6463 35.3167 ",
                     "tracker after arm 9.998 +- 0.031", "surface table 750.1 x 999.8 mm", "landmarks 12"):
            self.assertIn(line, shown)

    def test_another_rig_version_is_refused_in_words(self):
        with open(self.kept("rig.toml"), encoding="utf-8") as file:
            other = file.read().replace("rig_version = 1\n", "rig_version = 2\n")
        self.refuses(["rig", "check", self.write("other.toml", other)], 2, "rig_version", "is 2, this program reads 1")

    def test_a_recording(self):
        session = self.kept("session.mcap")
        self.assertIn("sound: 3030 messages in 15 chunks", self.runs("recording", "check", session).out)
        told = re.sub(" +", " ", self.runs("recording", "info", session).out)
        for line in ("written by palpate 0.1.0", "2.999 s, 3 streams", "2 attachments", "/arm/sample 3000 messages"):
            self.assertIn(line, told)


if __name__ == "__main__":
    unittest.main()
