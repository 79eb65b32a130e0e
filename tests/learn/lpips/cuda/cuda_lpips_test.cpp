// SPDX-License-Identifier: MIT
// LPIPS on the GPU against the golden values and the CPU.
#include "learn/lpips/cuda/gpu_metric.h"
#include "support/all_combinations.h"
#include "support/gpu.h"
#include "support/lpips_weights.h"

namespace qs::cuda::lpips {
namespace {

using qs::lpips::Convolution;
using qs::lpips::InputRange;

class CudaLpips : public test::GpuTest {};

TEST_F(CudaLpips, the_distance_is_the_published_one) {
  if (!test::kAllCombinations) {
    QS_NEEDS_REAL_GPU("whole networks take minutes; LpipsGolden has the same numbers on the CPU");
  }
  GpuMetric vgg16(test::golden_weights(qs::lpips::kNetworks[0]), 0);
  const auto [a, b] = test::golden_pictures(40, 32);
  EXPECT_NEAR(vgg16.distance(a, b, InputRange::unit), 1.175212379, 1.2e-6);
  EXPECT_NEAR(vgg16.distance(a, b, InputRange::symmetric), 1.403834518, 1.4e-6);
  GpuMetric alexnet(test::golden_weights(qs::lpips::kNetworks[1]), 0);
  const auto [c, d] = test::golden_pictures(72, 64);
  EXPECT_NEAR(alexnet.distance(c, d, InputRange::unit), 2.447580940, 2.4e-6);
  EXPECT_NEAR(alexnet.distance(c, d, InputRange::symmetric), 3.623819468, 3.6e-6);
}

// Its outputs do not fill a tile, and its inputs no step.
constexpr std::array<Convolution, 3> kSmallLayers = {{{0, 3, 32, 5, 2, 1, false, true},
                                                      {1, 32, 96, 3, 1, 1, true, false},
                                                      {2, 96, 32, 3, 1, 1, false, true}}};
constexpr qs::lpips::Network kSmall = {"small", 3, kSmallLayers};

TEST_F(CudaLpips, pictures_of_any_size_have_the_distance_of_the_cpu_also_one_after_another) {
  const qs::lpips::Weights weights = test::golden_weights(kSmall);
  GpuMetric metric(weights, 0);
  const qs::lpips::Metric cpu(weights);
  const int smallest = qs::lpips::smallest_side(kSmall);
  for (const auto& [width, height] :
       {std::pair{61, 64}, {smallest, smallest}, {33, 70}, {90, 13}}) {
    const auto [a, b] = test::golden_pictures(width, height);
    const double expected = cpu.distance(a, b, InputRange::unit, test::pool());
    EXPECT_NEAR(metric.distance(a, b, InputRange::unit), expected, 1e-6 * expected)
        << width << " x " << height;
    EXPECT_EQ(metric.distance(a, a, InputRange::unit), 0);
  }
}

}  // namespace
}  // namespace qs::cuda::lpips
