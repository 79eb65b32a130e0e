# SPDX-License-Identifier: MIT
"""Writes a .safetensors file of weights as files of PyTorch, without PyTorch: make_pth.py IN OUT_FOLDER
OUT_FOLDER/{old,zip}_{features,linear}.pth, and evil.pth, which would run a command if it was unpickled."""
import io
import json
import pickle
import struct
import sys
import types
import zipfile
from collections import OrderedDict

torch, utils = types.ModuleType("torch"), types.ModuleType("torch._utils")
sys.modules["torch"], sys.modules["torch._utils"] = torch, utils


class FloatStorage:
    pass


def _rebuild_tensor_v2(*_):
    pass


FloatStorage.__module__, _rebuild_tensor_v2.__module__ = "torch", "torch._utils"
FloatStorage.__qualname__, _rebuild_tensor_v2.__qualname__ = "FloatStorage", "_rebuild_tensor_v2"
torch.FloatStorage, utils._rebuild_tensor_v2 = FloatStorage, _rebuild_tensor_v2


class Storage:
    def __init__(self, key, values):
        self.key, self.values = key, values


class Tensor:
    def __init__(self, storage, shape):
        self.storage, self.shape = storage, shape

    def __reduce__(self):
        stride, count = [], 1
        for side in reversed(self.shape):
            stride.insert(0, count)
            count *= side
        return _rebuild_tensor_v2, (self.storage, 0, self.shape, tuple(stride), False, OrderedDict())


class Pickler(pickle.Pickler):
    old = False

    def persistent_id(self, item):
        if isinstance(item, Storage):
            return ("storage", FloatStorage, item.key, "cpu", len(item.values) // 4) + ((None,) if self.old else ())


def dump(item, file, old):
    pickler = Pickler(file, 2)
    pickler.old = old
    pickler.dump(item)


def save_old(path, tensors):
    with open(path, "wb") as file:
        pickle.dump(0x1950A86A20F9469CFC6C, file, 2)
        pickle.dump(1001, file, 2)
        pickle.dump({"protocol_version": 1001, "little_endian": True}, file, 2)
        dump(tensors, file, True)
        storages = sorted((tensor.storage for tensor in tensors.values()), key=lambda s: s.key)
        pickle.dump([storage.key for storage in storages], file, 2)
        for storage in storages:
            file.write(struct.pack("<q", len(storage.values) // 4) + storage.values)


def save_zip(path, tensors):
    with zipfile.ZipFile(path, "w") as archive:
        text = io.BytesIO()
        dump(tensors, text, False)
        archive.writestr("weights/data.pkl", text.getvalue())
        for tensor in tensors.values():
            archive.writestr(f"weights/data/{tensor.storage.key}", tensor.storage.values)


class Evil:
    def __reduce__(self):
        return print, ("this code must not run",)


content = open(sys.argv[1], "rb").read()
length = struct.unpack_from("<Q", content)[0]
features, linear = OrderedDict(), OrderedDict()
for i, (name, entry) in enumerate(json.loads(content[8 : 8 + length]).items()):
    if name == "__metadata__":
        continue
    begin, end = (8 + length + offset for offset in entry["data_offsets"])
    storage, shape = Storage(str(i), content[begin:end]), tuple(entry["shape"])
    if name.startswith("lin"):
        linear[name.replace(".", ".model.1.")] = Tensor(storage, (1, *shape, 1, 1))
    else:
        features[name] = Tensor(storage, shape)
for name, tensors in (("features", features), ("linear", linear)):
    save_old(f"{sys.argv[2]}/old_{name}.pth", tensors)
    save_zip(f"{sys.argv[2]}/zip_{name}.pth", tensors)
with zipfile.ZipFile(f"{sys.argv[2]}/evil.pth", "w") as archive:
    archive.writestr("weights/data.pkl", pickle.dumps(Evil(), 2))
