"""Every public C++ function that takes arrays, indices or counts has its borders tested, one by one.

The public headers are those that CMakeLists.txt names; what they declare is read here. What is tested are the
labels "function parameter" or "Class::function parameter" of the calls of tests/cpp/borders.hpp in the
module's test_borders.cpp, which runs under sanitizers. A label is believed where what it names is called
within the refusal that it labels.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from extension.cpp import public_headers
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
UNCHECKED = "declared to be a pointer into the blocks, for inner loops"
EXCEPTIONS = {
    "AffineStiffness::AffineStiffness assembler": CHECKED,
    "BlockMatrix::block entry": UNCHECKED,
    "ConjugateGradient::ConjugateGradient A": CHECKED,
    "ConjugateGradient::precondition z": RESIZED,
    "ConjugateGradient::solve_many X": RESIZED,
    "LinearSolver::make A": CHECKED,
    "LinearSolver::solve_many X": RESIZED,
    "NodePattern::find col": ANY,
    "Recorder::Recorder simulation": CHECKED,
    "State::validate shape": "is what Simulation::restore and renewed ask of a state",
    "StrainGauge::StrainGauge measure": "is one of two names",
    "StepTaken::StepTaken": "probes are read by Simulation::displacement_of",
    "Waveform::exists_in scene": "asks what parts there are",
    "as_vector p": ANY,
    "for_chunks n": ANY,
    "for_chunks work": ANY,
    "for_slices": "is for_chunks",
    "origin_near x": ANY,
    "surface_nodes airway": ANY,
    "waveforms_of scene": "asks what parts there are",
    "without_zero_blocks A": CHECKED,
}


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


REFUSALS = re.compile(r"\b(?:sizes|indices|numbers(?:<[\w:]+>)?|refused)\(")  # each has its CHECK_THROWS_AS
LABEL = re.compile(r'"((?:\w+::)?[\w*]+ \w+)(?:\.\w+)*"')


def cases(module: str) -> Iterator[str]:
    """The body of each test case of the module's borders."""
    text = re.sub(r"//[^\n]*", "", (ROOT / "tests/cpp" / module / "test_borders.cpp").read_text())
    for found in re.finditer(r'TEST_CASE\("[^"]*"\) \{', text):
        yield text[found.end() : closing(text, found.end() - 1, "{}")]


def calls(function: str, text: str, lambdas: dict[str, str]) -> bool:
    """Whether a text calls "function" or "Class::function", itself or through a lambda of the case."""
    name = function.split("::")[-1]
    call = r"[\w)]\s?\* ?\w" if name == "operator*" else rf"\b{name}(?:<[\w:]+>)?(?:\s\w+)?[({{]"
    known = [body for other, body in lambdas.items() if re.search(rf"\b{other}\b", text)]
    return any(re.search(call, part) for part in (text, *known))


def around(text: str, at: int) -> Iterator[str]:
    """What is in the brackets around a place, the inner ones first, within the case's statement."""
    depth = 0
    while at > 0 and not (depth == 0 and text[at] == ";"):
        at -= 1
        depth += (text[at] in ")}") - (text[at] in "({")
        if depth < 0:
            yield text[at + 1 : closing(text, at, "()" if text[at] == "(" else "{}")]
            depth = 0


def labels(text: str) -> dict[str, bool]:
    """What a case names, without the members of structs, and whether it calls that within a refusal."""
    lambdas = {
        made[1]: text[made.end() - 1 : closing(text, made.end() - 1, "{}")]
        for made in re.finditer(
            r"(?:const auto|std::function<[^;=]*>) (\w+) = \[[^\]]*\](?: ?\([^)]*\))? \{", text
        )
    }
    refusals = [
        text[made.end() - 1 : closing(text, made.end() - 1, "()") + 1] for made in REFUSALS.finditer(text)
    ]
    believed: dict[str, bool] = {}
    for label in LABEL.finditer(text):
        function = label[1].split()[0]
        if any(label[0] in refusal for refusal in refusals):
            held = [refusal for refusal in refusals if label[0] in refusal]
        else:  # of a table, whose names go to a refusal one by one
            named = any(re.match(r"\(\s*\w+,", refusal) for refusal in refusals)
            held = list(around(text, label.start()))[:2] if named else []
        believed[label[1]] = believed.get(label[1], False) or any(
            calls(function, one, lambdas) for one in held
        )
    return believed


def borders_of(module: str) -> set[str]:
    """What the module's borders are tested of: what is named, and called there with what must be refused."""
    return {label for case in cases(module) for label, believed in labels(case).items() if believed}


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
    missing = {name for name in REQUIRED[module] - borders_of(module) if not excepted(name)}
    assert not missing, f"tests/cpp/{module}/test_borders.cpp"


def test_no_exception_is_stale() -> None:
    declared = set().union(*REQUIRED.values())
    functions = {name.split()[0] for name in declared}
    assert set(EXCEPTIONS) <= declared | functions
    found = set().union(*map(borders_of, REQUIRED))
    assert not {name for name in found & declared if excepted(name)}


def test_a_label_is_believed_only_of_a_call_that_is_refused() -> None:
    wrong = "const auto call = [&] { solve(b); };\n"
    assert labels(wrong + 'sizes("solve b", b, call);') == {"solve b": True}
    assert labels('sizes("solve b", b, [&] { solve(b); });') == {"solve b": True}
    assert labels('refused("Plane::Plane n", [] { Plane{-1}; });') == {"Plane::Plane n": True}
    assert labels('sizes("Matrix::operator* x", x, [&] { A* x; });') == {"Matrix::operator* x": True}
    assert labels(wrong + 'sizes("product b", b, call);') == {"product b": False}
    assert labels('sizes("solve b", b, [&] { product(b); });\nsolve(b);') == {"solve b": False}
    assert labels('const char* name = "solve b";\nsolve(b);') == {"solve b": False}
    table = 'for (const auto& [name, call] : {{"solve b", [&] { solve(b); }}}) %s(name, b, call);'
    assert labels(table % "sizes") == {"solve b": True}
    assert labels(table % "printed") == {"solve b": False}


@pytest.mark.parametrize("module", REQUIRED)
def test_every_label_is_of_a_call_that_is_refused(module: str) -> None:
    named = [(label, believed) for case in cases(module) for label, believed in labels(case).items()]
    assert {label for label, _ in named} & REQUIRED[module]
    missing = {label for label, _ in named if label in REQUIRED[module]} - borders_of(module)
    assert not missing, f"tests/cpp/{module}/test_borders.cpp"
