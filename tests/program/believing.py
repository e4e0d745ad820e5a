"""What has to hold of a graphics server whatever its physics server says."""
import signal
import time

from fake_server import FakeServerTest
from odd_files_test import CONTROLS
from program import wait_until

FRAMES = 6            # of a camera with thirty a second, during each attack
MOST_GROWTH_MIB = 32
MOST_LINES = 60       # that a graphics server says of all attacks together
ENDS_WITHIN_S = 2.0


class BelievingTest(FakeServerTest):
    """Of those who believe a physics server: what has to hold whatever it says."""

    def setUp(self):
        super().setUp()
        self.environment["PALPATE_LOG"] = self.path("all.log")

    def nothing_odd(self, text):
        self.assertFalse(CONTROLS & {ord(c) for c in text}, text)

    def goes_on(self, graphics, server):
        """It draws, and says so to the server, honest or not."""
        before = server.frames
        wait_until(lambda: graphics.ended() or server.frames >= before + FRAMES, f"frames during {server.attack}")
        self.assertFalse(graphics.ended(), f"{server.attack}: {graphics.lines()}")
        self.assertIsNone(server.trouble)

    def recovers(self, graphics, server, after):
        """Answered in time again: of the next frames some are not late."""
        server.attack = None

        def in_time():
            frames, late = server.frames, server.late
            self.goes_on(graphics, server)
            return server.late - late < (server.frames - frames) / 2
        wait_until(in_time, f"frames with their states after {after}")

    def ends_at_once(self, graphics):
        begun = time.monotonic()
        graphics.send(signal.SIGTERM)
        done = graphics.ends()
        self.assertLess(time.monotonic() - begun, ENDS_WITHIN_S)
        self.assertEqual(done.code, 0, done)
        self.nothing_odd(done.err + done.out + self.read("all.log").decode())
        self.assertLess(len(done.lines), MOST_LINES, done)
        self.assertLess(max(map(len, done.lines)), 1000)
        return done

    def begins(self, *options, address=None):
        """A graphics server that has drawn some frames of an honest one."""
        server = self.fake(*self.learn()).start(address)
        graphics = self.start_graphics("--connect", address or f"ipc://{server.path}", *options)
        self.goes_on(graphics, server)
        self.goes_on(graphics, server)
        return graphics, server
