"""Prints docs/speed.md from what `wearfem bench --json FILE` wrote: python docs/make_speed.py FILE > docs/speed.md."""

import json
import sys
from pathlib import Path
from statistics import median

HEAD = """# Speed

Printed by `python docs/make_speed.py FILE` from `wearfem bench --json FILE` (wearfem {wearfem}, {machine}).

Every code runs the same packing with the same contact law, time step and number of cores. Machines drift, so each round times the
codes one after the other and the ratio is taken within the round; the tables show medians. The peers use the margin of their
lists that made them fastest, of those tried.
"""


def page(report: dict) -> str:
    text = [HEAD.format(**report)]
    for one in report["benchmarks"]:
        text += [
            f"## {one['text']}",
            "",
            f"{one['steps']} steps, {one['rounds']} rounds, {one['contacts_per_particle']:.2f} contacts a particle.",
            "",
            "| code | threads | million particle-steps/s | wearfem is faster by (least to most) |",
            "|---|---|---|---|",
        ]
        for code, speeds in one["speed"].items():
            for count, speed in speeds.items():
                ratio = one["ratio"].get(code, {}).get(count)
                times = f"{median(ratio):.2f} ({min(ratio):.2f} to {max(ratio):.2f})" if ratio else ""
                text.append(f"| {code} | {count} | {1e-6 * speed:.2f} | {times} |")
        text += ["", *(f"{sentence[0].upper()}{sentence[1:]}." for sentence in one["skipped"])]
        phase, memory = dict(one["phase_ns"]), one["memory"]
        pair_lists, wall_lists = phase.pop("pair_lists_per_100_steps"), phase.pop("wall_lists_per_100_steps")
        whole = sum(phase.values())
        text += [
            "",
            "| phase, one thread | ns a particle-step | share |",
            "|---|---|---|",
            *(f"| {name} | {value:.1f} | {100 * value / whole:.0f} % |" for name, value in phase.items()),
            "",
            f"Pairs are listed {pair_lists:.1f} times in 100 steps, walls {wall_lists:.1f} times. Memory: "
            f"{memory['bytes_in_all_per_particle']:.0f} bytes a particle in all, {memory['bytes_per_particle']:.0f} of them its own, "
            f"{memory['bytes_per_listed_pair']:.0f} a listed pair, {memory['bytes_per_contact']:.0f} a contact. First step after "
            f"{one['first_step_s']:.1f} s (compiling where nothing was compiled yet).",
            "",
        ]
    return "\n".join(text)


if __name__ == "__main__":
    print(page(json.loads(Path(sys.argv[1]).read_text())), end="")
