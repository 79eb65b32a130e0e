// SPDX-License-Identifier: MIT
//
// RAD (Spark): a tree of levels of detail in chunks of 65,536 nodes, beside each other in a .rad
// file or in files of their own (.radc). The leaves are read. Source: rust/spark-lib/src/rad.rs of
// sparkjsdev/spark; the code is our own.
#pragma once

#include "io/cloud/scene.h"

namespace qs {

RecogniseScene recognises_rad;
ReadScene read_rad;

}  // namespace qs
