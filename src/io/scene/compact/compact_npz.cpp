// SPDX-License-Identifier: MIT
#include <array>
#include <memory>
#include <optional>
#include <string_view>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_source.h"
#include "io/scene/compact/compact_model.h"
#include "io/scene/compact/huffman.h"
#include "io/tensor/npy.h"
#include "io/tensor/torch_tensor.h"
#include "raster/field/residual_codebook.h"
#include "raster/kernel/half.h"

namespace qs {
namespace {

constexpr std::uint64_t kMaxEntryBytes = std::uint64_t{1} << 36, kMaxObjectBytes = 64u << 20;
constexpr std::uint64_t kMaxGridValues = std::uint64_t{1} << 26;
constexpr std::int64_t kMaxLayers = 64, kMaxCodeBits = 16;

// An array of the archive, with its bytes.
struct Entry {
  Array<std::byte> content;
  NpyArray array;
  std::string source;  // messages begin with it
};

float half_at(const Entry& entry, std::size_t i) {
  return float_of_any_half(load<std::uint16_t>(entry.array.values.data() + 2 * i));
}

class Npz {
 public:
  Npz(ByteSpan content, const std::filesystem::path& path)
      : path_(path.string()), files_(files_in_zip(content, path, "xyz.npy")) {}

  const std::string& path() const { return path_; }
  bool has(const std::string& name) const { return files_->has(name + ".npy"); }
  std::vector<FilePart> take_parts() { return std::move(parts_); }

  // The array `name`, of this type.
  Entry read(const std::string& name, std::string_view type) {
    Entry entry;
    entry.source = path_ + ": " + name;
    entry.content = files_->read(name + ".npy", type == "|O" ? kMaxObjectBytes : kMaxEntryBytes);
    entry.array = parse_npy(entry.content, entry.source);
    if (entry.array.type != type)
      fail("{}: has values of another type than {}", entry.source, type);
    parts_.push_back({name, files_->stored_bytes(name + ".npy"), describe(entry)});
    return entry;
  }

  // 16-bit floats, `count` of them if it is given.
  std::vector<float> halves(const std::string& name, std::optional<std::uint64_t> count = {}) {
    const Entry entry = read(name, "<f2");
    if (count && entry.array.count() != *count)
      fail("{}: has {} values instead of {}", entry.source, entry.array.count(), *count);
    std::vector<float> values(entry.array.count());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = half_at(entry, i);
    return values;
  }

  // Huffman codes, of `count` symbols if it is given.
  Array<std::uint16_t> symbols(const std::string& name, std::optional<std::uint64_t> count) {
    const Entry stream = read(name, "|u1"), object = read("huftable_" + name, "|O");
    const Pickle pickle(object.array.values, object.source);
    const HuffmanDecoder decoder(read_huffman_table(pickle, object_in_array(pickle), stream.source),
                                 stream.source);
    auto found = decoder.decode(stream.array.values, count.value_or(kMaxGridValues));
    if (count && found.size() != *count)
      fail("{}: has {} symbols instead of {}", stream.source, found.size(), *count);
    return found;
  }

  // Symbols 0..255 for the values from minmax[0] to minmax[1]. `count` as in symbols().
  std::vector<float> quantised(const std::string& name, std::optional<std::uint64_t> count = {}) {
    const Entry bounds = read("minmax_" + name, "<f4");
    if (bounds.array.count() != 2) fail("{}: has not two values", bounds.source);
    const double low = static_cast<double>(load<float>(bounds.array.values.data()));
    const double high = static_cast<double>(load<float>(bounds.array.values.data() + 4));
    const Array<std::uint16_t> numbers = symbols(name, count);
    std::vector<float> values(numbers.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<float>((high - low) * numbers[i] / 255.0 + low);
    return values;
  }

  // The codebook's layers; `codebook` has its sizes.
  void read_codebook(const std::string& name, ResidualCodebook& codebook) {
    const Entry object = read(name, "|O");
    const Pickle pickle(object.array.values, object.source);
    const PickleRef dictionary = object_in_array(pickle);
    for (std::size_t layer = 0; layer < codebook.layers; ++layer) {
      const std::string key = fmt::format("layers.{}._codebook.embed", layer);
      const PickleRef found = pickle.find(dictionary, key);
      if (found == 0) fail("{}: has no tensor {}", object.source, key);
      const Tensor tensor = read_torch_tensor(pickle, found, embedded_torch_storage, key);
      const std::size_t expected = codebook.codes() * codebook.dimensions;
      if (tensor.values.size() != expected)
        fail("{}: {} has {} values instead of {}", object.source, key, tensor.values.size(),
             expected);
      codebook.values.insert(codebook.values.end(), tensor.values.begin(), tensor.values.end());
    }
  }

 private:
  // The only item of an array of objects without dimensions.
  static PickleRef object_in_array(const Pickle& pickle) {
    const PickleObject& array = pickle[pickle.root()];
    if (array.kind != PickleKind::call || !array.text.ends_with("_reconstruct"))
      fail("{}: its pickle: the object is no array", pickle.source());
    const PickleObject& items = pickle[pickle.tuple(array.state, 5, "the state of an array")[4]];
    if (items.kind != PickleKind::list || items.items.size() != 1)
      fail("{}: its pickle: the array has not one item", pickle.source());
    return items.items.front();
  }

  static std::string describe(const Entry& entry) {
    if (entry.array.type == "|O") return "an object";
    const std::uint64_t count = entry.array.count();
    const std::uint64_t bits = count > 0 ? entry.array.values.size() * 8 / count : 0;
    return fmt::format("{} values of {} bits", count, bits);
  }

  std::string path_;
  std::unique_ptr<FileSource> files_;
  std::vector<FilePart> parts_;
};

void read_means(Npz& npz, CompactModel& model) {
  const Entry entry = npz.read("xyz", "<f2");
  if (entry.array.shape.size() != 2 || entry.array.shape[1] != 3)
    fail("{}: has not the shape (N, 3)", entry.source);
  model.means.resize(entry.array.shape[0]);
  for (std::size_t i = 0; i < model.means.size(); ++i)
    model.means[i] = {half_at(entry, 3 * i), half_at(entry, 3 * i + 1), half_at(entry, 3 * i + 2)};
}

// Layers and bits of both codebooks.
ResidualCodebook read_sizes(Npz& npz) {
  const Entry entry = npz.read("rvq_info", "<i8");
  if (entry.array.count() != 2) fail("{}: has not two values", entry.source);
  const auto layers = load<std::int64_t>(entry.array.values.data());
  const auto bits = load<std::int64_t>(entry.array.values.data() + 8);
  if (layers < 1 || layers > kMaxLayers || bits < 1 || bits > kMaxCodeBits)
    fail("{}: {} layers of {} bits are not read", entry.source, layers, bits);
  ResidualCodebook codebook;
  codebook.layers = static_cast<std::size_t>(layers);
  codebook.bits = static_cast<int>(bits);
  return codebook;
}

// The codes of `count` Gaussians, layer by layer.
Array<std::uint16_t> read_codes(Npz& npz, const std::string& name, bool huffman,
                                std::uint64_t count, const ResidualCodebook& codebook) {
  const std::uint64_t numbers = count * codebook.layers;
  if (!huffman) {
    const Entry entry = npz.read(name, "|u1");
    const std::uint64_t expected = packed_bytes(numbers, codebook.bits);
    if (entry.array.values.size() != expected)
      fail("{}: has {} bytes instead of {} for {} Gaussians", entry.source,
           entry.array.values.size(), expected, count);
    return unpack_bits(entry.array.values, numbers, codebook.bits);
  }
  Array<std::uint16_t> codes = npz.symbols(name, numbers);
  for (const std::uint16_t code : codes)
    if (code >= codebook.codes())
      fail("{}: {}: code {} is not in the codebook of {}", npz.path(), name, code,
           codebook.codes());
  return codes;
}

// Calls take(i, vector) with the vector of every Gaussian.
template <class Take>
void read_vectors(Npz& npz, const std::string& name, bool huffman, std::size_t count,
                  std::size_t dimensions, ResidualCodebook codebook, const Take& take) {
  codebook.dimensions = dimensions;
  npz.read_codebook("codebook_" + name, codebook);
  const auto codes = read_codes(npz, name, huffman, count, codebook);
  std::array<float, 4> vector{};
  for (std::size_t i = 0; i < count; ++i) {
    codebook.decode(std::span(codes).subspan(i * codebook.layers, codebook.layers), vector.data());
    take(i, vector);
  }
}

}  // namespace

CompactModel read_compact_npz(ByteSpan content, const std::filesystem::path& path,
                              const Progress& progress) {
  Npz npz(content, path);
  const bool huffman = npz.has("huftable_hash");
  CompactModel model;
  model.form = huffman ? ".npz, post-processed" : ".npz";
  model.file_bytes = content.size();
  read_means(npz, model);
  const std::size_t count = model.means.size();
  model.opacities = huffman ? npz.quantised("opacity", count) : npz.halves("opacity", count);
  const ResidualCodebook sizes = read_sizes(npz);
  model.scales.resize(count);
  read_vectors(npz, "scale", huffman, count, 3, sizes, [&](std::size_t i, const auto& v) {
    model.scales[i] = {v[0], v[1], v[2]};
  });
  model.rotations.resize(count);
  read_vectors(npz, "rotation", huffman, count, 4, sizes, [&](std::size_t i, const auto& v) {
    model.rotations[i] = {v[0], v[1], v[2], v[3]};
  });
  progress.update(0.1f);
  std::vector<float> weights = npz.halves("mlp");
  std::vector<float> grid = huffman ? npz.quantised("hash") : npz.halves("hash");
  model.field = make_color_field(std::move(grid), std::move(weights), path.string());
  model.parts = npz.take_parts();
  return model;
}

}  // namespace qs
