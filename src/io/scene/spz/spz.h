// SPDX-License-Identifier: MIT
//
// .spz (Niantic), versions 1 to 4: quantised attributes in six blocks, compressed as one gzip
// member (1-3) or one zstd frame per block (4). Files store RUB axes unless an extension names
// another frame; files that store RDF without declaring it cannot be detected. Of Spark's trees of
// levels of detail the leaves are read. Source: README.md and load-spz.cc of nianticlabs/spz,
// rust/spark-lib/src/spz.rs of sparkjsdev/spark; the code is our own.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "base/parallel.h"
#include "base/progress.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/scene.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

RecogniseScene recognises_spz;
ReadScene read_spz;

// The writers use the frame RUB and the precision of Niantic's own writer: positions in 1/4096
// (coarser if more than 0.1 % of the Gaussians are beyond 2048), SH in 5 bits for degree 1 and 4
// bits for the others.

/// Names the Gaussians that move, because they are farther away than the positions' range: up to
/// 0.1 % are not worth a coarser step for all others. Else "".
std::string loss_in_spz(const GaussianCloud& cloud);

/// Version 3, one gzip stream: the version that nearly every reader supports.
WriteScene write_spz;

/// Version 4, zstd streams that can be read in parallel.
WriteScene write_spz_v4;

}  // namespace qs
