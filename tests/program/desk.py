"""A desk with a printed board, a webcam that sees it, and a desktop with a mouse, for the tests of `palpate play`."""
import json
import os
import subprocess

from display import Desktop
from program import ProgramTest

FILM = os.environ["BOARD_FILM"]


class DeskTest(ProgramTest):
    _rig = None

    def film(self, *arguments):
        subprocess.run([FILM, *map(str, arguments)], check=True, cwd=self.folder)

    def make_rig(self):
        """board.pdf, board.toml and desk.rig.toml with a calibrated lens; made once."""
        if DeskTest._rig is None:
            self.runs("board", "--out", "board.pdf")
            self.runs("rig", "webcam", "desk.rig.toml", "--board", "board.toml")
            os.mkdir(self.path("views"))
            self.film("views", "board.toml", "views", 12)
            done = self.runs("calibrate", "camera", "--images", self.path("views", "*.png"), "--board", "board.toml", "--rig", "desk.rig.toml", "--json", "-")
            DeskTest._lens = json.loads(done.out)
            DeskTest._rig, DeskTest._board, DeskTest._pdf = self.read("desk.rig.toml"), self.read("board.toml"), self.read("board.pdf")
        self.write("desk.rig.toml", DeskTest._rig)
        self.write("board.toml", DeskTest._board)

    def open_desktop(self, *size):
        self.desktop = Desktop(*size)
        self.addCleanup(self.desktop.close)
        self.environment.update(DISPLAY=self.desktop.name, ALSOFT_DRIVERS="null")
        self.environment.pop("WAYLAND_DISPLAY", None)
