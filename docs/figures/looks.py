"""Looks of curves that the figures of several pages share."""

from matplotlib.figure import Figure

from skinfield.plot import INK

DASHES = ((0, (6, 2)), ":")


def dashed(figure: Figure, *names: str) -> None:
    """Draw curves of what cannot be surpassed dashed in ink, in all panels and in the legend."""
    lines = [(line.get_label(), line) for axes in figure.axes for line in axes.lines]
    for legend in figure.legends:
        words = [text.get_text() for text in legend.get_texts()]
        lines += zip(words, legend.get_lines(), strict=True)
    for turn, name in enumerate(names):
        for word, line in lines:
            if word == name:
                line.set(color=INK, ls=DASHES[turn % 2], lw=1.2)
