"""Pictures with matplotlib, which is imported when one is asked for."""

from ._bipot import Result, SphereState, State

_STICK, _SLIP, _BODY = "#1f3b73", "#c8442c", "#d9dee8"


def _new_axes():
    try:
        from matplotlib import pyplot
    except ImportError:
        raise ImportError("plot() needs matplotlib (python3-matplotlib)") from None
    return pyplot.figure().add_subplot()


def plot_history(self, axes=None):
    """Errors over the judged iterations, and the tolerance, on matplotlib's axes; returns them.
    Raises ImportError without matplotlib."""
    axes = axes or _new_axes()
    h = self.history
    axes.semilogy(h["iteration"], h["guarded"], label="max(ε, η)", color=_STICK)
    axes.semilogy(h["iteration"], h["epsilon"], "--", label="ε", color=_STICK, linewidth=0.8)
    axes.semilogy(h["iteration"], h["eta"], ":", label="η", color=_STICK, linewidth=0.8)
    axes.axhline(self.tol, color=_SLIP, label="tolerance")
    axes.set(xlabel="iteration", ylabel="error", title=f"{self.solver}: {self.status}")
    axes.legend()
    return axes


def plot_bodies(self, axes=None):
    """Bodies, walls and forces, on matplotlib's axes; returns them. A line joins two bodies that
    push each other; its width grows with s_n. Spheres are seen along y, as x and z.
    Raises ImportError without matplotlib."""
    axes = axes or _new_axes()
    import numpy as np
    from matplotlib.collections import LineCollection, PatchCollection
    from matplotlib.patches import Circle

    seen = [0, 1] if self.positions.shape[1] == 2 else [0, 2]
    x, radii = self.positions[:, seen], self.radii
    order = range(len(x)) if seen == [0, 1] else np.argsort(-self.positions[:, 1])
    circles = [Circle(x[k], radii[k]) for k in order]
    axes.add_collection(PatchCollection(circles, facecolor=_BODY, edgecolor="#7d8799", linewidth=0.5))
    _draw_walls(self.walls, seen, axes)

    c = self.contacts
    c = c[c["s_n"] > 0]
    if len(c):
        normal = np.column_stack([c["n_x"], c["n_y" if seen == [0, 1] else "n_z"]])
        reach = radii[c["i"]] + c["gap"]
        bodies = c["j"] < len(x)
        reach[bodies] += radii[c["j"][bodies]]
        begin = x[c["i"]]
        lines = np.stack([begin, begin - reach[:, None] * normal], axis=1)
        widths = 5 * c["s_n"] / c["s_n"].max()
        for status, colour, label in ((1, _STICK, "sticks"), (2, _SLIP, "slips")):
            those = c["status"] == status
            if those.any():
                axes.add_collection(
                    LineCollection(lines[those], linewidths=widths[those], color=colour)
                )
                axes.plot([], [], color=colour, label=label)  # for the legend
        axes.legend(loc="upper right")

    low, high = x - radii[:, None], x + radii[:, None]
    for wall in self.walls:  # planes have no end
        if wall["radius"] is not None or wall["b"] is not None:
            for end in (wall["a"], wall["b"] or wall["a"]):
                place, reach = np.array([end[k] for k in seen]), wall["radius"] or 0
                if (n := _seen_axis(wall, seen)) is not None:  # an endless cylinder: across it
                    place += (x.mean(axis=0) - place) @ n * np.array(n) if len(x) else 0
                    reach *= np.abs([n[1], n[0]])
                low, high = np.vstack([low, place - reach]), np.vstack([high, place + reach])
    if len(low):
        low, high = low.min(axis=0), high.max(axis=0)
        margin = 0.05 * (high - low).max()
        axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    axes.set_aspect("equal")
    axes.locator_params(nbins=6)
    axes.set(xlabel="x [m]", ylabel=f"{'xyz'[seen[1]]} [m]", title=f"t = {self.time:g} s")
    return axes


def _seen_axis(wall, seen):
    """Axis in the picture of a cylinder that is seen from the side; else None."""
    if wall["radius"] is None or wall["normal"] is None or abs(wall["normal"][1]) > 1e-9:
        return None
    return [wall["normal"][k] for k in seen]


def _draw_walls(walls, seen, axes):
    """Those that are lines or circles in the plane of the picture."""
    from matplotlib.patches import Circle

    for wall in walls:
        a = [wall["a"][k] for k in seen]
        normal = wall["normal"]
        across = 0 if normal is None or len(normal) == 2 else abs(normal[1])
        if wall["radius"] is not None:
            if normal is None or len(normal) == 2 or across > 1 - 1e-9:
                axes.add_patch(Circle(a, wall["radius"], fill=False, edgecolor="black"))
            elif (n := _seen_axis(wall, seen)) is not None:
                for reach in (-wall["radius"], wall["radius"]):
                    side = (a[0] - reach * n[1], a[1] + reach * n[0])
                    axes.axline(side, (side[0] + n[0], side[1] + n[1]), color="black")
        elif wall["b"] is not None:
            axes.plot(*zip(a, [wall["b"][k] for k in seen]), color="black")
        elif normal is not None and across < 1e-9:
            n = [normal[k] for k in seen]
            axes.axline(a, (a[0] - n[1], a[1] + n[0]), color="black")


Result.plot = plot_history
State.plot = SphereState.plot = plot_bodies
