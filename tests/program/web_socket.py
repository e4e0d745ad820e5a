"""A WebSocket client of this file's own (RFC 6455). It shares nothing with the program."""
import base64
import hashlib
import os
import socket
import struct

GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


def request(port, path="/", host=None, headers=()):
    """The status, the headers (lower case) and the stream of a GET, and its socket."""
    link = socket.create_connection(("127.0.0.1", port), timeout=30)
    lines = [f"GET {path} HTTP/1.1", *(() if host == "" else (f"Host: {host or f'127.0.0.1:{port}'}",)), *headers]
    link.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
    stream = link.makefile("rb")
    first = stream.readline()
    got = {}
    while (line := stream.readline().strip()):
        name, _, value = line.decode().partition(":")
        got[name.lower()] = value.strip()
    return int(first.split()[1]) if first else 0, got, stream, link


def get(port, path="/", **more):
    """The status, the headers and the body."""
    status, headers, stream, link = request(port, path, **more)
    with link:
        return status, headers, stream.read(int(headers.get("content-length", 0)))


class Refused(Exception):
    pass


class WebSocket:
    def __init__(self, port, protocol, path="/", host=None, origin=None):
        key = base64.b64encode(os.urandom(16))
        headers = ["Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13", f"Sec-WebSocket-Key: {key.decode()}"]
        headers += [f"Sec-WebSocket-Protocol: {protocol}"] if protocol else []
        headers += [f"Origin: {origin}"] if origin else []
        status, got, self.stream, self.link = request(port, path, host, headers)
        if status != 101:
            self.link.close()
            raise Refused(status)
        assert got["sec-websocket-accept"] == base64.b64encode(hashlib.sha1(key + GUID).digest()).decode()
        assert not protocol or got["sec-websocket-protocol"] in protocol
        self.protocol = got.get("sec-websocket-protocol")

    def send(self, data, opcode=1):
        data = data.encode() if isinstance(data, str) else data
        size = bytes([0x80 | len(data)]) if len(data) < 126 else \
            b"\xfe" + struct.pack(">H", len(data)) if len(data) < 65536 else b"\xff" + struct.pack(">Q", len(data))
        self.link.sendall(bytes([0x80 | opcode]) + size + b"\0\0\0\0" + data)

    def receive(self):
        """The next whole message: text or bytes; None where the other side has ended the connection."""
        parts, kind = b"", None
        while True:
            try:
                head = self.stream.read(2)
            except ConnectionError:
                return None
            if len(head) < 2:
                return None
            opcode, size = head[0] & 15, head[1]
            size = struct.unpack(">H", self.stream.read(2))[0] if size == 126 else struct.unpack(">Q", self.stream.read(8))[0] if size == 127 else size
            data = self.stream.read(size)
            if opcode == 8:
                return None
            if opcode == 9:
                self.send(data, 10)
            elif opcode in (0, 1, 2):
                kind = opcode or kind
                parts += data
                if head[0] & 0x80:
                    return parts.decode() if kind == 1 else parts

    def close(self):
        self.link.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
