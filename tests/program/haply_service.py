"""Haply's service as its public documentation describes it (Inverse SDK 3.5, WebSocket protocol and control commands), over a
WebSocket of this file's own (RFC 6455). It shares nothing with the program."""
import base64
import hashlib
import json
import socket
import struct
import threading

GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


class Service:
    def __init__(self, port=0):
        self.server = socket.create_server(("127.0.0.1", port))
        self.port = self.server.getsockname()[1]
        self.guard = threading.Lock()
        self.place, self.basis, self.present = (0.0, -0.12, 0.15), "XYZ", True
        self.force, self.forces, self.messages = (0.0, 0.0, 0.0), [], 0
        self.ending = False
        self.client = None
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def close(self):
        self.ending = True
        for one in (self.client, self.server):
            try:
                one.shutdown(socket.SHUT_RDWR)
            except (OSError, AttributeError):
                pass
        self.server.close()
        self.thread.join(30)

    def move(self, place):
        with self.guard:
            self.place = tuple(place)

    def newest(self):
        with self.guard:
            return self.force, self.messages

    def serve(self):
        while not self.ending:
            try:
                self.client, _ = self.server.accept()
                self.client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                with self.client:
                    self.talk(self.client.makefile("rb"))
            except (OSError, EOFError, ValueError):
                pass
            with self.guard:
                self.force = (0.0, 0.0, 0.0)  # nobody drives the arm: it is idle

    def talk(self, stream):
        key = None
        stream.readline()
        while (line := stream.readline().strip()):
            name, _, value = line.partition(b":")
            if name.lower() == b"sec-websocket-key":
                key = value.strip()
        accept = base64.b64encode(hashlib.sha1(key + GUID).digest())
        self.client.sendall(b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                            b"Sec-WebSocket-Accept: " + accept + b"\r\n\r\n")
        self.say(True)
        while not self.ending:
            message = self.read_frame(stream)
            self.say(self.hear(json.loads(message)))

    @staticmethod
    def read_frame(stream):
        def read(count):
            data = stream.read(count)
            if len(data) < count:
                raise EOFError
            return data
        first, second = read(2)
        if first != 0x81 or not second & 0x80:
            raise EOFError  # no whole text of a client: it says good-bye
        size = second & 0x7F
        if size == 126:
            size, = struct.unpack(">H", read(2))
        elif size == 127:
            size, = struct.unpack(">Q", read(8))
        mask, data = read(4), read(size)
        return bytes(byte ^ mask[i % 4] for i, byte in enumerate(data))

    def hear(self, message):
        with self.guard:
            self.messages += 1
            for arm in message.get("inverse3", []):
                if "basis" in message.get("session", {}).get("configure", {}):
                    assert message["session"]["configure"]["basis"] == {"permutation": "XYZ"}
                command = arm["commands"]["set_cursor_force"]
                vector = command.get("vector", command.get("values"))  # as 3.5 and as 3.1 has it
                self.force = (vector["x"], vector["y"], vector["z"])
                self.forces.append(self.force)
        return "force_render_full_state" in message.get("session", {})

    def say(self, whole):
        with self.guard:
            place, force = (dict(zip("xyz", v)) for v in (self.place, self.force))
            arm = {"device_id": "049D", "state": {"cursor_position": place, "current_cursor_force": force},
                   "status": {"calibrated": True, "power_supply": True}}
            if whole:
                arm["config"] = {"type": "inverse3", "basis": {"permutation": self.basis}, "filters": {"force_gate": {"gain": 0.3}}}
            grip = {"device_id": "61576", "state": {"orientation": {"w": 0.5, "x": 0.5, "y": 0.5, "z": 0.5}, "buttons": {"a": False, "b": True, "c": False}}}
            state = {"session_id": 1, "inverse3": [arm] if self.present else [], "wireless_verse_grip": [grip]}
        data = json.dumps(state).encode()
        size = bytes([len(data)]) if len(data) < 126 else b"\x7e" + struct.pack(">H", len(data))
        self.client.sendall(b"\x81" + size + data)
