"""Options that take one value are given once: a second one is refused, not put in the place of the first."""

from typing import TYPE_CHECKING, Any

import typer
from typer.core import TyperCommand

if TYPE_CHECKING:
    _Parsing = TyperCommand
else:
    _Parsing = object


class GivenOnce(_Parsing):
    """A command, or a group of them, that refuses an option of one value that is given twice."""

    def make_parser(self, ctx: Any) -> Any:
        """Return the parser of the command's arguments."""
        parser: Any = super().make_parser(ctx)
        parse = parser.parse_args

        def parse_args(args: list[str]) -> Any:
            values, rest, order = parse(args=args)
            for option in order:
                if option.param_type_name == "option" and _takes_one(option) and order.count(option) > 1:
                    ctx.fail(f"Option {option.opts[0]!r} is given {order.count(option)} times; give it once.")
            return values, rest, order

        parser.parse_args = parse_args
        return parser


class Command(GivenOnce, TyperCommand):
    """What every command of ``hhrl-bench`` is."""


def require_once(app: typer.Typer) -> None:
    """Let every command of an application, and of the groups in it, refuse an option of one value given twice."""
    for info in app.registered_commands:
        info.cls = Command
    for group in app.registered_groups:
        if group.typer_instance is not None:
            require_once(group.typer_instance)


def _takes_one(option: Any) -> bool:
    return not (option.multiple or option.is_flag or option.count)
