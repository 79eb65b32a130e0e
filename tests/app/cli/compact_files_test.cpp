// SPDX-License-Identifier: MIT
//
// PyTorch and NumPy open the models of Compact-3DGS that this program writes.
#include <gtest/gtest.h>

#include "app/support/run_program.h"
#include "support/compact_models.h"
#include "support/shared.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

TEST(CompactFiles, are_opened_by_pytorch_and_numpy) {
  std::string python;
  for (const char* candidate : {"python3", "/usr/bin/python3"}) {
    if (run_program(candidate, {"-c", "import torch, numpy"}).exit_code == 0) python = candidate;
  }
  if (python.empty()) GTEST_SKIP() << "python3 has no torch: files were not opened by PyTorch";
  const TemporaryFolder folder;
  for (const std::size_t count : {1, 50}) {
    const SavedModel saved = saved_model(count);
    const std::string base = (folder / "point_cloud").string();
    write_compact_ply(saved.model, base + ".ply");
    write_compact_npz(saved.model, saved.scales, saved.rotations, base + ".npz");
    write_compact_processed(saved.model, saved.scales, saved.rotations, base + "_pp.npz");
    const ProgramRun run =
        run_program(python, {source_path("tests/support/check_compact.py").string(), base});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.out, std::to_string(count) + "\n");
  }
}

}  // namespace
}  // namespace qs::test
