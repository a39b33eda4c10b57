#!/usr/bin/env python3
"""How many wrong programs the tests notice: operators of the sources, chosen at random, do something else when told to.

    tests/mutants.py make FOLDER [--count 100] [--seed 1]   writes a copy of the sources with the mutants, and builds its tests
    tests/mutants.py run FOLDER [--jobs N] [--mutants 3,17] runs the tests once for each mutant, and tells which are
                                                            noticed; exit status 1 if more than 15 % are not

All mutants are in one build: `a < b` becomes `a < mutant<7> < b`, which compares as before unless the environment variable
MUTANT is 7. Constants stay as they are. A mutant that does not compile is exchanged for another one.
"""

import argparse
import concurrent.futures
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
LEAST_SHARE = 0.85  # of mutants that the tests have to notice
ROOMS = ("mesher/", "pipeline/matching/", "exporters/core/")
PROGRAMS = (
    "test_mesher",
    "test_surface_oracle",
    "test_matching",
    "test_exporters",
    "test_stages",
    "test_tiles",
    "test_pipeline",
)
INSTEAD = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "+": "-", "-": "+", "*": "+", "/": "*"}
OPERATOR = re.compile(r"(?<=[\w\])] )(?:[<>]=?|[=!]=|[-+*/])(?= [\w(\-!*])")
NOT_RUN = re.compile(r'^\s*(#|static_assert|template|using)|constexpr|operator|"')
HEADER = """#pragma once
#include <cstdlib>
#include <type_traits>
namespace mutants {
inline const int chosen = std::getenv("MUTANT") ? std::atoi(std::getenv("MUTANT")) : 0;
template <int kNumber> struct Mutant {};
template <int kNumber> inline constexpr Mutant<kNumber> mutant;
template <int kNumber, typename T> struct Left { const T& value; };
}
"""
OPERATORS = (
    "namespace mutants {{ template <typename T> constexpr Left<{number}, T> operator{sign}(const T& a, Mutant<{number}>)"
    " {{ return {{a}}; }} template <typename T, typename U> constexpr auto operator{sign}(Left<{number}, T> a, const U& b)"
    " -> decltype(a.value {sign} b) {{ return !std::is_constant_evaluated() && chosen == {number}"
    " ? static_cast<decltype(a.value {sign} b)>(a.value {instead} b) : a.value {sign} b; }} }}\n"
)


def line_of(path, at):
    return (ROOT / path).read_text().count("\n", 0, at) + 1


def operators_of(path):
    """Returns the binary operators of a source outside comments, texts, directives and constants: (path, begin, end)."""
    begin, places = 0, []
    for line in (ROOT / path).read_text().splitlines(keepends=True):
        code = line.split("//")[0]
        if not NOT_RUN.search(code):
            places += [(path, begin + m.start(), begin + m.end()) for m in OPERATOR.finditer(code)]
        begin += len(line)
    return places


def write(folder, path, chosen):
    """Writes a source with those of the mutants {number: (path, begin, end)} that are in it."""
    text = (ROOT / path).read_text()
    head = '#include "mutants.h"\n'
    for number, (_, begin, end) in sorted(chosen.items(), key=lambda item: -item[1][1]):
        sign = text[begin:end]
        head += OPERATORS.format(number=number, sign=sign, instead=INSTEAD[sign])
        text = f"{text[:begin]}{sign} ::mutants::mutant<{number}> {text[begin:]}"
    (folder / path).write_text(head + f'#line 1 "{path}"\n' + text)


def that_do_not_compile(errors, chosen):
    """Returns the numbers of the mutants at the places that a compiler's errors name, or near them."""
    wrong = set()
    for path, line in set(re.findall(r"([\w./]+):(\d+)(?::\d+)?: +(?:error|required from)", errors)):
        own = {n: abs(line_of(p, at) - int(line)) for n, (p, at, _) in chosen.items() if path.endswith(p)}
        wrong |= {n for n, lines in own.items() if lines == min(own.values()) and lines < 4}
    return wrong


def make(folder, count, seed):
    files = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    for path in files:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / path, folder / path)
    (folder / "mutants.h").write_text(HEADER)
    places = [at for p in files if p.startswith(ROOMS) and p.endswith((".h", ".cpp")) for at in operators_of(p)]
    print(f"{count} of {len(places)} operators")
    random.Random(seed).shuffle(places)
    chosen = {number: places.pop() for number in range(1, count + 1)}
    changed = {path for path, _, _ in chosen.values()}
    options = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS_DEBUG=-O1 -w", "-DHEXRELIEF_CUDA=OFF"]
    subprocess.run(["cmake", "-S", folder, "-B", folder / "build", *options], check=True, stdout=subprocess.DEVNULL)
    while changed:
        for path in changed:
            write(folder, path, {n: at for n, at in chosen.items() if at[0] == path})
        command = ["cmake", "--build", folder / "build", "--target", "hexrelief", *PROGRAMS, "--", "-k", "0"]
        built = subprocess.run(command, capture_output=True, text=True)
        wrong = that_do_not_compile(built.stdout, chosen)
        if built.returncode and not wrong:
            sys.exit(built.stdout[-4000:])
        changed = {chosen[number][0] for number in wrong}
        for number in wrong:
            chosen[number] = places.pop()
            changed.add(chosen[number][0])
        print(f"{len(wrong)} do not compile")
    rows = [f"{n}\t{p}:{line_of(p, begin)}\t{(ROOT / p).read_text()[begin:end]}" for n, (p, begin, end) in chosen.items()]
    (folder / "mutants.txt").write_text("\n".join(rows) + "\n")


def is_noticed(commands, number, seconds):
    """Returns whether a test fails, crashes or takes more than `seconds` with the mutant; 0 is none."""
    for command in commands:
        try:
            if subprocess.run(
                command, env=os.environ | {"MUTANT": str(number)}, capture_output=True, timeout=seconds
            ).returncode:
                return True
        except subprocess.TimeoutExpired:
            return True
    return False


def run(folder, jobs, only):
    commands = [[folder / "tests/golden/golden.py", folder / "build/hexrelief", "--threads", "1"]]
    for name in PROGRAMS:
        program = next(p for p in (folder / "build/tests").rglob(name) if p.is_file())
        commands.append([program, "--gtest_fail_fast", "--gtest_brief=1"])
    rows = [line.split("\t") for line in (folder / "mutants.txt").read_text().splitlines()]
    rows = [row for row in rows if not only or int(row[0]) in only]
    begun = time.monotonic()
    if is_noticed(commands, 0, None):
        sys.exit("the tests fail without a mutant")
    seconds = 60 + 3 * (time.monotonic() - begun)
    noticed = 0
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        tested = {pool.submit(is_noticed, commands, row[0], seconds): row for row in rows}
        for result in concurrent.futures.as_completed(tested):
            row = tested[result]
            noticed += result.result()
            print("noticed" if result.result() else "MISSED", *row, INSTEAD[row[2]], sep="\t", flush=True)
    print(f"{noticed} of {len(rows)} mutants are noticed")
    return 0 if noticed >= LEAST_SHARE * len(rows) else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["make", "run"])
    parser.add_argument("folder", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--mutants", type=lambda text: set(map(int, text.split(","))), default=set())
    given = parser.parse_args()
    if given.command == "make":
        make(given.folder, given.count, given.seed)
        return 0
    return run(given.folder, given.jobs, given.mutants)


if __name__ == "__main__":
    sys.exit(main())
