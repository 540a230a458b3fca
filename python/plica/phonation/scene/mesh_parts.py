"""The meshes a scene may have: the parametric larynx, blocks, or a file."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator

from plica.phonation.scene.face_selection import FaceSelection
from plica.phonation.scene.part import Part, problem
from plica.units import Length

__all__ = ["Block", "Blocks", "Larynx", "LarynxOptions", "Mesh", "MeshFile", "Sides"]

Order = Literal[1, 2]
Name = Annotated[str, Field(min_length=1)]
MAX_LINES = 10**6
"""Of mesh lines in one direction: beyond any memory, and well within the engine's 32 bits."""
Count = Annotated[int, Field(ge=1, le=MAX_LINES)]
PositiveLength = Annotated[Length, Field(gt=0)]
Label = int | str


def _as_labels(value: object) -> object:
    return (value,) if isinstance(value, (int, str)) else value


Labels = Annotated[tuple[Label, ...], BeforeValidator(_as_labels), Field(min_length=1)]


def _surface_kind(value: object) -> str:
    return "<selection>" if isinstance(value, (Mapping, FaceSelection)) else "<labels>"


Surface = Annotated[
    Annotated[FaceSelection, Tag("<selection>")] | Annotated[Labels, Tag("<labels>")],
    Discriminator(_surface_kind),
]


class LarynxOptions(Part):
    """Overrides of a preset; a field left out is the preset's."""

    sections: Annotated[tuple[tuple[Length, PositiveLength], ...], Field(min_length=2)] | None = None
    """[m] Height z and minor half-axis of each section, upward (Paper A, Table II)."""
    major: PositiveLength | None = None
    """[m] Major half-axis of every section."""
    radius: PositiveLength | None = None
    """[m] Of the embedding cylinder."""
    layer_thickness: PositiveLength | None = None
    """[m] Of the cover, and of the ligament."""
    layers_from_section: Annotated[int, Field(ge=0, le=MAX_LINES)] | None = None
    """Position in `sections` from which cover and ligament extend upward."""
    layers_to_section: Annotated[int, Field(ge=0, le=MAX_LINES)] | None = None
    """Position in `sections` to which they extend."""
    layers_along: Literal["level", "normal"] | None = None
    """Along what the thickness of the layers is measured: ``"level"`` with the ground, or ``"normal"`` to the
    surface, in the plane y = 0."""
    size: PositiveLength | None = None
    """[m] Length of edges between the sections that the layers lie between. Not in levels."""
    growth: Annotated[float, Field(ge=0)] | None = None
    """Edges are longer by this times the distance from there. Not in levels."""
    levels: tuple[Count, ...] | None = None
    """In levels: subdivisions between consecutive sections, one fewer than sections."""
    around: Annotated[int, Field(ge=8, le=MAX_LINES, multiple_of=4)] | None = None
    """Mesh lines around the airway."""
    cover_rings: Count | None = None
    """In levels: rings of cells across the cover."""
    ligament_rings: Count | None = None
    """In levels: across the ligament."""
    body_rings: Count | None = None
    """In levels: across the body."""


class Larynx(Part):
    """The parametric larynx of Paper A, Sec. 3, both folds; layers ``body``, ``ligament`` and ``cover``.

    Surfaces ``airway``, ``airway_left``, ``airway_right``; node sets ``wall`` and ``ends``.
    """

    larynx: Literal[
        "coarse", "demo", "fine", "finest", "thesis", "thesis_coarse", "thesis_demo", "thesis_medium"
    ] = "thesis"
    """The preset. By purpose, with order 2: ``"coarse"`` 9,864 unknowns, ``"demo"`` 21,720, ``"fine"``
    43,440, ``"finest"`` 87,984; their lowest three symmetric frequencies are at most
    2.1, 0.6, 0.3 and 0.1 % above those of a mesh of 100,000 unknowns, 2.5, 1.0, 0.7 and 0.5 % above the
    limit.
    In levels, the way of the thesis: ``"thesis"``, and coarser ones."""
    order: Order = 1
    """2: quadratic tetrahedra; their sides follow the airway and the wall, but in levels are straight."""
    options: LarynxOptions = LarynxOptions()
    """Overrides of the preset."""

    @model_validator(mode="after")
    def _options_of_its_kind(self) -> Self:
        from plica import _engine

        known = _engine.larynx_preset(self.larynx)
        for name, value in self.options.model_dump(mode="json", exclude_none=True).items():
            if name not in known:
                kind = "is meshed in levels" if "levels" in known else "is not meshed in levels"
                raise problem(
                    f'must be left out: the larynx "{self.larynx}" {kind}.', "options", name, value=value
                )
        return self

    def before_change(self, names: Collection[str]) -> Self:
        """Options that only repeat the preset's, as those of a stored scene do, go with the preset."""
        if "larynx" not in names:
            return self
        from plica.phonation.scene.mesh_source import larynx_fields

        repeated = larynx_fields(Larynx(larynx=self.larynx))
        given = self.options.model_dump(mode="json", exclude_none=True)
        own = {name: value for name, value in given.items() if value != repeated[name]}
        return type(self)(larynx=self.larynx, order=self.order, options=LarynxOptions(**own))


class Block(Part):
    """A box of structured tetrahedra, layer ``body``.

    Its sides are surfaces and node sets ``x_min``, ``x_max``, ``y_min``, ...
    """

    corner: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    """[m] Its least x, y and z."""
    size: tuple[PositiveLength, PositiveLength, PositiveLength]
    """[m] Along x, y and z."""
    divisions: tuple[Count, Count, Count] = (1, 1, 1)
    """Hexahedra along x, y and z, of six tetrahedra each."""
    order: Order = 1
    """2: quadratic tetrahedra."""


class Blocks(Part):
    """Two boxes side by side. Each is a layer of its name; its sides are ``name.x_min``, ..."""

    blocks: Annotated[dict[Name, Block], Field(min_length=2, max_length=2)]
    """Layer name to its box."""
    order: Order = 1
    """2: quadratic tetrahedra."""

    @model_validator(mode="after")
    def _one_order(self) -> Self:
        for name, block in self.blocks.items():
            if block.order != 1:
                raise problem(
                    'must be left out. Give "order" of the mesh.', "blocks", name, "order", value=block.order
                )
        return self


class Sides(Part):
    """Cell labels of the file that belong to each fold."""

    left: Labels
    """Label, or labels, of the left fold."""
    right: Labels
    """Of the right fold."""


def _one(unit: object) -> object:
    """A unit alone is one of it: ``"mm"`` is ``"1 mm"``."""
    return f"1 {unit}" if isinstance(unit, str) and unit[:1].isalpha() else unit


class MeshFile(Part):
    """A mesh of tetrahedra in any format that meshio reads, its labels mapped to names."""

    file: Annotated[Path, AfterValidator(Path.resolve)]
    """Its path, relative to the scene file or, of a part made in Python, to the working directory; kept
    absolute."""
    unit: Annotated[PositiveLength, BeforeValidator(_one)] = 1.0
    """[m] One unit of the file's coordinates, e.g. ``"mm"``."""
    labels: str | None = None
    """The cell data that hold the labels; left out: the physical groups, or the only whole-number data."""
    layers: dict[Name, Labels] = Field(default_factory=dict)
    """Layer name to the label, or labels, of its tetrahedra: a number, or a name the file gives. Left out,
    where they all have one label or none: the layer ``body``."""
    surfaces: dict[Name, Surface] = Field(default_factory=dict)
    """Surface name to the labels of its triangles, to ``"boundary"``: all of it, or to what its faces have in
    common, e.g. ``{facing = {along = [0, 0, 1]}}``. Each is a node set too."""
    sides: Sides | Literal["x"] | None = None
    """Which cells are the left and the right fold; ``"x"``: left those of smaller x than the middle of the
    surface ``airway``, or of the mesh where no surface has that name. Left out: neither."""
    order: Order = 1
    """2: quadratic tetrahedra; made from linear ones where the file has those."""


_KINDS = {"larynx": "<larynx>", "file": "<file>", "block": "block", "blocks": "<blocks>"}


def _kind(data: Any) -> str | None:
    """The tag of a mesh: of the one key that says what it is."""
    for kind, tag in ((Larynx, "larynx"), (MeshFile, "file"), (Block, "block"), (Blocks, "blocks")):
        if isinstance(data, kind):
            return _KINDS[tag]
    given = [name for name in _KINDS if isinstance(data, Mapping) and name in data]
    return _KINDS[given[0]] if len(given) == 1 else None


def _unwrap_block(data: Any) -> Any:
    """``{block = {...}, order = 2}`` is the block with that order."""
    if isinstance(data, Mapping) and isinstance(data.get("block"), Mapping):
        return {**data["block"], **{name: value for name, value in data.items() if name != "block"}}
    return data


Mesh = Annotated[
    Annotated[Larynx, Tag("<larynx>")]
    | Annotated[MeshFile, Tag("<file>")]
    | Annotated[Block, BeforeValidator(_unwrap_block), Tag("block")]
    | Annotated[Blocks, Tag("<blocks>")],
    Discriminator(
        _kind,
        custom_error_type="scene",
        custom_error_message="must have exactly one of larynx, file, block, blocks.",
        custom_error_context={
            "relation": "must have exactly one of larynx, file, block, blocks.",
            "path": (),
        },
    ),
]
