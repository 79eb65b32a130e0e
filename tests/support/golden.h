// SPDX-License-Identifier: MIT
//
// Compares results with files in tests/golden that a person has looked at.
// With QUADSPLAT_UPDATE_GOLDEN=1 in the environment the files are rewritten instead: look at what
// changed before committing it. Otherwise a result that differs is written to a temporary file,
// which the failure names.
#pragma once

#include <string>

#include "raster/scene/image.h"

namespace qs::test {

/// `name` in tests/golden, for example "drawings/heatmap.png". Values may differ by 2 of 255. One
/// pixel in 10,000 may differ more, where another processor rounds an edge differently.
void expect_golden_image(const std::string& name, const Image& image);

/// The same for a text. Numbers with a decimal point may differ by one unit of their last digit or
/// by 1e-5 of their value.
void expect_golden_text(const std::string& name, const std::string& text);

}  // namespace qs::test
