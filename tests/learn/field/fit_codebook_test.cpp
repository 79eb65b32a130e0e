// SPDX-License-Identifier: MIT
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "learn/field/code_training.h"
#include "support/pool.h"

namespace qs {
namespace {

const Random kRandom = Random::of(1, RandomUse::color_field, 2);

std::vector<float> some_vectors(std::size_t count, std::size_t dimensions) {
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  std::vector<float> values(count * dimensions);
  for (float& value : values) value = normal(random);
  return values;
}

double rms(const ResidualCodebook& book, const std::vector<float>& vectors) {
  const auto numbers = encode_all(book, vectors, test::pool());
  const std::size_t d = book.dimensions;
  std::vector<float> decoded(d);
  double sum = 0;
  for (std::size_t i = 0; i * d < vectors.size(); ++i) {
    book.decode(std::span(numbers).subspan(i * book.layers, book.layers), decoded.data());
    for (std::size_t k = 0; k < d; ++k)
      sum += std::pow(static_cast<double>(decoded[k] - vectors[i * d + k]), 2);
  }
  return std::sqrt(sum / static_cast<double>(vectors.size()));
}

TEST(FitCodebook, every_stage_makes_the_difference_smaller) {
  const auto vectors = some_vectors(3000, 3);
  double before = 1;
  for (const std::size_t layers : {1u, 2u, 4u, 6u}) {
    const auto book = fit_codebook({layers, 6, 3, {}}, vectors, kRandom, test::pool());
    const double difference = rms(book, vectors);
    EXPECT_LT(difference, (layers == 1 ? 0.5 : 0.6) * before) << layers;
    before = difference;
  }
  EXPECT_LT(before, 0.01);
}

TEST(FitCodebook, a_few_vectors_are_their_own_codes) {
  const auto vectors = some_vectors(5, 4);
  EXPECT_LT(rms(fit_codebook({6, 6, 4, {}}, vectors, kRandom, test::pool()), vectors), 1e-6);
}

TEST(FitCodebook, without_vectors_all_codes_are_zero) {
  const auto book = fit_codebook({6, 6, 4, {}}, {}, kRandom, test::pool());
  EXPECT_EQ(book.values, std::vector<float>(6 * 64 * 4, 0.0f));
  EXPECT_TRUE(encode_all(book, {}, test::pool()).empty());
}

TEST(FitCodebook, threads_change_nothing_and_the_random_numbers_do) {
  const auto vectors = some_vectors(3000, 3);
  const auto fit = [&](const Random& random, int threads) {
    return fit_codebook({3, 6, 3, {}}, vectors, random, test::pool(threads)).values;
  };
  EXPECT_EQ(fit(kRandom, 1), fit(kRandom, 3));
  EXPECT_NE(fit(kRandom, 1), fit(Random::of(2, RandomUse::color_field, 2), 1));
}

}  // namespace
}  // namespace qs
