// SPDX-License-Identifier: MIT
//
// Compares results with files in tests/golden that a person has checked.
// With QUADSPLAT_UPDATE_GOLDEN=1 in the environment the files are rewritten instead: check the
// changes before committing them. Otherwise a result that differs is written to a temporary file,
// which the failure names. QUADSPLAT_GOLDEN_FOLDER names another folder than tests/golden.
#pragma once

#include <string>

#include "raster/scene/image.h"

namespace qs::test {

/// `name` in tests/golden, for example "drawings/heatmap.png". Values may differ by 2 of 255. One
/// pixel in 10,000 may differ more, because another processor may round an edge differently.
void expect_golden_image(const std::string& name, const Image& image);

/// The same for a text. Numbers with a decimal point may differ by one unit of their last digit or
/// by 1e-5 of their value.
void expect_golden_text(const std::string& name, const std::string& text);

}  // namespace qs::test
