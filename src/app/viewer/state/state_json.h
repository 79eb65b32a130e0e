// SPDX-License-Identifier: MIT
//
// What the window shows as JSON, for tests and for reports of problems.
#pragma once

#include <string>

#include "app/viewer/state/viewer.h"

namespace qs {

std::string state_json(const Viewer& viewer);

}  // namespace qs
