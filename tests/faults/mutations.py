#!/usr/bin/env python3
"""Mutated decks: every deck is either accepted or refused with sentences, and an accepted one
computes, or fails with a sentence.

    mutations.py PROGRAM INPUTS FOLDER [--count N] [--seed S] [--workers W]

Each case is a deck under INPUTS with a random change (see MUTATIONS), or an override of a random
parameter by an extreme value. `check` must end with 0 or 2 within 20 s and 4 GB; an accepted deck
then runs for a few windows and must end with 0, 3 or 4 (or within the time for a run, which is then
stopped and must obey). The table at the end counts the outcomes; FOLDER keeps the decks of
findings. The exit code is 1 if there are findings.
"""
import argparse
import collections
import concurrent.futures
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import alone  # noqa: E402

PATIENCE, RUN_PATIENCE, OBEYS = 20, 20, 15  # s: of check, of a run, to stop after a signal
MEMORY = 4 << 30  # bytes
WINDOWS = "output.stop_after=3"
EXTREMES = ("0", "-1", "1", "1e-300", "1e300", "5e-324", "-5e-324", "nan", "inf", "-inf", "1e25",
            "-1e25", "1e-30", "9223372036854775807", "-9223372036854775808", "2147483648", "1e9",
            "1e6", "1e-6", "0.1", "1000", "true", "false", '""', '"x"', "[]", "[0]", "[1e300, 1]",
            "[nan]", "{}", "1979-05-27", '"' + "y" * 5000 + '"', "0x7fffffffffffffff")
TOKENS = ("[", "]", "[[", "]]", "=", '"', "'", "\n", ".", "nan", "1e999", "{}", "#", "\\", "\0",
          "'''", "-", ",", "\u00e9", "\ufeff", "[dem.a]", "a." * 300 + "b = 1\n", "[[stage]]\n",
          'kind = "fill"\n')
# What the program must not print: its own words name the cause.
ROUGH = re.compile(r"exception\.|bad_alloc|std::|terminate called|Assertion|core dumped|vector::"
                   r"|basic_string|map::at|stoi|stod|\?\?\?")
NUMBER = re.compile(r"(?<![\w.])-?\d+\.?\d*(?:e-?\d+)?(?![\w.])")


def extreme_number(text, chance):
    """Another number, or any number within a list."""
    found = [match for match in NUMBER.finditer(text) if "#" not in text[text.rfind(
        "\n", 0, match.start()) + 1:match.start()]]
    if not found:
        return token(text, chance)
    match = chance.choice(found)
    return text[:match.start()] + chance.choice(EXTREMES) + text[match.end():]


def scaled_number(text, chance):
    """A unit mistaken: a number times a power of ten."""
    found = list(NUMBER.finditer(text))
    if not found:
        return token(text, chance)
    match = chance.choice(found)
    value = float(match[0]) * 10.0**chance.choice((-9, -6, -3, -2, -1, 1, 2, 3, 6, 9))
    whole = "." not in match[0] and "e" not in match[0] and value == int(value) \
        and abs(value) < 1e18
    return text[:match.start()] + (str(int(value)) if whole else repr(value)) + text[match.end():]


def lines_of(text):
    return text.splitlines(keepends=True)


def without_line(text, chance):
    lines = lines_of(text)
    del lines[chance.randrange(len(lines))]
    return "".join(lines)


def line_twice(text, chance):
    lines = lines_of(text) or [" "]
    at = chance.randrange(len(lines))
    lines.insert(chance.randrange(len(lines)), lines[at])
    return "".join(lines)


def without_section(text, chance):
    parts = re.split(r"(?m)^(?=\[)", text)
    del parts[chance.randrange(len(parts))]
    return "".join(parts)


def section_twice(text, chance):
    parts = re.split(r"(?m)^(?=\[)", text)
    parts.insert(chance.randrange(1, len(parts) + 1), chance.choice(parts[1:] or parts))
    return "".join(parts)


def sections_swapped(text, chance):
    parts = re.split(r"(?m)^(?=\[)", text)
    one, other = chance.randrange(len(parts)), chance.randrange(len(parts))
    parts[one], parts[other] = parts[other], parts[one]
    return "".join(parts)


def word_exchanged(text, chance):
    """A name or a choice in quotation marks for another one of the deck."""
    words = re.findall(r'"[^"\n]*"', text)
    if len(words) < 2:
        return without_line(text, chance)
    return text.replace(chance.choice(words), chance.choice(words), 1)


def letter(text, chance):
    at = chance.randrange(len(text))
    return text[:at] + chr(chance.randrange(256)) + text[at + 1:]


def token(text, chance):
    at = chance.randrange(len(text))
    return text[:at] + chance.choice(TOKENS) + text[at:]


def cut(text, chance):
    return text[:chance.randrange(len(text))]


MUTATIONS = (extreme_number, extreme_number, extreme_number, scaled_number, scaled_number,
             scaled_number, without_line, line_twice, without_section, section_twice,
             sections_swapped, word_exchanged, letter, token, cut)


def parameters_of(program):
    """Keys of all parameters; elements of lists have the number 0."""
    text = subprocess.run([program, "describe", "all"], capture_output=True, text=True,
                          check=True).stdout
    found, section = [], ""
    for line in text.splitlines():
        if heading := re.match(r"## `\[*([^\]`]+)", line):
            section = "" if "Top of" in line else heading[1].strip("[]") + "."
        elif key := re.match(r"\| `([a-z_0-9]+)` \|", line):
            found.append(section.replace("[].", ".0.") + key[1])
    return found


class Case:
    """A deck with its overrides, in a folder of its own."""

    def __init__(self, number, seed, decks, keys, folder):
        chance = random.Random(f"{seed} {number}")
        self.deck, self.words, self.place = chance.choice(decks), [], folder / f"case_{number}"
        text = self.deck.read_text(encoding="utf-8")
        self.kind = "override"
        if chance.random() < 0.3:
            self.words = [f"{chance.choice(keys)}={chance.choice(EXTREMES)}"
                          for _ in range(chance.choice((1, 1, 2)))]
        else:
            for _ in range(chance.choice((1, 1, 1, 2, 4))):
                mutation = chance.choice(MUTATIONS)
                self.kind = mutation.__name__
                text = mutation(text, chance) or " "
        self.text = text

    def write(self):
        """The path of the deck; files that it names lie where its folder has them."""
        self.place.mkdir(parents=True)
        for path in self.deck.parent.iterdir():
            if path.suffix != ".toml" and path.is_file():
                (self.place / path.name).symlink_to(path)
        path = self.place / self.deck.name
        path.write_bytes(self.text.encode("utf-8", "surrogatepass"))
        return path


def limit_memory():
    if "TRACKBED_SANITIZED" not in os.environ:  # sanitizers map far more than they use
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def called(command, patience):
    """(exit code, output): None instead of the code if it did not end in time; then it receives
    SIGTERM, and -SIGKILL is the code of one that does not obey."""
    with alone() as environment, tempfile.TemporaryFile() as out:
        with subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, env=environment,
                              stdin=subprocess.DEVNULL, preexec_fn=limit_memory) as process:
            try:
                code = process.wait(patience)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGTERM)
                try:
                    process.wait(OBEYS)
                    code = None
                except subprocess.TimeoutExpired:
                    process.kill()
                    code = -signal.SIGKILL
        out.seek(0)
        return code, out.read().decode("utf-8", "replace")


def judged(program, case):
    """(outcome, why it is a finding or nothing)."""
    deck = case.write()
    code, out = called([program, "check", deck, *case.words], PATIENCE)
    if code is None:
        return "check takes long", "check does not end in time"
    if code not in (0, 2):
        return f"check {code}", f"check ends with {code}"
    if rough := ROUGH.search(out):
        return f"check {code}", f"check prints {rough[0]}"
    if code == 2:
        # Of a text that is no TOML the parser states line and column.
        named = case.deck.name in out or "command line" in out
        return "refused", "" if named else "a refusal that does not name the deck"
    if re.search(r"(?<![\w.-])(nan|inf)(?![\w.])|-\d{15,}", out.partition("\n")[2]):  # no title
        return "accepted", "check accepts a deck and prints nan, inf or a negative count"
    run = [program, "run", deck, *case.words, WINDOWS, "-o", case.place / "results"]
    code, out = called(run, RUN_PATIENCE)
    if code is None:
        return "accepted, stopped", ""
    if code not in (0, 3, 4):
        return f"accepted, run {code}", f"check accepts the deck, but the run ends with {code}"
    if rough := ROUGH.search(out):
        return f"accepted, run {code}", f"the run prints {rough[0]}"
    return f"accepted, run {code}", ""


def work(program, case):
    outcome, finding = judged(program, case)
    if not finding:
        shutil.rmtree(case.place, ignore_errors=True)
    return outcome, finding, case.place, [*case.words, case.kind]


def attack(work_on, cases, workers):
    """(Counter of outcomes, number of findings), which are also printed. `work_on(case)`: outcome,
    finding or nothing, folder, words."""
    counts, findings = collections.Counter(), 0
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        for outcome, finding, place, words in pool.map(work_on, cases):
            counts[outcome] += 1
            if finding:
                findings += 1
                print(f"{place}: {finding}: {', '.join(words)[:300]}", flush=True)
    print("\n| outcome | cases |\n|---|---|")
    for outcome, count in counts.most_common():
        print(f"| {outcome} | {count} |")
    print(f"| findings | {findings} |")
    return counts, findings


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program")
    parser.add_argument("inputs", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    shutil.rmtree(given.folder, ignore_errors=True)
    given.folder.mkdir(parents=True)
    decks, keys = sorted(given.inputs.rglob("*.toml")), parameters_of(given.program)
    cases = [Case(number, given.seed, decks, keys, given.folder)
             for number in range(given.first, given.first + given.count)]
    counts, findings = attack(lambda case: work(given.program, case), cases, given.workers)
    # Of 500 cases 20 % are accepted.
    few = counts["refused"] > 0.95 * given.count or counts["refused"] < 0.3 * given.count
    if few:
        print("nearly all decks are refused, or accepted: are they still mutated decks?")
    return 1 if findings or few else 0


if __name__ == "__main__":
    sys.exit(main())
