"""A window on the screen that shows frames at a steady pace. Needs the ``render`` extra."""

import os

from numpy import uint8
from numpy.typing import NDArray

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")  # before the import: pygame would print a greeting

import pygame

from hhrl_envs.errors import InputError


class Window:
    """Shows frames, ``frames_per_second`` at most, in a window of its own that opens with the first one.

    Once its close button was pressed it stays closed: further frames are neither shown nor waited for. One that
    ``pygame.quit()`` has destroyed opens again with the next frame.

    Raises:
        InputError: the machine has no screen.
    """

    def __init__(self, title: str, frames_per_second: int) -> None:
        self._title, self._pace = title, frames_per_second
        self._clock = pygame.time.Clock()
        self._window: pygame.Window | None = None
        self.closed = False

    def __reduce__(self) -> tuple[type["Window"], tuple[str, int], dict[str, bool]]:
        """Return how to copy or unpickle it: as a window of its own, which opens with its first frame."""
        return Window, (self._title, self._pace), {"closed": self.closed}

    def show(self, frame: NDArray[uint8]) -> None:
        """Show a frame, uint8 [H, W, 3], and wait until its time is over."""
        if not (self.closed or self._is_open()):
            self._open(frame.shape[1], frame.shape[0])
        self._listen()
        if self._window is not None:
            pygame.surfarray.blit_array(self._window.get_surface(), frame.swapaxes(0, 1))
            self._window.flip()
            self._clock.tick(self._pace)

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            self._window.destroy()
        self._window, self.closed = None, True

    def _is_open(self) -> bool:
        """Return whether there is a window; ``pygame.quit()``, called by anybody in this process, destroys it.

        One that is destroyed is forgotten before the next one opens: pygame destroys it once more when nobody refers
        to it, and by then the next one may have its address.
        """
        if self._window is None:
            return False
        try:
            self._window.get_surface()
        except pygame.error:
            self._window = None
            return False
        return True

    def _open(self, width: int, height: int) -> None:
        try:
            pygame.display.init()
        except pygame.error as refused:
            raise _no_screen(str(refused)) from refused
        if pygame.display.get_driver() == "offscreen" and "offscreen" not in os.environ.get("SDL_VIDEODRIVER", ""):
            pygame.display.quit()
            raise _no_screen("there is no display")
        self._window = pygame.Window(self._title, (width, height))

    def _listen(self) -> None:
        """Take all events of the user, and heed those that ask a window to close; other windows hear theirs too."""
        if self._window is None:
            return
        for event in pygame.event.get():
            if event.type == pygame.WINDOWCLOSE and event.window is not self._window:
                pygame.event.post(event)
            elif event.type == pygame.WINDOWCLOSE:
                self.close()


def _no_screen(why: str) -> InputError:
    return InputError(f"no screen for render_mode 'human' ({why}); write 'rgb_array' instead")
