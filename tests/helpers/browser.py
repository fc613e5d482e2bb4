"""A real headless Chromium through its driver's own HTTP interface (W3C WebDriver): no package is needed."""

import json
import shutil
import socket
import subprocess
import time
import urllib.error
import urllib.request

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
MISSING = "" if CHROMIUM and DRIVER else "chromium and chromedriver are not installed (apt: chromium chromium-driver)"
_ELEMENT = "element-6066-11e4-a52e-4f735466cecf"


class Browser:
    """One window; use as a context manager."""

    def __init__(self, downloads):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        command = [DRIVER, f"--port={self.port}", "--log-level=SEVERE"]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--mute-audio"]
        flags.append("--autoplay-policy=no-user-gesture-required")
        options = {"binary": CHROMIUM, "args": flags, "prefs": {"download.default_directory": str(downloads)}}
        self.session = ""
        self.wait(lambda: self.call("GET", "/status")["ready"], 60)
        wanted = {"capabilities": {"alwaysMatch": {"goog:chromeOptions": options}}}
        self.session = "/session/" + self.call("POST", "/session", wanted)["sessionId"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.call("DELETE", "")
        finally:
            self.process.terminate()
            self.process.wait(20)

    def call(self, method, path, body=None):
        """The driver's answer."""
        data = None if body is None else json.dumps(body).encode()
        url = f"http://127.0.0.1:{self.port}{self.session}{path}"
        request = urllib.request.Request(url, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise AssertionError(error.read().decode()[:500]) from error

    def open(self, url):
        """Load a page."""
        self.call("POST", "/url", {"url": url})

    def run(self, script):
        """What a script returns."""
        return self.call("POST", "/execute/sync", {"script": script, "args": []})

    def element(self, selector):
        """The path of an element."""
        return "/element/" + self.call("POST", "/element", {"using": "css selector", "value": selector})[_ELEMENT]

    def click(self, selector):
        """Click as a person does: what is hidden or covered cannot be clicked."""
        self.call("POST", f"{self.element(selector)}/click", {})

    def type(self, selector, text):
        """Type into a field."""
        self.call("POST", f"{self.element(selector)}/value", {"text": text})

    def shown(self, selector):
        """Whether an element can be seen."""
        return self.call("GET", f"{self.element(selector)}/displayed")

    def wait(self, condition, seconds=30):
        """Until ``condition()`` is true."""
        end = time.monotonic() + seconds
        while True:
            try:
                if condition():
                    return
            except (urllib.error.URLError, ConnectionError):
                pass
            if time.monotonic() > end:
                raise AssertionError("what was waited for did not happen")
            time.sleep(0.1)
