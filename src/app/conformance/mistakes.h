// SPDX-License-Identifier: MIT
//
// The usual mistakes of renderers. Each can be applied to a drawing, so that the picture of a
// renderer can be compared with pictures that have the mistake.
// To add a mistake: a function and a row of kMistakes in mistakes.cpp. The tests run for every row:
// it must change a scene of the kit, and no other mistake may draw all scenes like it.
// The tests make the same mistakes in two other renderers, which the judge does not know: one that
// reads the kit's files (tests/support/planted_renderer.h) and the plugin of examples/plugin
// (tests/plugin/mistakes.h).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/conformance/kit_scenes.h"
#include "app/conformance/plain_renderer.h"

namespace qs {

/// Everything that a mistake may change before and after a scene is drawn.
struct Drawing {
  KitView view;
  Rules rules;
  std::vector<Image (*)(const Image&)> afterwards = {};  ///< applied to the finished image
};

struct Mistake {
  const char* name;
  const char* what;       ///< one sentence without its full stop, about the renderer
  std::string_view part;  ///< two mistakes in the same part of the renderer exclude each other
  void (*make)(Drawing& drawing);
};

/// Several mistakes are made in this order.
std::span<const Mistake> mistakes();

/// Indices of mistakes(), ascending.
using MistakeSet = std::vector<std::size_t>;

/// The empty set; or each mistake alone; or every two mistakes that do not exclude each other.
std::vector<MistakeSet> sets_of_mistakes(int count);

/// "quaternion-xyzw + dilation-missing"; "none" for an empty set.
std::string names_of(const MistakeSet& set);

/// A view drawn with these mistakes. They change `rules`.
Image draw_with(const KitView& view, const MistakeSet& set, const Rules& rules = {});

/// RGB values as in a PNG file, row by row.
using Picture8 = std::vector<std::uint8_t>;
Picture8 picture8(const Image& image);

}  // namespace qs
