"""Arrays of all kinds as NumPy arrays, copied only where they must be."""

import ctypes

import numpy as np

from . import _core


def host_array(array, name):
    """Any array as a NumPy array: what is on the host is not copied; what is on a CUDA device is."""
    if isinstance(array, np.ndarray):
        return array
    if hasattr(array, "__cuda_array_interface__"):
        return _from_interface(array.__cuda_array_interface__)
    if hasattr(array, "__dlpack_device__"):
        kind, _ = array.__dlpack_device__()
        if kind == 1:  # the host's own memory
            return np.from_dlpack(array)
        return _from_capsule(array.__dlpack__(stream=1))
    converted = np.asarray(array)
    if converted.dtype == object:
        raise TypeError(f"{name}: {type(array).__name__} is no array")
    return converted


def picture_array(array, name):
    """(H, W) or (H, W, channels) uint8, whose rows have no gaps inside; 2 and 4 channels are with alpha. None stays."""
    if array is None:
        return None
    array = host_array(array, name)
    if array.dtype == np.bool_:
        array = array.view(np.uint8)
    if array.dtype != np.uint8:
        raise TypeError(f"{name}: pictures are arrays of uint8, not {array.dtype}")
    if array.ndim not in (2, 3):
        raise ValueError(f"{name}: pictures have the shape (H, W) or (H, W, 3), not {array.shape}")
    return _rows(array, name)


def map_array(array, name):
    """(H, W) float32, uint16 or uint8; other floats become float32. None stays."""
    if array is None:
        return None
    array = host_array(array, name)
    if array.ndim == 3 and array.shape[2] == 1:
        array = array[:, :, 0]
    if array.ndim != 2:
        raise ValueError(f"{name}: a map has the shape (H, W), not {array.shape}")
    if np.issubdtype(array.dtype, np.floating):
        array = array.astype(np.float32, copy=False)
    elif array.dtype not in (np.uint8, np.uint16):
        hint = "; OpenCV's matchers give 16 times the disparity: array.astype(np.float32) / 16"
        raise TypeError(
            f"{name}: maps are arrays of floats, or of uint16 or uint8, not of {array.dtype}"
            + (hint if array.dtype == np.int16 else "")
        )
    return _rows(array, name)


def _rows(array, name):
    """As it is where the elements of a row follow each other, else a copy."""
    if array.size == 0:
        raise ValueError(f"{name}: the array is empty")
    inner = array.itemsize
    for axis in reversed(range(1, array.ndim)):
        if array.strides[axis] != inner and array.shape[axis] > 1:
            return np.ascontiguousarray(array)
        inner *= array.shape[axis]
    aligned = array.flags.aligned and array.dtype.isnative and array.strides[0] >= inner
    return array if aligned else np.ascontiguousarray(array, array.dtype.newbyteorder("="))


def _from_device(pointer, shape, strides, dtype):
    """A copy of the memory between the array's first and last element, seen with its shape."""
    dtype = np.dtype(dtype)
    if strides is None:
        strides = np.ndarray(shape, np.uint8).strides if dtype.itemsize == 1 else _packed(shape, dtype)
    if any(step < 0 for step in strides):
        raise ValueError("an array on a device with negative strides; copy it first")
    extent = dtype.itemsize + sum((length - 1) * step for length, step in zip(shape, strides))
    return np.ndarray(shape, dtype, _core.from_device(pointer, extent), 0, strides)


def _packed(shape, dtype):
    strides, step = [], dtype.itemsize
    for length in reversed(shape):
        strides.insert(0, step)
        step *= length
    return tuple(strides)


def _from_interface(interface):
    return _from_device(
        interface["data"][0], tuple(interface["shape"]), interface.get("strides"), interface["typestr"]
    )


class _Tensor(ctypes.Structure):
    """DLTensor of dlpack.h."""

    _fields_ = [
        ("data", ctypes.c_void_p),
        ("device_type", ctypes.c_int32),
        ("device_id", ctypes.c_int32),
        ("ndim", ctypes.c_int32),
        ("code", ctypes.c_uint8),
        ("bits", ctypes.c_uint8),
        ("lanes", ctypes.c_uint16),
        ("shape", ctypes.POINTER(ctypes.c_int64)),
        ("strides", ctypes.POINTER(ctypes.c_int64)),
        ("byte_offset", ctypes.c_uint64),
    ]


def tensor_of(capsule):
    """(address, shape, strides in bytes or None, dtype) of a DLPack capsule, which keeps its owner."""
    pointer_of = ctypes.pythonapi.PyCapsule_GetPointer
    pointer_of.restype, pointer_of.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    tensor = _Tensor.from_address(pointer_of(capsule, b"dltensor"))
    dtype = np.dtype({0: "i", 1: "u", 2: "f"}.get(tensor.code, "V") + str(tensor.bits // 8))
    shape = tuple(tensor.shape[axis] for axis in range(tensor.ndim))
    strides = None
    if tensor.strides:
        strides = tuple(tensor.strides[axis] * dtype.itemsize for axis in range(tensor.ndim))
    return tensor.data + tensor.byte_offset, shape, strides, dtype


def _from_capsule(capsule):
    return _from_device(*tensor_of(capsule))
