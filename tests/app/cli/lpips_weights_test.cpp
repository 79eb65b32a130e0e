// SPDX-License-Identifier: MIT
// scripts/lpips_weights as users run it, on files in PyTorch's formats with weights made by a rule.
#include "support/lpips_weights.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/run_program.h"
#include "io/tensor/tensor.h"
#include "support/paths.h"
#include "support/safetensors.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::ProgramRun;

class LpipsWeights : public testing::Test {
 protected:
  void SetUp() override {
    if (test::run_program("python3", {"--version"}).exit_code == 127)
      GTEST_SKIP() << "python3 is not installed";
    test::write_lpips_weights(test::golden_weights(lpips::kNetworks[1]),
                              folder_ / "in.safetensors");
    const ProgramRun run =
        test::run_program("python3", {test::source_path("tests/support/make_pth.py").string(),
                                      path("in.safetensors"), folder_.path().string()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  ProgramRun convert(const std::string& features, const std::string& linear,
                     const std::string& out = "out.safetensors") const {
    return test::run_program("python3", {test::source_path("scripts/lpips_weights").string(),
                                         path(features), path(linear), path(out)});
  }

  void expect_refused(const ProgramRun& run, const std::string& sentence) const {
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(run.err, "lpips_weights: " + sentence + "\n");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.safetensors"));
  }

  TemporaryFolder folder_;
};

TEST_F(LpipsWeights, are_the_tensors_of_both_of_pytorch_s_formats) {
  const TensorFile expected = read_safetensors(folder_ / "in.safetensors");
  for (const std::string format : {"old", "zip"}) {
    const ProgramRun run = convert(format + "_features.pth", format + "_linear.pth");
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.out, "lpips_weights: alexnet, 15 tensors, in " + path("out.safetensors") + "\n");
    const TensorFile file = read_safetensors(folder_ / "out.safetensors");
    EXPECT_EQ(file.metadata, expected.metadata);
    ASSERT_EQ(file.tensors.size(), expected.tensors.size());
    for (const auto& [name, tensor] : expected.tensors) {
      EXPECT_EQ(file.tensors.at(name).shape, tensor.shape) << name;
      EXPECT_EQ(file.tensors.at(name).values, tensor.values) << name;
    }
  }
}

TEST_F(LpipsWeights, other_files_are_refused_and_no_code_of_theirs_runs) {
  expect_refused(convert("evil.pth", "zip_linear.pth"),
                 path("evil.pth") + ": names __builtin__.print, which no file of weights needs");
  expect_refused(convert("zip_linear.pth", "zip_linear.pth"),
                 path("zip_linear.pth") + ": is neither VGG16 nor AlexNet of torchvision");
  expect_refused(convert("zip_features.pth", "old_features.pth"),
                 path("old_features.pth") + ": has no tensor lin0.model.1.weight");
  expect_refused(convert("nowhere.pth", "zip_linear.pth"),
                 path("nowhere.pth") + ": No such file or directory");
  expect_refused(convert("in.safetensors", "zip_linear.pth"),
                 path("in.safetensors") + ": is damaged or no file of PyTorch (UnpicklingError)");
  const auto old = folder_ / "old_features.pth";
  std::filesystem::copy(old, folder_ / "alexnet-00000000.pth");
  EXPECT_THAT(convert("alexnet-00000000.pth", "old_linear.pth").err,
              testing::HasSubstr("is damaged: its SHA-256 begins with"));
  std::filesystem::resize_file(old, std::filesystem::file_size(old) - 1);
  expect_refused(convert("old_features.pth", "old_linear.pth"), old.string() + ": is cut off");
  EXPECT_EQ(convert("zip_features.pth", "zip_linear.pth", "zip_linear.pth").err,
            "lpips_weights: " + path("zip_linear.pth") + ": is also read\n");
}

}  // namespace
}  // namespace qs
