// SPDX-License-Identifier: MIT
//
// OpenUSD's ParticleField3DGaussianSplat (version 26.03 and later) in text: .usda, and .usdz, an
// uncompressed zip with it. Reads all such prims with the transforms of their parents, as they
// stand in the file: other files, variants and values that change over time are not read, and a
// warning says so. Source: pxr/usd/usdVol/schema.usda of OpenUSD.
#pragma once

#include "io/cloud/scene.h"

namespace qs {

RecogniseScene recognises_usd;
ReadScene read_usd;

/// Write a stage with one prim: Y up, so positions, rotations and SH are turned by 180 degrees
/// about x. Floats are written with the digits that give them back. The stage of a .usdz is made in
/// memory.
WriteScene write_usda, write_usdz;

}  // namespace qs
