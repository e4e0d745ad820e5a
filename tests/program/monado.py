"""Monado, an OpenXR runtime nobody of us wrote, on a virtual X display, with a head that stands where it is told (its remote driver).

Its window is the display of the headset: each eye sees 85 degrees on the 480 pixels of its half, which are a little wider than high.
That driver listens at a port for everybody, so all of it runs in a network of its own."""
import fcntl
import json
import math
import os
import shutil
import socket
import struct
import subprocess
import sys
import unittest

from Xlib import X, error

from display import Desktop
from program import ProgramTest, wait_until

EYE_PX = 480, 540
HALF_VIEW = math.radians(42.5), math.atan(math.tan(math.radians(42.5)) * 0.07 / 0.065)  # to the sides, up and down: the half is 65 by 70 mm
PX_PER_TANGENT = [0.5 * px / math.tan(half) for px, half in zip(EYE_PX, HALF_VIEW)]
EYE_DISTANCE_M = 0.064
PORT = 4242  # the remote driver's
ALONE = "MONADO_TEST_IS_ALONE"


def place():
    """Where Monado is installed: what PALPATE_MONADO names, else where monado-service is found; None: nowhere."""
    service = shutil.which("monado-service")
    return os.environ.get("PALPATE_MONADO") or (service and os.path.dirname(os.path.dirname(os.path.realpath(service))))


def run_alone():
    """Starts this script once more, in a network of its own; or goes on, where that is not to be had."""
    command = ["unshare", "--map-root-user", "--net"]
    if ALONE not in os.environ and place() and subprocess.run([*command, "true"], stderr=subprocess.DEVNULL, check=False).returncode == 0:
        os.execvpe(command[0], [*command, sys.executable, *sys.argv], {**os.environ, ALONE: "1"})


def why_not():
    """Why nothing can be tried here; None: it can."""
    if not place():
        return "not tried: no Monado (PALPATE_MONADO, or monado-service in PATH)"
    return None if ALONE in os.environ else "not tried: this user may not make networks"


def turned(q, v):
    """By the unit quaternion w, x, y, z."""
    w, axis = q[0], q[1:]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    once = cross(axis, v)
    twice = cross(axis, once)
    return [v[i] + 2.0 * (w * once[i] + twice[i]) for i in range(3)]


class Head:
    """Where the head is: metres, and degrees to the left and up; x right, y up, z backwards."""

    def __init__(self, at=(0.0, 1.6, 0.0), left_deg=0.0, up_deg=0.0):
        self.at = at
        left, up = math.radians(left_deg) / 2, math.radians(up_deg) / 2
        self.turn = (math.cos(left) * math.cos(up), math.cos(left) * math.sin(up), math.sin(left) * math.cos(up), -math.sin(left) * math.sin(up))

    def room(self, point):
        return [a + b for a, b in zip(self.at, turned(self.turn, point))]

    def pixel(self, point, eye):
        """Where that eye sees a point of the room, from the upper left corner of its half; pixel centres have halves."""
        back = (self.turn[0], *(-x for x in self.turn[1:]))
        x, y, z = turned(back, [a - b for a, b in zip(point, self.at)])
        x -= (eye - 0.5) * EYE_DISTANCE_M
        return EYE_PX[0] / 2 - PX_PER_TANGENT[0] * x / z, EYE_PX[1] / 2 + PX_PER_TANGENT[1] * y / z


def packet(head):
    """What the remote driver of Monado 25 takes (r_interface.h); both hands are away."""
    def pose(turn, at):
        return struct.pack("<7f", *turn[1:], turn[0], *at)
    upright = (1.0, 0.0, 0.0, 0.0)
    views = b"".join(struct.pack("<4f", -HALF_VIEW[0], HALF_VIEW[0], HALF_VIEW[1], -HALF_VIEW[1]) + pose(upright, ((eye - 0.5) * EYE_DISTANCE_M, 0.0, 0.0)) + bytes(4) for eye in (0, 1))
    hand = pose(upright, (0.0, 0.0, 0.0)) + bytes(92)
    return b"mndrmt3\0" + views + pose(head.turn, head.at) + b"\1\0\0\0" + 2 * hand


class MonadoTest(ProgramTest):
    def setUp(self):
        if reason := why_not():
            raise unittest.SkipTest(reason)
        super().setUp()
        with socket.socket() as any_socket:  # up goes the network's own loop: SIOCSIFFLAGS, IFF_UP
            fcntl.ioctl(any_socket, 0x8914, struct.pack("16sh14x", b"lo", 1))
        self.desktop = Desktop(1280, 720)
        self.addCleanup(self.desktop.close)
        self.environment.update(XR_RUNTIME_JSON=os.path.join(place(), "share/openxr/1/openxr_monado.json"), DISPLAY=self.desktop.name)
        self.environment.pop("WAYLAND_DISPLAY", None)
        self.start_monado()

    def start_monado(self):
        with open(os.path.join(self.logs, "monado"), "ab") as log:
            self.monado = subprocess.Popen(
                [os.path.join(place(), "bin/monado-service")], stdin=subprocess.DEVNULL, stdout=log, stderr=log, cwd=self.folder,
                env={**self.environment, "P_OVERRIDE_ACTIVE_CONFIG": "remote", "XRT_COMPOSITOR_FORCE_XCB": "1", "XRT_NO_STDIN": "1", **self.monado_settings()})
        self.addCleanup(self.stop_monado)
        wait_until(lambda: self.reached() or self.monado.poll() is not None, f"monado-service answers; it says {self.monado_says()}")
        self.assertIsNone(self.monado.poll(), self.monado_says())
        self.addCleanup(self.remote.close)
        self.put_head(Head())

    def monado_settings(self):
        return {}

    def monado_says(self):
        with open(os.path.join(self.logs, "monado"), encoding="utf-8") as log:
            return log.read()[-2000:]

    def reached(self):
        try:
            self.remote = socket.create_connection(("127.0.0.1", PORT))
            return True
        except ConnectionRefusedError:
            return False

    def stop_monado(self):
        self.monado.kill()
        self.monado.wait()
        socket_file = os.path.join(self.meeting, "monado_comp_ipc")
        if os.path.exists(socket_file):
            os.remove(socket_file)

    def put_head(self, head):
        self.remote.sendall(packet(head))

    def window(self):
        """Monado's, once it is to be seen: which is as long as somebody shows pictures."""
        for window in self.desktop.root.query_tree().children:
            try:
                if self.desktop.box(window)[2:] == (2 * EYE_PX[0], EYE_PX[1]) and window.get_attributes().map_state == X.IsViewable:
                    return window
            except error.BadDrawable:
                continue
        return None

    def picture(self):
        window = self.window()
        return window and self.desktop.picture(window)

    def shows_something(self):
        picture = self.picture()
        return picture and any(picture.data[::4])

    def steady_picture(self):
        """Once it is the same for three looks, far more than a frame apart."""
        looks = []

        def steady():
            looks.append(self.picture())
            return None not in looks[-3:] and len(looks) > 2 and looks[-1].data == looks[-2].data == looks[-3].data
        wait_until(lambda: self.frames_pass(6) and steady(), "the display shows what stands still")
        return looks[-1]

    def frames_pass(self, count):
        raise NotImplementedError


class Dots:
    """tests/headset_dots.cpp in the background."""

    def __init__(self, test):
        with open(os.path.join(test.logs, "dots"), "wb") as log:
            self.process = subprocess.Popen([os.environ["HEADSET_DOTS"]], env=test.environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log)
        self.log = os.path.join(test.logs, "dots")
        test.addCleanup(self.close)

    def __call__(self, command):
        print(command, file=self.process.stdin, flush=True)
        line = self.process.stdout.readline()
        if not line:
            with open(self.log, encoding="utf-8") as log:
                raise AssertionError(f"{command}: {log.read()}")
        return json.loads(line)

    def close(self):
        self.process.stdin.close()
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
