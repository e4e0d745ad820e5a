"""Chromium without a screen, driven over its DevTools protocol through web_socket.py."""
import base64
import json
import os
import shutil
import subprocess
import time

from web_socket import WebSocket, get

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


class Browser:
    def __init__(self, folder, width=1400, height=1000):
        self.process = subprocess.Popen(
            [CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", "--remote-debugging-port=0",
             "--remote-allow-origins=*", f"--user-data-dir={folder}", f"--window-size={width},{height}", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        place = os.path.join(folder, "DevToolsActivePort")
        until = time.monotonic() + 60
        while not os.path.exists(place) or not (lines := open(place, encoding="ascii").read().split()):
            assert time.monotonic() < until and self.process.poll() is None, "Chromium does not start"
            time.sleep(0.05)
        port = int(lines[0])
        while not (pages := [one for one in json.loads(get(port, "/json")[2]) if one["type"] == "page"]):
            time.sleep(0.05)
        self.link = WebSocket(port, None, path=pages[0]["webSocketDebuggerUrl"].split(str(port), 1)[1])
        self.number, self.told = 0, []
        self.do("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.do("Runtime.enable")
        self.do("Log.enable")

    def do(self, method, **parameters):
        self.number += 1
        self.link.send(json.dumps({"id": self.number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self.link.receive())
            if message.get("id") == self.number:
                return message["result"]
            self.hear(message)

    def hear(self, message):
        """Errors that the page tells."""
        what = message.get("params", {})
        if message.get("method") == "Runtime.exceptionThrown":
            self.told.append(json.dumps(what["exceptionDetails"])[:500])
        elif message.get("method") == "Log.entryAdded" and what["entry"]["level"] == "error":
            self.told.append(what["entry"]["text"])
        elif message.get("method") == "Runtime.consoleAPICalled" and what["type"] == "error":
            self.told.append(json.dumps(what["args"])[:500])

    def open(self, url):
        self.do("Page.navigate", url=url)

    def value(self, expression):
        return self.do("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")

    def waits_for(self, expression, seconds=60):
        until = time.monotonic() + seconds
        while not self.value(expression):
            if time.monotonic() > until:
                return False
            time.sleep(0.1)
        return True

    def picture(self, name, whole=True):
        data = self.do("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]
        with open(name, "wb") as file:
            file.write(base64.b64decode(data))

    def close(self):
        self.link.close()
        self.process.terminate()
        self.process.wait(30)
