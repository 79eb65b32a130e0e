// SPDX-License-Identifier: MIT
//
// Small Compact-3DGS models with codes, to be written.
#pragma once

#include <cstddef>

#include "io/scene/compact/compact_model.h"
#include "support/golden_field.h"

namespace qs::test {

struct SavedModel {
  CompactModel model;
  CodedVectors scales, rotations;
};

inline CodedVectors coded_vectors(std::size_t count, std::size_t dimensions, std::size_t first) {
  CodedVectors vectors;
  vectors.codebook.dimensions = dimensions;
  for (std::size_t i = 0; i < vectors.codebook.value_count(); ++i) {
    const std::size_t layer = i / (vectors.codebook.codes() * dimensions);
    vectors.codebook.values.push_back(golden_value(first + i) / static_cast<float>(1 << 2 * layer));
  }
  for (std::size_t i = 0; i < count * vectors.codebook.layers; ++i) {
    vectors.numbers.push_back(
        static_cast<std::uint16_t>((golden_value(first + 7 * i) + 1) * 31.99f));
  }
  return vectors;
}

/// `count` Gaussians whose scales and rotations follow from codes, and a small field.
inline SavedModel saved_model(std::size_t count) {
  SavedModel saved;
  saved.scales = coded_vectors(count, 3, 100);
  saved.rotations = coded_vectors(count, 4, 5000);
  CompactModel& model = saved.model;
  const auto decode = [](const CodedVectors& vectors, std::size_t i, float* out) {
    const std::size_t layers = vectors.codebook.layers;
    vectors.codebook.decode(std::span(vectors.numbers).subspan(i * layers, layers), out);
  };
  for (std::size_t i = 0; i < count; ++i) {
    model.means.emplace_back(golden_value(3 * i, 4), golden_value(3 * i + 1, 4),
                             golden_value(3 * i + 2, 4));
    decode(saved.scales, i, &model.scales.emplace_back().x);
    decode(saved.rotations, i, &model.rotations.emplace_back().x);
    model.opacities.push_back((golden_value(i + 900) + 1) / 2);
  }
  GridShape grid;
  grid.log2_entries = 5;
  model.field = golden_field(grid, 64);
  return saved;
}

}  // namespace qs::test
