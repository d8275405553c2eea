#!/usr/bin/env python3
"""Writes src/filter/size.md and size.svg from the figures of eifmap_large_map.

  eifmap_large_map --csv copies.csv --copies
  plot_size.py copies.csv
or with another run, without --copies, before or after it.
"""
import csv
import pathlib
import sys

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "src" / "filter"
WIDTH, HEIGHT, LEFT, TOP = 420, 260, 60, 30
COLOURS = ["#1f77b4", "#d62728"]


def rows_of(path):
    with open(path, encoding="utf-8") as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


def round_up(value):
    step = 1
    while True:
        for factor in (1, 2, 5):
            if value <= factor * step:
                return factor * step
        step *= 10


def chart(x0, title, lines, most):
    """lines: (label, colour, dashes, [(keyframes, value)])"""
    right = max(x for *_, points in lines for x, _ in points)
    def place(x, y):
        return f"{x0 + LEFT + x / right * (WIDTH - LEFT - 20):.1f},{TOP + (1 - y / most) * (HEIGHT - 2 * TOP):.1f}"
    out = [f'<text x="{x0 + LEFT}" y="18" font-weight="bold">{title}</text>']
    for k in range(6):
        _, y = place(0, most * k / 5).split(",")
        out.append(f'<line x1="{x0 + LEFT}" x2="{x0 + WIDTH - 20}" y1="{y}" y2="{y}" stroke="#ddd"/>')
        out.append(f'<text x="{x0 + LEFT - 6}" y="{float(y) + 4}" text-anchor="end">{most * k / 5:g}</text>')
        x, _ = place(right * k / 5, 0).split(",")
        out.append(f'<text x="{x}" y="{HEIGHT - 12}" text-anchor="middle">{right * k / 5:g}</text>')
    for n, (label, colour, dashes, points) in enumerate(lines):
        path = " ".join(place(x, y) for x, y in points)
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2" stroke-dasharray="{dashes}"/>')
        out.append(f'<text x="{x0 + LEFT + 8}" y="{TOP + 14 + 15 * n}" fill="{colour}">{label}</text>')
    return out


def has_copies(rows):
    return any(r["ms_copy"] for r in rows)


def svg(runs):
    names = ["with a copy" if has_copies(rows) else "filter alone" for rows in runs]
    time, memory = [], []
    for name, colour, rows in zip(names, COLOURS, runs):
        time.append((f"{name}: update", colour, "", [(r["keyframes"], r["ms_median"]) for r in rows]))
        if has_copies(rows):
            time.append((f"{name}: copying", colour, "5 3", [(r["keyframes"], r["ms_copy"]) for r in rows]))
        memory.append((name, colour, "", [(r["keyframes"], r["peak_rss_mib"]) for r in rows]))
    most = [round_up(max(y for *_, points in lines for _, y in points)) for lines in (time, memory)]
    body = chart(0, "ms a keyframe (CPU, median)", time, most[0])
    body += chart(WIDTH, "MiB, at most (2048 is the bar)", memory, most[1])
    return "\n".join([f'<svg xmlns="http://www.w3.org/2000/svg" width="{2 * WIDTH}" height="{HEIGHT}" '
                      'font-family="sans-serif" font-size="11">',
                      '<rect width="100%" height="100%" fill="white"/>', *body, "</svg>", ""])


def table(rows):
    lines = ["| keyframes | landmarks | observations | update, median ms | 99 % ms | copy ms | peak MiB |",
             "|---|---|---|---|---|---|---|"]
    for r in rows:
        if r["keyframes"] % 500 == 0:
            lines.append(f'| {r["keyframes"]:.0f} | {r["landmarks"]:.0f} | {r["observations"]:.0f} '
                         f'| {r["ms_median"]:.0f} | {r["ms_p99"]:.0f} | {r["ms_copy"]:.1f} '
                         f'| {r["peak_rss_mib"]:.0f} |')
    return "\n".join(lines)


def page(runs):
    text = ["# What a large map costs", "",
            "The filter, fed keyframe by keyframe and updated after each along one lap past points "
            "that come and go (`eifmap_large_map`, tests/bench). CPU time on one core, of an update; "
            "memory as the process has it at most, the simulated world (84 MiB of 5,000 keyframes) included. "
            "Made by tests/bench/plot_size.py; not made again by anything else.", "",
            "![time and memory against keyframes](size.svg)"]
    for rows in runs:
        if has_copies(rows):
            text += ["", "## With a copy of it for each keyframe", "",
                     "As the mapper does: frames are tracked on the map as it was, while a keyframe goes "
                     "into its copy; here a copy of each moment's filter is held until the next update is done. "
                     "The two share all that the update does not write to (src/shared_vector.h), so that a copy "
                     "costs what becomes another in it. Where all of it does, as when a lap closes, memory may for "
                     "that moment be twice that of the filter alone (not measured). The rest of a map (keypoints, descriptors) is "
                     "not in these figures; copies of it share it too."]
        else:
            text += ["", "## The filter alone"]
        text += ["", table(rows)]
    return "\n".join(text) + "\n"


def main():
    runs = [rows_of(path) for path in sys.argv[1:]]
    if not 1 <= len(runs) <= 2:
        sys.exit(__doc__)
    (FOLDER / "size.svg").write_text(svg(runs), encoding="utf-8")
    (FOLDER / "size.md").write_text(page(runs), encoding="utf-8")


if __name__ == "__main__":
    main()
