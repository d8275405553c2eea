#!/usr/bin/env python3
"""Checks server/failure_contract.md against the sources: every test that it names exists, every counter is
in the status, every reason code is one, and no code of refused input is left out.
"""
import argparse
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "server/failure_contract.md"
STATUS = ["messages/status_t.lcm", "server/status_board.cpp", "server/diagnostics.cpp"]
COLUMNS = 5  # input, what happens, reason, counter, shown by


def rows():
    """The cells of each row, without the heads."""
    for line in PAGE.read_text().splitlines():
        if line.startswith("|") and not re.match(r"\|[-|]+$", line):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            if cells[0] != "input":
                yield cells


def quoted(cell):
    return re.findall(r"`([^`]+)`", cell)


def gtests():
    """Suite.Test of each in the sources, with the text of its file."""
    found = {}
    for file in (ROOT / "tests").rglob("*.cpp"):
        text = file.read_text()
        for suite, name in re.findall(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", text, re.M):
            found[f"{suite}.{name}"] = text
    return found


def other_tests(build):
    """Those that CTest runs as programs."""
    listed = subprocess.run(["ctest", "-N", "--test-dir", build], capture_output=True, text=True)
    return set(re.findall(r"Test +#\d+: (\S+)", listed.stdout))


def missing_test(name, known, programs):
    test, _, parameter = name.partition("/")
    if test in known:
        return parameter and f'"{parameter}"' not in known[test]
    return name not in programs


def refused_codes():
    """Names of the reasons for which input is refused, by the comments of reason.h."""
    text = (ROOT / "src/reason.h").read_text()
    codes = re.search(r"// Input rejected\n(.*?)\n  //", text, re.S).group(1)
    constants = re.findall(r"(k\w+) =", codes)
    names = dict(re.findall(r'(k\w+),\s*"(\w+)"', (ROOT / "src/reason.cpp").read_text()))
    return {names[constant] for constant in constants}, set(names.values())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", required=True, help="folder of the build, for CTest")
    options = parser.parse_args()
    known, programs = gtests(), other_tests(options.build)
    refused, codes = refused_codes()
    status = "".join((ROOT / file).read_text() for file in STATUS)
    problems, said, count = [], set(), 0
    for row in rows():
        count += 1
        if len(row) != COLUMNS:
            problems.append(f"a row has {len(row)} cells: {row}")
            continue
        _, _, reason, counter, shown = row
        said.update(quoted(reason))
        problems += [f"{code}: is no reason code" for code in quoted(reason) if code not in codes]
        for name in quoted(counter):
            if not re.search(rf"\b{re.escape(name.rstrip('.'))}\b", status):
                problems.append(f"{name}: the status has no such counter")
        tests = quoted(shown)
        if not tests:
            problems.append(f"no test shows: {row[0]}")
        problems += [f"{name}: there is no such test" for name in tests
                     if missing_test(name, known, programs)]
    problems += [f"{code}: input is refused for it, and no row says so"
                 for code in sorted(refused - said)]
    if count < 30:
        problems.append(f"only {count} rows could be read")
    if problems:
        sys.exit("FAILED:\n" + "\n".join(problems))
    print(f"{count} kinds of input, {len(said)} codes")


main()
