"""Plots trajectories of a log as seen from above:

    python3 plot_trajectory.py run.lcmlog                                   # every channel of poses, trajectory.svg
    python3 plot_trajectory.py run.lcmlog --channel GROUND_TRUTH ICP_POSE --out path.png

PNG and PDF need matplotlib; SVG needs nothing.
"""
import argparse
import os
import sys
import xml.sax.saxutils

try:
    import lcmslam_log
    import numpy as np
except ImportError as error:
    sys.exit(f"{os.path.basename(sys.argv[0])}: {error}")

COLOURS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00")
POSE_TYPES = ("pose_estimate_t", "odometry_t", "ground_truth_t", "pose_t")


def pose_channels(log):
    """Channels whose first message is a pose."""
    first = {}
    for event in log.events:
        kind = log.types.of(log.data(event)) if event.channel not in first else None
        first.setdefault(event.channel, kind.name if kind else None)
    return sorted(channel for channel, kind in first.items() if kind in POSE_TYPES)


def plot(paths, out):
    """`paths`: channel -> (N, 2) m."""
    if out.endswith(".svg"):
        with open(out, "w") as file:
            file.write(svg(paths))
        return
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    for (channel, xy), colour in zip(paths.items(), COLOURS * len(paths)):
        pyplot.plot(xy[:, 0], xy[:, 1], color=colour, label=channel)
    pyplot.axis("equal")
    pyplot.xlabel("x (m)")
    pyplot.ylabel("y (m)")
    pyplot.legend()
    pyplot.savefig(out)


def svg(paths, width=800, margin=40):
    every = np.concatenate(list(paths.values()))
    low, size = every.min(axis=0), np.ptp(every, axis=0)
    scale = (width - 2 * margin) / max(size.max(), 1e-3)  # pixels a metre
    height = int(size[1] * scale) + 2 * margin
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif">',
             f'<rect width="{width}" height="{height}" fill="#ffffff"/>']
    for row, (channel, xy) in enumerate(paths.items()):
        colour = COLOURS[row % len(COLOURS)]
        pixels = (xy - low) * scale + margin
        points = " ".join(f"{x:.1f},{height - y:.1f}" for x, y in pixels)
        lines.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/>')
        lines.append(f'<text x="{margin}" y="{20 + 16 * row}" fill="{colour}">{xml.sax.saxutils.escape(channel)}</text>')
    lines.append(f'<path d="M{width - margin - scale:.1f},{height - 15} h{scale:.1f}" stroke="#000000"/>')
    lines.append(f'<text x="{width - margin}" y="{height - 20}" text-anchor="end">1 m</text>')
    return "\n".join(lines + ["</svg>", ""])


def main():
    parser = argparse.ArgumentParser(description="Plots trajectories of a log as seen from above.")
    parser.add_argument("log", help="an .lcmlog file")
    parser.add_argument("--channel", nargs="+", help="channels of poses; default: all")
    parser.add_argument("--out", default="trajectory.svg", help=".svg; .png and .pdf with matplotlib")
    arguments = parser.parse_args()
    try:
        log = lcmslam_log.Log(arguments.log)
        channels = arguments.channel or pose_channels(log)
        if not channels:
            raise lcmslam_log.LogError(f"{log.path}: has no channel of poses; it has {', '.join(sorted(log.channels))}")
        paths = {channel: log.poses(channel).T[:, :2, 3] for channel in channels}
        plot(paths, arguments.out)
    except lcmslam_log.LogError as error:
        return str(error)
    except OSError as error:
        return f"{arguments.out}: cannot be written: {error.strerror}"
    except ImportError:
        return f"{arguments.out}: needs matplotlib (apt-get install python3-matplotlib); --out NAME.svg needs nothing"
    for channel, xy in paths.items():
        print(f"{channel}: {len(xy)} poses, {np.linalg.norm(np.diff(xy, axis=0), axis=1).sum():.2f} m")
    for damage in log.damages:
        print(f"{damage.file}, byte {damage.offset}: left out: {damage.reason}", file=sys.stderr)
    print(arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
