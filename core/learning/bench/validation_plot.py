"""Plots the validation curves of the trainings. Needs matplotlib."""

from pathlib import Path

from ...files import atomic_file

_AXES = (("maje_code", "MAJE (code) of validation windows, mm"), ("fgd", "FGD of validation windows"))


def plot(report: dict, path: Path) -> None:
    """Plot MAJE and FGD of all validations over the training step, one line per training; dots mark the weights that were used.

    ``report`` is that of :class:`run.Runner`. Without validations no picture is written.
    """
    rows = {name: row for name, row in report["systems"].items() if any(row["curves"])}
    if not rows:
        return
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.5), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (key, title) in zip(figure.subplots(1, 2), _AXES, strict=True):
        for number, (name, row) in enumerate(rows.items()):
            look = {"color": f"C{number}", "linewidth": 2.6 if name == "s2ag" else 1.3}
            for seed, (curve, best) in enumerate(zip(row["curves"], row["best"], strict=True)):
                steps, values = ([point[field] for point in curve] for field in ("step", key))
                axes.plot(steps, values, label="" if seed else row["title"], **look)
                axes.plot(best, values[steps.index(best)], "o", color=look["color"], markersize=5)
        axes.set(xlabel="batches", title=title)
        axes.grid(alpha=0.3)
    axes.set_yscale("log")
    axes.legend(fontsize=8)
    with atomic_file(path) as temporary:
        figure.savefig(temporary, format="png")
