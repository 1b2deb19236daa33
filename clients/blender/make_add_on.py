#!/usr/bin/env python3
"""Packs the Blender add-on: alder_blender with the Python client inside, as a zip that Blender 4.2+ installs as an extension and
older ones as an add-on.

    python3 clients/blender/make_add_on.py -o alder_blender.zip
    python3 clients/blender/make_add_on.py --nodes build/alder       # writes al_nodes.json anew from the program's catalogue
"""
import argparse
import json
import os
import subprocess
import sys
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGE = os.path.join(HERE, "alder_blender")
CLIENT = os.path.join(HERE, "..", "python", "alder")


def files(folder, prefix):
    for base, folders, names in os.walk(folder):
        folders[:] = sorted(f for f in folders if f not in ("__pycache__", "vendor"))
        for name in sorted(names):
            if name.endswith((".py", ".json", ".toml", ".typed")):
                path = os.path.join(base, name)
                yield prefix + os.path.relpath(path, folder).replace(os.sep, "/"), path


def pack(output):
    """Blender 4.2 wants the manifest at the top or in one folder; older ones want one folder that is the package."""
    members = {**dict(files(PACKAGE, "alder_blender/")), **dict(files(CLIENT, "alder_blender/vendor/alder/"))}
    with zipfile.ZipFile(output, "w", zipfile.ZIP_DEFLATED) as z:
        for name, path in sorted(members.items()):
            with open(path, "rb") as f:
                z.writestr(zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0)), f.read(), zipfile.ZIP_DEFLATED)
        z.writestr(zipfile.ZipInfo("alder_blender/vendor/__init__.py", date_time=(1980, 1, 1, 0, 0, 0)), "")


def write_nodes(program):
    items = json.loads(subprocess.run([program, "nodes", "--json"], capture_output=True, text=True, check=True).stdout)["items"]
    items = sorted((i for i in items if i["system"] == "alshaders"), key=lambda i: i["name"])
    with open(os.path.join(PACKAGE, "al_nodes.json"), "w", encoding="utf-8") as f:
        json.dump({"items": items}, f, indent=None, separators=(",", ":"), sort_keys=True, ensure_ascii=False)
        f.write("\n")


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", help="OUT.zip")
    parser.add_argument("--nodes", metavar="ALDER", help="the program whose catalogue al_nodes.json is written from")
    args = parser.parse_args(argv)
    if not args.output and not args.nodes:
        parser.error("nothing to do: -o OUT.zip or --nodes ALDER")
    if args.nodes:
        write_nodes(args.nodes)
    if args.output:
        pack(args.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
