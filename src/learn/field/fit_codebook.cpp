// SPDX-License-Identifier: MIT
#include "learn/field/fit_codebook.h"

#include <algorithm>

#include "raster/kernel/nearest_code.h"

namespace qs {
namespace {

constexpr std::size_t kGrain = 1024;

// One layer of a codebook, and the code that is nearest to each vector.
struct CodeLayer {
  std::span<float> codes;
  std::size_t dimensions;
  std::vector<std::uint16_t> nearest;

  std::size_t size() const { return codes.size() / dimensions; }

  void assign(std::span<const float> vectors, ThreadPool& pool) {
    pool.for_chunks(nearest.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) nearest[i] = nearest_to(&vectors[i * dimensions]);
    });
  }

  // Codes without vectors stay.
  void move_to_means(std::span<const float> vectors) {
    std::vector<double> sums(codes.size());
    std::vector<std::size_t> counts(size());
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

 private:
  std::uint16_t nearest_to(const float* vector) const {
    return static_cast<std::uint16_t>(nearest_code(codes.data(), static_cast<unsigned>(size()),
                                                   static_cast<unsigned>(dimensions), vector));
  }
};

}  // namespace

ResidualCodebook fit_codebook(ResidualCodebook shape, std::span<const float> vectors,
                              const Random& random, ThreadPool& pool, int rounds) {
  ResidualCodebook book = std::move(shape);
  book.values.assign(book.value_count(), 0);
  const std::size_t d = book.dimensions, count = vectors.size() / d;
  if (count == 0) return book;
  std::vector<float> rest(vectors.begin(), vectors.end());
  for (std::size_t number = 0; number < book.layers; ++number) {
    CodeLayer layer{std::span(book.values).subspan(number * book.codes() * d, book.codes() * d), d,
                    std::vector<std::uint16_t>(count)};
    for (std::size_t code = 0; code < book.codes(); ++code) {
      const std::size_t drawn = random.bits(number * book.codes() + code) % count;
      std::copy_n(&rest[drawn * d], d, &layer.codes[code * d]);
    }
    for (int round = 0; round < rounds; ++round) {
      layer.assign(rest, pool);
      layer.move_to_means(rest);
    }
    layer.assign(rest, pool);
    for (std::size_t at = 0; at < rest.size(); ++at)
      rest[at] -= layer.codes[layer.nearest[at / d] * d + at % d];
  }
  return book;
}

std::vector<std::uint16_t> encode_all(const ResidualCodebook& codebook,
                                      std::span<const float> vectors, ThreadPool& pool) {
  const std::size_t count = vectors.size() / codebook.dimensions;
  std::vector<std::uint16_t> numbers(count * codebook.layers);
  pool.for_chunks(count, kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      codebook.encode(&vectors[i * codebook.dimensions],
                      std::span(numbers).subspan(i * codebook.layers, codebook.layers));
    }
  });
  return numbers;
}

}  // namespace qs
