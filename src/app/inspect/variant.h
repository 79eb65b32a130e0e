// SPDX-License-Identifier: MIT
//
// One way to draw a view, as comparisons set it against another.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "raster/renderer.h"

namespace qs {

struct Variant {
  CullMode mode = kDefaultMode;  ///< kReferenceMode: on the CPU, whatever the others say
  Pipeline pipeline = kDefaultPipeline;
  Backend backend = Backend::cpu;

  bool operator==(const Variant&) const = default;
};

/// "cuda fast", "cpu", which has one pipeline.
std::string drawn_by(const Variant& variant);

/// "quadbox, cuda fast", "quadbox, cpu", "reference": what there is one of is not named.
std::string full_name(const Variant& variant);

/// The same with no more than what tells it from `other`: "quadbox", or "quadbox, cuda classic".
std::string name_beside(const Variant& variant, const Variant& other);

/// The variant of a full_name(), or of a mode's name, drawn as `like`; unset when there is none
/// here.
std::optional<Variant> find_variant(std::string_view name, const Variant& like);

}  // namespace qs
