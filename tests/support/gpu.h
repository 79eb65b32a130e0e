// SPDX-License-Identifier: MIT
//
// Base classes and comparisons for tests of the CUDA backend. They skip with the reason if no GPU
// can be used. The same tests also run on the emulated GPU of raster/emulator; a test that needs a
// real GPU declares it with QS_NEEDS_REAL_GPU.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "raster/api/renderer.h"
#include "support/all_combinations.h"
#include "support/pool.h"

namespace qs::test {

class GpuTest : public testing::Test {
 protected:
  void SetUp() override {
    const std::string problem = gpu_report().problem;
    if (!problem.empty()) GTEST_SKIP() << "no GPU: " << problem;
  }

  static std::unique_ptr<Renderer> renderer_of(Backend backend, const GaussianCloud& cloud) {
    auto renderer = make_renderer(backend, pool());
    renderer->upload(cloud, {});
    return renderer;
  }
};

/// True in the program that runs the kernels on raster/emulator.
inline bool gpu_is_emulated() {
  const GpuReport report = gpu_report();
  return !report.gpus.empty() && report.gpus[0].name == "emulator";
}

/// A test that runs once per pipeline.
class PipelineTest : public GpuTest, public testing::WithParamInterface<Pipeline> {
 protected:
  static RenderSettings settings_of_pipeline() {
    RenderSettings settings;
    settings.pipeline = GetParam();
    return settings;
  }
};

inline const auto kPipelines = testing::Values(Pipeline::classic, Pipeline::fast);

inline std::string name_of_pipeline(const testing::TestParamInfo<Pipeline>& info) {
  return kPipelineNames[static_cast<int>(info.param)];
}

/// The first difference of two traces, compared bit for bit: footprints, depths, tile lists. "" if
/// they are equal.
inline std::string difference(const Trace& a, const Trace& b) {
  const auto equal_bits = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0);
  };
  if (!equal_bits(a.gaussians, b.gaussians)) return "the visible Gaussians";
  if (!equal_bits(a.footprints, b.footprints)) return "the footprints";
  if (!equal_bits(a.depths, b.depths)) return "the depths";
  if (!equal_bits(a.tile_begin, b.tile_begin)) return "the lengths of the tile lists";
  if (!equal_bits(a.listed, b.listed)) return "the tile lists";
  return "";
}

/// Outputs for the decisions of preprocessing, binning and sorting; nothing is blended.
inline Outputs decisions() {
  Outputs outputs;
  outputs.color = false;
  outputs.pairs = outputs.trace = true;
  return outputs;
}

/// Compares two frames of decisions() or more, bit for bit.
inline void expect_equal_decisions(const Frame& frame, const Frame& expected) {
  EXPECT_EQ(difference(frame.trace, expected.trace), "");
  EXPECT_EQ(frame.pairs, expected.pairs);
  EXPECT_EQ(frame.stats.visible, expected.stats.visible);
  EXPECT_EQ(frame.stats.tile_pairs, expected.stats.tile_pairs);
  EXPECT_EQ(frame.stats.max_pairs_in_a_tile, expected.stats.max_pairs_in_a_tile);
}

/// Fraction of the values that differ by more than `tolerance`, 0..1.
inline double share_beyond(const Image& a, const Image& b, double tolerance) {
  EXPECT_EQ(a.values.size(), b.values.size());
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double d = static_cast<double>(a.values[i]) - static_cast<double>(b.values[i]);
    if (!(std::abs(d) <= tolerance)) ++beyond;
  }
  return static_cast<double>(beyond) /
         static_cast<double>(std::max<std::size_t>(1, a.values.size()));
}

/// The tolerance for images of other backends and pipelines.
inline void expect_same_image(const Image& gpu, const Image& cpu) {
  EXPECT_LE(share_beyond(gpu, cpu, 1.0 / 255), 1e-4);
  EXPECT_GE(psnr_8bit(gpu, cpu), 80.0);
}

/// All modes except reference, which runs on the CPU only.
inline std::vector<CullMode> tiled_modes() {
  std::vector<CullMode> modes;
  for (CullMode mode = 1; mode <= culler_count(); ++mode) modes.push_back(mode);
  return modes;
}

}  // namespace qs::test

/// Skips the running test on the emulated GPU, with the reason why it needs a real GPU.
#define QS_NEEDS_REAL_GPU(reason) \
  if (qs::test::gpu_is_emulated()) GTEST_SKIP() << "needs a real GPU: " << (reason)

/// Skips the running test, which takes long on the emulated GPU, with every push.
#define QS_EMULATED_BEFORE_A_RELEASE()                            \
  if (qs::test::gpu_is_emulated() && !qs::test::kAllCombinations) \
  GTEST_SKIP() << "takes long on the emulated GPU: scripts/test --all asan runs it"
