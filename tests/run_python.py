"""Runs the Python tests (tests/**/*_test.py) and closes with one line of counts that ./dev reads."""
import argparse
import importlib.util
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent


def flatten(suite):
    for test in suite:
        if isinstance(test, unittest.TestSuite):
            yield from flatten(test)
        else:
            yield test


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="regular expression: run the tests whose full name matches")
    args = parser.parse_args()
    sys.path.insert(0, str(ROOT))
    loader, chosen = unittest.TestLoader(), unittest.TestSuite()
    for path in sorted(ROOT.rglob("*_test.py")):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        spec = importlib.util.spec_from_file_location(name, path)
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
        for test in flatten(loader.loadTestsFromModule(module)):
            if re.search(args.only, test.id()):
                chosen.addTest(test)
    result = unittest.TextTestRunner(verbosity=2).run(chosen)
    failed = len(result.failures) + len(result.errors) + len(result.unexpectedSuccesses)
    skipped = len(result.skipped)
    passed = max(0, result.testsRun - failed - skipped)
    print(f"python: {passed} passed, {failed} failed, {skipped} skipped", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
