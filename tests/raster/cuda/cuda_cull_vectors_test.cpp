// SPDX-License-Identifier: MIT
// Every mode passes the test vectors in device code too: the header-only package is for both.
#include "support/cull_vectors.h"
#include "support/gpu.h"
#include "support/tiles_on_gpu.h"

namespace qs {
namespace {

class CudaCullVectors : public test::GpuTest {};

TEST_F(CudaCullVectors, are_passed_by_every_mode) {
  const test::CullVectors vectors = test::read_cull_vectors();
  for (CullMode mode = 1; mode <= mode_count(); ++mode) {
    const std::string& map = vectors.map_of_mode.at(mode_name(mode));
    const std::vector<std::set<int>> listed = test::tiles_on_gpu(mode, vectors.all);
    for (std::size_t i = 0; i < listed.size(); ++i) {
      EXPECT_EQ(vectors.all[i].maps.at(map).fault_of(listed[i]), "")
          << mode_name(mode) << " " << vectors.all[i].name;
    }
  }
}

}  // namespace
}  // namespace qs
