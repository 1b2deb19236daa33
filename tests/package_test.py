"""The Debian package: what is in it, and that its service is one that systemd takes."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILD = os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build"))


class PackageTest(unittest.TestCase):
    @unittest.skipUnless(shutil.which("dpkg-deb") and shutil.which("dpkg-shlibdeps") and shutil.which("cpack"), "dpkg-dev is not installed")
    def test_package_holds_programs_loader_service_and_documents(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(["cpack", "-G", "DEB", "-B", folder], cwd=BUILD, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout[-2000:] + done.stderr[-2000:])
            package, = pathlib.Path(folder).glob("alder_*.deb")
            names = subprocess.run(["dpkg-deb", "--contents", str(package)], capture_output=True, text=True, check=True).stdout
            for name in ("/usr/bin/alder", "/usr/bin/alderd", "/usr/lib/alder/alder_images.so", "/lib/systemd/system/alderd.service", "/usr/share/doc/alder/jobs.md", "/usr/share/doc/alder/README.md"):
                self.assertRegex(names, re.escape(name) + r"\n", name)
            control = subprocess.run(["dpkg-deb", "--info", str(package)], capture_output=True, text=True, check=True).stdout
            self.assertRegex(control, r"Package: alder\n")
            for library in ("libembree3", "libopenimageio", "libsqlite3", "libssl3"):
                self.assertIn(library, control)
            # As it lies in the package the daemon finds its loader, and runs.
            subprocess.run(["dpkg-deb", "-x", str(package), folder + "/root"], check=True)
            version = subprocess.run([folder + "/root/usr/bin/alderd", "--version"], capture_output=True, text=True)
            self.assertRegex(version.stdout, r"^alderd \d+\.\d+\.\d+")

    @unittest.skipUnless(shutil.which("systemd-analyze"), "systemd is not installed")
    def test_service_is_well_formed(self):
        with tempfile.TemporaryDirectory() as folder:
            unit = pathlib.Path(folder) / "alderd.service"
            text = (ROOT / "server/packaging/alderd.service").read_text()
            unit.write_text(text.replace("/usr/bin/alderd", BUILD + "/alderd"))   # systemd asks whether the program is there
            done = subprocess.run(["systemd-analyze", "verify", "--man=no", str(unit)], capture_output=True, text=True)
            complaints = [line for line in (done.stdout + done.stderr).splitlines() if "alderd.service" in line]
            self.assertEqual(complaints, [])

    def test_dockerfile_copies_what_there_is(self):
        text = (ROOT / "server/packaging/Dockerfile").read_text()
        instructions = re.findall(r"^([A-Z]+) ", text, re.M)
        self.assertLessEqual(set(instructions), {"FROM", "ENV", "WORKDIR", "COPY", "RUN", "USER", "VOLUME", "EXPOSE", "STOPSIGNAL", "ENTRYPOINT"})
        self.assertEqual(instructions.count("FROM"), 2)
        for target in re.search(r"--target ([\w ]+) -j", text).group(1).split():
            self.assertRegex((ROOT / "CMakeLists.txt").read_text(), r"add_(executable|library)\(%s\b" % target)


if __name__ == "__main__":
    unittest.main()
