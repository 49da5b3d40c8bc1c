#!/usr/bin/env bash
# Runs the recipes of docs/report.md over the rows of committed records, in pandas and in DuckDB, which it installs aside, and compares what
# they give with the records themselves: tests/notebooks.sh. It needs target/release/tracebench, python3 and a network.
set -euo pipefail
cd "$(dirname "$0")/.."
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -m venv "$scratch/venv"
"$scratch/venv/bin/pip" install --quiet pandas duckdb ||
    { echo 'notebooks: skipped, pandas and duckdb cannot be installed'; exit 0; }
target/release/tracebench report --quiet results/software-watertight results/software-stability --csv "$scratch/rows.csv" > "$scratch/out"
"$scratch/venv/bin/python" - "$scratch" << 'PYTHON'
import collections, json, lzma, math, os, re, statistics, sys
import duckdb

text = open("docs/report.md").read().split("## Notebooks")[1]
[recipe], [query] = (re.findall(f"```{kind}\n(.*?)```", text, re.S) for kind in ("python", "sql"))

groups = collections.defaultdict(lambda: ([], []))
for folder in ("software-watertight", "software-stability"):
    for row in json.load(lzma.open(f"results/{folder}/run.json.xz"))["rows"]:
        tracer = row["tracer"]
        changed = "".join(f", {name}={tracer['parameters'][name]}" for name in tracer["changed"])
        for trace in row["traces"]:
            if trace["query"] == "closest":
                of = groups[trace["rays"], tracer["name"], tracer["preset"], changed]
                of[0].extend([trace["median_ms"]] if trace["samples_ms"] else [])
                of[1].append(trace["judgement"]["agreement"]["tight"])
median = lambda values: statistics.median(values) if values else math.nan
# Nothing is in order with what is no number.
order = lambda rows: sorted(((row[0], *row[-2:]) for row in rows), key=lambda row: [str(value) for value in row])
expected = order((key[0], median(times), median(right)) for key, (times, right) in groups.items())

os.chdir(sys.argv[1])
names = {}
exec(recipe, names)
pandas_rows = names["answer"].values.tolist()
duckdb_rows = [[math.nan if value is None else value for value in row] for row in duckdb.sql(query).fetchall()]


def same(one, other):
    numbers = lambda row: [value for value in row if isinstance(value, float)]
    close = lambda a, b: math.isnan(a) and math.isnan(b) or math.isclose(a, b, rel_tol=1e-9)
    return len(one) == len(other) and all(
        a[0] == b[0] and all(map(close, numbers(a), numbers(b))) for a, b in zip(one, other)
    )


assert len(expected) > 20 and same(pandas_rows, duckdb_rows), "pandas and DuckDB differ"
assert same(order(pandas_rows), expected), "the recipes differ from the records"
# What is wrong in one number is noticed.
expected[3] = (expected[3][0], expected[3][1], expected[3][2] + 0.001)
assert not same(order(pandas_rows), expected)
print(f"notebooks: {len(pandas_rows)} medians by pandas, by DuckDB and by the records")
PYTHON
