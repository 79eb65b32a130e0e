// SPDX-License-Identifier: MIT
#include "raster/kernel/cull/mode.h"

#include <cassert>

#include "raster/kernel/cull/table.h"

namespace qs {

int culler_count() { return kCullerCount; }

int mode_count() { return kModeCount; }

const CullerRow& row_of(CullMode mode) {
  assert(mode >= 0 && mode <= kModeCount);
  return kCullers[mode];
}

const char* mode_name(CullMode mode) { return row_of(mode).name; }

CullMode find_culler(std::string_view name) { return number_of(name); }

CullMode default_mode() {
  static constexpr CullMode kQuadBox = number_of("quadbox");
  static_assert(kQuadBox > 0);
  return kQuadBox;
}

}  // namespace qs
