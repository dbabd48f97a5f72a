"""The C functions have the arguments of FMI's own header, as FMPy ships it."""

import re
from pathlib import Path

import fmpy
from fmus import ROOT

HEADER = Path(fmpy.__file__).parent / "c-code" / "fmi3FunctionTypes.h"
MACRO = ROOT / "interface" / "src" / "export" / "functions.rs"
WIDTHS = {
    "fmi3Boolean": "u8",
    "fmi3Float64": "f64",
    "fmi3Instance": "pointer",
    "fmi3FMUState": "pointer",
    "fmi3InstanceEnvironment": "pointer",
    "fmi3String": "pointer",
    "fmi3ValueReference": "u32",
    "size_t": "usize",
}


def header_width(argument):
    pointer = "*" in argument or "[]" in argument or "Callback" in argument
    return "pointer" if pointer else WIDTHS[argument.split()[-2]]


def rust_width(argument):
    width = argument.split(":", 1)[1].strip()
    pointer = "*" in width or "Handle" in width or "Text" in width or width.startswith("Option<")
    return "pointer" if pointer else width


def arguments(text):
    return [part for part in text.split(",") if part.strip() not in ("", "void")]


def test_arguments_are_those_of_the_header():
    """Order and width of the arguments; unused ones may be left out at the end."""
    declared = {}
    for name, inside in re.findall(r"\b(fmi3\w+?)TYPE\s*\(([^)]*)\)", HEADER.read_text()):
        declared[name] = [header_width(argument) for argument in arguments(inside)]
    source = re.sub(r"//[^\n]*", "", MACRO.read_text())
    written = {}
    for name, inside in re.findall(r"fn (fmi3\w+)\(([^)]*)\)", source):
        written[name] = [rust_width(argument) for argument in arguments(inside)]
    for name, inside in re.findall(r"(fmi3\w+) = \w+\(([^)]*)\)", source):
        written[name] = ["pointer", *(rust_width(argument) for argument in arguments(inside))]
    assert written.keys() == declared.keys() and len(written) > 70
    for name, widths in written.items():
        assert widths == declared[name][: len(widths)], name
