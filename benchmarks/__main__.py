"""Run the benchmarks and write a table with ratios to out/bench/table.md."""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from pathlib import Path

import pytest

OUT = Path("out/bench")


def table(raw: Path) -> str:
    """A Markdown table: per group the rows by median, each with its ratio to the first one named `ours`."""
    groups: dict[str, list[dict]] = defaultdict(list)
    found = json.loads(raw.read_text())
    for entry in found["benchmarks"]:
        groups[entry["group"]].append(entry)
    machine = found["machine_info"]
    lines = [f"{machine.get('cpu', {}).get('brand_raw', 'unknown processor')}, Python {machine['python_version']}, medians", ""]
    lines += ["| problem | method | median ms | spread (IQR) ms | times ours | what it found |", "|---|---|---|---|---|---|"]
    for group, entries in groups.items():
        ours = next(entry["stats"]["median"] for entry in entries if entry["extra_info"].get("ours"))
        for entry in sorted(entries, key=lambda entry: entry["stats"]["median"]):
            stats, info = entry["stats"], entry["extra_info"]
            ratio = stats["median"] / ours
            lines.append(
                f"| {group} | {info['method']} | {1e3 * stats['median']:.3g} | {1e3 * stats['iqr']:.2g} | {ratio:.2f} | {info.get('found', '')} |"
            )
    return "\n".join(lines) + "\n"


def main() -> int:
    """Run pytest-benchmark on this folder, then write the table and print it."""
    OUT.mkdir(parents=True, exist_ok=True)
    raw = OUT / "raw.json"
    arguments = [
        "-p",
        "no:cacheprovider",
        "-o",
        "addopts=",
        "-o",
        "python_files=bench_*.py",
        "-o",
        "python_functions=bench_*",
        "-o",
        "filterwarnings=default",
        "-q",
        f"--benchmark-json={raw}",
        "--benchmark-disable-gc",
    ]
    code = pytest.main([str(Path(__file__).parent), *arguments])
    if code == 0:
        text = table(raw)
        (OUT / "table.md").write_text(text)
        sys.stdout.write(text)
    return int(code)


if __name__ == "__main__":
    sys.exit(main())
