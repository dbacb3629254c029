"""Plots of times, as PNG files for people to look at."""

import matplotlib
import numpy as np

import environment

matplotlib.use('Agg')
from matplotlib import pyplot

FOLDER = environment.REPOSITORY / 'target/bench'
SIZE_INCHES = (8, 5.5)


def line(x, y):
    """Slope and value at 0 of the straight line nearest to the points."""
    slope, start = np.polyfit(x, y, 1)
    return slope, start


def power(x, y):
    """Exponent and factor of the power of x nearest to y, both seen as logarithms."""
    exponent, factor = line(np.log(x), np.log(y))
    return exponent, np.exp(factor)


def save(name, title, x_label, y_label, draw):
    """Writes target/bench/NAME.png with what `draw(axes)` puts into it, and says so."""
    figure, axes = pyplot.subplots(figsize=SIZE_INCHES, layout='constrained')
    draw(axes)
    axes.set(title=title, xlabel=x_label, ylabel=y_label)
    axes.grid(which='both', alpha=0.25)
    axes.legend()
    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f'{name}.png'
    figure.savefig(path, dpi=120)
    pyplot.close(figure)
    print(f'plot: {path.relative_to(environment.REPOSITORY)}', flush=True)
