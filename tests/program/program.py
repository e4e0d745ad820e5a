"""Runs the program from outside: to its end, or in the background as a server. Nothing waits for a fixed time."""
import hashlib
import os
import random
import shutil
import socket
import subprocess
import tempfile
import time
import unittest

PROGRAM = os.environ["PALPATE"]
PATIENCE_S = 240.0  # for what ought to take seconds, on a busy machine and under sanitizers


def wait_until(condition, what, patience_s=PATIENCE_S):
    until = time.monotonic() + patience_s
    while not condition():
        if time.monotonic() > until:
            raise AssertionError(f"waited {patience_s:.0f} s until {what}")
        time.sleep(0.02)


def free_port():
    """Of those that the kernel gives to nobody by itself: one that it gave once it may give to a connection meanwhile."""
    while True:
        port = random.randrange(10000, 32000)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
                return port
            except OSError:
                pass


def resident_mib(process):
    with open(f"/proc/{process}/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


class Done:
    """A command that has ended."""

    def __init__(self, code, out, err):
        self.code, self.out, self.err = code, out, err
        self.lines = err.splitlines()

    def __str__(self):
        return f"exit {self.code}\nstandard output: {self.out}\nstandard error: {self.err}"


def without_phases(done):
    """A demo's end, without the lines that say what it does: into a file or a pipe no bar is drawn."""
    phases = ("calibrates everything", "plays ", "writes the report")
    lines = [line for line in done.lines if not line.startswith(tuple(f"palpate: demo: {phase}" for phase in phases))]
    return Done(done.code, done.out, "".join(line + "\n" for line in lines))


class Running:
    """A command in the background. Its output goes to files, so that no full pipe can stop it."""

    def __init__(self, arguments, logs, **how):
        self.arguments = [str(a) for a in arguments]
        self.files = [tempfile.NamedTemporaryFile(dir=logs, suffix=s) for s in (".out", ".err")]
        self.process = subprocess.Popen([PROGRAM, *self.arguments], stdin=subprocess.DEVNULL, stdout=self.files[0],
                                        stderr=self.files[1], **how)

    def _text(self, file):
        with open(file.name, encoding="utf-8") as again:
            return again.read()

    def lines(self):
        """The whole lines on standard error so far."""
        return self._text(self.files[1]).split("\n")[:-1]

    def output(self):
        """Standard output so far."""
        return self._text(self.files[0])

    def ended(self):
        return self.process.poll() is not None

    def says(self, words):
        """Waits for a line with these words; False where the command ends without it."""
        def said():
            return any(words in line for line in self.lines())
        wait_until(lambda: said() or self.ended(), f"{self.arguments} says '{words}'; so far {self.lines()}")
        return said()

    def send(self, number):
        self.process.send_signal(number)

    def ends(self, patience_s=PATIENCE_S):
        wait_until(self.ended, f"{self.arguments} ends; so far {self.lines()}", patience_s)
        return Done(self.process.returncode, self._text(self.files[0]), self._text(self.files[1]))

    def remove(self):
        if not self.ended():
            self.process.kill()
            self.process.wait()
        for file in self.files:
            file.close()


class ProgramTest(unittest.TestCase):
    """A scratch folder, also for sockets and shared memory, and the checks every refusal has to pass."""

    def setUp(self):
        # Short, because a socket's path has at most 107 bytes.
        self.root = tempfile.mkdtemp(prefix="palpate-", dir="/tmp")
        self.addCleanup(shutil.rmtree, self.root, ignore_errors=True)
        self.folder, self.logs, self.meeting = (os.path.join(self.root, name) for name in ("files", "logs", "run"))
        for folder in (self.folder, self.logs, self.meeting):
            os.mkdir(folder, 0o700)
        self.environment = {**os.environ, "XDG_RUNTIME_DIR": self.meeting,
                            "XDG_CONFIG_HOME": os.path.join(self.root, "config")}

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def write(self, name, content):
        with open(self.path(name), "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
        return self.path(name)

    def read(self, *names):
        with open(self.path(*names), "rb") as file:
            return file.read()

    def files(self):
        """Every file below the scratch folder with its content's hash, folders with nothing."""
        found = {}
        for place, folders, names in os.walk(self.folder):
            found.update((os.path.relpath(os.path.join(place, name), self.folder), None) for name in folders)
            for name in names:
                path = os.path.relpath(os.path.join(place, name), self.folder)
                found[path] = hashlib.sha256(self.read(path)).hexdigest() if os.path.isfile(self.path(path)) else None
        return found

    def run_program(self, *arguments, stdout=subprocess.PIPE, before=None):
        done = subprocess.run([PROGRAM, *map(str, arguments)], stdin=subprocess.DEVNULL, stdout=stdout,
                              stderr=subprocess.PIPE, text=True, timeout=PATIENCE_S, check=False,
                              env=self.environment, cwd=self.folder, preexec_fn=before)
        return Done(done.returncode, done.stdout or "", done.stderr)

    def runs(self, *arguments):
        done = self.run_program(*arguments)
        self.assertEqual(done.code, 0, f"{arguments}: {done}")
        return done

    def start(self, *arguments, **how):
        running = Running(arguments, self.logs, **{"env": self.environment, "cwd": self.folder, **how})
        self.addCleanup(running.remove)
        return running

    def says_no(self, done, code, *words):
        """One line on standard error with these words, nothing on standard output, this exit code."""
        self.assertEqual(done.code, code, done)
        self.assertEqual(len(done.lines), 1, done)
        self.assertTrue(done.lines[0].startswith("palpate: "), done)
        for word in words:
            self.assertIn(word, done.lines[0])
        self.assertEqual(done.out, "", done)

    def refuses(self, arguments, code, *words, **how):
        """Says no and leaves every file as it was."""
        before = self.files()
        self.says_no(self.run_program(*arguments, **how), code, *words)
        self.assertEqual(self.files(), before, arguments)
        self.assertEqual(os.listdir(self.meeting), [])
