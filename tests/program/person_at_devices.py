"""A script in the place of a person: reads what `calibrate all`, or `verify`, asks for, has the laboratory's person do it, presses the keys."""
import json
import os
import signal
import subprocess
import threading

from program import PATIENCE_S, PROGRAM, wait_until


def as_devices_run():
    """Before the program: first in turn where the machine allows that, for a device has electronics of its own."""
    try:
        os.nice(-15)
    except PermissionError:
        pass


class Laboratory:
    """`world run --gestures`: its person does what it is told, a line each."""

    def __init__(self, test, *options, environment=None):
        self.process = subprocess.Popen([PROGRAM, "world", "run", "--gestures", *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, env=environment or test.environment, cwd=test.folder)
        test.addCleanup(self.remove)
        self.said = []
        self._opened = threading.Event()
        threading.Thread(target=self._listen, daemon=True).start()
        if not self._opened.wait(60):
            raise AssertionError(f"the laboratory does not open: {self.said}")

    def _listen(self):
        for line in self.process.stderr:
            self.said.append(line)
            if "are open" in line:
                self._opened.set()

    def does(self, instruction):
        """Until the person is there; what they answer."""
        self.process.stdin.write(json.dumps(instruction) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def ends(self):
        """As with Ctrl-C: it writes what it has to write."""
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(60)

    def remove(self):
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            pipe.close()


class Session:
    """`calibrate all`, or another `command`, with a person at its keys; `at_the_end(step, ended)` gives the key after each step, Enter where there is none."""

    def __init__(self, test, laboratory, *options, command=("calibrate", "all"), at_the_end=lambda step, ended: "\n"):
        self.fifo = test.path("instructions")
        if not os.path.exists(self.fifo):
            os.mkfifo(self.fifo)
        self.laboratory, self.at_the_end = laboratory, at_the_end
        self.shown, self.ended, self.lines = [], [], []
        self.posing, self.poses, self.sees = False, 0, True  # whether a pose is held, the how many-th; whether the tracker sees the stylus
        self.process = subprocess.Popen([PROGRAM, *command, "--instructions", self.fifo, *options], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=test.environment, cwd=test.folder)
        test.addCleanup(self.remove)
        threading.Thread(target=lambda: self.lines.extend(self.process.stderr), daemon=True).start()
        threading.Thread(target=self._sit, daemon=True).start()

    def press(self, key):
        try:
            self.process.stdin.write(key)
            self.process.stdin.flush()
        except OSError:
            pass  # it has ended

    def _sit(self):
        with open(self.fifo, encoding="utf-8") as instructions:
            for line in instructions:
                told = json.loads(line)
                self.shown.append(told)
                if "gesture" in told:
                    answer = self.laboratory.does({key: told[key] for key in told if key != "text"})
                    self.posing = told["gesture"] == "next_pose" and "ready" in answer
                    self.poses += 1
                    self.press("\n" if "ready" in answer else "n" if answer["no_more"] else "s")
                    self._look_again()
                elif "seen" in told:
                    self.sees = told["seen"]["stylus"]
                    self._look_again()
                elif "taken" in told:
                    self.posing = False
                elif "released" in told:
                    self.laboratory.does({"gesture": "rest"})
                elif "ended" in told:
                    self.ended.append(told)
                    self.press(self.at_the_end(told["ended"], told))

    def _look_again(self):
        """Another pose, where the tracker does not see the stylus in this one."""
        if self.posing and not self.sees:
            pose = self.poses
            threading.Timer(3.0, lambda: self.press("s") if self.posing and not self.sees and self.poses == pose else None).start()

    def ends(self, patience_s=PATIENCE_S):
        wait_until(lambda: self.process.poll() is not None, f"the session ends; so far {self.lines[-5:]}", patience_s)
        return self.process.returncode

    def remove(self):
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            pipe.close()
