// SPDX-License-Identifier: MIT
#include "learn/field/fit_codebook.h"

#include <algorithm>

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
  for (std::size_t at = 0; at < codes.size(); ++at) {
    if (const std::size_t count = counts[at / dimensions]; count > 0)
      codes[at] = static_cast<float>(sums[at] / static_cast<double>(count));
  }
}

}  // namespace

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
