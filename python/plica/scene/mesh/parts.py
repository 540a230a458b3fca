"""The meshes of a scene: the parametric larynx, blocks, or a file."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator

from plica import _engine
from plica.scene.composition import require_combinable
from plica.scene.mesh.face_selection import FaceSelection
from plica.scene.mesh.folds import SHAPE, Folds
from plica.scene.part import Part, problem
from plica.units import Length

__all__ = ["Block", "Blocks", "Larynx", "LarynxOptions", "Mesh", "MeshFile", "Sides"]

Order = Literal[1, 2]
Name = Annotated[str, Field(min_length=1)]
MAX_LINES = 10**6
"""Limit of mesh lines in one direction: beyond any memory, and within the engine's 32 bits."""
Count = Annotated[int, Field(ge=1, le=MAX_LINES)]
PositiveLength = Annotated[Length, Field(gt=0)]
Label = int | str
BOUNDARY = "boundary"
"""The name, in place of labels, of all faces of the boundary."""


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
    """Overrides of a preset; other fields are those of the preset."""

    sections: Annotated[tuple[tuple[Length, PositiveLength], ...], Field(min_length=2)] | None = None
    """[m] Height z and minor half-axis of each section, upward (Paper A, Table II)."""
    major: PositiveLength | None = None
    """[m] Major half-axis of every section."""
    radius: PositiveLength | None = None
    """[m] Radius of the embedding cylinder."""
    layer_thickness: PositiveLength | None = None
    """[m] Thickness of the cover, and of the ligament."""
    ligament_thickness: PositiveLength | None = None
    """[m] Thickness of the ligament; default: that of the cover."""
    layers_from_section: Annotated[int, Field(ge=0, le=MAX_LINES)] | None = None
    """Index in `sections` from which cover and ligament extend upward."""
    layers_to_section: Annotated[int, Field(ge=0, le=MAX_LINES)] | None = None
    """Index in `sections` up to which they extend."""
    layers_along: Literal["level", "normal"] | None = None
    """Direction of the thickness of the layers: horizontal (``"level"``), or ``"normal"`` to the surface, in
    the plane y = 0."""
    size: PositiveLength | None = None
    """[m] Length of edges in the height range of the layers. Not for presets meshed in levels."""
    growth: Annotated[float, Field(ge=0)] | None = None
    """Increase of the edge length per distance from there. Not for presets meshed in levels."""
    tip_cut: Annotated[float, Field(ge=0)] | None = None
    """Cells at the ends of the glottis are cut from its tip where the surface of the fold, one mesh line
    before it, is less than this times its distance from the tip off the middle plane; others are flat there,
    and the first to turn inside out. Default: 0.1, with `folds` 1. Not for presets meshed in levels."""
    levels: tuple[Count, ...] | None = None
    """Presets meshed in levels: subdivisions between consecutive sections, one fewer than sections."""
    around: Annotated[int, Field(ge=8, le=MAX_LINES, multiple_of=4)] | None = None
    """Mesh lines around the airway."""
    cover_rings: Count | None = None
    """Presets meshed in levels: rings of cells across the cover."""
    ligament_rings: Count | None = None
    """Presets meshed in levels: rings of cells across the ligament."""
    body_rings: Count | None = None
    """Presets meshed in levels: rings of cells across the body."""


_TIP_CUT = 1.0  # of a larynx with folds: cells are cut from the tip below and above a narrow glottis, too


class Larynx(Part):
    """The parametric larynx of Paper A, Sec. 3, both folds; layers ``body``, ``ligament`` and ``cover``.

    Its right fold is at x > 0, its front (anterior) at y > 0, and z is up, as the air goes. Surfaces
    ``airway``, ``airway_left``, ``airway_right``; node sets ``wall`` and ``ends``.
    """

    larynx: Literal[
        "coarse", "demo", "fine", "finest", "thesis", "thesis_coarse", "thesis_demo", "thesis_medium"
    ] = "thesis"
    """The preset. With order 2, ``"coarse"`` has 9,864 unknowns, ``"demo"`` 21,720, ``"fine"`` 43,440,
    ``"finest"`` 87,984; their lowest three symmetric frequencies are at most 2.1, 0.6, 0.3 and 0.1 % above
    those of a mesh of 100,000 unknowns, 2.5, 1.0, 0.7 and 0.5 % above the limit. ``"thesis"`` and its
    coarser versions are meshed in levels, as in the thesis."""
    order: Order = 1
    """2: quadratic tetrahedra; their sides follow the airway and the wall, but are straight in meshes in
    levels."""
    folds: Folds | None = None
    """Sizes of the folds; default: the thesis's larynx, or that of the options."""
    options: LarynxOptions = LarynxOptions()
    """Overrides of the preset."""

    def all_options(self) -> dict[str, Any]:
        """All fields of the engine's larynx, from the preset, its overrides and the folds, as plain data."""
        fields = dict(_engine.larynx_preset(self.larynx))
        if self.folds is not None:
            fields["tip_cut"] = _TIP_CUT
        fields |= self.options.model_dump(exclude_none=True)
        if self.folds is not None:
            fields |= self.folds.shape()
        fields["sections"] = np.asarray(fields["sections"], dtype=float).tolist()
        if "levels" in fields:
            fields["levels"] = [int(count) for count in fields["levels"]]
        return fields

    @model_validator(mode="after")
    def _options_fit_the_preset(self) -> Self:
        known = _engine.larynx_preset(self.larynx)
        if self.folds is not None and "levels" in known:
            raise problem(
                f'must be left out: the larynx "{self.larynx}" is meshed in levels. '
                "Use coarse, demo, fine or finest.",
                "folds",
            )
        for name, value in self.options.model_dump(mode="json", exclude_none=True).items():
            if self.folds is not None and name in SHAPE:
                raise problem("must be left out: mesh.folds sets it.", "options", name, value=value)
            if name not in known and name != "ligament_thickness":
                kind = "is meshed in levels" if "levels" in known else "is not meshed in levels"
                raise problem(
                    f'must be left out: the larynx "{self.larynx}" {kind}.', "options", name, value=value
                )
        return self

    def before_change(self, names: Collection[str]) -> Self:
        """Drops options that repeat what the old preset and folds set, as a stored scene does, if either
        changes."""
        if not {"larynx", "folds"} & set(names):
            return self
        repeated = Larynx(larynx=self.larynx, folds=self.folds).all_options()
        given = self.options.model_dump(mode="json", exclude_none=True)
        own = {name: value for name, value in given.items() if value != repeated.get(name)}
        return type(self)(
            larynx=self.larynx, order=self.order, folds=self.folds, options=LarynxOptions(**own)
        )


class Block(Part):
    """A box of structured tetrahedra, layer ``body``.

    Its sides are surfaces and node sets ``x_min``, ``x_max``, ``y_min``, ...
    """

    corner: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    """[m] Smallest x, y and z."""
    size: tuple[PositiveLength, PositiveLength, PositiveLength]
    """[m] Along x, y and z."""
    divisions: tuple[Count, Count, Count] = (1, 1, 1)
    """Number of hexahedra along x, y and z, each of six tetrahedra."""
    order: Order = 1
    """2: quadratic tetrahedra."""


class Blocks(Part):
    """Two boxes. Each is a layer of its name; its sides are ``name.x_min``, ..."""

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
    """Label, or labels, of the right fold."""


def _one(unit: object) -> object:
    """A unit without a number means one unit: ``"mm"`` is ``"1 mm"``."""
    return f"1 {unit}" if isinstance(unit, str) and unit[:1].isalpha() else unit


class MeshFile(Part):
    """A mesh of tetrahedra in any format that meshio reads, its labels mapped to names."""

    file: Annotated[Path, AfterValidator(Path.resolve)]
    """Path, relative to the scene file or, for a part created in Python, to the working directory; stored as
    an absolute path."""
    unit: Annotated[PositiveLength, BeforeValidator(_one)] = 1.0
    """[m] One unit of the file's coordinates, e.g. ``"mm"``."""
    labels: str | None = None
    """The cell data with the labels; default: the physical groups, or the only integer data."""
    layers: dict[Name, Labels] = Field(default_factory=dict)
    """Layer name to the label, or labels, of its tetrahedra: a number, or a name from the file, of a physical
    group or of a set of elements. Default, if all have one label or none: the layer ``body``."""
    surfaces: dict[Name, Surface] = Field(default_factory=dict)
    """Surface name to the labels of its triangles, to ``"boundary"`` for the whole boundary, or to a
    selection of faces, e.g. ``{facing = {along = [0, 0, 1]}}``. Each is also a node set."""
    sides: Sides | Literal["x"] | None = None
    """Which cells belong to the left and the right fold; ``"x"``: left are those with smaller x than the
    middle of the surface ``airway``, or of the mesh if no surface has that name. Default: neither."""
    mirror: Literal["fold", "quarter"] | None = None
    """What the file has if not all: ``"fold"``, one fold (on either side of x = 0), which is mirrored in that
    plane; ``"quarter"``, the front or the back half of one, which is mirrored in y = 0, too. Left is x < 0. A
    surface has the faces of all images; NAME_left and NAME_right are those of one fold. A tissue's `fibre` is
    that of the file's part. Faces in the planes join both sides to one tissue (docs/own_mesh.md)."""
    order: Order = 1
    """2: quadratic tetrahedra, made from linear ones if the file has those."""

    @model_validator(mode="after")
    def _combinable(self) -> Self:
        require_combinable(self)
        return self


_KINDS = {"larynx": "<larynx>", "file": "<file>", "block": "block", "blocks": "<blocks>"}


def _kind(data: Any) -> str | None:
    """The tag of a mesh, from the one key that defines its kind."""
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
