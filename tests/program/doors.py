"""One laboratory behind the protocols of real devices: an OpenIGTLink server, a GigE Vision camera, an arm at the socket of a stand-in
for OpenHaptics' library. Laboratory and doors meet in a run directory of their own, which no server knows: what servers get
comes through their drivers."""
import fcntl
import os
import signal
import subprocess

from person_at_devices import Laboratory, as_devices_run
from program import free_port

DOORS = os.environ["DOORS"]
TURN = "/tmp/palpate_network_camera.lock"  # one network camera at a time on a machine, as tests/fake_network_camera.h says
SERIAL = "PalpateDoor"
EXPOSURE_MS, RATE_HZ = 8, 15  # the reference world's has 30 pictures a second, which two cores do not draw beside all the rest


def write_world(test):
    """The reference world with this camera; its file's name."""
    test.runs("world", "new", "world.toml")
    before, camera = test.read("world.toml").decode().split("[camera]\n")
    assert "rate_hz = 30.0" in camera
    return test.write("world.toml", before + "[camera]\n" + camera.replace("rate_hz = 30.0", f"rate_hz = {RATE_HZ}.0", 1))


def wait_for_turn(test):
    try:
        turn = os.open(TURN, os.O_RDONLY | os.O_CLOEXEC)
    except FileNotFoundError:
        turn = os.open(TURN, os.O_RDONLY | os.O_CREAT | os.O_CLOEXEC, 0o644)
    test.addCleanup(os.close, turn)
    fcntl.flock(turn, fcntl.LOCK_EX)


def close(process):
    process.kill()
    process.wait()
    process.stdout.close()


class Channel:
    """The same laboratory without doors: its devices over its own channel."""

    def __init__(self, test, *world_options):
        self.environment = test.environment
        self.laboratory = Laboratory(test, *world_options)
        self.devices = ("--arm", "lab", "--tracker", "lab", "--camera", "lab")
        self.physics, self.graphics = ("--arm", "lab"), ()


class Doors:
    """Opened with the laboratory; the test's own environment is what servers run in."""

    def __init__(self, test, *world_options):
        wait_for_turn(test)
        self.test = test
        hidden = os.path.join(test.root, "laboratory")
        os.mkdir(hidden, 0o700)
        self.environment = {**test.environment, "XDG_RUNTIME_DIR": hidden}
        self.laboratory = Laboratory(test, *world_options, environment=self.environment)
        self.port, self.cable = free_port(), os.path.join(test.root, "arm")
        self.doors = {kind: self._open(DOORS, kind, "lab", *options) for kind, options in
                      (("tracker", (self.port,)), ("camera", (SERIAL, EXPOSURE_MS, RATE_HZ)), ("arm", (self.cable,)))}
        test.environment.update(PALPATE_LIBHD=os.environ["HD_STUB"], HD_STUB_ARM=self.cable)
        test.environment.pop("HD_STUB_STATE", None)
        self.tracker = f"igtl://127.0.0.1:{self.port}"
        self.camera = "aravis:127.0.0.1"  # by address: a machine of several networks answers to the name by way of any of them
        self.devices = ("--arm", "openhaptics", "--tracker", self.tracker, "--camera", self.camera)
        self.physics, self.graphics = ("--arm", "openhaptics"), ("--tracker", self.tracker, "--camera", self.camera)

    def _open(self, *command):
        process = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, text=True, env=self.environment,
                                   preexec_fn=as_devices_run)
        self.test.addCleanup(close, process)
        self.test.assertEqual(process.stdout.readline(), "ready\n", command)
        return process

    def pull(self, kind):
        self.doors[kind].send_signal(signal.SIGKILL)
        self.doors[kind].wait()
