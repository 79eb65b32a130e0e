// SPDX-License-Identifier: MIT
#include "fuzz/targets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string_view>

#include "app/remote/sibr_message.h"
#include "app/serve/message.h"
#include "app/viewer/preferences.h"
#include "base/error.h"
#include "io/camera/camera_formats.h"
#include "io/camera/cameras.h"
#include "io/edits/edits_file.h"
#include "io/edits/measures_file.h"
#include "io/picture/picture_formats.h"
#include "io/picture/webp_image.h"
#include "io/scene/compact/huffman.h"
#include "io/scene/reader.h"
#include "io/tensor/npy.h"
#include "io/tensor/pickle.h"
#include "io/tensor/tensor.h"
#include "io/tensor/torch_tensor.h"
#include "raster/pages/page_stream.h"
#include "raster/select/editing.h"
#include "support/gzip.h"
#include "support/paths.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

namespace fs = std::filesystem;
using Bytes = std::span<const std::byte>;

const fs::path kData = source_path("tests/data");

void demand(bool promise, const char* what) {
  if (!promise) throw std::logic_error(std::string("broken promise: ") + what);
}

// Runs read(), which may throw an Error about `source`.
template <class Read>
void expect_sentence_at_most(const std::string& source, Read read) {
  try {
    read();
  } catch (const Error& error) {
    const std::string_view sentence = error.what();
    demand(sentence.starts_with(source), "a message begins with the file's name");
    demand(sentence.find('\n') == sentence.npos, "a message is one line");
  }
}

std::string name_of(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '.' || c == ' '; }, '_');
  return text;
}

// COLMAP's readers find the other file of a sound model beside the fuzzed one.
struct InputFolder : TemporaryFolder {
  InputFolder() { fs::copy(kData / "cameras", path()); }
};

// A file of that name with the bytes of the current input.
fs::path input_file(const std::string& name, Bytes content) {
  static const InputFolder folder;
  std::ofstream file(folder / name, std::ios::binary);
  file.write(reinterpret_cast<const char*>(content.data()),
             static_cast<std::streamsize>(content.size()));
  return folder / name;
}

// ---- scenes -------------------------------------------------------------------------------------

// Readers of several files find the other files of a sound scene beside the fuzzed one.
fs::path path_for(std::string_view reader) {
  const fs::path valid = kData / "corpus/valid";
  if (reader == "sog") return valid / "sog_v1_folder/meta.json";
  if (reader == "streamed sog") return valid / "lod_of_sog_v1/lod-meta.json";
  if (reader == "compact-3dgs") return valid / "compact_small.ply";
  return valid / "fuzzed";
}

void check(const GaussianCloud& cloud) {
  demand(!cloud.empty(), "a cloud is not empty");
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  demand(cloud.sh.size() == cloud.size() * coefficients, "SH fit the degree");
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3& p = cloud.positions[i];
    demand(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "positions are finite");
    const glm::quat& q = cloud.rotations[i];
    demand(std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 1e-3f, "unit rotations");
    demand(!std::isnan(cloud.opacity_logits[i]), "opacities are numbers");
    demand(cloud.log_scales[i].x < 100, "scales are finite");
  }
}

void read_scene(const ReaderRow& reader, Bytes content) {
  static ThreadPool pool(1);
  Scene scene;
  scene.path = path_for(reader.name);
  expect_sentence_at_most(scene.path.string(), [&] {
    reader.read(content, scene.path, pool, {}, scene);
    check(scene.cloud);
  });
}

// A tree of which all pages are read.
void read_pages(Bytes content) {
  static ThreadPool pool(1);
  const fs::path path = input_file("fuzzed.rad", content);
  expect_sentence_at_most(path.string(), [&] {
    ReadOptions options;
    options.streams = StreamedTrees::all;
    const Scene scene = read_scene(path, pool, options);
    if (!scene.stream) return;
    check(scene.cloud);
    const auto open = [](const LodPage&, std::size_t) { return 1.0f; };
    demand(scene.stream->await_cut(open, {}, pool).cut.count > 0, "a cut has a node");
  });
}

FuzzTarget scene_target(const ReaderRow& reader) {
  return {name_of(reader.name), reader.extensions, [&reader](Bytes content) {
            reader.recognises(content, "fuzzed");
            read_scene(reader, content);
            // Changed bytes would rarely pass the checksum of gzip.
            if (reader.name == std::string_view("spz"))
              read_scene(reader, gzip(std::vector(content.begin(), content.end()), 1));
          }};
}

// ---- cameras ------------------------------------------------------------------------------------

void check(const Camera& camera) {
  demand(camera.width > 0 && camera.height > 0, "pictures have pixels");
  demand(camera.focal_px.x > 0 && camera.focal_px.y > 0, "focal lengths are positive");
  for (int i = 0; i < 4; ++i) {
    const glm::dvec3& column = camera.view_from_world[i];
    demand(std::isfinite(column.x + column.y + column.z), "matrices are finite");
  }
}

FuzzTarget camera_target(const CameraFormat& format, const std::string& file) {
  return {name_of(file), "/" + file, [&format, file](Bytes content) {
            const fs::path path = input_file(file, content);
            expect_sentence_at_most(path.parent_path().string(), [&] {
              for (const LensCamera& camera : format.read(path).cameras) check(camera.camera);
            });
          }};
}

FuzzTarget points_target(const std::string& file) {
  return {name_of(file), "/" + file, [file](Bytes content) {
            const fs::path path = input_file(file, content);
            expect_sentence_at_most(path.parent_path().string(), [&] {
              std::vector<std::string> warnings;
              for (const ScenePoint& point : read_points(path, warnings)) {
                const glm::vec3 position(point.position);
                for (int i = 0; i < 3; ++i) demand(std::isfinite(position[i]), "points are finite");
              }
            });
          }};
}

// ---- pictures and preferences -------------------------------------------------------------------

FuzzTarget picture_target(const PictureFormat& format) {
  const std::string extension = format.extension;
  return {extension.substr(1), extension, [&format, extension](Bytes content) {
            const fs::path path = input_file("picture" + extension, content);
            expect_sentence_at_most(path.string(), [&] {
              const Image image = format.read(path);
              demand(image.width > 0 && image.height > 0, "pictures have pixels");
            });
          }};
}

void read_exif(Bytes content) {
  const int orientation = exif_orientation(content);
  demand(orientation >= 1 && orientation <= 8, "orientations are 1 to 8");
}

void read_webp(Bytes content) {
  expect_sentence_at_most("picture", [&] {
    const std::uint64_t pixels = webp_size(content, "picture").pixels();
    // The SOG reader checks the size like this before it decodes, because pictures of one colour
    // are tiny.
    if (pixels > 65536 + 16 * content.size()) return;
    demand(decode_webp(content, "picture").size() == 4 * pixels, "pictures have their size");
  });
}

void read_tensors(Bytes content) {
  expect_sentence_at_most("tensors", [&] {
    for (const auto& [name, tensor] : parse_safetensors(content, "tensors").tensors) {
      std::uint64_t count = 1;
      for (const std::uint64_t side : tensor.shape) count *= side;
      demand(tensor.values.size() == count, "tensors have their size");
    }
  });
}

// ---- pickles ------------------------------------------------------------------------------------

void read_pickle(Bytes content) {
  expect_sentence_at_most("pickle", [&] {
    const Pickle pickle(content, "pickle");
    for (PickleRef object = 0; object < pickle.object_count(); ++object) {
      for (const PickleRef item : pickle[object].items)
        demand(item > 0 && item < pickle.object_count(), "items are objects");
    }
  });
}

void read_torch(Bytes content) {
  expect_sentence_at_most("torch", [&] {
    const TorchFile file(content, "torch");
    for (const char* name : {"0.params", "1.params", "floats", "halves", "part", "parameter"}) {
      if (!file.has(name)) continue;
      const Tensor tensor = file.tensor(name);
      std::uint64_t count = 1;
      for (const std::uint64_t side : tensor.shape) count *= side;
      demand(tensor.values.size() == count, "tensors have their size");
    }
  });
}

void read_array(Bytes content) {
  expect_sentence_at_most("array", [&] {
    const NpyArray array = parse_npy(content, "array");
    demand(array.type == "|O" || array.values.size() >= array.count(), "arrays have their size");
  });
}

// A pickle of a table, and a stream.
void read_huffman(Bytes content) {
  expect_sentence_at_most("huffman", [&] {
    const Pickle pickle(content, "huffman");
    const HuffmanDecoder decoder(read_huffman_table(pickle, pickle.root(), "huffman"), "huffman");
    constexpr std::uint64_t kMost = 100'000;
    const auto symbols = decoder.decode(content.subspan(pickle.size()), kMost);
    demand(symbols.size() <= kMost, "there are not too many symbols");
  });
}

void read_preferences_text(Bytes content) {
  Viewer viewer;
  glm::ivec2 window_size(1280, 720);
  try {
    parse_preferences({reinterpret_cast<const char*>(content.data()), content.size()}, viewer,
                      window_size);
  } catch (const std::exception& error) {
    const std::string_view sentence = error.what();
    demand(sentence.find('\n') == sentence.npos, "a message is one line");
  }
  demand(window_size.x >= 320 && window_size.y >= 240, "windows are visible");
}

// Gaussians in a row.
GaussianCloud few_gaussians() {
  GaussianCloud cloud;
  cloud.resize(20, 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto at = static_cast<float>(i);
    cloud.positions[i] = {at, 0, 5};
    cloud.log_scales[i] = glm::vec3(-0.1f * at);
    cloud.rotations[i] = {1, 0, 0, 0};
    cloud.opacity_logits[i] = at - 10;
    cloud.sh[i] = glm::vec3(0.1f * at - 1);
  }
  return cloud;
}

// Edits that are read are carried out on a few Gaussians, and written and read again.
void read_edits_file(Bytes content) {
  static ThreadPool pool(1);
  static const GaussianCloud cloud = few_gaussians();
  const fs::path path = input_file("fuzzed.edits.json", content);
  expect_sentence_at_most(path.string(), [&] {
    const EditsFile edits = read_edits(path, cloud.origin);
    const std::string text = format_edits(edits, cloud.origin);
    std::ofstream(path) << text;
    demand(format_edits(read_edits(path, cloud.origin), cloud.origin) == text,
           "edits survive writing");
    EditState state(cloud.size());
    const EditTools tools{cloud, pool,
                          [](const GaussianSet& rest, const Camera&, const Shape& shape, float) {
                            shape.pixels({64, 64});
                            return rest;
                          },
                          set_hash};
    for (const EditStep& step : edits.steps) {
      carry_out(step, tools, path.string(), state);
      GaussianSet gone = state.selected;
      demand((gone -= state.rest()).empty(), "selected Gaussians are there");
    }
  });
}

void read_measures_file(Bytes content) {
  const std::string text(reinterpret_cast<const char*>(content.data()), content.size());
  expect_sentence_at_most("measures", [&] {
    const MeasuresFile file = parse_measures(text, "measures", glm::dvec3(0));
    const std::string written = format_measures(file, glm::dvec3(0));
    demand(format_measures(parse_measures(written, "measures", glm::dvec3(0)), glm::dvec3(0)) ==
               written,
           "measures survive writing");
    for (const auto& line : file.measures.lines)
      measure_rows(line, 1, file.measures.scale, glm::dvec3(0, -1, 0));
  });
}

// ---- messages -----------------------------------------------------------------------------------

void read_view(const message::ShowView& view) {
  demand(view.camera.size() <= kMostCamera, "cameras are short");
  expect_sentence_at_most("view", [&] { check(parse_camera(view.camera, "view")); });
}

void read_message(Bytes content) {
  const auto parsed =
      parse_message({reinterpret_cast<const char*>(content.data()), content.size()});
  if (!parsed) return;
  if (const auto* hello = std::get_if<message::Hello>(&parsed->body)) {
    const glm::ivec2 size = hello->size;
    demand(size.x >= 1 && size.y >= 1 && size.x <= kMostSide && size.y <= kMostSide,
           "pictures have a sound size");
  }
  if (const auto* received = std::get_if<message::Received>(&parsed->body))
    demand(received->held >= 0 && received->held <= 1e4, "a time is within its limits");
  if (const auto* button = std::get_if<message::Button>(&parsed->body))
    demand(std::abs(button->at.x) <= 1e5 && std::abs(button->at.y) <= 1e5, "places are finite");
  if (const auto* set = std::get_if<message::SetControl>(&parsed->body))
    demand(std::abs(set->value) <= 1e9 && set->control.size() <= 200, "values are finite");
  if (const auto* drag = std::get_if<message::DragHandle>(&parsed->body))
    demand(drag->face >= 0 && drag->face < 6 && std::abs(drag->at.x) <= 1e5, "a box has six faces");
  if (const auto* view = std::get_if<message::ShowView>(&parsed->body)) read_view(*view);
  if (const auto* wheel = std::get_if<message::Wheel>(&parsed->body))
    demand(std::abs(wheel->notches) <= 100, "notches are few");
}

// A connection that carries the bytes of the input and then ends.
ReadBytes connection(Bytes& content) {
  return [&content](std::span<std::byte> bytes) {
    if (bytes.size() > content.size()) return false;
    std::copy_n(content.begin(), bytes.size(), bytes.begin());
    content = content.subspan(bytes.size());
    return true;
  };
}

// All requests of a viewer, as `serve --sibr` reads them.
void read_sibr_requests(Bytes content) {
  const ReadBytes read = connection(content);
  while (const auto request = read_sibr_request(read)) {
    const auto is_side = [](int side) { return side >= 0 && side <= kMostSibrSide; };
    demand(is_side(request->width) && is_side(request->height), "pictures have a sound size");
    const auto camera = camera_of(*request);
    if (!camera) continue;
    check(*camera);
    const std::string again = sibr_message(request_for(*camera));
    demand(again.size() <= 1400, "a request fits a segment");
    demand(parse_sibr_request(again.substr(4)).has_value(), "a request can be read");
  }
}

// The answers of a trainer, as `view --connect` reads them. The first bytes are the sides of its
// pictures and what is known of its dialect.
void read_sibr_answers(Bytes content) {
  constexpr std::size_t kHead = 3;
  if (content.size() < kHead) return;
  const std::size_t pixels =
      std::to_integer<std::size_t>(content[0]) * std::to_integer<std::size_t>(content[1]);
  auto dialect = static_cast<SibrDialect>(std::to_integer<int>(content[2]) % 3);
  content = content.subspan(kHead);
  const ReadBytes read = connection(content);
  if (dialect == SibrDialect::trainer_first && read_sibr_modes(read, dialect) != SibrEnd::done)
    return;
  SibrAnswer answer;
  for (bool is_first = true;; is_first = false) {
    if (read_sibr_answer(read, 3 * pixels, is_first, dialect, answer) != SibrEnd::done) return;
    demand(answer.rgb.size() == 3 * pixels, "pictures have their size");
    demand(answer.source.size() <= kMostSibrText, "texts are short");
    demand(dialect != SibrDialect::unknown, "an answer shows the dialect");
    parse_metrics(answer.metrics);
  }
}

}  // namespace

std::vector<FuzzTarget> fuzz_targets() {
  std::vector<FuzzTarget> targets;
  for (const ReaderRow& reader : readers()) targets.push_back(scene_target(reader));
  for (const CameraFormat& format : camera_formats()) {
    const fs::path place = fs::path(format.place).filename();
    targets.push_back(camera_target(format, place.string()));
    if (place.stem() == "images")  // COLMAP's lenses
      targets.push_back(camera_target(format, "cameras" + place.extension().string()));
  }
  for (const char* file : {"points3D.bin", "points3D.txt", "points3D.ply"})
    targets.push_back(points_target(file));
  for (const PictureFormat& format : picture_formats()) targets.push_back(picture_target(format));
  targets.push_back({"rad_pages", ".rad", read_pages});
  targets.push_back({"exif", ".jpg", read_exif});
  targets.push_back({"webp", ".webp", read_webp});
  targets.push_back({"safetensors", ".safetensors", read_tensors});
  targets.push_back({"pickle", ".pkl", read_pickle});
  targets.push_back({"torch", ".pth", read_torch});
  targets.push_back({"array", ".npy", read_array});
  targets.push_back({"huffman", ".huffman", read_huffman});
  targets.push_back({"message", ".message", read_message});
  targets.push_back({"sibr_request", ".sibr_request", read_sibr_requests});
  targets.push_back({"sibr_answer", ".sibr_answer", read_sibr_answers});
  targets.push_back({"edits", ".edits.json", read_edits_file});
  targets.push_back({"measures", ".measures.json", read_measures_file});
  targets.push_back({"preferences", "/viewer.json", read_preferences_text});
  return targets;
}

}  // namespace qs::test
