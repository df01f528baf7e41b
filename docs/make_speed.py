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

FOOT = """## What bounds it

Measured once, in November 2026, on one 2-core machine with AVX-512, an otherwise idle core,
5 000 spheres: sifting the listed pairs for those that touch takes 16 ns a particle-step, gathering them into
lanes 15, the laws on 64 lanes 22, scattering forces 15, walls 20,
moving 13. Only the 22 ns are arithmetic that fills the vectors; the rest is scalar loads and stores, 2.4 contacts a
particle. Fewer roots and divisions in the laws, longer or shorter blocks, and sums kept in registers changed nothing
that could be measured.

The aim is 1.6 times LIGGGHTS on settled beds with two threads. In three sittings of one day (22 November 2026,
`./dev bench`) medians were 1.57, 1.47 and
1.45 for 5 000 spheres (missed), 1.62, 1.86 and 1.67 for 20 000, and 1.63 for 100 000 (one sitting); the plate with
wear, where the aim is 2, 2.39 (one sitting). Single rounds scatter by a third, because the machine is shared.
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
    return "\n".join([*text, FOOT])


if __name__ == "__main__":
    print(page(json.loads(Path(sys.argv[1]).read_text())), end="")
