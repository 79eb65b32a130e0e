// SPDX-License-Identifier: MIT
#include "learn/field/code_training.h"

#include <utility>

#include "learn/field/integer_sums.h"
#include "learn/gradient/residual_codes.h"

namespace qs {

constexpr std::size_t kVectorGrain = 1024;

CodeState CodeState::starting_with(ResidualCodebook codebook) {
  CodeState state;
  state.first.resize(codebook.values.size());
  state.second.resize(codebook.values.size());
  state.codebook = std::move(codebook);
  return state;
}

std::vector<float> coded(const ResidualCodebook& codebook, std::span<const float> vectors,
                         ThreadPool& pool) {
  const std::size_t d = codebook.dimensions;
  std::vector<float> result(vectors.size());
  pool.for_chunks(vectors.size() / d, kVectorGrain, [&](std::size_t begin, std::size_t end, int) {
    std::vector<std::uint16_t> numbers(codebook.layers);
    for (std::size_t i = begin; i < end; ++i) {
      codebook.encode(&vectors[i * d], numbers);
      codebook.decode(numbers, &result[i * d]);
    }
  });
  return result;
}

void take_code_step(CodeState& state, std::span<const float> vectors, ThreadPool& pool) {
  ResidualCodebook& book = state.codebook;
  const std::size_t d = book.dimensions, values = book.codes() * d, count = vectors.size() / d;
  if (count == 0) return;
  const AdamStep step = AdamStep::number(++state.steps);
  std::vector<float> rest(vectors.begin(), vectors.end());
  IntegerSums sums;
  for (std::size_t layer = 0; layer < book.layers; ++layer) {
    sums.reset(values);
    pool.for_each(count, kVectorGrain, [&](std::size_t i) {
      const std::size_t number = book.nearest(layer, &rest[i * d]);
      for (std::size_t k = 0; k < d; ++k)
        sums.add(number * d + k, book.code(layer, number)[k] - rest[i * d + k]);
    });
    for (std::size_t at = 0; at < values; ++at) {
      const std::size_t value = layer * values + at;
      move_code(step, code_gradient(sums.sum(at), vectors.size()), book.values[value],
                state.first[value], state.second[value]);
    }
    pool.for_each(count, kVectorGrain, [&](std::size_t i) {
      const float* const code = book.code(layer, book.nearest(layer, &rest[i * d]));
      for (std::size_t k = 0; k < d; ++k) rest[i * d + k] -= code[k];
    });
  }
}

}  // namespace qs
