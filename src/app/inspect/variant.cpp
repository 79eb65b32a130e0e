// SPDX-License-Identifier: MIT
#include "app/inspect/variant.h"

#include <fmt/format.h>

namespace qs {

std::string drawn_by(const Variant& variant) {
  const char* backend = kBackendNames[static_cast<int>(variant.backend)];
  if (variant.backend == Backend::cpu) return backend;
  return fmt::format("{} {}", backend, kPipelineNames[static_cast<int>(variant.pipeline)]);
}

std::string full_name(const Variant& variant) {
  if (variant.mode == kReferenceMode) return mode_name(variant.mode);
  return fmt::format("{}, {}", mode_name(variant.mode), drawn_by(variant));
}

std::string name_beside(const Variant& variant, const Variant& other) {
  const bool alike = drawn_by(variant) == drawn_by(other) || other.mode == kReferenceMode;
  return alike ? mode_name(variant.mode) : full_name(variant);
}

std::optional<Variant> find_variant(std::string_view name, const Variant& like) {
  if (const CullMode mode = find_culler(name); mode >= 0)
    return Variant{mode, like.pipeline, like.backend};
  for (CullMode mode = 1; mode <= mode_count(); ++mode) {
    for (const Backend backend : available_backends()) {
      for (const Pipeline pipeline : pipelines_of(backend)) {
        const Variant variant{mode, pipeline, backend};
        if (full_name(variant) == name) return variant;
      }
    }
  }
  return std::nullopt;
}

}  // namespace qs
