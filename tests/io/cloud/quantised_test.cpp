// SPDX-License-Identifier: MIT
#include "io/cloud/quantised.h"

#include <cmath>
#include <limits>

#include <glm/gtc/packing.hpp>
#include <gtest/gtest.h>

namespace qs {
namespace {

TEST(Quantised, glm_decodes_every_half_float_exactly) {
  for (unsigned half = 0; half < 65536; ++half) {
    const float value = glm::unpackHalf1x16(static_cast<glm::uint16>(half));
    const int exponent = half >> 10 & 31, mantissa = half & 1023;
    EXPECT_EQ(std::signbit(value), half >= 32768) << half;
    if (exponent == 31) {
      EXPECT_TRUE(mantissa == 0 ? std::isinf(value) : std::isnan(value)) << half;
    } else {
      const double magnitude = exponent == 0 ? std::ldexp(mantissa, -24)
                                             : std::ldexp(1 + mantissa / 1024.0, exponent - 15);
      EXPECT_EQ(std::abs(value), magnitude) << half;
    }
  }
}

TEST(Quantised, bytes_of_opacity_become_logits_and_return) {
  EXPECT_EQ(logit_of_byte(0), -INFINITY);
  EXPECT_EQ(logit_of_byte(255), INFINITY);
  for (int byte = 1; byte < 255; ++byte) {
    const double logit = logit_of_byte(static_cast<std::uint8_t>(byte));
    EXPECT_NEAR(255 / (1 + std::exp(-logit)), byte, 1e-4);
  }
}

TEST(Quantised, rounding_is_to_the_nearest_and_clamps) {
  EXPECT_EQ(round_to_integer(2.49, 255), 2u);
  EXPECT_EQ(round_to_integer(2.5, 255), 3u);
  EXPECT_EQ(round_to_integer(254.6, 255), 255u);
  EXPECT_EQ(round_to_integer(1e30, 255), 255u);
  EXPECT_EQ(round_to_integer(-3, 255), 0u);
  EXPECT_EQ(round_to_integer(std::numeric_limits<double>::quiet_NaN(), 255), 0u);
}

TEST(Quantised, quaternions_survive_without_their_largest_component) {
  for (std::size_t largest = 0; largest < 4; ++largest) {
    for (const double sign : {1.0, -1.0}) {
      std::array<double, 4> q = {0.1, -0.2, 0.3, -0.4};
      q[largest] = sign * std::sqrt(1 - (0.01 + 0.04 + 0.09 + 0.16 - q[largest] * q[largest]));
      const SmallestThree three = drop_largest(q);
      EXPECT_EQ(three.dropped, largest);
      const auto restored = restore_largest(three.others, three.dropped);
      for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(restored[i], sign * q[i], 1e-12);
    }
  }
  EXPECT_EQ(restore_largest({1, 1, 1}, 2)[2], 0);  // damaged: longer than 1
}

}  // namespace
}  // namespace qs
