// SPDX-License-Identifier: MIT
#include "learn/field/code_training.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "support/pool.h"

namespace qs {
namespace {

std::vector<float> vectors_around(std::size_t count, float middle) {
  std::mt19937 random(2);
  std::normal_distribution<float> normal(middle);
  std::vector<float> values(3 * count);
  for (float& value : values) value = normal(random);
  return values;
}

CodeState codes_of(const std::vector<float>& vectors) {
  return CodeState::starting_with(fit_codebook(
      {2, 3, 3, {}}, vectors, Random::of(1, RandomUse::color_field, 2), test::pool(), 1));
}

double difference(const CodeState& state, const std::vector<float>& vectors) {
  const auto decoded = coded(state.codebook, vectors, test::pool());
  double sum = 0;
  for (std::size_t i = 0; i < vectors.size(); ++i)
    sum += std::pow(static_cast<double>(decoded[i] - vectors[i]), 2);
  return std::sqrt(sum / static_cast<double>(vectors.size()));
}

TEST(CodeTraining, codes_follow_vectors_that_move) {
  const auto before = vectors_around(500, 0), after = vectors_around(500, 0.05f);
  CodeState state = codes_of(before);
  for (int step = 0; step < 600; ++step) take_code_step(state, after, test::pool());
  EXPECT_LT(difference(state, after), 0.98 * difference(codes_of(after), after))
      << "better than new codes";
  EXPECT_EQ(state.steps, 600u);
}

// Adam's first step has the size of the rate.
TEST(CodeTraining, the_first_step_moves_codes_with_a_gradient_by_the_rate) {
  CodeState state = CodeState::starting_with({1, 1, 1, {0, 10}});
  take_code_step(state, std::vector<float>{1, 2, 3}, test::pool());
  EXPECT_NEAR(state.codebook.values[0], 1e-4, 1e-8);
  EXPECT_EQ(state.codebook.values[1], 10) << "no vector is near";
}

TEST(CodeTraining, threads_change_nothing) {
  const auto vectors = vectors_around(3000, 0);
  CodeState one = codes_of(vectors), many = one;
  for (int step = 0; step < 5; ++step) {
    take_code_step(one, vectors, test::pool(1));
    take_code_step(many, vectors, test::pool(3));
  }
  EXPECT_EQ(many.codebook.values, one.codebook.values);
  EXPECT_EQ(many.second, one.second);
  EXPECT_EQ(coded(one.codebook, vectors, test::pool(1)),
            coded(one.codebook, vectors, test::pool(3)));
}

TEST(CodeTraining, without_vectors_nothing_happens) {
  CodeState state = codes_of(vectors_around(9, 0));
  const auto before = state.codebook.values;
  take_code_step(state, {}, test::pool());
  EXPECT_EQ(state.codebook.values, before);
  EXPECT_FALSE(CodeState().exists());
}

}  // namespace
}  // namespace qs
