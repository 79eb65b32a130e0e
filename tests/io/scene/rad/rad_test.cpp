// SPDX-License-Identifier: MIT
//
// RAD: every encoding against values computed by hand, and files whose claims do not fit.
#include "io/scene/rad/rad.h"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/parallel.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/inflate.h"
#include "io/bytes/replace_file.h"
#include "io/scene/rad/rad_original.h"
#include "io/scene/rad/rad_pages.h"
#include "io/scene/rad/rad_writer.h"
#include "io/scene/reader.h"
#include "io/support/limits.h"
#include "raster/kernel/constants.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

template <class T>
std::string bytes_of(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) put_values(bytes, value);
  return bytes;
}

std::string padded(std::string bytes) {
  bytes.resize((bytes.size() + 7) / 8 * 8);
  return bytes;
}

std::string deflated(const std::string& plain) {
  std::string packed;
  Deflater deflater(DeflateForm::deflate, 6, 8, [&](std::string_view part) { packed += part; });
  deflater.write(plain);
  deflater.finish();
  return packed;
}

struct Part {
  std::string property, encoding, bytes;
  json more = json::object();  // min, max
};

std::string block(const std::string& magic, const std::string& description) {
  std::string bytes = magic;
  put_values(bytes, static_cast<std::uint32_t>(description.size()));
  return padded(bytes + description);
}

using Change = std::function<void(json& description)>;

std::string chunk_of(int base, int count, const std::vector<Part>& parts, bool deflate,
                     const Change& change = {}) {
  json properties = json::array();
  std::string payload;
  for (const Part& part : parts) {
    const std::string bytes = deflate ? deflated(part.bytes) : part.bytes;
    json property = {{"offset", payload.size()},
                     {"bytes", bytes.size()},
                     {"property", part.property},
                     {"encoding", part.encoding}};
    if (deflate) property["compression"] = "gz";
    property.update(part.more);
    properties.push_back(property);
    payload += padded(bytes);
  }
  json description = {{"version", 1},
                      {"base", base},
                      {"count", count},
                      {"payloadBytes", payload.size()},
                      {"properties", properties}};
  if (change) change(description);
  std::string bytes = block("RADC", description.dump());
  put_values(bytes, std::uint64_t{payload.size()});
  return bytes + payload;
}

std::string file_of(int count, int size, const std::vector<std::string>& chunks,
                    const Change& change = {}) {
  json list = json::array();
  std::string body;
  for (const std::string& chunk : chunks) {
    list.push_back({{"offset", body.size()}, {"bytes", chunk.size()}});
    body += chunk;
  }
  json description = {{"version", 1},        {"type", "gsplat"}, {"count", count},
                      {"chunkSize", size},   {"chunks", list},   {"allChunkBytes", body.size()},
                      {"lodTree", count > 1}};
  if (change) change(description);
  return block("RAD0", description.dump()) + body;
}

Scene read(const std::string& text, const std::filesystem::path& path = "test.rad",
           const ReadOptions& options = {}) {
  Scene scene;
  scene.path = path;
  ThreadPool pool(2);
  read_rad(to_bytes(text), scene.path, pool, options, scene);
  return scene;
}

// ---- one Gaussian -------------------------------------------------------------------------------

std::vector<Part> one_gaussian() {
  return {{"center", "f32", bytes_of({1.f, -2.f, 3.f})},
          {"alpha", "f32", bytes_of({0.75f})},
          {"rgb", "f32", bytes_of({0.5f, 1.f, 0.f})},
          {"scales", "f32", bytes_of({1.f, 2.f, 0.f})},
          {"orientation", "f32", bytes_of({0.5f, -0.5f, 0.5f})}};
}

// The Gaussian with `part` in the place of its property of this name.
std::string with(const Part& part, bool deflate = false) {
  std::vector<Part> parts = one_gaussian();
  const auto old = std::ranges::find(parts, part.property, &Part::property);
  if (old != parts.end())
    *old = part;
  else
    parts.push_back(part);
  return file_of(1, 65536, {chunk_of(0, 1, parts, deflate)});
}

TEST(Rad, floats_are_read_as_they_are) {
  for (const bool deflate : {false, true}) {
    const Scene scene = read(with({"alpha", "f32", bytes_of({0.75f})}, deflate));
    const GaussianCloud& cloud = scene.cloud;
    EXPECT_EQ(cloud.positions[0], glm::vec3(1, -2, 3));
    EXPECT_FLOAT_EQ(cloud.opacity_logits[0], std::log(3.f));
    EXPECT_EQ(cloud.log_scales[0], glm::vec3(0, std::log(2.f), -INFINITY));
    EXPECT_EQ(cloud.rotations[0], glm::quat(0.5f, 0.5f, -0.5f, 0.5f));
    EXPECT_NEAR(cloud.sh[0].y, 0.5 / kSh0, 1e-6);
    EXPECT_EQ(cloud.sh_degree, 0);
    EXPECT_EQ(scene.axes, "RDF");
    EXPECT_EQ(scene.format, "rad, without levels");
    EXPECT_FALSE(scene.levels);
    EXPECT_THAT(scene.warnings, IsEmpty());
  }
}

TEST(Rad, every_encoding_has_its_values) {
  const double dc = 1 / kSh0;
  const double s = std::sqrt(0.5);
  struct Row {
    Part part;
    std::function<std::vector<double>(const GaussianCloud&)> of;
    std::vector<double> expected;
  };
  const auto position = [](const GaussianCloud& c) {
    return std::vector<double>{c.positions[0].x, c.positions[0].y, c.positions[0].z};
  };
  const auto opacity = [](const GaussianCloud& c) {
    return std::vector<double>{1 / (1 + std::exp(-static_cast<double>(c.opacity_logits[0])))};
  };
  const auto color = [](const GaussianCloud& c) {
    return std::vector<double>{c.sh[0].x, c.sh[0].y, c.sh[0].z};
  };
  const auto scale = [](const GaussianCloud& c) {
    return std::vector<double>{c.log_scales[0].x, c.log_scales[0].y, c.log_scales[0].z};
  };
  const auto rotation = [](const GaussianCloud& c) {
    const glm::quat& q = c.rotations[0];
    return std::vector<double>{q.w, q.x, q.y, q.z};
  };
  const auto band_1 = [](const GaussianCloud& c) {
    return std::vector<double>{c.sh[1].x, c.sh[1].y, c.sh[1].z, c.sh[2].x, c.sh[3].z};
  };
  const json unit = {{"min", -1}, {"max", 2}}, two = {{"min", 0}, {"max", 2}};
  const json logs = {{"min", -12}, {"max", 9}}, half = {{"max", 0.5}};
  const std::string nine("\x7f\x81\x00\x3f\x01\x02\x03\x04\xc1", 9);
  const std::vector<double> nine_values = {0.5, -0.5, 0, 0.5 * 63 / 127, 0.5 * -63 / 127};
  const std::vector<Row> rows = {
      {{"center", "f16", bytes_of<std::uint16_t>({0x3e00, 0xc000, 0x7bff})},
       position,
       {1.5, -2, 65504}},
      {{"center", "f32_lebytes",
        std::string("\0\0\0"
                    "\0\0\0"
                    "\xc0\0\x80"
                    "\x3f\xc0\x40",
                    12)},
       position,
       {1.5, -2, 4}},
      {{"center", "f16_lebytes",
        std::string("\0\0\xff"
                    "\x3e\xc0\x7b",
                    6)},
       position,
       {1.5, -2, 65504}},
      {{"alpha", "f16", bytes_of<std::uint16_t>({0x3800})}, opacity, {0.5}},
      {{"alpha", "r8", "\x33", two}, opacity, {0.4}},
      {{"rgb", "f16", bytes_of<std::uint16_t>({0x3800, 0x3c00, 0x3e00})}, color, {0, 0.5 * dc, dc}},
      {{"rgb", "r8", std::string("\x00\x55\xff", 3), unit},
       color,
       {-1.5 * dc, -0.5 * dc, 1.5 * dc}},
      {{"rgb", "r8_delta", std::string("\x00\x55\xff", 3), unit},
       color,
       {-1.5 * dc, -0.5 * dc, 1.5 * dc}},
      {{"scales", "ln_f16", bytes_of<std::uint16_t>({0xc000, 0x3c00, 0xfc00})},
       scale,
       {-2, 1, -INFINITY}},
      {{"scales", "ln_0r8", std::string("\x00\x01\xff", 3), logs}, scale, {-INFINITY, -12, 9}},
      {{"orientation", "f16", bytes_of<std::uint16_t>({0x3800, 0xb800, 0x0000})},
       rotation,
       {s, 0.5, -0.5, 0}},
      // The axis is (1, 1/255, -1/255) with y folded to 0, the angle pi; then no angle; then -z.
      {{"orientation", "oct88r8", std::string("\xff\x80\xff", 3)}, rotation, {0, 1, 0, -0.0039370}},
      {{"orientation", "oct88r8", std::string("\x80\x00\x00", 3)}, rotation, {1, 0, 0, 0}},
      {{"orientation", "oct88r8", std::string("\x00\x00\xff", 3)}, rotation, {0, 0, 0, -1}},
      {{"sh1", "s8", nine, half}, band_1, nine_values},
      {{"sh1", "s8_delta", nine, half}, band_1, nine_values},
      {{"sh1", "r8", std::string("\x00\xff\x33\x66\0\0\0\0\x99", 9), two},
       band_1,
       {0, 2, 0.4, 0.8, 1.2}},
      {{"sh1", "r8_delta", std::string("\x00\xff\x33\x66\0\0\0\0\x99", 9), two},
       band_1,
       {0, 2, 0.4, 0.8, 1.2}},
      {{"sh1", "f32", bytes_of({1.f, 2.f, 3.f, 4.f, 5.f, 6.f, 7.f, 8.f, 9.f})},
       band_1,
       {1, 2, 3, 4, 9}},
      {{"sh1", "f16",
        bytes_of<std::uint16_t>(
            {0x3c00, 0x4000, 0x4200, 0x4400, 0x4500, 0x4600, 0x4700, 0x4800, 0x4880})},
       band_1,
       {1, 2, 3, 4, 9}},
  };
  for (const Row& row : rows) {
    for (const bool deflate : {false, true}) {
      SCOPED_TRACE(row.part.property + " " + row.part.encoding);
      const Scene scene = read(with(row.part, deflate));
      const std::vector<double> values = row.of(scene.cloud);
      ASSERT_EQ(values.size(), row.expected.size());
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (std::isinf(row.expected[i]))
          EXPECT_EQ(values[i], row.expected[i]);
        else
          EXPECT_NEAR(values[i], row.expected[i], 1e-5) << i;
      }
    }
  }
}

TEST(Rad, higher_bands_follow_lower_ones) {
  std::vector<Part> parts = one_gaussian();
  for (const auto& [name, count, first] :
       {std::tuple("sh1", 9, 0), std::tuple("sh2", 15, 9), std::tuple("sh3", 21, 24)}) {
    std::string bytes;
    for (int i = 0; i < count; ++i) put_values(bytes, static_cast<float>(first + i));
    parts.push_back({name, "f32", bytes});
    const Scene scene = read(file_of(1, 65536, {chunk_of(0, 1, parts, false)}));
    const int coefficients = (first + count) / 3;
    ASSERT_EQ(scene.cloud.sh.size(), static_cast<std::size_t>(1 + coefficients));
    for (int k = 0; k < coefficients; ++k) {
      const auto value = static_cast<float>(3 * k);
      EXPECT_EQ(scene.cloud.sh[static_cast<std::size_t>(1 + k)],
                glm::vec3(value, value + 1, value + 2));
    }
  }
}

// ---- trees --------------------------------------------------------------------------------------

struct Tree {
  std::vector<std::uint16_t> counts = {2, 2, 2, 0, 0, 0, 0};
  std::vector<std::uint32_t> starts = {1, 3, 5, 0, 0, 0, 0};
};

// The nodes [base, base + count) of a tree; node i is at x = i.
std::string chunk_of_tree(const Tree& tree, int base, int count, const Change& change = {}) {
  std::string center, alpha, rgb, scales, rotation, counts, starts;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = base; i < base + count; ++i) {
      put_values(center, axis == 0 ? static_cast<float>(i) : 0.f);
      put_values(rgb, 0.5f);
      put_values(scales, 1.f);
      put_values(rotation, 0.f);
    }
  }
  for (int i = base; i < base + count; ++i) {
    put_values(alpha, 0.5f);
    put_values(counts, tree.counts[static_cast<std::size_t>(i)]);
    put_values(starts, tree.starts[static_cast<std::size_t>(i)]);
  }
  return chunk_of(base, count,
                  {{"center", "f32", center},
                   {"alpha", "f32", alpha},
                   {"rgb", "f32", rgb},
                   {"scales", "f32", scales},
                   {"orientation", "f32", rotation},
                   {"child_count", "u16", counts},
                   {"child_start", "u32", starts}},
                  true, change);
}

std::string tree_file(const Tree& tree, const Change& change = {}) {
  const int count = static_cast<int>(tree.counts.size());
  return file_of(count, 65536, {chunk_of_tree(tree, 0, count)}, change);
}

std::vector<float> places(const Scene& scene) {
  std::vector<float> x;
  for (const glm::vec3& p : scene.cloud.positions) x.push_back(p.x);
  return x;
}

TEST(Rad, leaves_of_a_tree_are_read) {
  const Scene scene = read(tree_file({}));
  EXPECT_THAT(places(scene), ElementsAre(3, 4, 5, 6));
  EXPECT_EQ(scene.levels, (LevelsOfDetail{.levels = 3, .nodes = 7, .leaves = 4, .merged = 3}));
  EXPECT_EQ(scene.format, "rad");
  EXPECT_THAT(scene.warnings, IsEmpty());
}

TEST(Rad, leaves_keep_their_order_across_chunks) {
  const Tree tree{{3, 0, 2, 0, 0, 0}, {1, 0, 4, 0, 0, 0}};
  for (const int size : {1, 2, 3, 4, 5, 6}) {
    std::vector<std::string> chunks;
    for (int base = 0; base < 6; base += size)
      chunks.push_back(chunk_of_tree(tree, base, std::min(size, 6 - base)));
    EXPECT_THAT(places(read(file_of(6, size, chunks))), ElementsAre(1, 3, 4, 5)) << size;
  }
}

TEST(Rad, a_chunk_alone_gives_its_leaves) {
  const Scene scene = read(chunk_of_tree({}, 2, 3));
  EXPECT_THAT(places(scene), ElementsAre(3, 4));
  EXPECT_EQ(scene.format, "rad, one chunk");
  EXPECT_THAT(scene.warnings, ElementsAre("A part of a .rad file: 2 leaves of 3 nodes were read."));
}

TEST(Rad, chunks_may_be_files_of_their_own) {
  const TemporaryFolder folder;
  const std::string second = chunk_of_tree({}, 4, 3);
  write_bytes(folder / "a-1.radc", to_bytes(second));
  const auto with_name = [&](const std::string& name) {
    return file_of(7, 4, {chunk_of_tree({}, 0, 4)}, [&](json& head) {
      head["chunks"].push_back({{"offset", 0}, {"bytes", second.size()}, {"filename", name}});
    });
  };
  EXPECT_THAT(places(read(with_name("a-1.radc"), folder / "a.rad")), ElementsAre(3, 4, 5, 6));
  for (const char* name : {"../a-1.radc", "/etc/passwd", "http://a/b.radc", "C:\\a", "", "x/.."})
    EXPECT_THAT(error_of([&] { read(with_name(name), folder / "a.rad"); }, ErrorKind::input),
                HasSubstr("unsafe file name"))
        << name;
  EXPECT_THAT(error_of([&] { read(with_name("b.radc"), folder / "a.rad"); }),
              HasSubstr("the file b.radc that it names is missing"));
}

TEST(Rad, labels_choose_from_the_table_of_the_first_chunk) {
  std::vector<Part> parts = one_gaussian();
  std::string codes;
  for (int value = 0; value < 9; ++value)
    for (int row = 0; row < 3; ++row) put_values(codes, static_cast<float>(100 * row + value));
  parts.push_back({"sh1_code", "f32", codes});
  for (const auto& [encoding, label] : {std::pair("u16", bytes_of<std::uint16_t>({2})),
                                        std::pair("u32", bytes_of<std::uint32_t>({2}))}) {
    std::vector<Part> labelled = parts;
    labelled.push_back({"sh_label", encoding, label});
    const Change three = [](json& head) { head["shCodeCount"] = 3; };
    const Scene scene = read(file_of(1, 65536, {chunk_of(0, 1, labelled, false)}, three));
    EXPECT_EQ(scene.cloud.sh[1], glm::vec3(200, 201, 202));
    EXPECT_EQ(scene.cloud.sh[3], glm::vec3(206, 207, 208));
  }
  parts.push_back({"sh_label", "u16", bytes_of<std::uint16_t>({3})});
  const Scene scene = read(file_of(1, 65536, {chunk_of(0, 1, parts, false)},
                                   [](json& head) { head["shCodeCount"] = 3; }));
  EXPECT_EQ(scene.cloud.sh[1], glm::vec3(0));
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("only their base colour")));
}

TEST(Rad, opacities_above_1_are_clamped_with_a_warning) {
  const Scene scene = read(with({"alpha", "r8", "\xff", {{"min", 0}, {"max", 2}}}));
  EXPECT_EQ(scene.cloud.opacity_logits[0], INFINITY);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("outside 0 to 1")));
}

TEST(Rad, ignored_data_gets_a_warning) {
  std::vector<Part> parts = one_gaussian();
  parts.push_back({"velocity", "f32", bytes_of({1.f})});
  const std::string chunk = chunk_of(0, 1, parts, false);
  EXPECT_THAT(read(file_of(1, 65536, {chunk})).warnings,
              ElementsAre("The property 'velocity' is not known and was ignored."));
  const std::string known = chunk_of(0, 1, one_gaussian(), false);
  EXPECT_THAT(read(file_of(1, 65536, {known}) + "123").warnings,
              ElementsAre("3 bytes after the properties of its chunks were ignored."));
}

// ---- damage -------------------------------------------------------------------------------------

TEST(Rad, every_claim_that_does_not_fit_has_a_sentence) {
  const auto head = [](const char* key, const json& value) {
    return tree_file({}, [&](json& description) { description[key] = value; });
  };
  const auto chunk = [](const char* key, const json& value) {
    return file_of(7, 65536,
                   {chunk_of_tree({}, 0, 7, [&](json& description) { description[key] = value; })});
  };
  const auto property = [](std::size_t i, const char* key, const json& value) {
    return file_of(7, 65536, {chunk_of_tree({}, 0, 7, [&](json& description) {
                     description["properties"][i][key] = value;
                   })});
  };
  const auto range = [](const char* key, const json& value) {
    return tree_file({}, [&](json& description) { description["chunks"][0][key] = value; });
  };
  std::string no_magic = tree_file({});
  no_magic[3] = '1';
  const std::string first = chunk_of_tree({}, 0, 4);
  const struct {
    std::string file, sentence;
  } rows[] = {
      {no_magic, "does not begin with 'RAD0'"},
      {head("version", 2), "version 2, only 1 exists"},
      {head("version", -1), "version is -1, but must be a whole number"},
      {head("version", "1"), "version is not a number"},
      {head("type", "mesh"), "the type 'mesh' is not known"},
      {head("count", 0), "holds no Gaussians"},
      {head("count", 68719476736), "68719476736 nodes in 1 chunks of 65536"},
      {head("count", 4294967296), "4294967296 nodes in 1 chunks of 65536"},
      {head("count", 6), "chunk 0: holds 7 nodes from node 0 on, but must hold 6 from node 0 on"},
      {head("count", 1e300), "must be a whole number"},
      {head("count", 7.5), "count is 7.5"},
      {head("chunkSize", 0), "7 nodes in 1 chunks of 0"},
      {head("chunkSize", 3), "7 nodes in 1 chunks of 3"},
      {head("chunks", 5), "chunks is not a list"},
      {head("chunks", json::array({5})), "something else than objects"},
      {head("chunks", nullptr), "chunks is missing"},
      {range("offset", 1e11), "chunk 0: cut off"},
      {range("offset", -8), "offset is -8"},
      {range("bytes", 16), "cut off"},
      {range("bytes", 1e12), "chunk 0: cut off"},
      {file_of(7, 4, {first, first}),
       "chunk 1: holds 4 nodes from node 0 on, but must hold 3 from node 4 on"},
      {chunk("version", 3), "chunk 0: version 3"},
      {chunk("base", 1), "holds 7 nodes from node 1 on"},
      {chunk("count", 8), "holds 8 nodes from node 0 on, but must hold 7"},
      {chunk("count", 1e12), "center: "},
      {chunk("properties", {{"a", 1}}), "properties is not a list"},
      {chunk("properties", json::array()), "it has no center"},
      {property(0, "offset", 8), "center: offset is 8, but the property before ends at 0"},
      {property(1, "offset", 0), "alpha: offset is 0, but the property before ends at"},
      {property(6, "bytes", 1e9), "child_start: cut off"},
      {property(0, "encoding", "ln_f16"), "center: the encoding 'ln_f16' cannot be read"},
      {property(0, "encoding", "zip"), "center: the encoding 'zip' cannot be read"},
      {property(0, "encoding", 7), "encoding is not a string"},
      {property(0, "compression", "br"), "center: the compression 'br' is not known"},
      {property(0, "compression", nullptr), "bytes for 21 values, which take 84"},
      {property(0, "encoding", "f16"), "center: more than 42 bytes unpacked, 42 are needed"},
      {property(2, "encoding", "r8"), "rgb: min is missing"},
      {property(0, "property", "alpha"), "alpha: is there twice"},
      {property(0, "property", "colour\n"), "it has no center"},
      {property(5, "property", "x"), "it has no child_count"},
      {tree_file({{2, 2, 2, 0, 0, 0, 0}, {0, 3, 5, 0, 0, 0, 0}}),
       "the children of node 0 begin with node 0, but must come after it"},
      {tree_file({{2, 2, 2, 0, 0, 0, 0}, {1, 1, 5, 0, 0, 0, 0}}), "the children of node 1"},
      {tree_file({{2, 2, 2, 0, 0, 0, 0}, {1, 3, 4, 0, 0, 0, 0}}), "node 4 is the child of two"},
      {tree_file({{2, 2, 1, 0, 0, 0, 0}, {1, 3, 5, 0, 0, 0, 0}}),
       "node 6 of its tree is the child of no node"},
      {tree_file({{2, 2, 3, 0, 0, 0, 0}, {1, 3, 5, 0, 0, 0, 0}}),
       "node 2 has 3 children from node 5 on, but its tree has 7 nodes"},
      {tree_file({{2, 2, 65535, 0, 0, 0, 0}, {1, 3, 0xffffffff, 0, 0, 0, 0}}), "node 2 has 65535"},
      {block("RAD0", std::string(1 << 20, '[')), "more than 64 levels of brackets"},
      {block("RAD0", "[]"), "its description is not an object"},
      {block("RAD0", "{"), "not valid JSON"},
      {with({"center", "f32", bytes_of({NAN, 0.f, 0.f})}),
       "every one of its 1 Gaussians has a position"},
      {with({"rgb", "f32", bytes_of({1e30f, 0.f, 0.f})}),
       "every one of its 1 Gaussians has a colour"},
      {with({"rgb", "r8", "abc", {{"min", -1e300}, {"max", 1e300}}}), "has a colour"},
  };
  for (const auto& row : rows) {
    expect_within_limits([&] {
      const std::string message = error_of([&] { read(row.file); }, ErrorKind::input);
      EXPECT_THAT(message, StartsWith("test.rad: "));
      EXPECT_THAT(message, HasSubstr(row.sentence));
      EXPECT_EQ(message.find('\n'), message.npos);
      return std::size_t{0};
    });
  }
}

TEST(Rad, a_range_of_one_value_gives_that_value) {
  const Scene scene = read(with({"rgb", "r8", "abc", {{"min", 0.5}, {"max", 0.5}}}));
  EXPECT_EQ(scene.cloud.sh[0], glm::vec3(0));
}

TEST(Rad, deflated_bombs_are_refused_before_memory_is_taken) {
  const std::string zeros = deflated(std::string(64 << 20, '\0'));
  const auto file = [&](int count) {
    std::vector<Part> parts = one_gaussian();
    std::string chunk = chunk_of(0, count, parts, true);
    return file_of(count, 1 << 30, {chunk});
  };
  const HeapPeak heap;
  EXPECT_THAT(error_of([&] { read(file(1'000'000'000)); }),
              HasSubstr("center: 1000000000 rows, but the chunk has only"));
  EXPECT_THAT(error_of([&] { read(file(10'000)); }), HasSubstr("center: 10000 rows"));
  std::vector<Part> parts = one_gaussian();
  const std::string small = chunk_of(0, 1, parts, true);
  json bomb = {{"version", 1}, {"base", 0}, {"count", 1}, {"properties", json::array()}};
  std::string payload;
  for (const Part& part : parts) {
    bomb["properties"].push_back({{"offset", payload.size()},
                                  {"bytes", zeros.size()},
                                  {"property", part.property},
                                  {"encoding", part.encoding},
                                  {"compression", "gz"}});
    payload += padded(zeros);
  }
  std::string chunk = block("RADC", bomb.dump());
  put_values(chunk, std::uint64_t{payload.size()});
  EXPECT_THAT(error_of([&] { read(file_of(1, 65536, {chunk + payload})); }),
              HasSubstr("center: more than 12 bytes unpacked, 12 are needed"));
  EXPECT_LT(heap.bytes(), 8u << 20);
}

TEST(Rad, cut_files_have_a_sentence) {
  for (const std::string& file :
       {tree_file({}), file_of(7, 4, {chunk_of_tree({}, 0, 4), chunk_of_tree({}, 4, 3)}),
        chunk_of_tree({}, 2, 3), with({"sh1", "s8", std::string(9, '\1'), {{"max", 1}}})}) {
    for (std::size_t size = 0; size + 8 < file.size(); ++size)
      EXPECT_THAT(error_of([&] { read(file.substr(0, size)); }, ErrorKind::input),
                  StartsWith("test.rad: "))
          << size;
  }
}

TEST(Rad, changed_bytes_are_survived) {
  const std::string file = tree_file({});
  for (std::size_t at = 0; at < file.size(); ++at) {
    for (const int bits : {0xff, 0x80, 0x01}) {
      std::string damaged = file;
      damaged[at] = static_cast<char>(damaged[at] ^ bits);
      expect_within_limits([&] {
        error_of([&] { read(damaged); }, ErrorKind::input);
        return std::size_t{0};
      });
    }
  }
}

// ---- quadsplat's own block ----------------------------------------------------------------------

// A root and two leaves as the writer writes them.
RadNodes small_tree() {
  RadNodes tree;
  tree.nodes.resize(3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    LodNode& node = tree.nodes[i];
    node.center = {static_cast<float>(i), 0.1f, -2};
    node.scales = {0.5f, 0.25f, 0};
    node.rotation = glm::normalize(glm::quat(0.1f, -0.9f, 0.2f, static_cast<float>(i)));
    node.alpha = 0.5f;
  }
  LodNode& root = tree.nodes[0];
  root.first_child = 1;
  root.child_count = 2;
  root.gains = {255, 200, 0, 1, 2, 3, 4, 5};
  root.errors = {9, 8, 7, 6, 5, 4, 3, 2};
  root.layers = 4;
  root.opacities = 0.5f;
  root.radius = 2;
  tree.sh.assign(3 * 12, 0x3800);  // 0.5
  return tree;
}

std::string written_tree(const RadNodes& tree, const glm::dvec3& origin = glm::dvec3(0)) {
  std::ostringstream stream;
  ThreadPool pool(2);
  RadWriter writer(stream, {3, 1, 0.125f, true, !tree.original.empty(), origin}, pool);
  writer.write({&tree, 1});
  writer.finish();
  return stream.str();
}

LodPage first_page(const std::string& text) {
  const TemporaryFolder folder;
  write_text(folder / "test.rad", text);
  return RadPages(folder / "test.rad").read(0);
}

TEST(RadWriter, its_files_have_the_values_that_were_written) {
  const RadNodes tree = small_tree();
  const std::string text = written_tree(tree);
  const Scene leaves = read(text);
  EXPECT_THAT(leaves.warnings, IsEmpty());
  EXPECT_EQ(leaves.cloud.size(), 2u);
  EXPECT_TRUE(leaves.cloud.antialiased);
  const LodPage page = first_page(text);
  const GaussianCloud& cloud = page.cloud;
  ASSERT_EQ(page.nodes.size(), 3u);
  EXPECT_EQ(page.nodes[0].gains, tree.nodes[0].gains);
  EXPECT_EQ(page.nodes[0].errors, tree.nodes[0].errors);
  EXPECT_EQ(page.nodes[0].layers, 4);
  EXPECT_EQ(page.nodes[0].opacities, 0.5f);
  EXPECT_EQ(page.nodes[0].radius, 2);
  EXPECT_EQ(page.nodes[1].radius, 0);
  EXPECT_EQ(page.nodes[1].layers, 0);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(cloud.positions[i], tree.nodes[i].center);
    EXPECT_NEAR(cloud.log_scales[i].x, std::log(0.5f), 1e-3);
    EXPECT_LT(cloud.log_scales[i].z, -1000);
    EXPECT_NEAR(cloud.opacity_logits[i], 0, 1e-3);
    EXPECT_NEAR(cloud.sh[4 * i].x, 0.5f, 2e-3);
    EXPECT_NEAR(cloud.sh[4 * i + 1].y, 0.5f, 4e-3);
    // w is the largest component, and half a turn about an axis of the ellipsoid changes nothing.
    const glm::quat q = cloud.rotations[i];
    EXPECT_GE(q.w, 0.4999f);
    const glm::mat3 a = glm::mat3_cast(q), b = glm::mat3_cast(tree.nodes[i].rotation);
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(std::abs(glm::dot(a[axis], b[axis])), 1, 1e-5);
  }
}

// The tree with the original values of its two leaves, and a cloud of these in their order.
RadNodes original_tree(GaussianCloud& leaves, std::array<std::uint32_t, 2> numbers = {1, 0}) {
  leaves = read(written_tree(small_tree())).cloud;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto f = static_cast<float>(i);
    leaves.positions[i].x = 2 - f;  // the first leaf of the file has number 1
    leaves.opacity_logits[i] = 0.1f + f;
    leaves.log_scales[i] = {-0.3f * f, -1.7f, -20.1f};
    leaves.rotations[i] = glm::normalize(glm::quat(0.1f, 0.7f + f, -0.3f, 0.2f));
    for (std::size_t k = 0; k < 4; ++k) leaves.sh[4 * i + k] = glm::vec3(0.1f, f, -0.77f);
  }
  RadNodes tree = small_tree();
  const std::size_t words = original_words(1);
  tree.original.resize(2 * words);
  for (std::size_t leaf = 0; leaf < 2; ++leaf)
    pack_original(leaves, 1 - leaf, numbers[leaf],
                  std::span(tree.original).subspan(leaf * words, words));
  return tree;
}

TEST(RadWriter, the_origin_comes_back_as_doubles) {
  const glm::dvec3 origin(500'000, 4'650'000.125, -1e-3);
  const std::string text = written_tree(small_tree(), origin);
  EXPECT_EQ(read(text).cloud.origin, origin);
  EXPECT_EQ(read(text).cloud.positions[1].x, 2);
  EXPECT_EQ(first_page(text).cloud.origin, origin);
  EXPECT_EQ(written_tree(small_tree()).find("origin"), std::string::npos);
  EXPECT_THAT(error_of([&] {
                read(written_tree(small_tree(), {1, 2, 1e10}));
              }),
              HasSubstr("quadsplat: origin is too far away"));
}

TEST(RadWriter, original_values_come_back_in_the_order_of_the_source) {
  GaussianCloud source;
  const std::string text = written_tree(original_tree(source));
  const Scene leaves = read(text);
  EXPECT_THAT(leaves.warnings, IsEmpty());
  EXPECT_TRUE(leaves.levels->has_originals);
  EXPECT_EQ(leaves.cloud.positions, source.positions);
  EXPECT_EQ(leaves.cloud.opacity_logits, source.opacity_logits);
  EXPECT_EQ(leaves.cloud.log_scales, source.log_scales);
  EXPECT_EQ(leaves.cloud.rotations, source.rotations);
  EXPECT_EQ(leaves.cloud.sh, source.sh);
  const LodPage page = first_page(text);  // its nodes have the order of the file
  EXPECT_THAT(page.numbers, ElementsAre(kNoNumber, 1, 0));
  EXPECT_EQ(page.cloud.positions[1].x, 1);
  EXPECT_EQ(page.cloud.opacity_logits[1], source.opacity_logits[1]);
  // Without them, everything but the description is the same, and the chunk is shorter.
  const auto chunk = [](const std::string& file) { return file.substr(file.find("RADC")); };
  const auto payload = [&](const std::string& file) {
    const std::string part = chunk(file);
    return part.substr(16 + (load<std::uint32_t>(std::as_bytes(std::span(part)).data() + 4) + 7) /
                                8 * 8);
  };
  const std::string plain = written_tree(small_tree());
  EXPECT_TRUE(payload(text).starts_with(payload(plain)));
  EXPECT_EQ(plain.find("original"), plain.npos);
  // A chunk alone has its leaves in its own order.
  EXPECT_EQ(read(chunk(text)).cloud.opacity_logits[0], source.opacity_logits[1]);
}

TEST(RadWriter, damage_of_original_values_is_one_sentence) {
  GaussianCloud cloud;
  const auto sentence = [](const std::string& text) { return error_of([&] { read(text); }); };
  const auto numbered = [&](std::uint32_t first, std::uint32_t second) {
    return sentence(written_tree(original_tree(cloud, {first, second})));
  };
  EXPECT_THAT(numbered(1, 1), HasSubstr("is leaf 1 of 2, or another leaf is it"));
  EXPECT_THAT(numbered(2, 0), HasSubstr("node 1 is leaf 2 of 2, or another leaf is it"));
  EXPECT_THAT(numbered(~0u, 0), HasSubstr("node 1 is leaf 4294967295 of 2"));
  RadNodes tree = original_tree(cloud);
  const std::string sound = written_tree(tree);
  std::string changed = sound;
  changed[sound.size() - 12] ^= 1;
  EXPECT_THAT(sentence(changed), HasSubstr("original: damaged: its checksum is wrong"));
  std::string without = sound;
  without.replace(sound.rfind("\"original\":{"), 10, "\"0riginal\"");
  EXPECT_THAT(sentence(without), HasSubstr("chunk 0: has no original values, unlike its file"));
  tree.original.pop_back();
  EXPECT_THAT(sentence(written_tree(tree)),
              HasSubstr("original: only 164 bytes unpacked, 168 are needed"));
  tree = original_tree(cloud);
  tree.original.resize(3 * original_words(1));
  EXPECT_THAT(sentence(written_tree(tree)),
              HasSubstr("original: more than 168 bytes unpacked, 168 are needed"));
  tree = original_tree(cloud);
  tree.original[1] = 0x7fc00000;  // NaN
  const Scene flawed = read(written_tree(tree));
  EXPECT_EQ(flawed.cloud.size(), 1u);
  EXPECT_THAT(flawed.warnings, ElementsAre(HasSubstr("were dropped for an opacity that is NaN")));
}

TEST(RadWriter, chunks_have_65536_nodes_and_the_header_has_their_bytes) {
  RadNodes full, rest;
  full.nodes.resize(RadWriter::kChunk);
  full.sh.assign(RadWriter::kChunk * 3, 0);
  rest.nodes.resize(5);
  rest.sh.assign(15, 0);
  // The root has all nodes but itself as children, in groups of a chain.
  for (RadNodes* part : {&full, &rest})
    for (LodNode& node : part->nodes) node.scales = {1, 1, 1};
  for (std::uint32_t i = 0; i + 1 < RadWriter::kChunk; ++i) {
    full.nodes[i].first_child = i + 1;
    full.nodes[i].child_count = 1;
  }
  full.nodes.back().first_child = RadWriter::kChunk;
  full.nodes.back().child_count = 5;
  std::ostringstream stream;
  ThreadPool pool(2);
  RadWriter writer(stream, {RadWriter::kChunk + 5, 0, 1, false}, pool);
  const std::vector<RadNodes> chunks = {full, rest};
  writer.write(chunks);
  writer.finish();
  EXPECT_EQ(read(stream.str()).cloud.size(), 5u);
  EXPECT_EQ(read(stream.str()).levels->nodes, RadWriter::kChunk + 5);
}

TEST(RadWriter, damage_of_its_block_is_one_sentence) {
  const std::string text = written_tree(small_tree());
  const auto sentence = [](const std::string& damaged) {
    return error_of([&] { first_page(damaged); });
  };
  // The block is at the end; its padding is not checked.
  std::string changed = text;
  changed[text.size() - 20] ^= 1;
  EXPECT_THAT(sentence(changed), HasSubstr("quadsplat: damaged: its checksum is wrong"));
  EXPECT_THAT(error_of([&] { read(changed); }), HasSubstr("checksum is wrong"));
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string result = text;
    const std::size_t at = result.rfind(from);
    EXPECT_NE(at, result.npos) << from;
    return result.replace(at, from.size(), to);
  };
  EXPECT_THAT(sentence(replaced("\"quadsplat\":{\"offset", "\"quadspla_\":{\"offset")),
              HasSubstr("quadsplat lod did not write it"));
  EXPECT_THAT(sentence(replaced("\"quadsplat\":{\"footprint\":0.125",
                                "\"quadsplat\":{\"footprint\":-.125")),
              HasSubstr("test.rad: "));
  EXPECT_THAT(sentence(replaced("\"crc32\":", "\"crc_2\":")), HasSubstr("crc32"));
}

}  // namespace
}  // namespace qs::test
