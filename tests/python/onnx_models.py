"""Networks made for the tests: what they find is known, for they compare brightness with a level."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import onnx
from onnx import TensorProto, helper, numpy_helper

STEEP = 60.0  # logits a unit of brightness


def darker(
    path: Path,
    shape: tuple[Any, ...] = (1, 1, "h", "w"),
    *,
    level: float = 0.4,
    last: str = "Sigmoid",
    channels_out: int = 1,
    kind: int = TensorProto.FLOAT,
    **metadata: str,
) -> Path:
    """Sigmoid(60 (level - brightness)); `last` "" gives logits, another operator goes in its place.

    Two channels: the first is the other's complement (of logits: its negative half, the second its half).
    Metadata "plica_output" becomes "plica.output".
    """
    axis = 1 if shape[1] in (1, 3) else 3
    graph = _Graph()
    value = graph.add("Cast", "picture", to=TensorProto.FLOAT)
    if kind == TensorProto.UINT8:
        value = graph.add("Div", value, graph.constant(255.0))
    value = graph.add("ReduceMean", value, axes=[axis], keepdims=1)
    score = graph.add("Mul", graph.add("Sub", graph.constant(level), value), graph.constant(STEEP))
    if channels_out == 2:
        half = graph.add("Mul", score, graph.constant(0.5))
        score = graph.add("Concat", graph.add("Neg", half), half, axis=axis)
        found = graph.add("Softmax", score, axis=axis) if last else score
    else:
        found = graph.add(last, score) if last else score
        if channels_out == 0:
            found = graph.add("Squeeze", found, graph.constant([axis], TensorProto.INT64))
        elif channels_out > 1:
            found = graph.add("Concat", *[found] * channels_out, axis=axis)
    return graph.save(path, kind, shape, found, metadata)


def apart(path: Path, weights: str, **options: Any) -> Path:
    """The model of :func:`darker` with its numbers in a file of this name beside it."""
    model = onnx.load(str(darker(path, **options)))
    for constant in model.graph.initializer:
        constant.CopyFrom(numpy_helper.from_array(numpy_helper.to_array(constant), constant.name))
    path.with_name(weights).unlink(missing_ok=True)
    onnx.save(model, str(path), save_as_external_data=True, location=weights, size_threshold=0)
    return path


class _Graph:
    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def add(self, operator: str, *inputs: str, **attributes: Any) -> str:
        name = f"value{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, list(inputs), [name], **attributes))
        return name

    def constant(self, value: Any, kind: int = TensorProto.FLOAT) -> str:
        name = f"constant{len(self.constants)}"
        values = value if isinstance(value, list) else [value]
        dimensions = [len(values)] if isinstance(value, list) else []
        self.constants.append(helper.make_tensor(name, kind, dimensions, values))
        return name

    def save(self, path: Path, kind: int, shape: Any, found: str, metadata: dict[str, str]) -> Path:
        free = helper.make_tensor_value_info(found, TensorProto.FLOAT, None)
        given = helper.make_tensor_value_info("picture", kind, list(shape))
        graph = helper.make_graph(self.nodes, "glottis", [given], [free], self.constants)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=10)
        helper.set_model_props(
            model, {key.replace("plica_", "plica."): text for key, text in metadata.items()}
        )
        onnx.save(model, str(path))
        return path


def two_inputs(path: Path) -> Path:
    """A model that wants two pictures."""
    given = [helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, 1, "h", "w"]) for name in "ab"]
    free = helper.make_tensor_value_info("c", TensorProto.FLOAT, None)
    graph = helper.make_graph([helper.make_node("Add", ["a", "b"], ["c"])], "two", given, [free])
    onnx.save(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=10), str(path))
    return path


def smaller(path: Path) -> Path:
    """A model whose map is half as large as its picture."""
    graph = _Graph()
    value = graph.add("Sigmoid", graph.add("MaxPool", "picture", kernel_shape=[2, 2], strides=[2, 2]))
    return graph.save(path, TensorProto.FLOAT, (1, 1, "h", "w"), value, {})


def sums(path: Path) -> Path:
    """A model of two channels, the same probability in both."""
    graph = _Graph()
    value = graph.add("Sigmoid", "picture")
    both = graph.add("Concat", value, value, axis=1)
    return graph.save(path, TensorProto.FLOAT, (1, 1, "h", "w"), both, {})


def bare(path: Path, shape: tuple[Any, ...]) -> Path:
    """A model that takes any shape."""
    graph = _Graph()
    return graph.save(path, TensorProto.FLOAT, shape, graph.add("Sigmoid", "picture"), {})
