"""An episode as a GIF in real time. Needs the ``render`` extra."""

from collections.abc import Sequence
from io import BytesIO

import numpy as np
from PIL import Image

from hhrl_envs.drawing import NAMED_COLOURS
from hhrl_envs.moments import Moment
from hhrl_envs.scene import picture

_COLOURS = 128
_SAMPLE_EVERY = 10  # frames; the palette is chosen from these, the last one, and the named colours
_HOLD = 2500  # ms; how long the outcome stays on before the film starts anew


def gif(moments: Sequence[Moment]) -> bytes:
    """Return the bytes of a GIF with a frame for every moment; all share one palette, so that nothing flickers."""
    frames = [picture(moment) for moment in moments]
    swatches = [np.full((8, *frames[0].shape[1:]), colour, np.uint8) for colour in NAMED_COLOURS]
    sample = np.concatenate([*frames[::_SAMPLE_EVERY], frames[-1], *swatches])
    palette = Image.fromarray(sample).quantize(_COLOURS)
    images = [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    step = round(1000 * moments[0].scenario.dt)
    out = BytesIO()
    durations = [step] * (len(images) - 1) + [_HOLD]
    images[0].save(out, "GIF", save_all=True, append_images=images[1:], duration=durations, loop=0)
    return out.getvalue()
