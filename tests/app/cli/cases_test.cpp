// SPDX-License-Identifier: MIT
// Data sets after public bug reports, as users train from them: ../shared/cases, with the PSNR that
// the same set reaches without its fault, or the sentence about it.
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/run_program.h"
#include "base/text.h"
#include "support/paths.h"
#include "support/shared.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::ProgramRun;
using testing::HasSubstr;

struct CaseRow {
  const char* name;
  const char* options;
  double psnr;           // dB of the test views after 150 iterations; 0: not compared
  const char* sentence;  // a part of the output
};

constexpr double kTolerance = 0.3;  // dB

const CaseRow kCases[] = {
    {"01_undistorter_layout", "--iterations 150", 18.67, "9 of 9 cameras in"},
    {"02_transforms_subfolders", "--iterations 20 --random-points 500 --holdout 0", 0,
     "9 of 9 cameras in"},
    {"04_mask_path", "--iterations 150 --random-points 800", 18.53,
     "9 masks as transforms.json names them"},
    {"05_ply_file_path", "--iterations 150", 18.67, "800 points of"},
    // Their photographs have other names, so two others are the test views: the same pictures in
    // plain folders, named with slashes, reach 19.40.
    {"09_linked_subfolder", "--iterations 150", 19.40, "9 of 9 cameras in"},
    {"10_backslash_colmap", "--iterations 150", 19.40, "9 of 9 cameras in"},
    {"11_bom", "--iterations 20 --random-points 500 --holdout 0", 0, "4 of 4 cameras in"},
    {"12_case_differs", "--iterations 20 --random-points 500 --holdout 0", 0, "4 of 4 cameras in"},
    {"13_two_submodels", "--iterations 150", 18.67, "sparse/1 is the largest of 2 COLMAP models"},
    {"14_no_extension_jpg", "--iterations 20 --random-points 500 --holdout 0", 0,
     "4 of 4 cameras in"},
    {"18_json_nan", "--iterations 20 --random-points 500 --holdout 0", 0, "is NaN ("},
};

// The number before " dB" in the line about the test views.
double psnr_of(const std::string& output) {
  const std::size_t at = output.rfind("PSNR ");
  return at == output.npos ? 0 : std::strtod(output.c_str() + at + 5, nullptr);
}

// A link that a copy made a text is a link again.
void restore_links(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder)) return;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.file_size() > 100) continue;
    const std::string target = test::content_of(entry.path());
    if (!std::filesystem::is_directory(folder / target)) continue;
    std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
    std::filesystem::remove(entry.path());
    std::filesystem::create_directory_symlink(target, entry.path());
  }
}

class Cases : public testing::TestWithParam<CaseRow> {};

TEST_P(Cases, train_as_expected) {
  const CaseRow& row = GetParam();
  const std::string data = std::string("cases/") + row.name;
  QS_NEEDS_SHARED(data);
  const TemporaryFolder folder;
  std::filesystem::copy(test::shared_path(data), folder / "data",
                        std::filesystem::copy_options::recursive);
  restore_links(folder / "data/images");
  std::vector<std::string> words = {"train",      (folder / "data").string(),
                                    "--out-dir",  (folder / "model").string(),
                                    "--backend",  "cpu",
                                    "--strategy", "adc"};  // as expected PSNR was found
  for (const std::string& word : separated(row.options, ' ')) words.push_back(word);
  const ProgramRun run = test::run_quadsplat(words);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out + run.err, HasSubstr(row.sentence));
  if (row.psnr > 0) {
    EXPECT_NEAR(psnr_of(run.out + run.err), row.psnr, kTolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, Cases, testing::ValuesIn(kCases),
                         [](const auto& row) { return std::string(row.param.name); });

ProgramRun eval_of(const std::string& name) {
  return test::run_quadsplat({"eval", test::source_path("assets/plush.ply").string(), "--backend",
                              "cpu", "--cull", "quadbox", "--cameras",
                              test::shared_path("cases/" + name + "/transforms.json").string(),
                              "--images", test::shared_path("cases/" + name + "/images").string()});
}

TEST(Cases, photographs_in_subfolders_are_those_that_the_file_names) {
  QS_NEEDS_SHARED("cases/02_transforms_subfolders");
  const ProgramRun run = eval_of("02_transforms_subfolders");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("27.99")) << "dB, the mean";
}

TEST(Cases, photographs_of_a_fisheye_lens_are_undistorted) {
  QS_NEEDS_SHARED("cases/03_is_fisheye");
  const ProgramRun run = eval_of("03_is_fisheye");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("(OPENCV_FISHEYE, undistorted, "));
  // CASE.md: about 28 dB, and 17.83 dB as pinhole pictures.
  const std::size_t at = run.out.rfind("quadbox");
  ASSERT_NE(at, run.out.npos) << run.out;
  EXPECT_NEAR(std::strtod(run.out.c_str() + at + 7, nullptr), 28, 0.5) << run.out;
}

}  // namespace
}  // namespace qs
