"""Every public C++ function that takes arrays, indices or counts has its borders tested, one by one.

The public headers are those that CMakeLists.txt names; what they declare is read here. What is tested are the
labels "function parameter" or "Class::function parameter" of the calls of tests/cpp/borders.hpp in the
module's test_borders.cpp, which runs under sanitizers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from repository import ROOT

# Types of parameters in which no size or index can be wrong; whatever is not among them is to be tested.
WITHOUT_SIZE = {
    "Air", "CellMass", "FlowOptions", "Into", "KrylovOptions", "Material", "Options", "Side",
    "Symmetry", "Vector3", "bool", "double", "string",
}  # fmt: skip

# "function parameter" or "function" -> why there is nothing to refuse.
ANY = "any is answered"
CHECKED = "has been checked when it was made"
RESIZED = "is made as large as it must be"
UNCHECKED = "declared to be unchecked, for inner loops: pointers"
EXCEPTIONS = {
    "AffineStiffness::AffineStiffness assembler": CHECKED,
    "BlockMatrix::block entry": UNCHECKED,
    "BlockMatrix::multiply_rows": UNCHECKED,
    "BlockMatrix::multiply_rows_packed": UNCHECKED,
    "ConjugateGradient::ConjugateGradient A": CHECKED,
    "ConjugateGradient::multiply_rounded_rows": UNCHECKED,
    "ConjugateGradient::precondition z": RESIZED,
    "ConjugateGradient::precondition_rows": UNCHECKED,
    "ConjugateGradient::solve_many X": RESIZED,
    "LinearSolver::make A": CHECKED,
    "LinearSolver::solve_many X": RESIZED,
    "NodePattern::find col": ANY,
    "Recorder::Recorder simulation": CHECKED,
    "State::validate shape": "is what Simulation::restore and renewed ask of a state",
    "StepTaken::StepTaken": "probes are read by Simulation::displacement_of",
    "Waveform::exists_in scene": "asks what parts there are",
    "as_points v": "a view of whole rows; what is left over is not in it",
    "as_vector p": ANY,
    "for_chunks n": ANY,
    "for_chunks work": ANY,
    "for_slices": "is for_chunks",
    "origin_near x": ANY,
    "surface_nodes airway": ANY,
    "waveforms_of scene": "asks what parts there are",
    "without_zero_blocks A": CHECKED,
}


def public_headers() -> Iterator[tuple[str, Path]]:
    """Module and path of each."""
    text = (ROOT / "CMakeLists.txt").read_text()
    for module, headers in re.findall(r"plica_module\((\w+)[^)]*?PUBLIC_HEADERS ([^)]*)\)", text):
        for name in headers.split():
            yield module, ROOT / "cpp/plica" / module / name


def closing(text: str, start: int, pair: str) -> int:
    """Position of the bracket that closes the one at `start`."""
    depth = 0
    for at in range(start, len(text)):
        depth += (text[at] == pair[0]) - (text[at] == pair[1])
        if depth == 0:
            return at
    raise AssertionError(f"no {pair[1]} for {text[start : start + 60]!r}")


def declarations(text: str, scope: str = "", public: bool = True) -> Iterator[tuple[str, str]]:
    """Scope and text of each public declaration, without bodies."""
    start = at = 0
    while at < len(text):
        if label := re.compile(r"\s*(public|private|protected)\s*:(?!:)").match(text, start):
            public = label[1] == "public"
            start = at = label.end()
            continue
        char = text[at]
        if char == "(":
            at = closing(text, at, "()")
        elif char == "{":
            end = closing(text, at, "{}")
            head = text[start:at].strip()
            inner = re.match(r"(?:inline )?(namespace|class|struct)\b(?: ([\w:]+))?", head)
            if inner and "(" not in head:
                if public:
                    name = scope if inner[1] == "namespace" else f"{scope}{inner[2]}::"
                    yield from declarations(text[at + 1 : end], name, inner[1] != "class")
                start = end + 1
            elif "(" in head and "=" not in head.split("(")[0]:  # a function with its body
                if public:
                    yield scope, head
                start = end + 1
            at = end
        elif char == ";":
            if public:
                yield scope, text[start:at].strip()
            start = at + 1
        at += 1


def without_templates(text: str) -> str:
    while "<" in text:
        shorter = re.sub(r"<[^<>]*>", "", text)
        if shorter == text:
            break
        text = shorter
    return text


def parameters(header: Path) -> Iterator[str]:
    """ "function parameter" of every parameter of a public function that can have a wrong size or index."""
    text = re.sub(r"//[^\n]*|^\s*#(?:[^\n]*\\\n)*[^\n]*|\[\[\w+\]\]", "", header.read_text(), flags=re.M)
    for scope, declaration in declarations(text):
        if re.match(r"(using|friend|static_assert|extern|enum|typedef)\b", declaration):
            continue
        declaration = re.sub(r"^template\s*<[^>]*>", "", declaration)
        plain = without_templates(declaration.replace("operator*", "operator_times"))
        found = re.match(r"[^(=]*?(~?\w+)\s*\(", plain)
        if not found or found[1].startswith("~") or re.search(r"=\s*delete$", plain):
            continue
        inside = plain[found.end() : closing(plain, found.end() - 1, "()")]
        inside = re.sub(r"\([^()]*\)", "", inside)
        for parameter in filter(None, (part.split("=")[0].strip() for part in inside.split(","))):
            words = re.sub(r"\bconst\b|[&*]", " ", parameter).split()
            if len(words) < 2 or words[0].split("::")[-1] in WITHOUT_SIZE:  # unnamed: a move or a copy
                continue
            yield f"{scope}{found[1].replace('operator_times', 'operator*')} {words[-1]}"


def labels(module: str) -> set[str]:
    """What the module's borders are tested of, without the members of structs."""
    text = (ROOT / "tests/cpp" / module / "test_borders.cpp").read_text()
    return set(re.findall(r'"((?:\w+::)?[\w*]+ \w+)(?:\.\w+)*"', text))


REQUIRED: dict[str, set[str]] = {}
for module, header in public_headers():
    REQUIRED.setdefault(module, set()).update(parameters(header))


def excepted(name: str) -> bool:
    return name in EXCEPTIONS or name.split()[0] in EXCEPTIONS


def test_headers_are_read_as_they_are_written() -> None:
    assert {"add_folded", "at", "sign"} <= {
        name.split()[0].removeprefix("MirrorImages::") for name in REQUIRED["mesh"]
    }
    assert "BlockMatrix::operator* x" in REQUIRED["core"]
    assert "solve_lower r" in REQUIRED["estimation"]
    assert not any("require_node" in name for name in REQUIRED["mesh"])  # private
    assert sum(map(len, REQUIRED.values())) > 100


@pytest.mark.parametrize("module", REQUIRED)
def test_every_parameter_with_a_size_or_an_index_has_its_border_tested(module: str) -> None:
    missing = {name for name in REQUIRED[module] - labels(module) if not excepted(name)}
    assert not missing, f"tests/cpp/{module}/test_borders.cpp"


def test_no_exception_is_stale() -> None:
    declared = set().union(*REQUIRED.values())
    functions = {name.split()[0] for name in declared}
    assert set(EXCEPTIONS) <= declared | functions
    tested = set().union(*map(labels, REQUIRED))
    assert not {name for name in tested & declared if excepted(name)}
