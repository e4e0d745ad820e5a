#!/usr/bin/env python3
"""Every command of README and guides: run as it is written where it needs no device, no person and no minutes, else compared
word for word with the program's own help."""
import functools
import glob
import json
import os
import re
import shutil
import signal
import subprocess
import unittest

import documents
from laboratory import calibrate
from program import PATIENCE_S, PROGRAM, ProgramTest

GUIDES = ["README.md", "docs/guide.md", *sorted(glob.glob("docs/guides/*.md", root_dir=documents.ROOT))]
DOCUMENTS = [*GUIDES, *sorted(set(glob.glob("docs/**/*.md", root_dir=documents.ROOT, recursive=True)) - set(GUIDES))]
# What is only compared with the help, and why.
ONLY_COMPARED = {
    r"openhaptics|--arm haply|forcedimension|igtl://|v4l2|aravis": "a device",
    r"--window|--headset|calibrate headset": "a desktop or a headset, and somebody at it",
    r"^palpate demo": "minutes; demo_stopped and others play it",
    r"calibrate forces --arm lab": "minutes; forces_check does it",
    r"study palpation": "minutes",
    r"--app palpation|study learning": "a soft organ is computed, and searches are played: palpation does both",
    r"session\.mcap": "a session of four minutes; sampling has shorter ones",
    r"--images 'board\*\.png' --stamps": "pictures of a board by a tracked camera; pixel_hand_eye has the corners",
    r"^(scripts/|cmake|ctest|PALPATE_MONADO|alias)": "builds, or is the shell's",
}
# What ends with another exit code than 0 here, and why.
EXITS = {
    r"^palpate rig check": (1, "the rig is new: it says what is missing"),
}
SERVERS = {"world run": "are open", "physics": "answers graphics servers at", "graphics": "shows "}
POINTS = "label,x_mm,y_mm,z_mm\na,0,0,0\nb,100,0,0\nc,0,80,0\nd,0,0,60\n"


def only_compared(command):
    return any(re.search(pattern, command.text) for pattern in ONLY_COMPARED)


class Compared(ProgramTest):
    """Without running: each word is a command, each option one of that command."""
    maxDiff = None

    @functools.cache
    def help(self, *words):
        """Options and commands of this command."""
        text = self.runs(*words, "--help").out
        options = set(re.findall(r"(?<![\w-])--?[a-zA-Z][\w-]*", " ".join(re.findall(r"^  (-\S+)", text, re.M))))
        below = set(re.findall(r"^  ([a-z]\S*)", text.partition("Subcommands:")[2], re.M))
        return options, below

    def differs(self, command):
        """What the program does not know of this command; empty: nothing."""
        words, at = [word.strip("[]") for word in command.words() if word != "help"], []
        options, below = self.help()
        everywhere = options
        for word in words:
            if not below or not re.match("[a-z]", word):
                break
            at.append(word.split("|")[0])
            if at[-1] not in below:
                return f"{command}: 'palpate {' '.join(at[:-1])}' has no command {at[-1]}"
            options, below = self.help(*at)
        if below and words[len(at):]:  # `palpate calibrate X --json FILE`: of any X
            options = options.union(*(self.help(*at, name)[0] for name in below))
        strange = [word for word in words if re.match("--?[a-z]", word) and word.split("=")[0] not in options | everywhere]
        return f"{command}: 'palpate {' '.join(at)}' has no option {', '.join(strange)}" if strange else ""

    def test_words_and_options_are_the_programs(self):
        found, compared = [], 0
        for file in DOCUMENTS:
            commands = [command for block in documents.blocks(file) for command in block] + documents.in_text(file)
            for command in commands:
                if re.search(r"(^|\s)palpate ", command.text) and not command.text.startswith("alias"):
                    compared += 1
                    found.append(self.differs(command))
        self.assertGreater(compared, 200)
        self.assertEqual([words for words in found if words], [])

    def test_values_of_commands_that_are_not_run_are_accepted(self):
        for file in GUIDES:
            for block in documents.blocks(file):
                for command in block:
                    if command.text.startswith("palpate ") and only_compared(command):
                        done = self.run_program(*command.words(), "--help")
                        self.assertEqual(done.code, 0, f"{command}: {done}")

    def test_scripts_and_presets_are_there(self):
        with open(os.path.join(documents.ROOT, "CMakePresets.json"), encoding="utf-8") as file:
            presets = json.load(file)
        known = {preset["name"] for kind in presets.values() if isinstance(kind, list) for preset in kind}
        for file in DOCUMENTS:
            for command in (command for block in documents.blocks(file) for command in block):
                for script in re.findall(r"(?<!\S)scripts/\S+", command.text.partition("#")[0]):
                    self.assertTrue(os.access(os.path.join(documents.ROOT, script), os.X_OK), command)
                for preset in re.findall(r"--preset (\S+)", command.text):
                    self.assertIn(preset, known, command)

    def test_no_reason_is_left_over(self):
        texts = [command.text for file in GUIDES for block in documents.blocks(file) for command in block]
        for pattern in [*ONLY_COMPARED, *EXITS]:
            self.assertTrue(any(re.search(pattern, text) for text in texts), f"no command is like {pattern}")


class Run(ProgramTest):
    """In a folder in which lie the files that the documents name, made from samples of the simulated laboratory."""
    _files = None

    def setUp(self):
        super().setUp()
        programs = os.path.join(self.root, "programs")
        os.mkdir(programs)
        os.symlink(PROGRAM, os.path.join(programs, "palpate"))
        self.environment["PATH"] = programs + os.pathsep + os.environ["PATH"]
        os.symlink(os.path.join(documents.ROOT, "data"), self.path("data"))

    def samples(self):
        """samples/ and rig.toml: what a person has after the first hour; made once."""
        if Run._files is None:
            calibrate(self.runs)
            for kind in ("pivot", "pointer", "landmarks"):
                self.runs("world", "sample", kind, "--out", "samples")
            self.runs("calibrate", "pivot", "--poses", "samples/pivot.csv", "--rig", "rig.toml")
            self.runs("calibrate", "pivot", "--marker", "pointer", "--poses", "samples/pointer.csv", "--rig", "rig.toml")
            self.runs("calibrate", "landmarks", "--points", "samples/landmarks.csv", "--rig", "rig.toml")
            Run._files = {name: self.read(name) for name in ("rig.toml", *(f"samples/{name}" for name in os.listdir(self.path("samples"))))}
        os.makedirs(self.path("samples"), exist_ok=True)
        for name, content in Run._files.items():
            self.write(name, content)

    def put(self, **names):
        """`put(stylus="pivot")`: stylus.csv is the sample pivot.csv."""
        for name, sample in names.items():
            path = self.path(name.replace("__", "/") + ".csv")
            os.makedirs(os.path.dirname(path), exist_ok=True)
            shutil.copy(self.path("samples", sample + ".csv"), path)

    def views(self, *patterns):
        """Chessboard pictures of others under the names that a document's patterns find; the reader looks at the content."""
        for pattern in patterns:
            for i, picture in enumerate(sorted(glob.glob(self.path("data/opencv_chessboard_left/left*.jpg")))):
                os.makedirs(os.path.dirname(self.path(pattern)), exist_ok=True)
                shutil.copy(picture, self.path(pattern.replace("*", f"{i:02}")))

    def board_views(self, folder):
        """Pictures of the board that `palpate board` prints, computed."""
        os.makedirs(self.path(folder), exist_ok=True)
        subprocess.run([os.environ["BOARD_FILM"], "views", "board.toml", folder, "12"], check=True, cwd=self.folder)

    def mesh(self, file):
        """A solid with four corners as STL, mm; where they are."""
        corners = [(0, 0, 0), (80, 0, 0), (0, 80, 0), (0, 0, 80)]
        faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
        facets = ("facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*corners[i]) for i in face) + "endloop\nendfacet\n" for face in faces)
        self.write(file, "solid made\n" + "".join(facets) + "endsolid made\n")
        return corners

    def run_block(self, block):
        """As it is written, one after the other; servers run until the block's end."""
        running = []
        for command in (command for command in block if not only_compared(command)):
            words = " ".join(command.words())
            server = next((server for server in SERVERS if words.startswith(server)), None)
            if server is not None:
                if server != "world run" and not running:
                    running.append(self.serve("world run", ["world", "run"]))
                running.append(self.serve(server, command.words()))
                continue
            done = subprocess.run(["bash", "-c", command.text], cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL,
                                  capture_output=True, text=True, timeout=PATIENCE_S, check=False)
            expected = next((code for pattern, (code, _) in EXITS.items() if re.search(pattern, command.text)), 0)
            if not command.text.startswith("palpate doctor"):  # 1 where this machine lacks something
                self.assertEqual(done.returncode, expected, f"{command}\n{done.stdout}{done.stderr}")
        for server in reversed(running):
            server.send(signal.SIGINT)
            done = server.ends()
            self.assertEqual(done.code, 0, f"{server.arguments}: {done}")
            self.assertEqual(len(done.out.splitlines()), 1, done)  # its figures

    def serve(self, server, words):
        running = self.start(*words)
        self.assertTrue(running.says(SERVERS[server]), f"{words}: {running.lines()}")
        return running

    def run_document(self, file):
        for block in documents.blocks(file):
            self.run_block(block)

    def test_readme(self):
        self.samples()
        shutil.copy(self.path("rig.toml"), self.path("my.rig.toml"))
        os.mkdir(self.path("palpate-report"))
        shutil.copy(self.path("rig.toml"), self.path("palpate-report/rig.toml"))
        self.put(stylus="pivot", arm="arm", marker="hand", board="eye", camera="eye", table="surface", dots="landmarks")
        self.write("a.csv", POINTS)
        self.write("b.csv", POINTS.replace(",0,", ",10,"))
        for name, source in (("robot.csv", "3D_UR5_uncalibrated_grid_cleaned.csv"), ("my_robot.toml", "ur5.toml")):
            shutil.copy(self.path("data/ur5_laser_tracker", source), self.path(name))
        self.views("left*.jpg")
        self.runs("board", "--out", "board.pdf")
        self.board_views("made")
        for picture in os.listdir(self.path("made")):
            shutil.move(self.path("made", picture), self.path("desk" + picture))
        self.run_document("README.md")

    def test_guide(self):
        self.samples()
        self.put(stylus="pivot", arm="arm", marker="hand", board="eye", board_right="eye", pointer="pointer", table="surface",
                 wall="wall", dots="landmarks")
        self.views("board/*.png", "right*.png")
        head = self.mesh("head.stl")
        for file, moved in (("head_in_its_mesh.csv", 0), ("head_touched.csv", 300)):
            self.write(file, "x_mm,y_mm,z_mm\n" + "".join(f"{x + moved},{y},{z}\n" for x, y, z in head))
        self.run_document("docs/guide.md")

    def test_cameras(self):
        self.runs("rig", "new", "my.rig.toml")
        self.views("board/*.png")
        self.run_document("docs/guides/cameras.md")

    def test_experiments(self):
        (table,) = re.findall(r"^```\n(stimulus,.*?)^```$", documents.read("docs/guides/experiments.md"), re.M | re.S)
        self.write("table.csv", table)
        trials = ["stimulus,response,sight,practice,excluded"]
        for sight, shares in (("with", (5, 20, 45, 70, 90, 97)), ("without", (0, 10, 30, 55, 80, 95))):
            trials += [f"{(0.7, 0.85, 1.0, 1.15, 1.3, 1.5)[i % 6]},{int(i // 6 * 37 % 100 < shares[i % 6])},{sight},0,0" for i in range(198)]
        self.write("run_1.csv", "\n".join(trials) + "\n")
        self.run_document("docs/guides/experiments.md")

    def test_sampling(self):
        self.samples()
        shutil.copy(self.path("rig.toml"), self.path("my.rig.toml"))
        self.put(arm__arm="arm", table__points="surface", board__hand="hand", board__eye="eye")
        head, *poses = self.read("samples/pivot.csv").decode().splitlines()
        os.mkdir(self.path("pivot"))
        self.write("pivot/pivot.csv", "\n".join([head + ",segment", *(pose + ",1" for pose in poses)]) + "\n")
        self.run_document("docs/guides/sampling.md")

    def test_touch(self):
        self.samples()
        self.mesh("liver.stl")
        self.run_document("docs/guides/touch.md")

    def test_webcam(self):
        board, calibration, play = documents.blocks("docs/guides/webcam.md")
        self.run_block(board)
        self.board_views("pictures")
        self.run_block(calibration)
        self.run_block(play)

    def test_every_guide_is_run_or_has_nothing_to_run(self):
        run = set(re.findall(r'run_document\("([^"]+)"\)|blocks\("([^"]+)"\)', documents.read("tests/program/documented_commands_test.py")))
        run = {name for names in run for name in names}
        for file in set(GUIDES) - run:
            left = [command for block in documents.blocks(file) for command in block if not only_compared(command)]
            self.assertEqual([str(command) for command in left if not command.text.startswith("palpate doctor")], [])


if __name__ == "__main__":
    unittest.main()
