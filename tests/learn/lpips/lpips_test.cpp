// SPDX-License-Identifier: MIT
//
// LPIPS with weights made by a rule. tests/golden/lpips.py computes the golden values in double
// precision.
#include "learn/lpips/lpips.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stop_token>

#include <gtest/gtest.h>

#include "support/lpips_weights.h"
#include "support/pool.h"

namespace qs {
namespace {

using lpips::Convolution;
using lpips::InputRange;
using lpips::Metric;
using lpips::Network;
using lpips::Weights;

struct Golden {
  const Network& network;
  int width, height;
  double unit, symmetric;
};

class LpipsGolden : public testing::TestWithParam<Golden> {};

TEST_P(LpipsGolden, the_distance_is_the_published_one) {
  const auto& [network, width, height, unit, symmetric] = GetParam();
  const Metric metric(test::golden_weights(network));
  const auto [a, b] = test::golden_pictures(width, height);
  EXPECT_NEAR(metric.distance(a, b, InputRange::unit, test::pool()), unit, 1e-6 * unit);
  EXPECT_NEAR(metric.distance(a, b, InputRange::symmetric, test::pool()), symmetric,
              1e-6 * symmetric);
}

INSTANTIATE_TEST_SUITE_P(
    Networks, LpipsGolden,
    testing::Values(Golden{lpips::kNetworks[0], 40, 32, 1.175212379, 1.403834518},
                    Golden{lpips::kNetworks[1], 72, 64, 2.447580940, 3.623819468}),
    [](const auto& golden) { return std::string(golden.param.network.name); });

TEST(Lpips, networks_take_pictures_from_their_smallest_side_on) {
  const Metric vgg16(test::golden_weights(lpips::kNetworks[0]));
  const Metric alexnet(test::golden_weights(lpips::kNetworks[1]));
  EXPECT_EQ(smallest_side(vgg16.network()), 16);
  EXPECT_EQ(smallest_side(alexnet.network()), 31);
  const auto [a, b] = test::golden_pictures(31, 31);
  EXPECT_GT(alexnet.distance(a, b, InputRange::unit, test::pool()), 0);
  const auto [c, d] = test::golden_pictures(16, 16);
  EXPECT_GT(vgg16.distance(c, d, InputRange::unit, test::pool()), 0);
}

// A small network with every kind of layer, and its values by the definition, in double precision.
constexpr std::array<Convolution, 3> kSmallLayers = {{{0, 3, 32, 5, 2, 1, false, true},
                                                      {1, 32, 64, 3, 1, 1, true, false},
                                                      {2, 64, 32, 3, 1, 1, false, true}}};
constexpr Network kSmall = {"small", 3, kSmallLayers};

struct Map {
  int width, height, channels;
  std::vector<double> values;  // channels, rows, columns
  double at(int c, int y, int x) const {
    if (x < 0 || y < 0 || x >= width || y >= height) return 0;
    return values[static_cast<std::size_t>((c * height + y) * width + x)];
  }
};

template <class Value>
Map make_map(int width, int height, int channels, const Value& value) {
  Map map{width, height, channels, {}};
  for (int c = 0; c < channels; ++c) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) map.values.push_back(value(c, y, x));
    }
  }
  return map;
}

Map pooled(const Map& in, int size) {
  return make_map((in.width - size) / 2 + 1, (in.height - size) / 2 + 1, in.channels,
                  [&](int c, int y, int x) {
                    double largest = 0;
                    for (int i = 0; i < size * size; ++i)
                      largest = std::max(largest, in.at(c, 2 * y + i / size, 2 * x + i % size));
                    return largest;
                  });
}

Map convolved(const Map& in, const Convolution& layer, const std::vector<float>& filters,
              const std::vector<float>& biases) {
  return make_map(
      layer.side_of(in.width), layer.side_of(in.height), layer.outputs, [&](int c, int y, int x) {
        double sum = static_cast<double>(biases[static_cast<std::size_t>(c)]);
        auto filter = filters.begin() + c * layer.inputs * layer.size * layer.size;
        for (int i = 0; i < layer.inputs; ++i) {
          for (int dy = 0; dy < layer.size; ++dy) {
            for (int dx = 0; dx < layer.size; ++dx) {
              sum +=
                  static_cast<double>(*filter++) * in.at(i, y * layer.stride - layer.padding + dy,
                                                         x * layer.stride - layer.padding + dx);
            }
          }
        }
        return std::max(sum, 0.0);
      });
}

std::vector<Map> compared_maps(const Image& image, const Weights& weights) {
  constexpr double kShift[] = {-.030, -.088, -.188}, kScale[] = {.458, .448, .450};
  Map map = make_map(image.width, image.height, 3, [&](int c, int y, int x) {
    return (static_cast<double>(image.at(x, y, c)) - kShift[c]) / kScale[c];
  });
  std::vector<Map> maps;
  for (std::size_t i = 0; i < weights.filters.size(); ++i) {
    const Convolution& layer = weights.network->convolutions[i];
    if (layer.pooled_before) map = pooled(map, weights.network->pool_size);
    map = convolved(map, layer, weights.filters[i], weights.biases[i]);
    if (layer.compared) maps.push_back(map);
  }
  return maps;
}

double length(const Map& map, int y, int x) {
  double sum = 0;
  for (int c = 0; c < map.channels; ++c) sum += map.at(c, y, x) * map.at(c, y, x);
  return std::sqrt(sum) + 1e-10;
}

double distance_by_definition(const Image& a, const Image& b, const Weights& weights) {
  const std::vector<Map> of_a = compared_maps(a, weights), of_b = compared_maps(b, weights);
  double distance = 0;
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    const Map &f = of_a[i], &g = of_b[i];
    for (int y = 0; y < f.height; ++y) {
      for (int x = 0; x < f.width; ++x) {
        const double of_f = length(f, y, x), of_g = length(g, y, x);
        for (int c = 0; c < f.channels; ++c) {
          const double difference = f.at(c, y, x) / of_f - g.at(c, y, x) / of_g;
          distance += static_cast<double>(weights.linear[i][static_cast<std::size_t>(c)]) *
                      difference * difference / (f.width * f.height);
        }
      }
    }
  }
  return distance;
}

TEST(Lpips, pictures_of_any_size_have_the_distance_of_the_definition) {
  const Weights weights = test::golden_weights(kSmall);
  const Metric metric(weights);
  const int smallest = smallest_side(kSmall);
  // Bands of rows end within filters and pools; rows end with every number of pixels.
  for (const auto& [width, height] : {std::pair{smallest, smallest},
                                      {smallest, 200},
                                      {61, 64},
                                      {62, 65},
                                      {33, 129},
                                      {47, 131},
                                      {90, 66}}) {
    const auto [a, b] = test::golden_pictures(width, height);
    const double expected = distance_by_definition(a, b, weights);
    EXPECT_NEAR(metric.distance(a, b, InputRange::unit, test::pool()), expected, 1e-6 * expected)
        << width << " x " << height;
  }
}

TEST(Lpips, the_number_of_threads_changes_no_bit) {
  const Metric metric(test::golden_weights(kSmall));
  const auto [a, b] = test::golden_pictures(70, 150);
  ThreadPool one(1), five(5);
  EXPECT_EQ(metric.distance(a, b, InputRange::unit, one),
            metric.distance(a, b, InputRange::unit, five));
}

TEST(Lpips, equal_pictures_have_no_distance_and_their_order_does_not_matter) {
  const Metric metric(test::golden_weights(kSmall));
  const auto [a, b] = test::golden_pictures(40, 30);
  EXPECT_EQ(metric.distance(a, a, InputRange::symmetric, test::pool()), 0);
  EXPECT_EQ(metric.distance(a, b, InputRange::symmetric, test::pool()),
            metric.distance(b, a, InputRange::symmetric, test::pool()));
  const Image black(40, 30, 3);
  EXPECT_EQ(metric.distance(black, black, InputRange::unit, test::pool()), 0);
}

TEST(Lpips, the_comparison_can_be_cancelled) {
  const Metric metric(test::golden_weights(kSmall));
  const auto [a, b] = test::golden_pictures(40, 200);
  std::stop_source stop;
  const Progress progress{[&](float done) {
                            if (done > 0.5f) stop.request_stop();
                          },
                          stop.get_token()};
  EXPECT_THROW(metric.distance(a, b, InputRange::unit, test::pool(), progress), Cancelled);
}

}  // namespace
}  // namespace qs
