"""Property-based tests of the whole interface, made from what the daemon says of it in /v1/openapi.json (Schemathesis, from PyPI).

    python3 -m venv .venv && .venv/bin/pip install schemathesis
    .venv/bin/python tests/server/api_test.py [--examples N] [--seed N]

Not a part of ./dev test, which needs nothing but Debian; ./dev test-api makes the environment and runs this."""
import argparse
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs/examples"))
from daemon import Daemon  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", default=os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build")))
    parser.add_argument("--examples", type=int, default=50, help="requests made up for each operation")
    parser.add_argument("--seed", type=int, default=1)
    options, more = parser.parse_known_args()
    program = pathlib.Path(sys.executable).parent / "schemathesis"
    with Daemon(options.build, "--max-render-seconds", "20", "--log-level", "warn") as daemon:
        command = [str(program), "--config-file", str(ROOT / "tests/server/schemathesis.toml"), "run", daemon.url + "/v1/openapi.json", "--checks", "all",
                   "--max-examples", str(options.examples), "--seed", str(options.seed), "--workers", "2", "--no-color", *more]
        status = subprocess.run(command).returncode
        alive = daemon.ask("GET", "/livez")[0] == 200
        log = daemon.log_text()
    crashed = [line for line in log.splitlines() if "crashed" in line or '"exception"' in line]
    print("\n".join(crashed[:20]))
    return status or (0 if alive and not crashed else 1)


if __name__ == "__main__":
    sys.exit(main())
