"""A scene: a mesh, its tissue, and optional parts."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from pydantic import Field, PrivateAttr, ValidationError, model_validator

from plica.errors import InvalidInput, SceneError, nearest, one_of
from plica.scene.changes import changed
from plica.scene.composition import require_combinable
from plica.scene.mesh.folds import SHAPE
from plica.scene.mesh.parts import Blocks, Larynx, Mesh
from plica.scene.part import Part, problem
from plica.scene.parts import (
    Airflow,
    Contact,
    Initial,
    Load,
    Output,
    Reduction,
    Solver,
    Stepping,
    Strain,
    Supports,
)
from plica.scene.posture import Posture
from plica.scene.problems import describe, unknown_text
from plica.scene.stepping import is_whole
from plica.scene.tissue import Tissue
from plica.scene.tissue_presets import by_name
from plica.scene.toml_text import toml_text
from plica.scene.tubes import Trachea, Tract
from plica.scene.voices import VOICES, voice_file
from plica.storage.files import require_file, write_text
from plica.units import Acceleration

__all__ = ["Scene"]


class Scene(Part):
    """The scene of a simulation. Parts that are left out are neither constructed nor stored.

    Parameters
    ----------
    mesh : Larynx, MeshFile, Block or Blocks
    tissue : dict of str to Tissue, or str
        One per layer of the mesh; or the name of a preset, `plica.TISSUE_PRESETS`.
    **parts
        The fields below.

    Examples
    --------
    >>> import plica
    >>> scene = plica.Scene(
    ...     plica.Block(size=("1 cm", "2 mm", "2 mm"), divisions=(10, 2, 2)),
    ...     {"body": plica.Tissue(E="20 kPa", nu=0.3)},
    ...     time=plica.Stepping(step="50 us", duration="1 ms"),
    ...     supports=plica.Supports(fixed=("x_min",)),
    ... )
    >>> scene.time.steps
    20
    """

    mesh: Mesh
    """The mesh of the tissue."""
    tissue: dict[str, Tissue] = Field(min_length=1)
    """Layer name to its tissue, or to the name of a preset, "thesis_corrected" or "thesis"; or that
    name for all layers."""
    time: Stepping
    """Scheme, step and duration."""
    supports: Supports | None = None
    """Where the tissue is fixed; default for a larynx: at its wall."""
    posture: Posture | None = None
    """How the tissue is stretched before it moves; default: not at all."""
    strain: Strain | None = None
    """Tissue at finite strain, ``"finite"``; default: it is linear about its shape, at its posture if it has
    one."""
    airflow: Airflow | None = None
    """Airflow that drives the tissue; default: none."""
    trachea: Trachea | None = None
    """Air between the glottis and what drives it; default: none, the subglottal pressure is right below the
    glottis."""
    tract: Tract | None = None
    """Vocal tract above the glottis; default: none, the pressure there is that of the room."""
    contact: Contact | None = None
    """Contact between two surfaces; default: none, bodies pass through each other."""
    loads: tuple[Load, ...] = ()
    """Prescribed tractions."""
    gravity: tuple[Acceleration, Acceleration, Acceleration] | None = None
    """[m/s^2] Acceleration of gravity as x, y, z; default: none."""
    initial: Initial | None = None
    """Displacement and velocity at t = 0; default: rest."""
    reduction: Reduction | None = None
    """Reduced basis of displacements; default: none."""
    symmetry: Literal["half", "quarter"] | None = None
    """``"half"``: mesh, tissue, supports, loads and initial values are symmetric about the plane x = 0 (left
    and right), and the motion is forced to be; half of the tissue is solved for. ``"quarter"``: symmetric
    about x = 0 and y = 0 (front and back); a quarter is solved for. A scene that is not symmetric is
    refused: a larynx can be symmetric, a block and blocks never are, as all boxes are divided along the same
    diagonals. Waveforms and fields are of all nodes; with contact by penalty or mortar faces, whose slave
    side makes a run without symmetry lean, they differ from that run by some percent, with a caution
    (docs/theory/symmetry.md). Default: no symmetry."""
    solver: Solver = Solver()
    """Solver of the linear systems."""
    output: Output = Output()
    """Results that are stored in addition to the waveforms."""

    _source: str = PrivateAttr(default="Scene")

    positional: ClassVar[tuple[str, ...]] = ("mesh", "tissue")

    if TYPE_CHECKING:  # Part handles the two positional arguments

        def __init__(self, mesh: Any = ..., tissue: Any = ..., **parts: Any) -> None: ...

    @property
    def source(self) -> str:
        """Name of the scene in messages: that of its file, or ``Scene``."""
        return self._source

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a scene file.

        Raises
        ------
        SceneError
            With one line per error, each with the file and the key.
        """
        path = Path(path)
        try:
            require_file(path, str(path))
        except InvalidInput as error:
            raise SceneError(str(error)) from None
        try:
            text = path.read_text(encoding="utf-8-sig")  # Windows editors write a byte order mark
        except FileNotFoundError:
            raise SceneError(f"{path}: there is no such file.") from None
        except IsADirectoryError:
            raise SceneError(f"{path}: is a directory; must be a scene file (TOML).") from None
        except UnicodeDecodeError:
            raise SceneError(f"{path}: must be text in UTF-8.") from None
        except OSError as error:
            raise SceneError(f"{path}: cannot be read: {error.strerror}.") from None
        return cls.from_text(text, path.name, path.parent)

    @classmethod
    def from_text(cls, text: str, where: str = "Scene", folder: Path | None = None) -> Self:
        """Read a scene from text.

        Parameters
        ----------
        text : str
            TOML.
        where : str
            Prefix of messages.
        folder : Path, optional
            Directory that paths of a mesh file and of a run are relative to; default: the working directory.
        """
        try:
            data = tomllib.loads(text)
        except ValueError as error:  # TOMLDecodeError, or a number of thousands of digits
            raise SceneError(f"{where}: not TOML: {error}.") from None
        for name, path in (("mesh", "file"), ("reduction", "basis"), ("tract", "file"), ("trachea", "file")):
            part = data.get(name)
            if isinstance(part, dict) and isinstance(part.get(path), str):
                part[path] = str(((folder or Path()) / part[path]).resolve())
        if "voice" in data or "without" in data:
            scene = cls._of_a_voice(data, where)
        else:
            try:
                scene = cls.model_validate(data)
            except ValidationError as error:
                raise SceneError(describe(error, where, cls)) from None
        scene._source = where
        return scene

    @classmethod
    def of_voice(cls, name: str) -> Self:
        """The scene of a person's voice, ``"male"``, ``"female"`` or ``"child"`` (docs/voices.md).

        Raises
        ------
        SceneError

        Examples
        --------
        >>> import plica
        >>> scene = plica.Scene.of_voice("female").replace({"tract.vowel.name": "i", "symmetry": None})
        >>> scene.tract.vowel.length
        0.145
        """
        if name not in VOICES:
            shown = json.dumps(name, default=str)
            meant = {"man": "male", "woman": "female", "girl": "child", "boy": "child"}.get(str(name))
            hint = f' Did you mean "{meant}"?' if meant else nearest(str(name), VOICES, 0.3)
            raise SceneError(f"voice = {shown}; must be {one_of(VOICES)}.{hint}")
        return cls.load(voice_file(name))

    @classmethod
    def _of_a_voice(cls, data: dict[str, Any], where: str) -> Self:
        """The scene of a file with the key `voice`: what else the file has changes that of the preset."""
        name, without = data.pop("voice", None), data.pop("without", [])
        if name is None:
            raise SceneError(
                f"{where}: without: must be left out, or voice given: it leaves out parts of a voice."
            )
        if not isinstance(without, list) or not all(isinstance(key, str) for key in without):
            raise SceneError(f'{where}: without: must be a list of keys, e.g. ["symmetry", "tract"].')
        for key in without:
            _leave_out(data, key, where)
        try:
            voice = cls.of_voice(name)
        except SceneError as error:
            raise SceneError(f"{where}: {error}") from None
        tissue = data.get("tissue")
        for layer, given in tissue.items() if isinstance(tissue, dict) else ():
            partial = isinstance(given, dict) and not {"E", "nu"} <= given.keys() and "preset" not in given
            if partial and layer not in voice.tissue and nearest(layer, voice.tissue, 0.6):
                raise SceneError(f"{where}: {unknown_text(('tissue',), layer, list(voice.tissue))}")
        return changed(voice, data, where)

    def replace(self, changes: Mapping[str, Any]) -> Self:
        """A validated copy with some fields changed (keys and values as in `Part.replace`).

        Examples
        --------
        >>> import plica
        >>> tissue = plica.Tissue(E="10 kPa", nu=0.4)
        >>> scene = plica.Scene(
        ...     plica.Block(size=("1 cm", "2 mm", "2 mm")),
        ...     {"body": tissue},
        ...     time=plica.Stepping(step="50 us", duration="1 ms"),
        ... )
        >>> softer = scene.replace({"tissue.body.E": "5 kPa", "time.duration": "2 ms"})
        >>> softer.tissue["body"].E, softer.time.steps
        (5000.0, 40)
        """
        scene = super().replace(changes)
        scene._source = _changed(self._source)
        return scene

    def resolved(self) -> dict[str, Any]:
        """The scene as plain data in SI, with every default filled in and without absent parts."""
        data = self.model_dump(mode="json", exclude_none=True)
        for table in (
            data,
            *(data[name] for name in ("supports", "initial", "output", "mesh") if name in data),
        ):
            for name in [name for name, field in table.items() if field in ({}, [])]:
                del table[name]
        if not (folds := data["mesh"].get("folds") or {}).get("lesions", True):
            del folds["lesions"]
        if data.get("supports") == {}:  # held by nothing, which an empty table does not say
            data["supports"] = {"fixed": []}
        if isinstance(self.mesh, Larynx):
            options = self.mesh.all_options()
            data["mesh"]["options"] = {
                name: value for name, value in options.items() if self.mesh.folds is None or name not in SHAPE
            }
        elif not isinstance(self.mesh, Blocks) and "size" in data["mesh"]:
            order = data["mesh"].pop("order")
            data["mesh"] = {"order": order, "block": data["mesh"]}
        return data

    def text(self) -> str:
        """The resolved scene as TOML; `load` returns an equal scene from it."""
        return toml_text(self.resolved())

    def digest(self) -> str:
        """SHA-256 of the resolved scene, as 64 hexadecimal digits."""
        return hashlib.sha256(json.dumps(self.resolved(), sort_keys=True).encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        """Whether the resolved scenes are equal, regardless of the names of their files."""
        return isinstance(other, Scene) and self.resolved() == other.resolved()

    def __hash__(self) -> int:
        return hash(self.digest())

    def save(self, path: str | Path) -> None:
        """Write the resolved scene as TOML."""
        write_text(self.text(), Path(path))

    @model_validator(mode="before")
    @classmethod
    def _fix_larynx_at_its_wall(cls, data: Any) -> Any:
        if isinstance(data, dict) and data.get("supports") is None:
            mesh = data.get("mesh")
            if isinstance(mesh, Larynx) or (isinstance(mesh, dict) and "larynx" in mesh):
                return {**data, "supports": Supports(fixed=("wall",))}
        return data

    @model_validator(mode="before")
    @classmethod
    def _fill_in_tissue_presets(cls, data: Any) -> Any:
        if isinstance(data, dict) and "tissue" in data:
            return {**data, "tissue": by_name(data["tissue"])}
        return data

    @model_validator(mode="after")
    def _parts_fit_together(self) -> Self:
        require_combinable(self)
        on_larynx = isinstance(self.mesh, Larynx)
        if self.supports is not None and self.supports.wall_from_y is not None and not on_larynx:
            raise problem("must be left out: only a larynx has that wall.", "supports", "wall_from_y")
        if self.supports is not None and self.supports.cartilages and not on_larynx:
            raise problem("must be left out: only a larynx has them.", "supports", "cartilages")
        wall_from_y = self.supports.wall_from_y if self.supports is not None else None
        if self.supports is not None and wall_from_y is not None and "wall" not in self.supports.fixed:
            relation = 'must be left out, or supports.fixed must have "wall".'
            raise problem(relation, "supports", "wall_from_y", value=wall_from_y)
        step = self.time.step
        if self.output.every is not None and self.output.every < step * (1 - 1e-9):
            raise problem(
                f"must be >= time.step = {step:g} s.", "output", "every", value=self.output.every, unit=" s"
            )
        for name in ("every", "start"):
            value = getattr(self.output, name)
            if value is not None and not is_whole(value / step):
                raise problem(
                    f"must be a whole number of steps of {step:g} s.", "output", name, value=value, unit=" s"
                )
        for name in self.supports.components if self.supports is not None else ():
            if self.supports is not None and name in self.supports.fixed:
                raise problem("must not be in supports.fixed too.", "supports", "components", name)
        return self


def _leave_out(data: dict[str, Any], key: str, where: str) -> None:
    """Add to the tables of a scene file that they have no such key, a dotted path."""
    *path, last = key.split(".")
    table: Any = data
    for name in path:
        table = table.setdefault(name, {}) if isinstance(table, dict) else None
    if not isinstance(table, dict) or last in table:
        twice = isinstance(table, dict) and table[last] is None
        relation = "must stand once; it stands twice." if twice else "must not be left out and given."
        raise SceneError(f"{where}: without: {key} {relation}")
    table[last] = None


def _changed(source: str) -> str:
    """Name in messages of a scene that was changed after loading."""
    return source if source == "Scene" or source.endswith(", changed") else f"{source}, changed"
