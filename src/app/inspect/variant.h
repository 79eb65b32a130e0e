// SPDX-License-Identifier: MIT
//
// One way to render a view: a culling mode on a pipeline of a backend. Comparisons name and choose
// variants.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "raster/api/renderer.h"

namespace qs {

struct Variant {
  CullMode mode =
      default_mode();  ///< kReferenceMode runs on the CPU; the other members are ignored
  Pipeline pipeline = kDefaultPipeline;
  Backend backend = Backend::cpu;

  bool operator==(const Variant&) const = default;
};

/// "cuda fast", "cuda classic" or "cpu".
std::string drawn_by(const Variant& variant);

/// "quadbox, cuda fast", "quadbox, cpu" or "reference".
std::string full_name(const Variant& variant);

/// The shortest name that distinguishes `variant` from `other`: "quadbox" or "quadbox, cuda
/// classic".
std::string name_beside(const Variant& variant, const Variant& other);

/// The variant with this full_name(); or with this mode, and backend and pipeline of `like`. Unset
/// if the name is unknown or the backend is not available.
std::optional<Variant> find_variant(std::string_view name, const Variant& like);

}  // namespace qs
