#!/usr/bin/env python3
"""scripts/three-doors --devices: the laboratory behind its three doors stays open, and its person does what a session asks for; the keys are
yours to press.

DOORS_SEED: another laboratory."""
import json
import os
import shlex
import signal
import sys

from doors import Doors, write_world
from program import PROGRAM, ProgramTest


class ByHand(ProgramTest):
    def runTest(self):
        doors = Doors(self, "--world", write_world(self), "--seed", os.environ.get("DOORS_SEED", "5"))
        asked = os.path.join(self.root, "asked")
        os.mkfifo(asked)
        for line in (
                "The devices are on. In another terminal:", "",
                *(f"    export {name}={shlex.quote(self.environment[name])}" for name in ("PALPATE_LIBHD", "HD_STUB_ARM", "XDG_RUNTIME_DIR")), "",
                f"The arm is openhaptics, the tracker {doors.tracker}, the camera {doors.camera}; the program is {PROGRAM}.",
                "The values of `palpate rig new` fit these devices. Give a session also this option, so that the person here hears what is",
                "asked for (a pipe that the session alone opens; look at it here instead):", "",
                f"    --instructions {asked}", "", "Ctrl-C switches everything off.", ""):
            print(line, flush=True)
        while True:
            with open(asked, encoding="utf-8") as instructions:
                for line in instructions:
                    self.obeys(doors.laboratory, json.loads(line))
            # Whoever plays next finds the board put away, a head that looks at the table, and a stylus that moves.
            doors.laboratory.does({"gesture": "wander"})
            print("the session is over: the person looks at the table and moves the stylus about", flush=True)

    def obeys(self, laboratory, told):
        if "step" in told:
            print(f"--- {told['number']} of {told['of']}: {told['step']}", flush=True)
        if "released" in told:
            laboratory.does({"gesture": "rest"})
        if "gesture" not in told:
            return
        answer = laboratory.does({key: told[key] for key in told if key != "text"})
        what = " ".join(str(told[key]) for key in ("gesture", "what", "index") if told.get(key) not in (None, ""))
        said = ("is there (it counts by itself)" if told["gesture"] == "next_pose" else "is there") if "ready" in answer else "finds no more of them (n)" if answer["no_more"] else "does not get there (s)"
        print(f"the person, asked for {what}: {said}", flush=True)


if __name__ == "__main__":
    for ending in (signal.SIGINT, signal.SIGTERM):  # a shell's background jobs ignore the first
        signal.signal(ending, signal.default_int_handler)
    hands = ByHand()
    hands.setUp()
    try:
        hands.runTest()
    except KeyboardInterrupt:
        sys.exit(0)
    finally:
        hands.doCleanups()
