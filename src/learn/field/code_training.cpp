// SPDX-License-Identifier: MIT
#include "learn/field/code_training.h"

#include <algorithm>
#include <utility>

#include "learn/field/integer_sums.h"
#include "learn/gradient/residual_codes.h"

namespace qs {
namespace {

constexpr std::size_t kGrain = 1024;

// Moves every code to the mean of the vectors whose nearest code it is. Codes without vectors stay.
void move_to_means(std::span<const float> vectors, std::span<const std::uint16_t> nearest,
                   std::size_t dimensions, std::span<float> codes) {
  std::vector<double> sums(codes.size());
  std::vector<std::size_t> counts(codes.size() / dimensions);
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    ++counts[nearest[i]];
    for (std::size_t k = 0; k < dimensions; ++k)
      sums[nearest[i] * dimensions + k] += static_cast<double>(vectors[i * dimensions + k]);
  }
  for (std::size_t at = 0; at < codes.size(); ++at)
    if (const std::size_t count = counts[at / dimensions]; count > 0)
      codes[at] = static_cast<float>(sums[at] / static_cast<double>(count));
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
  const std::size_t d = codebook.dimensions, layers = codebook.layers;
  const std::vector<std::uint16_t> numbers = encode_all(codebook, vectors, pool);
  std::vector<float> result(vectors.size());
  pool.for_each(vectors.size() / d, kGrain, [&](std::size_t i) {
    codebook.decode(std::span(numbers).subspan(i * layers, layers), &result[i * d]);
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
    pool.for_each(count, kGrain, [&](std::size_t i) {
      const std::size_t number = book.nearest(layer, &rest[i * d]);
      for (std::size_t k = 0; k < d; ++k)
        sums.add(number * d + k, book.code(layer, number)[k] - rest[i * d + k]);
    });
    for (std::size_t at = 0; at < values; ++at) {
      const std::size_t value = layer * values + at;
      move_code(step, code_gradient(sums.sum(at), vectors.size()), book.values[value],
                state.first[value], state.second[value]);
    }
    pool.for_each(count, kGrain, [&](std::size_t i) {
      const float* const code = book.code(layer, book.nearest(layer, &rest[i * d]));
      for (std::size_t k = 0; k < d; ++k) rest[i * d + k] -= code[k];
    });
  }
}

ResidualCodebook fit_codebook(ResidualCodebook shape, std::span<const float> vectors,
                              const Random& random, ThreadPool& pool, int rounds) {
  ResidualCodebook book = std::move(shape);
  book.values.assign(book.value_count(), 0);
  const std::size_t d = book.dimensions, count = vectors.size() / d;
  if (count == 0) return book;
  std::vector<float> rest(vectors.begin(), vectors.end());
  std::vector<std::uint16_t> nearest(count);
  for (std::size_t layer = 0; layer < book.layers; ++layer) {
    const auto codes = std::span(book.values).subspan(layer * book.codes() * d, book.codes() * d);
    const auto find_nearest = [&] {
      pool.for_each(count, kGrain,
                    [&](std::size_t i) { nearest[i] = book.nearest(layer, &rest[i * d]); });
    };
    for (std::size_t code = 0; code < book.codes(); ++code) {
      const std::size_t drawn = random.bits(layer * book.codes() + code) % count;
      std::copy_n(&rest[drawn * d], d, &codes[code * d]);
    }
    for (int round = 0; round < rounds; ++round) {
      find_nearest();
      move_to_means(rest, nearest, d, codes);
    }
    find_nearest();
    for (std::size_t at = 0; at < rest.size(); ++at)
      rest[at] -= codes[nearest[at / d] * d + at % d];
  }
  return book;
}

std::vector<std::uint16_t> encode_all(const ResidualCodebook& codebook,
                                      std::span<const float> vectors, ThreadPool& pool) {
  const std::size_t count = vectors.size() / codebook.dimensions;
  std::vector<std::uint16_t> numbers(count * codebook.layers);
  pool.for_each(count, kGrain, [&](std::size_t i) {
    codebook.encode(&vectors[i * codebook.dimensions],
                    std::span(numbers).subspan(i * codebook.layers, codebook.layers));
  });
  return numbers;
}

}  // namespace qs
