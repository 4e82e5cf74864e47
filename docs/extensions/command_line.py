"""The commands of staffa as Markdown, from the program itself."""

from collections.abc import Iterator
from typing import Any

import typer

from staffa.cli.commands import app
from staffa.errors import EXIT_CODES


def commands_page() -> str:
    """Return a section for each command: its use, its arguments and its options."""
    group: Any = typer.main.get_command(app)
    lines: list[str] = []
    for name, command in group.commands.items():
        lines += _command(name, command)
    codes = EXIT_CODES.removeprefix("Exit codes: ").removesuffix(".").split("; ")
    lines += ["## Exit codes", "", "| code | meaning |", "| --- | --- |"]
    lines += [
        f"| {number} | {meaning} |" for number, meaning in (one.split(" ", 1) for one in codes)
    ]
    return "\n".join(lines)


def _command(name: str, command: Any) -> Iterator[str]:
    arguments = [one for one in command.params if one.param_type_name == "argument"]
    options = ["[OPTIONS]"] if len(arguments) < len(command.params) else []
    usage = " ".join(["staffa", name, *options, *map(_argument, arguments)])
    yield from [f"## staffa {name}", "", str(command.help), "", "```sh", usage, "```", ""]
    for parameter in command.params:
        yield from _parameter(parameter)


def _parameter(parameter: Any) -> Iterator[str]:
    option = parameter.param_type_name == "option"
    names = [*parameter.opts, *parameter.secondary_opts]
    shown = [f"`{name}`" for name in (names if option else [_argument(parameter)])]
    default = parameter.default
    notes = [str(getattr(parameter, "help", None) or "")]
    notes += ["needed"] if option and parameter.required else []
    notes += ["may be given again"] if parameter.multiple else []
    if option and default not in (None, False, (), []) and not callable(default):
        notes.append(f"default {default}")
    yield from [", ".join(shown), f": {'; '.join(note for note in notes if note)}", ""]


def _argument(parameter: Any) -> str:
    """Return the name of an argument."""
    return str(parameter.metavar or parameter.name.upper())
