// SPDX-License-Identifier: MIT
#include "raster/field/code_training.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "raster/kernel/adam.h"

namespace qs {
namespace {

constexpr std::size_t kCodeBlocks = 64;  // of vectors, each with its own sums

// Calls visit(block, first vector, end) for fixed blocks of `count` vectors.
template <class Visit>
void for_each_block(std::size_t count, ThreadPool& pool, const Visit& visit) {
  pool.for_chunks(kCodeBlocks, 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t block = begin; block < end; ++block)
      visit(block, block * count / kCodeBlocks, (block + 1) * count / kCodeBlocks);
  });
}

std::size_t nearest_code(const ResidualCodebook& book, std::size_t stage, const float* vector) {
  std::size_t best = 0;
  float least = std::numeric_limits<float>::infinity();
  for (std::size_t number = 0; number < book.codes(); ++number) {
    const float* const code = book.code(stage, number);
    float distance = 0;
    for (std::size_t k = 0; k < book.dimensions; ++k)
      distance += (vector[k] - code[k]) * (vector[k] - code[k]);
    if (distance < least) {
      least = distance;
      best = number;
    }
  }
  return best;
}

void move_code(const AdamStep& step, float by, float& value, float& first, float& second) {
  constexpr float kRate = 1e-4f, kEpsilon = 1e-8f;
  if (!std::isfinite(by)) by = 0;
  first += static_cast<float>(1 - kAdamBeta1) * (by - first);
  second += static_cast<float>(1 - kAdamBeta2) * (by * by - second);
  value -= kRate * step.first * first / (std::sqrt(second) * step.second + kEpsilon);
}

}  // namespace

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
  for_each_block(vectors.size() / d, pool, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<std::uint16_t> numbers(codebook.stages);
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
  std::vector<double> sums(kCodeBlocks * values);
  for (std::size_t stage = 0; stage < book.stages; ++stage) {
    std::fill(sums.begin(), sums.end(), 0.0);
    for_each_block(count, pool, [&](std::size_t block, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t number = nearest_code(book, stage, &rest[i * d]);
        for (std::size_t k = 0; k < d; ++k) {
          sums[block * values + number * d + k] +=
              static_cast<double>(book.code(stage, number)[k] - rest[i * d + k]);
        }
      }
    });
    const double factor = 2 / static_cast<double>(vectors.size());
    for (std::size_t at = 0; at < values; ++at) {
      double sum = 0;
      for (std::size_t block = 0; block < kCodeBlocks; ++block) sum += sums[block * values + at];
      const std::size_t value = stage * values + at;
      move_code(step, static_cast<float>(factor * sum), book.values[value], state.first[value],
                state.second[value]);
    }
    for_each_block(count, pool, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const float* const code = book.code(stage, nearest_code(book, stage, &rest[i * d]));
        for (std::size_t k = 0; k < d; ++k) rest[i * d + k] -= code[k];
      }
    });
  }
}

}  // namespace qs
