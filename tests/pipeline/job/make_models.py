#!/usr/bin/env python3
"""Writes small ONNX graphs that match pairs, and some that cannot be run: make_models.py FOLDER.

The matcher is the simplest there is: absolute differences of the greys, their means over a window, and the mean disparity
weighted by them (soft arg-min). Needs python3-onnx and python3-numpy.
"""
import sys
from pathlib import Path

import numpy
import onnx
from onnx import TensorProto, helper, numpy_helper

DISPARITIES = 48
WINDOW = 7


def value(name, shape, kind=TensorProto.FLOAT):
    return helper.make_tensor_value_info(name, kind, shape)


def weights(**arrays):
    return [numpy_helper.from_array(numpy.asarray(array, numpy.float32), name) for name, array in arrays.items()]


def conv(inputs, output, kernel_shape=(1, 1), **attributes):
    return helper.make_node("Conv", inputs, [output], kernel_shape=kernel_shape, **attributes)


def save(path, nodes, inputs, outputs, initializers=()):
    graph = helper.make_graph(nodes, "graph", inputs, outputs, initializers)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 16)])
    model.ir_version = 7
    onnx.save(model, path)


def matcher(path, height, width, names=("left", "right"), levels=255.0, mirrored=False):
    """levels: what white is in the network's pictures. mirrored: the disparities have the other sign."""
    count = DISPARITIES
    shift = numpy.zeros((count, 1, 1, count))
    for d in range(count):
        shift[d, 0, 0, count - 1 - d] = 1
    nodes = [
        conv([names[0], "grey"], "left_grey"),
        conv([names[1], "grey"], "right_grey"),
        conv(["right_grey", "shift"], "shifted", kernel_shape=[1, count], pads=[0, count - 1, 0, 0]),
        conv(["left_grey", "copies"], "here"),
        helper.make_node("Sub", ["here", "shifted"], ["signed"]),
        helper.make_node("Abs", ["signed"], ["differences"]),
        helper.make_node("AveragePool", ["differences"], ["means"], kernel_shape=[WINDOW, WINDOW],
                         pads=[WINDOW // 2] * 4),
        conv(["means", "sharpness"], "likeness", group=count),
        helper.make_node("Softmax", ["likeness"], ["shares"], axis=1),
        conv(["shares", "each"], "disparity"),
        helper.make_node("ReduceMax", ["shares"], ["confidence"], axes=[1], keepdims=1),
    ]
    initializers = weights(
        grey=numpy.full((1, 3, 1, 1), 1 / 3), shift=shift, copies=numpy.ones((count, 1, 1, 1)),
        sharpness=numpy.full((count, 1, 1, 1), -255.0 / levels),
        each=(-1 if mirrored else 1) * numpy.arange(count).reshape(1, count, 1, 1))
    save(path, nodes, [value(name, [1, 3, height, width]) for name in names],
         [value(name, [1, 1, height, width]) for name in ("confidence", "disparity")], initializers)


def one_layer(path, kind="Identity", inputs=2, channels=3, size=("h", "w"), more_outputs=(), **attributes):
    """A graph whose disparities are a channel of the first picture: what the network is given is what it answers."""
    names = ["left", "right", "third", "fourth"][:inputs]
    picks = numpy.zeros((1, channels, 1, 1))
    picks[0, 0] = 1
    # OpenCV runs no graph with an input that nothing reads: the others count, but 0 times.
    nodes = [conv([name, "picks" if name == "left" else "nothing"], f"{name}_red") for name in names]
    nodes += [helper.make_node("Sum", [f"{name}_red" for name in names], ["red"]),
              helper.make_node(kind, {"GridSample": ["red", "places"], "Concat": ["left", "left"]}.get(kind, ["red"]),
                               ["disparity"], **attributes)]
    places = {}
    if kind == "GridSample":  # each pixel's own place
        rows, columns = numpy.meshgrid(*(numpy.linspace(-1, 1, side) for side in size), indexing="ij")
        places = {"places": numpy.stack([columns, rows], axis=-1)[None]}
    nodes += [helper.make_node("Sigmoid", ["red"], [name]) for name in more_outputs]
    outputs = [value(name, [1, 1, "h", "w"]) for name in ["disparity", *more_outputs]]
    save(path, nodes, [value(name, [1, channels, *size]) for name in names], outputs,
         weights(picks=picks, nothing=0 * picks, **places))


def main(folder):
    matcher(folder / "block.onnx", "height", "width")
    matcher(folder / "fixed.onnx", 240, 320, names=("image1", "image2"), mirrored=True)
    matcher(folder / "unit-tiles.onnx", 128, 224, levels=1.0)
    matcher(folder / "small.onnx", 96, 128)
    one_layer(folder / "red.onnx")
    one_layer(folder / "imagenet-red.onnx")
    one_layer(folder / "red-tiles.onnx", size=(96, 128))
    one_layer(folder / "s2m2-red.onnx", more_outputs=["occ", "conf"])
    one_layer(folder / "hidden-red.onnx", more_outputs=["occ"])
    one_layer(folder / "half.onnx", kind="AveragePool", kernel_shape=[2, 2], strides=[2, 2])
    one_layer(folder / "joined.onnx", inputs=1, channels=6)
    one_layer(folder / "four-inputs.onnx", inputs=4)
    one_layer(folder / "volume.onnx", kind="Concat", axis=1)
    one_layer(folder / "grid-sample.onnx", kind="GridSample", size=(64, 64), align_corners=1)
    one_layer(folder / "own-operator.onnx", kind="OwnOperator")
    one_layer(folder / "many-channels.onnx", channels=5)
    one_layer(folder / "huge.onnx", size=(1 << 20, 1 << 20))
    whole = (folder / "block.onnx").read_bytes()
    (folder / "cut-off.onnx").write_bytes(whole[:len(whole) // 2])
    (folder / "rubbish.onnx").write_bytes(bytes(range(256)) * 4)
    (folder / "empty.onnx").write_bytes(b"")
    model = onnx.load_from_string(whole)
    onnx.save(model, str(folder / "parts.onnx"), save_as_external_data=True, size_threshold=0, location="parts.bin")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
