// SPDX-License-Identifier: MIT
// FLIP against values of an independent evaluation (tests/golden/flip.py), and at colours whose
// difference is known.
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "raster/scene/image_metrics.h"
#include "support/pool.h"
#include "support/shared.h"

namespace qs {
namespace {

constexpr int kWidth = 48, kHeight = 36;

// The pictures of flip.py.
Image picture(const std::string& kind) {
  Image image(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) {
        int value = (5 * x + 3 * y + 40 * c + x * y / 16) % 200 + 20;
        if (kind == "shifted" && x > 10 && x < 30 && y > 8 && y < 20) value += 25 - 20 * c;
        if (kind == "dotted" && x % 12 == 5 && y % 9 == 4) value = 255 - 60 * c;
        if (kind == "inverted") value = 255 - value;
        image.at(x, y, c) = static_cast<float>(value) / 255.0f;
      }
  return image;
}

Image plain(float r, float g, float b) {
  Image image(20, 15, 3);
  for (int i = 0; i < 300; ++i) {
    image.at(i % 20, i / 20, 0) = r;
    image.at(i % 20, i / 20, 1) = g;
    image.at(i % 20, i / 20, 2) = b;
  }
  return image;
}

}  // namespace

TEST(Flip, equals_an_independent_evaluation) {
  const auto expected =
      nlohmann::json::parse(std::ifstream(test::source_path("tests/golden/flip.json")));
  int pixels = 0;
  for (const std::string kind : {"shifted", "dotted", "inverted"}) {
    for (const double ppd : {kFlipPixelsPerDegree, 20.0}) {
      const std::string name = kind + " at " + (ppd == 20 ? "20.0000" : "67.0206");
      const Image map = flip_map(picture("plain"), picture(kind), test::pool(2), ppd);
      EXPECT_NEAR(flip(picture("plain"), picture(kind), test::pool(2), ppd),
                  expected["means"][name].get<double>(), 1e-6)
          << name;
      for (const auto& [place, error] : expected["pixels"][name].items()) {
        const auto comma = place.find(',');
        const int x = std::stoi(place.substr(0, comma)), y = std::stoi(place.substr(comma + 1));
        EXPECT_NEAR(map.at(x, y, 0), error.get<double>(), 1e-6) << name << " " << place;
        ++pixels;
      }
    }
  }
  EXPECT_EQ(pixels, 18);
}

TEST(Flip, is_0_for_equal_pictures_and_1_for_the_two_colours_that_differ_most) {
  EXPECT_EQ(flip(picture("plain"), picture("plain"), test::pool(1)), 0);
  EXPECT_NEAR(flip(plain(0, 1, 0), plain(0, 0, 1), test::pool(1)), 1, 1e-6);
  EXPECT_NEAR(flip(plain(0, 0, 1), plain(0, 1, 0), test::pool(1)), 1, 1e-6);
}

TEST(Flip, does_not_depend_on_the_number_of_threads) {
  EXPECT_EQ(flip_map(picture("plain"), picture("dotted"), test::pool(1)).values,
            flip_map(picture("plain"), picture("dotted"), test::pool(3)).values);
}

TEST(Flip, clamps_values_that_no_display_shows) {
  EXPECT_EQ(flip(plain(1, 0, 1), plain(1.7f, -0.3f, 1), test::pool(1)), 0);
}

}  // namespace qs
