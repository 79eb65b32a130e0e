// SPDX-License-Identifier: MIT
// Checkpoints that end early or were changed.
#include <filesystem>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/training.h"
#include "base/error.h"
#include "learn/run/model_folder.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs::train {
namespace {

constexpr std::size_t kStored = 5;

struct Kind {
  bool masks, absolute, sums;
};

ModelState model_of(const Kind& kind) {
  Parameters parameters = test::ball_of_gaussians(kStored, 1);
  parameters.has_masks = kind.masks;
  parameters.mask_logits.resize(kind.masks ? parameters.size() : 0, 0.5f);
  ModelState model = ModelState::starting_with(std::move(parameters));
  if (kind.absolute) model.density.absolute.resize(model.size());
  if (kind.sums) {
    model.summed.resize_like(model.parameters);
    model.summed.resize(model.size());
  }
  return model;
}

// The size is compared before the arrays are allocated. So a file without the last byte of an array
// gives the same sentence as one that claims too many Gaussians.
TEST(Checkpoint, a_shorter_file_is_refused_and_its_arrays_are_counted_to_the_byte) {
  for (const Kind& kind : {Kind{false, false, false}, Kind{true, false, false},
                           Kind{false, true, false}, Kind{true, true, true}}) {
    const TemporaryFolder folder;
    const ModelState model = model_of(kind);
    write_checkpoint({{}, "data", {}, model}, folder / "whole");
    test::expect_same(read_checkpoint(folder / "whole").model, model);

    const std::uintmax_t bytes = std::filesystem::file_size(folder / "whole");
    const std::uintmax_t values =
        (kind.sums ? 4 : 3) *
            (11 + (kind.masks ? 1 : 0) + 3 * std::uintmax_t{model.parameters.sh_stride()}) +
        (kind.absolute ? 3 : 2);
    const std::uintmax_t arrays = 4 * values * model.size(), hash = 8;
    std::set<std::uintmax_t> cuts{bytes - hash - arrays - 1, bytes - hash - arrays,
                                  bytes - hash - 1, bytes - hash, bytes - 1};
    for (std::uintmax_t kept = 0; kept < bytes; kept += 17) cuts.insert(kept);
    for (const std::uintmax_t kept : cuts) {
      std::filesystem::copy_file(folder / "whole", folder / "short",
                                 std::filesystem::copy_options::overwrite_existing);
      std::filesystem::resize_file(folder / "short", kept);
      const std::string message = test::error_of([&] { read_checkpoint(folder / "short"); });
      ASSERT_NE(message, "") << kept << " of " << bytes;
      const bool header_is_whole = kept + hash + arrays >= bytes;
      const bool arrays_are_whole = kept + hash >= bytes;
      EXPECT_EQ(message.find("cut off: 5 Gaussians do not fit into") != std::string::npos,
                header_is_whole && !arrays_are_whole)
          << kept << " of " << bytes << ": " << message;
    }
  }
}

}  // namespace
}  // namespace qs::train
