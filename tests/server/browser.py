"""A headless Chromium through chromedriver (W3C WebDriver), standard library only. have_browser() tells whether both are there."""
import base64
import json
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"   # https://www.w3.org/TR/webdriver/#elements


def have_browser():
    return bool(shutil.which("chromium") and shutil.which("chromedriver"))


class Browser:
    """with Browser(1280, 900) as b: b.go(url); b.script("return document.title")"""

    def __init__(self, width, height):
        self.size = (width, height)

    def __enter__(self):
        with socket.socket() as s:
            s.bind(("127.0.0.1", 0))
            port = s.getsockname()[1]
        self.profile = tempfile.mkdtemp(prefix="alder-browser-")
        self.driver = subprocess.Popen(["chromedriver", "--port=%d" % port], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.base = "http://127.0.0.1:%d" % port
        arguments = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
                     "--disable-component-update", "--disable-sync", "--user-data-dir=" + self.profile, "--window-size=%d,%d" % self.size]
        capabilities = {"browserName": "chrome", "goog:chromeOptions": {"binary": shutil.which("chromium"), "args": arguments},
                        "goog:loggingPrefs": {"browser": "ALL"}}
        for attempt in range(100):
            try:
                answer = self.ask("POST", "/session", {"capabilities": {"alwaysMatch": capabilities}})
                break
            except (urllib.error.URLError, ConnectionError):
                if attempt == 99:
                    raise
                time.sleep(0.1)
        self.base += "/session/" + answer["sessionId"]
        return self

    def __exit__(self, *_):
        try:
            self.ask("DELETE", "")
        finally:
            self.driver.terminate()
            self.driver.wait(20)
            shutil.rmtree(self.profile, ignore_errors=True)

    def ask(self, method, path, body=None):
        data = json.dumps(body if body is not None else {}).encode() if method == "POST" else None
        request = urllib.request.Request(self.base + path, data=data, method=method, headers={"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=120) as answer:
                return json.loads(answer.read())["value"]
        except urllib.error.HTTPError as e:
            raise AssertionError("browser: " + json.loads(e.read())["value"]["message"][:500]) from None

    def go(self, url):
        self.ask("POST", "/url", {"url": url})

    def script(self, code, *arguments):
        return self.ask("POST", "/execute/sync", {"script": code, "args": list(arguments)})

    def wait(self, code, *arguments, seconds=60):
        """Until the script returns something true."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            value = self.script(code, *arguments)
            if value:
                return value
            time.sleep(0.05)
        raise AssertionError("the page did not come to: %s; it says: %s" % (code, self.script("return document.body.innerText")[:500]))

    def find(self, selector):
        return self.ask("POST", "/element", {"using": "css selector", "value": selector})[ELEMENT]

    def click(self, selector):
        self.ask("POST", "/element/%s/click" % self.find(selector))

    def keys(self, selector, text):
        self.ask("POST", "/element/%s/value" % self.find(selector), {"text": text})

    def messages(self):
        """What the page wrote to the console: errors of scripts, refused requests."""
        return [m["message"] for m in self.ask("POST", "/se/log", {"type": "browser"}) if m["level"] == "SEVERE"]

    def screenshot(self, path):
        with open(path, "wb") as f:
            f.write(base64.b64decode(self.ask("GET", "/screenshot")))
