// SPDX-License-Identifier: MIT
// Photographs that do not fit into memory are read again, and the result is the same.
#include "learn/run/photograph_cache.h"

#include <chrono>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/training.h"
#include "io/picture/image_file.h"
#include "learn/run/trainer.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/temporary_folder.h"

namespace qs::train {
namespace {

using test::error_of;
using test::pool;

constexpr std::uint64_t kPhotograph = 64 * 48 * 3;  // bytes

class Photos : public testing::Test {
 protected:
  // 16 views, 12 for training.
  void SetUp() override {
    test::write_data_set(test::data_set_of(test::ball_of_gaussians(200, 1), 16), folder_.path());
  }
  DataSet read(std::uint64_t photographs) const {
    DataOptions options;
    options.data = folder_.path();
    options.holdout = 4;
    options.photo_memory = photographs * kPhotograph;
    return read_data_set(options, pool());
  }
  TemporaryFolder folder_;
};

TEST_F(Photos, are_kept_if_all_fit_together) {
  const DataSet all = read(16), some = read(15);
  EXPECT_FALSE(all.on_disk());
  EXPECT_TRUE(some.on_disk());
  for (const auto* views : {&some.training, &some.test}) {
    for (const PhotographView& view : *views) EXPECT_FALSE(view.has_pixels());
  }
  EXPECT_EQ(some.fingerprint(), all.fingerprint());
  PhotographCache cache(all);
  EXPECT_EQ(&cache.view(all.training[3], {}), &all.training[3]);
  EXPECT_EQ(cache.reads(), 0u);
}

TEST_F(Photos, read_again_have_the_same_pixels) {
  const DataSet all = read(16), some = read(2);
  PhotographCache cache(some);
  for (std::size_t i = 0; i < some.training.size(); ++i) {
    const PhotographView& view = cache.view(some.training[i], {});
    EXPECT_EQ(view.rgb, all.training[i].rgb);
    EXPECT_EQ(view.camera.view_from_world, all.training[i].camera.view_from_world);
  }
}

TEST_F(Photos, least_recently_used_make_room) {
  const DataSet data = read(3);
  PhotographCache cache(data);
  const auto reads_of = [&](std::size_t view) {
    const std::size_t before = cache.reads();
    cache.view(data.training[view], {});
    return cache.reads() - before;
  };
  for (const std::size_t view : {0u, 1u, 2u}) EXPECT_EQ(reads_of(view), 1u);
  EXPECT_EQ(reads_of(0), 0u);
  EXPECT_EQ(reads_of(3), 1u) << "in the place of 1";
  for (const std::size_t view : {0u, 2u, 3u}) EXPECT_EQ(reads_of(view), 0u) << view;
  EXPECT_EQ(reads_of(1), 1u) << "in the place of 0";
  EXPECT_EQ(reads_of(3), 0u);
}

TEST_F(Photos, are_read_ahead_as_far_as_there_is_room) {
  const DataSet data = read(3);
  PhotographCache cache(data);
  const PhotographView* const next[] = {&data.training[1], &data.training[2], &data.training[3]};
  cache.view(data.training[0], next);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (cache.reads() < 3 && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(cache.reads(), 3u);
  cache.view(data.training[1], {});
  cache.view(data.training[2], {});
  EXPECT_EQ(cache.reads(), 3u);
}

TEST_F(Photos, two_find_room_in_any_limit) {
  DataSet data = read(1);
  data.photo_memory = 1;
  PhotographCache cache(data);
  const PhotographView* const next = &data.training[1];
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(cache.view(data.training[0], {&next, 1}).rgb.size(), kPhotograph);
    EXPECT_EQ(cache.view(data.training[1], {}).rgb.size(), kPhotograph);
  }
}

TEST_F(Photos, that_were_changed_or_removed_are_errors) {
  const DataSet data = read(2);
  PhotographCache cache(data);
  const std::filesystem::path changed = data.training[0].source.file;
  const std::filesystem::path removed = data.training[1].source.file;
  write_image(Image(64, 48, 3), changed);
  std::filesystem::remove(removed);
  const PhotographView* const next = &data.training[1];
  EXPECT_EQ(error_of(
                [&] {
                  cache.view(data.training[0], {&next, 1});
                },
                folder_.path()),
            changed.lexically_relative(folder_.path()).string() +
                ": was changed while it was trained from");
  EXPECT_EQ(error_of([&] { cache.view(data.training[1], {}); }, folder_.path()),
            removed.lexically_relative(folder_.path()).string() + ": no such file");
  EXPECT_TRUE(cache.view(data.training[2], {}).has_pixels());
}

TEST_F(Photos, model_is_the_same_to_the_bit_if_2_of_12_fit) {
  const DataSet all = read(16), two = read(2);
  ASSERT_TRUE(two.on_disk());
  ASSERT_EQ(two.training.size(), 12u);
  TrainSettings settings;
  settings.sh_degree = 0;
  settings.strategy = "fastgs";  // draws further views, before iteration 1001
  settings.many_gaussians = true;
  const auto trained = [&](const DataSet& data) {
    ModelState model =
        ModelState::starting_with(test::perturbed(test::ball_of_gaussians(200, 1), 2));
    model.iteration = 980;
    Trainer trainer = test::trainer_on(Backend::cpu, settings, data, std::move(model));
    for (int i = 0; i < 30; ++i) trainer.step();
    EXPECT_GT(trainer.gaussians(), 200u);
    const std::optional<Quality> quality = trainer.test_quality();
    trainer.step();
    return std::pair(trainer.model(), quality);
  };
  const auto [a, a_quality] = trained(all);
  const auto [b, b_quality] = trained(two);
  EXPECT_EQ(a_quality->psnr, b_quality->psnr);
  EXPECT_EQ(a_quality->ssim, b_quality->ssim);
  test::expect_same(a, b);
}

}  // namespace
}  // namespace qs::train
