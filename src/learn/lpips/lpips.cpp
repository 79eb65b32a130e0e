// SPDX-License-Identifier: MIT
#include "learn/lpips/lpips.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <numeric>

#include "learn/lpips/convolve.h"

namespace qs::lpips {
namespace {

// Rows of the pictures that enter the network together. More rows read the filters of the deep
// layers less often and take more memory.
constexpr int kBandRows = 64;

// LPIPS's scaling of the input, by channel.
constexpr std::array<double, 3> kShift = {-.030, -.088, -.188}, kScale = {.458, .448, .450};

std::size_t index(int value) { return static_cast<std::size_t>(value); }

// The rows of a feature map that are needed at the moment. Channels of a pixel are interleaved, and
// every row has `margin` pixels of zeros on both sides.
struct FeatureRows {
  int width, height, channels, margin;
  std::size_t stride = index(width + 2 * margin) * index(channels);
  int begin = 0, end = 0;  ///< rows [0, end) were appended so far, rows before `begin` were dropped
  std::vector<float> values = {};

  /// The first value of pixel x = -margin.
  float* row(int y) { return values.data() + index(y - begin) * stride; }
  const float* row(int y) const { return const_cast<FeatureRows*>(this)->row(y); }

  /// The first value of pixel x = 0.
  float* pixels(int y) { return row(y) + index(margin * channels); }

  void append(int rows) {
    end += rows;
    values.resize(index(end - begin) * stride);
  }

  void drop_before(int y) {
    const int first = std::clamp(y, begin, end);
    values.erase(values.begin(),
                 values.begin() + static_cast<std::ptrdiff_t>(index(first - begin) * stride));
    begin = first;
  }
};

// A convolution or a maximum pool.
struct Layer {
  const Convolution* convolution = nullptr;  ///< null: a pool
  std::size_t number = 0;                    ///< number of the convolution in the network
  int size, stride, padding;

  int side_of(int side) const { return (side + 2 * padding - size) / stride + 1; }
};

std::vector<Layer> layers_of(const Network& network) {
  std::vector<Layer> layers;
  for (const Convolution& convolution : network.convolutions) {
    if (convolution.pooled_before)
      layers.push_back({nullptr, 0, network.pool_size, kPoolStride, 0});
    const auto number = static_cast<std::size_t>(&convolution - network.convolutions.data());
    layers.push_back(
        {&convolution, number, convolution.size, convolution.stride, convolution.padding});
  }
  return layers;
}

// Calls body(i) for all i. Few chunks, so that a thread keeps the filters of a block in its cache.
template <class Body>
void in_parallel(ThreadPool& pool, std::size_t count, const Body& body) {
  const std::size_t chunks = 4 * static_cast<std::size_t>(pool.size());
  pool.for_each(count, (count + chunks - 1) / chunks, body);
}

// Passes both pictures through the network, a band of rows at a time.
class Comparison {
 public:
  // `packed` has its filters as pack() returns them.
  Comparison(const std::array<const Image*, 2>& images, const Weights& packed, ThreadPool& pool)
      : images_(images), packed_(packed), pool_(pool), layers_(layers_of(*packed.network)) {
    int width = images[0]->width, height = images[0]->height, channels = images[0]->channels;
    for (std::size_t i = 0; i <= layers_.size(); ++i) {
      const int margin = i < layers_.size() ? layers_[i].padding : 0;
      for (auto& maps : maps_) maps.push_back({width, height, channels, margin});
      if (i == layers_.size()) break;
      width = layers_[i].side_of(width);
      height = layers_[i].side_of(height);
      if (layers_[i].convolution != nullptr) channels = layers_[i].convolution->outputs;
    }
  }

  double run(InputRange range, const Progress& progress) {
    const int height = images_[0]->height;
    for (int y = 0; y < height; y += kBandRows) {
      progress.update(static_cast<float>(y) / static_cast<float>(height));
      enter(std::min(kBandRows, height - y), range);
      std::size_t compared = 0;
      for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
        const int first = maps_[0][layer + 1].end;
        advance(layer);
        if (layers_[layer].convolution != nullptr && layers_[layer].convolution->compared)
          compare(layer + 1, first, compared++);
      }
      for (auto& maps : maps_) maps.back().drop_before(maps.back().end);
    }
    return std::accumulate(sums_.begin(), sums_.end(), 0.0);
  }

 private:
  // Appends rows of the pictures, scaled as the network takes them.
  void enter(int rows, InputRange range) {
    for (std::size_t side = 0; side < 2; ++side) {
      FeatureRows& map = maps_[side].front();
      const int first = map.end;
      map.append(rows);
      for (int y = first; y < map.end; ++y) {
        const float* const in = images_[side]->row(y);
        float* const out = map.pixels(y);
        for (std::size_t i = 0; i < index(map.width) * 3; ++i) {
          const double unit = static_cast<double>(in[i]);
          const double value = range == InputRange::unit ? unit : 2 * unit - 1;
          out[i] = static_cast<float>((value - kShift[i % 3]) / kScale[i % 3]);
        }
      }
    }
  }

  // Computes all rows behind a layer whose inputs exist already, and drops inputs that are not
  // needed any more.
  void advance(std::size_t number) {
    const Layer& layer = layers_[number];
    const FeatureRows& input = maps_[0][number];
    const FeatureRows& output = maps_[0][number + 1];
    const int first = output.end;
    int end = output.height;
    if (input.end < input.height) {
      const int last_begin = input.end - layer.size + layer.padding;  // of an output's filter
      end = last_begin < 0 ? 0 : std::min(end, last_begin / layer.stride + 1);
    }
    if (end <= first) return;
    for (auto& maps : maps_) maps[number + 1].append(end - first);
    if (layer.convolution != nullptr) {
      convolve_rows(number, first, end);
    } else {
      pool_rows(number, first, end);
    }
    for (auto& maps : maps_) maps[number].drop_before(end * layer.stride - layer.padding);
  }

  void convolve_rows(std::size_t number, int first, int end) {
    const Layer& layer = layers_[number];
    const std::size_t rows = index(end - first), inputs = index(layer.convolution->inputs);
    const std::size_t run = index(layer.size) * inputs;
    const std::size_t blocks = index(layer.convolution->outputs) / kBlock;
    in_parallel(pool_, blocks * 2 * rows, [&](std::size_t i) {
      const std::size_t block = i / (2 * rows), side = i / rows % 2;
      const int y = first + static_cast<int>(i % rows);
      const FeatureRows& input = maps_[side][number];
      FeatureRows& output = maps_[side][number + 1];
      std::array<const float*, 16> filter_rows{};
      assert(index(layer.size) <= filter_rows.size());
      for (int row = 0; row < layer.size; ++row) {
        const int from = y * layer.stride - layer.padding + row;
        if (from >= 0 && from < input.height) filter_rows[index(row)] = input.row(from);
      }
      convolve({filter_rows.data(), layer.size, run, index(layer.stride) * inputs,
                packed_.filters[layer.number].data() + block * index(layer.size) * run * kBlock,
                packed_.biases[layer.number].data() + block * kBlock, output.width,
                output.pixels(y) + block * kBlock, index(output.channels)});
    });
  }

  void pool_rows(std::size_t number, int first, int end) {
    const Layer& layer = layers_[number];
    const std::size_t rows = index(end - first);
    in_parallel(pool_, 2 * rows, [&](std::size_t i) {
      const int y = first + static_cast<int>(i % rows);
      const FeatureRows& input = maps_[i / rows][number];
      FeatureRows& output = maps_[i / rows][number + 1];
      const std::size_t channels = index(input.channels);
      for (int x = 0; x < output.width; ++x) {
        float* const out = output.pixels(y) + index(x) * channels;
        for (int row = 0; row < layer.size; ++row) {
          const float* in = input.row(y * layer.stride + row) + index(x * layer.stride) * channels;
          for (int column = 0; column < layer.size; ++column, in += channels) {
            if (row == 0 && column == 0) {
              std::copy_n(in, channels, out);
            } else {
              for (std::size_t c = 0; c < channels; ++c) out[c] = std::max(out[c], in[c]);
            }
          }
        }
      }
    });
  }

  // Adds the distance of the rows from `first` on.
  void compare(std::size_t map, int first, std::size_t compared) {
    FeatureRows &f = maps_[0][map], &g = maps_[1][map];
    const std::size_t rows = index(f.end - first);
    const double pixels = static_cast<double>(f.width) * static_cast<double>(f.height);
    std::vector<double> row_sums(rows);
    in_parallel(pool_, rows, [&](std::size_t i) {
      const int y = first + static_cast<int>(i);
      row_sums[i] = feature_distance(f.pixels(y), g.pixels(y), packed_.linear[compared].data(),
                                     f.width, index(f.channels));
    });
    sums_.resize(std::max(sums_.size(), compared + 1));
    for (const double sum : row_sums) sums_[compared] += sum / pixels;
  }

  std::array<const Image*, 2> images_;
  const Weights& packed_;
  ThreadPool& pool_;
  std::vector<Layer> layers_;
  std::array<std::vector<FeatureRows>, 2> maps_;  // in front of every layer, and behind the last
  std::vector<double> sums_;                      // by compared layer
};

}  // namespace

int smallest_side(const Network& network) {
  int side = 1;
  const std::vector<Layer> layers = layers_of(network);
  for (auto layer = layers.rbegin(); layer != layers.rend(); ++layer)
    side = std::max(1, (side - 1) * layer->stride + layer->size - 2 * layer->padding);
  return side;
}

std::vector<float> pack(const Convolution& convolution, const std::vector<float>& filters) {
  const std::size_t size = index(convolution.size), inputs = index(convolution.inputs);
  assert(filters.size() == index(convolution.outputs) * inputs * size * size);
  std::vector<float> packed(filters.size());
  std::size_t from = 0;
  for (std::size_t output = 0; output < index(convolution.outputs); ++output) {
    float* const block = packed.data() + output / kBlock * kBlock * size * size * inputs;
    for (std::size_t input = 0; input < inputs; ++input)
      for (std::size_t pixel = 0; pixel < size * size; ++pixel)
        block[(pixel * inputs + input) * kBlock + output % kBlock] = filters[from++];
  }
  return packed;
}

Metric::Metric(const Weights& weights) : packed_(weights) {
  for (std::size_t i = 0; i < weights.filters.size(); ++i)
    packed_.filters[i] = pack(network().convolutions[i], weights.filters[i]);
}

double Metric::distance(const Image& a, const Image& b, InputRange range, ThreadPool& pool,
                        const Progress& progress) const {
  assert(a.width == b.width && a.height == b.height && a.channels == 3 && b.channels == 3);
  assert(std::min(a.width, a.height) >= smallest_side(network()));
  return Comparison({&a, &b}, packed_, pool).run(range, progress);
}

}  // namespace qs::lpips
