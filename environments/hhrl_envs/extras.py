"""Optional dependencies: imported when first needed, with a message that says which extra brings them."""

from importlib.util import find_spec

from hhrl_envs.errors import InputError


class MissingExtraError(InputError):
    """A feature was asked for whose optional dependency is not installed."""


def require(module: str, extra: str) -> None:
    """Return when the top-level ``module`` is installed.

    Raises:
        MissingExtraError: it is not; the message says how to install the extra that brings it.
    """
    if find_spec(module) is None:
        checkout = f"in a checkout: pip install -e '.[{extra}]'"
        raise MissingExtraError(f"{module} is not installed; run: pip install 'hhrl-bench[{extra}]', or {checkout}")
