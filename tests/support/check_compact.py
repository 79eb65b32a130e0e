# SPDX-License-Identifier: MIT
"""Opens the files of a Compact-3DGS model as PyTorch and NumPy do, and compares them: check_compact.py BASE
BASE.pth, BASE.npz and BASE_pp.npz. Prints the number of Gaussians. dahuffman is not needed: the class of its end symbol
is declared here, and its codes are decoded here."""
import sys
import types

import numpy as np
import torch


class _EndOfFileSymbol:
    pass


huffmancodec = types.ModuleType("dahuffman.huffmancodec")
huffmancodec._EndOfFileSymbol = _EndOfFileSymbol
sys.modules["dahuffman"], sys.modules["dahuffman.huffmancodec"] = types.ModuleType("dahuffman"), huffmancodec


def huffman_decode(table, data):
    lookup = {code: symbol for symbol, code in table.items()}
    symbols, bits, value = [], 0, 0
    for bit in np.unpackbits(data):
        bits, value = bits + 1, 2 * value + int(bit)
        if (bits, value) in lookup:
            symbol = lookup[bits, value]
            if isinstance(symbol, _EndOfFileSymbol):
                break
            symbols.append(symbol)
            bits, value = 0, 0
    return np.array(symbols)


def unpacked(data, count, bits):
    rows = np.unpackbits(data)[: count * bits].reshape(count, bits)
    return np.packbits(rows, axis=-1, bitorder="little").reshape(-1)


def expect(condition, what):
    if not condition:
        sys.exit(f"check_compact: {what}")


base = sys.argv[1]
state = torch.load(base + ".pth")
npz, processed = np.load(base + ".npz", allow_pickle=True), np.load(base + "_pp.npz", allow_pickle=True)
stages, bits = npz["rvq_info"]
count = len(npz["xyz"])
expect(list(state) == ["0.params", "1.params"], "the .pth has other tensors")
for key, name in (("0.params", "hash"), ("1.params", "mlp")):
    expect(np.array_equal(state[key].numpy().astype(np.float16), npz[name]), f"{key} differs from {name}")
expect(np.array_equal(npz["xyz"], processed["xyz"]) and np.array_equal(npz["mlp"], processed["mlp"]), "arrays differ")
for name, size in (("scale", 3), ("rotation", 4)):
    codes = huffman_decode(processed["huftable_" + name].item(), processed[name])
    expect(np.array_equal(codes, unpacked(npz[name], count * stages, bits)), f"the codes of {name} differ")
    books = npz["codebook_" + name].item()
    for stage in range(stages):
        embed = books[f"layers.{stage}._codebook.embed"]
        expect(tuple(embed.shape) == (1, 2**bits, size), f"codebook {name} has the shape {tuple(embed.shape)}")
        other = processed["codebook_" + name].item()[f"layers.{stage}._codebook.embed"]
        expect(torch.equal(embed, other), f"the codebooks of {name} differ")
for name, most in (("opacity", 0.003), ("hash", 0.11)):
    low, high = processed["minmax_" + name]
    values = low + (high - low) * huffman_decode(processed["huftable_" + name].item(), processed[name]) / 255
    difference = np.abs(values - npz[name].astype(np.float64).reshape(-1)).max()
    expect(difference < most, f"{name} differs by {difference}")
print(count)
