#!/usr/bin/env python3
"""Measures the figures of README and guide again and puts them in their places.

    python3 docs/figures.py [BINARY] [GROUP ...]

BINARY is the release binary (`target/release/ergopath`). Without groups all of them run, about a quarter of an
hour on two cores; those that need recordings are skipped, aloud, where `../shared` is absent.

`docs/figures.json` holds the groups. Each has `steps`, which run in one folder for all groups, and what is
read from the files that they write:

- `values`: `at` leads to a number or a text in a JSON `file`. A part `key=value` of it picks the first such
  entry of a list, `*` or `*key=value` all of them; `of` then takes the `least` or the `most`, and `over` leads to
  what they are divided by. The number is multiplied by `times` and shown with `digits`, with its sign where `signed`.
- `transcripts`: of a text `file`, for each prefix of `keep` the next line that begins with it; an empty
  prefix is an empty line.

A page holds a value between `<!--f:GROUP.NAME-->` and `<!--/f-->`, a transcript in the fence below
`<!--out:GROUP.NAME-->`. Tests compare the pages with the file, and the `cheap` groups with the program.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHARED = ROOT.parent / "shared"
FIGURES = ROOT / "docs" / "figures.json"
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


class Failed(Exception):
    """A group that could not be measured; its old figures stay."""


def placed(name):
    """A file name of a step or of a place in the project or the reference material."""
    return name.replace("REPO/", f"{ROOT}/").replace("SHARED/", f"{SHARED}/")


def run(step, binary, room):
    """One step in the folder."""
    if "run" in step:
        words = [binary, *map(placed, step["run"])]
        done = subprocess.run(words, cwd=room, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise Failed(f"{step['run']} ended with {done.returncode}:\n{done.stderr}")
        if "stdout" in step:
            (room / step["stdout"]).write_text(done.stdout)
        return
    source = room / placed(step["from"])
    target = room / step["to"]
    if "path_of" in step:
        paths = json.loads((source / "result.json").read_text())["candidates"]
        rank = next(path["rank"] for path in paths if path["family"] == step["path_of"])
        source = source / "paths" / f"{rank}.csv"
    if "replace" in step:
        text = source.read_text()
        for old, new in step["replace"]:
            if old not in text:
                raise Failed(f"{source} does not hold `{old}`")
            text = text.replace(old, new, 1)
        target.write_text(text)
    elif "slower" in step:
        header, *rows = source.read_text().splitlines()
        cells = [row.split(",", 1) for row in rows]
        slower = [f"{float(time) * step['slower']!r},{rest}" for time, rest in cells]
        target.write_text("\n".join([header, *slower]) + "\n")
    elif "lines" in step:
        target.write_text("\n".join(source.read_text().splitlines()[: step["lines"]]) + "\n")
    else:
        shutil.copy(source, target)


def found(value, at):
    """All that a pointer leads to, several only where a part of it begins with `*`."""
    values = [value]
    for part in at.strip("/").split("/"):
        key, _, wanted = part.lstrip("*").partition("=")
        if part.startswith("*") or "=" in part:
            entries = [entry for value in values for entry in value]
            fits = [e for e in entries if not key or str(e.get(key)) == wanted]
            values = fits if part.startswith("*") else fits[:1]
        else:
            values = [v[int(part)] if isinstance(v, list) else v[part] for v in values]
    return values


def shown(rule, room):
    """A value as the pages show it."""
    source = json.loads((room / rule["file"]).read_text())
    values = found(source, rule["at"])
    if "over" in rule:
        values = [a / b for a, b in zip(values, found(source, rule["over"]), strict=True)]
    pick = {"least": min, "most": max}.get(rule.get("of"), lambda values: values[0])
    value = pick(values)
    if "digits" not in rule:
        return str(value)
    sign = "+" if rule.get("signed") else ""
    return f"{value * rule.get('times', 1):{sign}.{rule['digits']}f}"


def kept(rule, room):
    """The lines of a transcript."""
    lines = iter((room / rule["file"]).read_text().replace("\u00a0", " ").splitlines())
    chosen = []
    for prefix in rule["keep"]:
        if prefix == "":
            chosen.append("")
            continue
        line = next((line for line in lines if line.startswith(prefix)), None)
        if line is None:
            raise Failed(f"{rule['file']} has no further line that begins with `{prefix}`")
        chosen.append(line.rstrip())
    return chosen


def note(group, room):
    """Reads the figures of a group from what its steps have written."""
    for rule in group.get("values", {}).values():
        rule["text"] = shown(rule, room)
    for rule in group.get("transcripts", {}).values():
        rule["text"] = kept(rule, room)


def measured(figures, wanted, binary):
    """Runs the groups and notes what they show; whether none failed."""
    ran = set()
    is_whole = True
    with tempfile.TemporaryDirectory() as folder:
        room = Path(folder)
        for name, group in figures.items():
            if wanted and name not in wanted:
                continue
            if "needs" in group and not Path(placed(group["needs"])).exists():
                print(f"SKIPPED {name}: no {group['needs']}")
                continue
            absent = [before for before in group.get("after", []) if before not in ran]
            if absent:
                print(f"SKIPPED {name}: it needs the group {', '.join(absent)}")
                continue
            print(f"{name} ...", flush=True)
            try:
                for step in group["steps"]:
                    run(step, binary, room)
                note(group, room)
                ran.add(name)
            except Failed as why:
                print(f"FAILED {name}: {why}")
                is_whole = False
    return is_whole


def rewritten(text, figures):
    """A page with the values and transcripts of the file."""

    def value(match):
        group, name = match[1].split(".", 1)
        return f"<!--f:{match[1]}-->{figures[group]['values'][name]['text']}<!--/f-->"

    def transcript(match):
        group, name = match[2].split(".", 1)
        lines = figures[group]["transcripts"][name]["text"]
        body = "".join(f"{match[1]}{line}".rstrip() + "\n" for line in lines)
        return f"{match[1]}<!--out:{match[2]}-->\n{match[3]}\n{body}{match[1]}```"

    text = re.sub(r"<!--f:([\w.]+)-->.*?<!--/f-->", value, text)
    fence = r"(?m)^( *)<!--out:([\w.]+)-->\n( *```text)\n(?:.*\n)*?\1```"
    return re.sub(fence, transcript, text)


def main():
    arguments = sys.argv[1:]
    binary = Path(arguments[0] if arguments else ROOT / "target" / "release" / "ergopath")
    if not os.access(binary, os.X_OK):
        sys.exit(f"{binary} is not a program: build it with `cargo build --release`")
    figures = json.loads(FIGURES.read_text())
    unknown = set(arguments[1:]) - set(figures)
    if unknown:
        sys.exit(f"no group is called {', '.join(sorted(unknown))}")
    is_whole = measured(figures, set(arguments[1:]), str(binary.resolve()))
    FIGURES.write_text(json.dumps(figures, indent=1, ensure_ascii=False) + "\n")
    for page in PAGES:
        page.write_text(rewritten(page.read_text(), figures))
    sys.exit(0 if is_whole else 1)


if __name__ == "__main__":
    main()
