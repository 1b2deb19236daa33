"""Who may come in, and how: the login cookie of pages, TLS, options by flag and environment."""
import hashlib
import http.client
import json
import os
import pathlib
import shutil
import ssl
import subprocess
import sys
import tempfile
import unittest
import warnings

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs/examples"))
from daemon import Daemon  # noqa: E402

BUILD = os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build"))


class AccessTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="alder-access-")
        self.addCleanup(shutil.rmtree, self.folder, True)

    def tokens(self, **tokens):
        path = os.path.join(self.folder, "tokens")
        with open(path, "w") as f:
            for token, scopes in tokens.items():
                f.write("%s-user:%s:%s\n" % (token, scopes, hashlib.sha256(token.encode()).hexdigest()))
        return path

    def test_a_page_logs_in_with_a_cookie_and_out_again(self):
        with Daemon(BUILD, "--token-file", self.tokens(secret="read")) as daemon:
            self.assertEqual(daemon.ask("GET", "/v1/nodes")[0], 401)
            self.assertEqual(daemon.ask("GET", "/ui")[0], 200, "the page itself asks for the token")
            self.assertEqual(daemon.ask("POST", "/v1/login", {"token": "wrong"})[0], 401)
            self.assertEqual(daemon.ask("POST", "/v1/login", {"token": "secret"}, {"Origin": "http://elsewhere.example"})[0], 403)
            status, headers, body = daemon.ask("POST", "/v1/login", {"token": "secret"})
            self.assertEqual((status, json.loads(body)), (200, {"user": "secret-user"}))
            cookie = headers["Set-Cookie"]
            for part in ("HttpOnly", "SameSite=Strict", "Path=/", "Max-Age="):
                self.assertIn(part, cookie)
            self.assertNotIn("secret", cookie)
            mine = {"Cookie": "theme=dark; " + cookie.split(";")[0]}
            self.assertEqual(daemon.ask("GET", "/v1/version", headers=mine)[0], 200)
            self.assertEqual(daemon.ask("POST", "/v1/preview", {"graph": {}}, mine)[0], 403, "the token's scopes hold for the cookie")
            self.assertEqual(daemon.ask("GET", "/v1/version", headers={"Cookie": "alder_session=" + 64 * "0"})[0], 401)
            status, headers, _ = daemon.ask("DELETE", "/v1/login", headers=mine)
            self.assertEqual(status, 204)
            self.assertIn("Max-Age=0", headers["Set-Cookie"])
            self.assertEqual(daemon.ask("GET", "/v1/version", headers=mine)[0], 401)
            self.assertNotIn("secret\"", daemon.log_text())

    def certificate(self, name="localhost"):
        cert, key = os.path.join(self.folder, "cert.pem"), os.path.join(self.folder, "key.pem")
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj", "/CN=" + name,
                        "-addext", "subjectAltName=DNS:%s,IP:127.0.0.1" % name, "-keyout", key, "-out", cert], check=True, capture_output=True)
        return cert, key

    @unittest.skipUnless(shutil.which("openssl"), "openssl is not installed")
    def test_tls(self):
        cert, key = self.certificate()
        with Daemon(BUILD, "--tls-cert", cert, "--tls-key", key) as daemon:
            host, port = daemon.address.rsplit(":", 1)
            trust = ssl.create_default_context(cafile=cert)
            c = http.client.HTTPSConnection(host, int(port), context=trust, timeout=30)
            for _ in range(3):   # one connection, several requests
                c.request("GET", "/v1/version")
                answer = c.getresponse()
                self.assertEqual(json.loads(answer.read())["name"], "alderd")
            body = json.dumps({"graph": {"nodes": {"s": {"type": "alSurface"}}, "outputs": {"surface": {"node": "s"}}}, "size": 64, "samples": 1})
            c.request("POST", "/v1/preview", body, {"Content-Type": "application/json", "Accept": "image/x-exr"})
            answer = c.getresponse()
            picture = answer.read()
            self.assertEqual((answer.status, picture[:4]), (200, b"\x76\x2f\x31\x01"))
            blob = os.urandom(3 << 20)   # larger than any buffer on the way, both ways
            name = "/v1/assets/sha256:" + hashlib.sha256(blob).hexdigest()
            c.request("PUT", name, blob)
            self.assertEqual((c.getresponse().read(), )[0][:2], b'{"')
            c.request("GET", name)
            self.assertEqual(c.getresponse().read(), blob)
            self.assertGreaterEqual(c.sock.version(), "TLSv1.2")
            with self.assertRaises((ConnectionError, http.client.HTTPException)):   # plain HTTP gets no answer
                plain = http.client.HTTPConnection(host, int(port), timeout=30)
                plain.request("GET", "/livez")
                plain.getresponse()
            with self.assertRaises(ssl.SSLError):   # what is older is refused
                old = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", DeprecationWarning)
                    old.maximum_version = ssl.TLSVersion.TLSv1_1
                old.check_hostname, old.verify_mode = False, ssl.CERT_NONE
                http.client.HTTPSConnection(host, int(port), context=old, timeout=30).connect()
            c.close()
            c = http.client.HTTPSConnection(host, int(port), context=trust, timeout=30)
            c.request("GET", "/livez")
            self.assertEqual(c.getresponse().read(), b"ok\n")
            c.close()

    def test_tls_files_that_cannot_be_used_are_named_at_the_start(self):
        for more in (["--tls-cert", "/nowhere.pem", "--tls-key", "/nowhere.pem"], ["--tls-cert", "/nowhere.pem"]):
            done = subprocess.run([BUILD + "/alderd", "--listen", "127.0.0.1:0", "--data", self.folder + "/data", *more], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertTrue("nowhere.pem" in done.stderr or "--tls-key" in done.stderr, done.stderr)

    def test_a_flag_goes_before_the_environment_and_that_before_the_file(self):
        config = os.path.join(self.folder, "alderd.toml")
        with open(config, "w") as f:
            f.write('# limits\nmax-body = 3000\nlog-level = "warn"\nasset-root = %s\nasset-root = /tmp\n' % self.folder)
        big = {"graph": {}, "x": 5000 * "x"}

        def limit(environment, *flags):
            os.environ.update(environment)
            try:
                with Daemon(BUILD, "--config", config, *flags) as daemon:
                    status, _, body = daemon.ask("POST", "/v1/preview", big)
                    return json.loads(body).get("limit") if status == 413 else None
            finally:
                for name in environment:
                    del os.environ[name]
        self.assertEqual(limit({}), 3000, "the file")
        self.assertEqual(limit({"ALDER_MAX_BODY": "2000"}), 2000, "the environment goes before the file")
        self.assertEqual(limit({"ALDER_MAX_BODY": "2000"}, "--max-body", "4000"), 4000, "a flag before both")
        for wrong in ("max-bodi = 1\n", "queue\n", "queue = many\n"):
            with open(config, "w") as f:
                f.write("\n" + wrong)
            done = subprocess.run([BUILD + "/alderd", "--config", config, "--data", self.folder + "/data"], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 2, done.stderr)


if __name__ == "__main__":
    unittest.main()
