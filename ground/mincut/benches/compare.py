"""Sets PyMaxflow beside this crate on the graphs of real pictures, in one run.

    pip install PyMaxflow numpy
    cargo build --release
    python3 ground/mincut/benches/compare.py target/release/chiaro FOLDER [--mpx 0.26,1] [SCENE...]

Graphs are dumped into FOLDER once. Every row is timed by turns, the best of three counts, one thread
each. PyMaxflow (Boykov and Kolmogorov's code behind a Python interface) gets the same integers.
"""

import argparse
import os
import subprocess
import time

import maxflow
import numpy as np

SIZES = {"0.26": "512x512", "1": "1024x1024", "2": "1920x1080", "8.3": "3840x2160"}
SETTINGS = {
    "global": ["global=1", "neighbour=0.8"],
    "local": ["global=0.1", "neighbour=0.15"],
}
LINKS = [(0, 0, 0, 0, 0, 1, 0, 0, 0), (0, 0, 0, 0, 0, 0, 0, 0, 1),
         (0, 0, 0, 0, 0, 0, 0, 1, 0), (0, 0, 0, 0, 0, 0, 1, 0, 0)]


def dump(chiaro, scene, size, setting, folder):
    if os.path.exists(f"{folder}/labels.npy"):
        return
    sets = [word for s in SETTINGS[setting] for word in ("--set", s)]
    subprocess.run([chiaro, "binary", scene, "-q", "--size", size, *sets, "-o", f"{folder}.png",
                    "--dump-graph", folder], check=True)


def bench(folder):
    """This crate's line for a graph."""
    command = ["cargo", "bench", "-q", "-p", "chiaro-mincut", "--bench", "graph", "--", folder]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    line = next(line for line in run.stdout.splitlines() if line.startswith(folder)).split()
    return dict(zip(line[1::2], line[2::2]))


def pymaxflow(folder):
    """Seconds to build and to solve, and the flow."""
    terminal, neighbour = (np.load(f"{folder}/{n}.npy") for n in ("terminal", "neighbour"))
    start = time.perf_counter()
    nodes = terminal.shape[0] * terminal.shape[1]
    graph = maxflow.GraphInt(nodes, 4 * nodes)
    ids = graph.add_grid_nodes(terminal.shape[:2])
    for link, structure in enumerate(LINKS):
        graph.add_grid_edges(ids, neighbour[..., link], np.array(structure).reshape(3, 3),
                             symmetric=True)
    graph.add_grid_tedges(ids, terminal[..., 0], terminal[..., 1])
    built = time.perf_counter()
    flow = graph.maxflow()
    return built - start, time.perf_counter() - built, int(flow)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("chiaro")
    parser.add_argument("folder")
    parser.add_argument("scenes", nargs="*", default=["demo:rocks"])
    parser.add_argument("--mpx", default="0.26,1,2,8.3")
    options = parser.parse_intermixed_args()
    print("| scene | Mpx | weights | ns a pixel | PyMaxflow build + solve | ratio to solve | bytes a pixel | flow |")
    print("|---|---|---|---|---|---|---|---|")
    for scene in options.scenes or ["demo:rocks"]:
        name = os.path.splitext(os.path.basename(scene.replace("demo:", "")))[0]
        for mpx in options.mpx.split(","):
            for setting in SETTINGS:
                folder = f"{options.folder}/{name}-{mpx}-{setting}"
                os.makedirs(options.folder, exist_ok=True)
                dump(options.chiaro, scene, SIZES[mpx], setting, folder)
                ours, theirs = [], []
                for _ in range(3 if mpx != "8.3" else 1):
                    ours.append(bench(folder))
                    theirs.append(pymaxflow(folder))
                pixels = int(ours[0]["pixels"])
                best = min(float(o["ns"]) for o in ours)
                build, solve = (min(t[i] for t in theirs) * 1e9 / pixels for i in (0, 1))
                equal = all(int(ours[0]["flow"]) == t[2] for t in theirs)
                print(f"| {name} | {mpx} | {setting} | {best:.0f} | {build:.0f} + {solve:.0f} "
                      f"| {solve / best:.1f} | {ours[0]['bytes']} | {'equal' if equal else 'OTHER'} |",
                      flush=True)


if __name__ == "__main__":
    main()
