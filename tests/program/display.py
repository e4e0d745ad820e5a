"""A desktop of its own for a test: a virtual X display with a mouse and a keyboard that can be moved and looked at."""
import os
import struct
import subprocess
import zlib

from Xlib import X, XK, display, error
from Xlib.ext import xtest
from Xlib.protocol import event


class Picture:
    """What the display shows: rows of blue, green, red, unused."""

    def __init__(self, width, height, data):
        self.width, self.height, self.data = width, height, data

    def at(self, x, y):
        i = 4 * (y * self.width + x)
        blue, green, red = self.data[i:i + 3]
        return red, green, blue

    def share(self, box, wanted, step=2):
        """Of the pixels in x, y, width, height for which wanted(red, green, blue) holds."""
        x, y, width, height = box
        found = total = 0
        for row in range(max(0, y), min(self.height, y + height), step):
            for column in range(max(0, x), min(self.width, x + width), step):
                total += 1
                found += bool(wanted(*self.at(column, row)))
        return found / max(1, total)

    def write(self, path):
        rows = []
        for y in range(self.height):
            row = self.data[4 * self.width * y:4 * self.width * (y + 1)]
            rgb = bytearray(3 * self.width)
            rgb[0::3], rgb[1::3], rgb[2::3] = row[2::4], row[1::4], row[0::4]
            rows.append(b"\0" + bytes(rgb))

        def chunk(name, content):
            return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
        with open(path, "wb") as file:
            file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", self.width, self.height, 8, 2, 0, 0, 0)) +
                       chunk(b"IDAT", zlib.compress(b"".join(rows), 6)) + chunk(b"IEND", b""))


class Desktop:
    def __init__(self, width=1280, height=900):
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24", "-nolisten", "tcp", "-noreset"],
            pass_fds=[write], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read, encoding="ascii") as number:
            self.name = ":" + number.readline().strip()
        self.display = display.Display(self.name)
        self.root = self.display.screen().root

    def close(self):
        self.display.close()
        self.server.terminate()
        self.server.wait()

    def window(self, title):
        """The top window of that title, or None."""
        for window in self.root.query_tree().children:
            try:
                if window.get_wm_name() == title and window.get_attributes().map_state == X.IsViewable:
                    return window
            except error.BadWindow:
                continue
        return None

    def box(self, window):
        """x, y, width, height on the screen."""
        geometry = window.get_geometry()
        return geometry.x, geometry.y, geometry.width, geometry.height

    def resize(self, window, width, height, x=0, y=0):
        window.configure(x=x, y=y, width=width, height=height)
        self.display.sync()

    def focus(self, window):
        """Keys go there from now on."""
        window.set_input_focus(X.RevertToParent, X.CurrentTime)
        self.display.sync()

    def close_window(self, window):
        """As the cross in its frame does: it is asked to close."""
        protocols, delete = self.display.intern_atom("WM_PROTOCOLS"), self.display.intern_atom("WM_DELETE_WINDOW")
        window.send_event(event.ClientMessage(window=window, client_type=protocols, data=(32, [delete, X.CurrentTime, 0, 0, 0])))
        self.display.sync()

    def point(self, x, y):
        xtest.fake_input(self.display, X.MotionNotify, x=int(x), y=int(y))
        self.display.sync()

    def press(self, *names):
        """Keys by their X names, all held together."""
        codes = [self.display.keysym_to_keycode(XK.string_to_keysym(name)) for name in names]
        for code in codes:
            xtest.fake_input(self.display, X.KeyPress, code)
        for code in reversed(codes):
            xtest.fake_input(self.display, X.KeyRelease, code)
        self.display.sync()

    def button(self, number, down):
        xtest.fake_input(self.display, X.ButtonPress if down else X.ButtonRelease, number)
        self.display.sync()

    def click(self, number):
        self.button(number, True)
        self.button(number, False)

    def picture(self, window=None, box=None):
        """Of all of it, or of `box` alone: x, y, width, height."""
        drawable = window or self.root
        if box is None:
            geometry = drawable.get_geometry()
            box = 0, 0, geometry.width, geometry.height
        image = drawable.get_image(*box, X.ZPixmap, 0xffffffff)
        return Picture(box[2], box[3], image.data)
