// SPDX-License-Identifier: MIT
// Structs of callers that were built for an older or a newer header.
#include "library/check/structs.h"

#include <algorithm>
#include <array>
#include <vector>

#include "library/opened_scene.h"
#include "support/error_of.h"
#include "support/scenes.h"

namespace qs::library {

/// A struct that had 8 bytes in version 1 and grew twice.
struct Grown {
  std::uint32_t size;
  std::uint32_t first;
  std::uint64_t second, third;
};

template <>
inline constexpr std::size_t kFirstBytes<Grown> = 8;

namespace {

constexpr Where kWhere{"call", "grown"};

// Room behind the struct.
struct Roomy {
  Grown grown;
  std::uint64_t tail[2];
};

TEST(LibraryStructs, of_older_callers_have_zeros_for_the_members_they_lack) {
  Grown given{8, 1, 2, 3};
  EXPECT_EQ(read_struct(&given, kWhere).first, 1u);
  EXPECT_EQ(read_struct(&given, kWhere).second, 0u);
  given.size = 16;
  EXPECT_EQ(read_struct(&given, kWhere).second, 2u);
  EXPECT_EQ(read_struct(&given, kWhere).third, 0u);
}

TEST(LibraryStructs, of_older_callers_are_written_up_to_their_end) {
  Grown given{16, 1, 2, 3};
  write_struct(Grown{0, 7, 8, 9}, &given, kWhere);
  EXPECT_EQ(given.size, 16u);
  EXPECT_EQ(given.first, 7u);
  EXPECT_EQ(given.second, 8u);
  EXPECT_EQ(given.third, 3u);
}

TEST(LibraryStructs, of_newer_callers_may_be_longer_if_the_rest_is_0) {
  Roomy given{{sizeof(Roomy), 1, 2, 3}, {0, 0}};
  EXPECT_EQ(read_struct(&given.grown, kWhere).third, 3u);
  write_struct(Grown{0, 7, 8, 9}, &given.grown, kWhere);
  EXPECT_EQ(given.grown.third, 9u);
  EXPECT_EQ(given.tail[0], 0u);
  given.tail[1] = std::uint64_t{1} << 63;
  EXPECT_EQ(test::error_of([&] { read_struct(&given.grown, kWhere); }, ErrorKind::usage),
            "call: grown: has members that this library does not have, and they are not 0: it "
            "needs a newer libquadsplat");
}

TEST(LibraryStructs, without_their_size_are_refused) {
  for (const std::uint32_t size : {0u, 7u, 4097u, 0xffffffffu}) {
    const Grown given{size, 1, 2, 3};
    EXPECT_EQ(test::error_of([&] { read_struct(&given, kWhere); }, ErrorKind::usage),
              fmt::format("call: grown.size: is {}: set it to the size of the struct, 24 bytes in "
                          "this library",
                          size));
  }
  EXPECT_EQ(test::error_of([&] { read_struct<Grown>(nullptr, kWhere); }), "call: grown: is null");
}

TEST(LibraryStructs, in_arrays_all_have_the_size_of_the_first) {
  std::array<Roomy, 3> given{};
  for (std::uint64_t i = 0; i < 3; ++i) given[i].grown = {sizeof(Roomy), 0, i, 0};
  EXPECT_EQ(element(&given[0].grown, 2, kWhere)->second, 2u);
}

TEST(LibraryStructs, of_newer_callers_are_taken_by_the_functions) {
  struct NewCamera {
    QsCamera camera;
    double more[4];
  };
  struct NewPicture {
    QsPicture picture;
    double more[2];
  };
  quadsplat::Context context = test::cpu(1);
  quadsplat::Scene scene = context.wrap(test::gaussians_of(test::random_cloud(300, 0, 1)));
  std::array<NewCamera, 2> cameras{};
  std::array<NewPicture, 2> pictures{};
  std::array<std::vector<float>, 2> values;
  for (std::size_t i = 0; i < 2; ++i) {
    cameras[i].camera = test::c_camera(test::front_camera(20 + static_cast<int>(i), 10));
    cameras[i].camera.size = sizeof(NewCamera);
    values[i].resize(3 * 10 * (20 + i));
    pictures[i].picture.size = sizeof(NewPicture);
    pictures[i].picture.color =
        quadsplat::array_of(values[i].data(), {10, 20 + static_cast<int>(i), 3});
  }
  quadsplat::check(qs_render, scene.get(), &cameras[0].camera, std::uint64_t{2}, nullptr,
                   &pictures[0].picture);
  for (std::size_t i = 0; i < 2; ++i) {
    QsCamera usual = cameras[i].camera;
    usual.size = sizeof(usual);
    EXPECT_EQ(values[i], test::colors(scene, usual));
  }
  cameras[1].more[3] = 1;
  EXPECT_EQ(test::sentence_of([&] {
              quadsplat::check(qs_render, scene.get(), &cameras[0].camera, std::uint64_t{2},
                               nullptr, &pictures[0].picture);
            }),
            "qs_render: cameras[1]: has members that this library does not have, and they are not "
            "0: it needs a newer libquadsplat");
}

TEST(LibraryStructs, of_cameras_of_the_first_header_are_pinhole_cameras) {
  quadsplat::Context context = test::cpu(1);
  quadsplat::Scene scene = context.wrap(test::gaussians_of(test::random_cloud(300, 0, 1)));
  const QsCamera usual = test::c_camera(test::front_camera(20, 10));
  QsCamera old = usual;
  old.size = 152;  // the memory behind it is not the camera's
  test::set_model(old, "FISHEYE", {1, 2, 3});
  std::copy(usual.focal_px, usual.focal_px + 2, old.focal_px);
  std::copy(usual.center_px, usual.center_px + 2, old.center_px);
  EXPECT_EQ(test::colors(scene, old), test::colors(scene, usual));
  old.focal_px[0] = 1;
  quadsplat::check(qs_camera_resize, &old, 40, 20);
  EXPECT_EQ(old.focal_px[0], 2);
  EXPECT_STREQ(old.model, "FISHEYE") << "it is not written";
}

}  // namespace
}  // namespace qs::library
