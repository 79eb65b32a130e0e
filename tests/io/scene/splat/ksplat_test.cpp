// SPDX-License-Identifier: MIT
//
// .ksplat files built here from GaussianSplats3D's definition: every level and degree, several
// sections, full and partial buckets, and every limit with its message.
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <string>

#include <glm/gtc/packing.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/scene/splat/splat.h"
#include "support/corpus.h"
#include "support/error_of.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::size_t kHeader = 4096, kSectionHeader = 1024;

struct SectionPlan {
  std::uint32_t count, max_count;
  std::uint16_t degree;
  std::uint32_t bucket_size = 1, full_buckets = 0;
  std::vector<std::uint32_t> partial = {};  // rows of each
  float block_size = 5;
  std::uint32_t range = 0;   // 0 stands for 32767
  std::uint32_t unused = 1;  // buckets beyond the full and the partial ones
};

// A number for each field of each Gaussian.
double value_of(std::size_t gaussian, std::size_t field) {
  return static_cast<double>((gaussian * 37 + field * 11) % 64) / 64;
}
std::uint8_t byte_of(std::size_t gaussian, std::size_t field) {
  return static_cast<std::uint8_t>((gaussian * 53 + field * 29) % 254 + 1);
}

class Ksplat {
 public:
  Ksplat(std::uint16_t level, const std::vector<SectionPlan>& sections, std::uint32_t room) {
    std::uint32_t count = 0;
    for (const SectionPlan& section : sections) count += section.count;
    bytes_.resize(kHeader + room * kSectionHeader);
    set(1, std::uint8_t{1});
    set(4, room);
    set(8, static_cast<std::uint32_t>(sections.size()));
    set(12, count);
    set(16, count);
    set(20, level);
    std::size_t first = 0;
    for (std::size_t i = 0; i < sections.size(); ++i) {
      add(level, sections[i], kHeader + i * kSectionHeader, first);
      first += sections[i].count;
    }
  }

  template <class T>
  void set(std::size_t at, T value) {
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  std::vector<std::byte>& bytes() { return bytes_; }

 private:
  template <class T>
  void append(T value) {
    bytes_.resize(bytes_.size() + sizeof value);
    set(bytes_.size() - sizeof value, value);
  }
  void number(std::uint16_t level, double value) {
    if (level == 0) return append(static_cast<float>(value));
    append(glm::packHalf1x16(static_cast<float>(value)));
  }

  void add(std::uint16_t level, const SectionPlan& plan, std::size_t header, std::size_t first) {
    const auto buckets =
        static_cast<std::uint32_t>(plan.full_buckets + plan.partial.size() + plan.unused);
    set(header, plan.count);
    set(header + 4, plan.max_count);
    set(header + 8, plan.bucket_size);
    set(header + 12, level == 0 ? 0 : buckets);
    set(header + 16, plan.block_size);
    set(header + 20, std::uint16_t{12});
    set(header + 24, plan.range);
    set(header + 32, plan.full_buckets);
    set(header + 36, static_cast<std::uint32_t>(plan.partial.size()));
    set(header + 40, plan.degree);
    if (level > 0) {
      for (const std::uint32_t rows : plan.partial) append(rows);
      for (std::uint32_t b = 0; b < buckets; ++b) {
        for (std::uint32_t axis = 0; axis < 3; ++axis) append(static_cast<float>(10 * b + axis));
      }
    }
    const std::size_t rest = static_cast<std::size_t>((plan.degree + 1) * (plan.degree + 1)) - 1;
    for (std::size_t i = 0; i < plan.max_count; ++i) {
      const std::size_t g = first + i;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        level == 0 ? append(static_cast<float>(value_of(g, axis)))
                   : append(static_cast<std::uint16_t>(1000 * (g % 60) + 7 * axis));
      }
      for (std::size_t axis = 0; axis < 3; ++axis) number(level, 0.25 + value_of(g, 3 + axis));
      for (std::size_t k = 0; k < 4; ++k) number(level, k == g % 4 ? 1 : 0);
      for (std::size_t k = 0; k < 4; ++k) append(byte_of(g, k));
      for (std::size_t k = 0; k < 3 * rest; ++k)
        level == 2 ? append(byte_of(g, 4 + k)) : number(level, value_of(g, 6 + k));
    }
  }

  std::vector<std::byte> bytes_;
};

Scene read(const std::vector<std::byte>& bytes) {
  Scene scene;
  scene.path = "a.ksplat";
  ThreadPool pool(2);
  read_ksplat(bytes, scene.path, pool, {}, scene);
  return scene;
}

std::string error_of(const std::vector<std::byte>& bytes) {
  return test::error_of([&] { read(bytes); }, ErrorKind::input);
}

// Two sections of different degrees in a file with room for three; the first has two full buckets,
// then two partial buckets.
std::vector<SectionPlan> two_sections(std::uint16_t degree) {
  SectionPlan first{9, 10, degree}, second{4, 4, 0};
  first.bucket_size = 3;
  first.full_buckets = 2;
  first.partial = {1, 2};
  second.bucket_size = 4;
  second.full_buckets = 1;
  second.block_size = 3;
  second.range = 1000;
  return {first, second};
}
constexpr std::size_t kBucketOfRow[] = {0, 0, 0, 1, 1, 1, 2, 3, 3};

TEST(Ksplat, values_of_every_level_and_degree_are_read) {
  for (const std::uint16_t level : std::array<std::uint16_t, 3>{0, 1, 2}) {
    for (const std::uint16_t degree : std::array<std::uint16_t, 3>{0, 1, 2}) {
      SCOPED_TRACE(testing::Message() << "level " << level << ", degree " << degree);
      Ksplat file(level, two_sections(degree), 3);
      if (degree == 2) {
        file.set(36, -2.0f);
        file.set(40, 3.0f);
      }
      ASSERT_TRUE(recognises_ksplat(file.bytes(), ""));
      const Scene scene = read(file.bytes());
      const GaussianCloud& cloud = scene.cloud;
      EXPECT_EQ(scene.format, "ksplat, level " + std::to_string(level));
      EXPECT_THAT(scene.warnings, IsEmpty());
      ASSERT_EQ(cloud.size(), 13u);
      ASSERT_EQ(cloud.sh_degree, degree);
      const std::size_t n = static_cast<std::size_t>((degree + 1) * (degree + 1));
      for (std::size_t g = 0; g < 13; ++g) {
        SCOPED_TRACE(g);
        const bool in_first = g < 9;
        for (int axis = 0; axis < 3; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          const double center = 10.0 * (in_first ? static_cast<double>(kBucketOfRow[g]) : 0) + axis;
          const double stored = 1000.0 * static_cast<double>(g % 60) + 7 * axis;
          const double range = in_first ? 32767 : 1000, block = in_first ? 5 : 3;
          EXPECT_NEAR(cloud.positions[g][axis],
                      level == 0 ? value_of(g, a) : center + (stored - range) * block / 2 / range,
                      2e-5);
          EXPECT_NEAR(cloud.log_scales[g][axis], std::log(0.25 + value_of(g, 3 + a)), 1e-6);
          EXPECT_NEAR(cloud.sh[g * n][axis], (byte_of(g, a) / 255.0 - 0.5) / 0.28209479177387814,
                      1e-6);
        }
        const glm::quat& q = cloud.rotations[g];
        const float wxyz[] = {q.w, q.x, q.y, q.z};
        for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(wxyz[k], k == g % 4 ? 1 : 0);
        const double alpha = byte_of(g, 3) / 255.0;
        EXPECT_NEAR(cloud.opacity_logits[g], std::log(alpha / (1 - alpha)), 1e-5);
        // Band by band, and channel by channel within a band.
        std::size_t field = 0;
        for (std::size_t l = 1; l <= degree; ++l) {
          for (int channel = 0; channel < 3; ++channel) {
            for (std::size_t k = l * l; k < (l + 1) * (l + 1); ++k, ++field) {
              const double low = degree == 2 ? -2 : -1.5, high = degree == 2 ? 3 : 1.5;
              const double value = level == 2 ? low + (high - low) * byte_of(g, 4 + field) / 255.0
                                              : value_of(g, 6 + field);
              EXPECT_NEAR(cloud.sh[g * n + k][channel], in_first ? value : 0, 1e-6) << k;
            }
          }
        }
      }
    }
  }
}

TEST(Ksplat, what_is_at_a_limit_is_read_and_what_is_beyond_is_refused) {
  const std::size_t section = kHeader;
  struct Row {
    std::function<void(Ksplat&)> change;
    const char* message;
  };
  const auto set = [](std::size_t at, auto value) {
    return [=](Ksplat& file) { file.set(at, value); };
  };
  const Row rows[] = {
      {[](Ksplat&) {}, ""},
      {set(0, std::uint8_t{1}), "a.ksplat: .ksplat version 1.1, only 0.1 exists"},
      {set(1, std::uint8_t{2}), "a.ksplat: .ksplat version 0.2, only 0.1 exists"},
      {set(1, std::uint8_t{0}), "a.ksplat: .ksplat version 0.0, only 0.1 exists"},
      {set(20, std::uint16_t{3}), "a.ksplat: compression level 3, 0 to 2 exist"},
      {set(8, 4u), "a.ksplat: 4 sections where there is room for 3"},
      {set(36, INFINITY), "a.ksplat: the range of its SH values is not finite"},
      {set(40, -INFINITY), "a.ksplat: the range of its SH values is not finite"},
      {set(16, 14u), "a.ksplat: the header announces 14 Gaussians, its sections 13"},
      {set(section + 40, std::uint16_t{3}), "a.ksplat: SH degree 3 does not exist in .ksplat"},
      {set(section + 4, 8u), "a.ksplat: a section has 9 Gaussians and room for 8"},
      {set(section + 8, 0u), "a.ksplat: a section has buckets of 0 rows and 12 bytes"},
      {set(section + 20, std::uint16_t{13}),
       "a.ksplat: a section has buckets of 3 rows and 13 bytes"},
      {set(section + 12, 3u), "a.ksplat: a section uses 4 buckets and has 3"},
      {set(section + 36, 1u), "a.ksplat: the buckets of a section hold 7 of its 9 Gaussians"},
      {set(section + 32, 4u), "a.ksplat: a section uses 6 buckets and has 5"},
      // Counts that are stated twice: the lengths of partial buckets, the room, the bytes.
      {set(kHeader + 3 * kSectionHeader, 2u),
       "a.ksplat: the buckets of a section hold 10 of its 9 Gaussians"},
      {set(kHeader + 3 * kSectionHeader, 4u),
       "a.ksplat: a bucket of a section holds 4 Gaussians and has room for 3"},
      {set(12, 12u), "a.ksplat: the header announces room for 12 Gaussians, there are 13"},
      {set(section + 28, 488u), ""},
      {set(section + 28, 489u), "a.ksplat: a section announces 489 bytes, its parts have 488"},
      {[](Ksplat& file) {
         file.set(kHeader + 32, 4u);
         file.set(kHeader + 36, 1u);
       },
       "a.ksplat: the buckets of a section hold 13 of its 9 Gaussians"},
      {set(4, 1000u),
       "a.ksplat: cut off: section headers needs 1024000 bytes at offset 4096, 3680 are left"},
      {[](Ksplat& file) { file.bytes().resize(4095); },
       "a.ksplat: cut off: the header needs 4096 bytes at offset 0, 4095 are left"},
      {[](Ksplat& file) { file.bytes().pop_back(); },
       "a.ksplat: cut off: a section needs 96 bytes at offset 7680, 95 are left"},
  };
  for (const Row& row : rows) {
    Ksplat file(1, two_sections(1), 3);
    row.change(file);
    EXPECT_EQ(error_of(file.bytes()), row.message);
  }
  // As many sections as there is room for, and as many buckets as there are.
  Ksplat full(1, two_sections(1), 2);
  EXPECT_EQ(error_of(full.bytes()), "");
  SectionPlan none{0, 0, 0};
  EXPECT_EQ(error_of(Ksplat(0, {none}, 1).bytes()), "a.ksplat: holds no Gaussians");
}

TEST(Ksplat, unused_buckets_change_no_gaussian) {
  std::vector<SectionPlan> sections = two_sections(1);
  const auto read_with = [&](std::uint32_t first, std::uint32_t second) {
    sections[0].unused = first;
    sections[1].unused = second;
    return read(Ksplat(1, sections, 3).bytes());
  };
  const Scene expected = read_with(0, 0);
  for (const auto& [first, second] : {std::pair{1u, 0u}, {0u, 3u}, {5u, 2u}}) {
    const Scene scene = read_with(first, second);
    EXPECT_THAT(scene.warnings, IsEmpty());
    EXPECT_EQ(scene.cloud.positions, expected.cloud.positions) << first << " " << second;
    EXPECT_EQ(scene.cloud.log_scales, expected.cloud.log_scales) << first << " " << second;
    EXPECT_EQ(scene.cloud.sh, expected.cloud.sh) << first << " " << second;
  }
  // The first bucket of the first section is stated, but its section does not have it.
  Ksplat file(1, sections, 3);
  file.set(kHeader + 12, 3u);
  EXPECT_EQ(error_of(file.bytes()), "a.ksplat: a section uses 4 buckets and has 3");
}

TEST(Ksplat, bytes_after_the_last_section_are_ignored_with_a_warning) {
  Ksplat file(2, two_sections(2), 2);
  file.bytes().resize(file.bytes().size() + 3);
  EXPECT_THAT(read(file.bytes()).warnings,
              ElementsAre("3 bytes after the last section were ignored."));
}

TEST(Ksplat, is_recognised_by_plausible_numbers_in_its_header) {
  const auto recognised = [](const std::function<void(Ksplat&)>& change) {
    Ksplat file(1, two_sections(1), 2);
    change(file);
    return recognises_ksplat(file.bytes(), "");
  };
  EXPECT_TRUE(recognised([](Ksplat&) {}));
  EXPECT_TRUE(recognised([](Ksplat& file) { file.set(20, std::uint16_t{2}); }));
  EXPECT_TRUE(recognised([](Ksplat& file) { file.set(8, 1u); }));
  EXPECT_TRUE(recognised([](Ksplat& file) { file.set(16, 1u); }));
  EXPECT_FALSE(recognised([](Ksplat& file) { file.set(0, std::uint8_t{1}); }));
  EXPECT_FALSE(recognised([](Ksplat& file) { file.set(1, std::uint8_t{0}); }));
  EXPECT_FALSE(recognised([](Ksplat& file) { file.set(20, std::uint16_t{3}); }));
  EXPECT_FALSE(recognised([](Ksplat& file) { file.set(8, 0u); }));
  EXPECT_FALSE(recognised([](Ksplat& file) { file.set(8, 3u); }));
  EXPECT_FALSE(recognised([](Ksplat& file) { file.set(16, 0u); }));
  EXPECT_FALSE(recognised([](Ksplat& file) { file.set(4, 1000u); }));
  EXPECT_FALSE(recognised([](Ksplat& file) { file.bytes().resize(kHeader + kSectionHeader - 1); }));
  Ksplat smallest(0, {{1, 1, 0}}, 1);
  smallest.bytes().resize(kHeader + kSectionHeader);
  EXPECT_TRUE(recognises_ksplat(smallest.bytes(), ""));
}

TEST(Ksplat, sections_without_gaussians_are_skipped) {
  for (const auto level : {std::uint16_t{0}, std::uint16_t{1}, std::uint16_t{2}}) {
    for (const std::uint32_t bucket_size : {0u, 256u}) {
      SCOPED_TRACE(testing::Message() << level << " " << bucket_size);
      SectionPlan empty{0, 0, 0, bucket_size};
      empty.unused = 0;
      SectionPlan full{3, 3, 0, 4, 0, {3}};
      for (const auto& sections : {std::vector{empty, full}, std::vector{full, empty},
                                   std::vector{empty, full, empty, empty}}) {
        Ksplat file(level, sections, 5);
        EXPECT_EQ(read(file.bytes()).cloud.size(), 3u);
      }
    }
  }
}

}  // namespace
}  // namespace qs::test
