// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <ostream>
#include <string>

#include "base/fail.h"
#include "base/list_of.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/replace_file.h"
#include "io/bytes/zip.h"
#include "io/scene/compact/compact_model.h"
#include "io/scene/compact/huffman.h"
#include "io/scene/ply/ply.h"
#include "io/tensor/npy.h"
#include "io/tensor/torch_tensor.h"
#include "raster/kernel/half.h"

namespace qs {
namespace {

constexpr float kMostZeroOfGrid = 0.1f;

// Values of any plain type as bytes.
template <class T>
std::string raw(std::span<const T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

ZipEntry array(const std::string& name, const char* type, const std::string& shape,
               const std::string& values) {
  return {name + ".npy", npy_header(type, shape) + values};
}

std::string row_of(std::size_t count) { return fmt::format("({},)", count); }

ZipEntry bytes_entry(const std::string& name, ByteSpan bytes) {
  return array(name, "|u1", row_of(bytes.size()), raw(bytes));
}

std::string halves_of(std::span<const float> values) {
  const auto halves = list_of<std::uint16_t>(values, round_to_half);
  return raw(std::span<const std::uint16_t>(halves));
}

// An array without dimensions that holds one object, which add(pickle) appends.
template <class Add>
ZipEntry object_entry(const std::string& name, const Add& add) {
  PickleWriter pickle;
  pickle.name("numpy.core.multiarray", "_reconstruct").begin().name("numpy", "ndarray");
  pickle.begin().integer(0).tuple().bytes("b").tuple().call();
  pickle.begin().integer(1).begin().tuple();
  pickle.name("numpy", "dtype").begin().text("O8").boolean(false).boolean(true).tuple().call();
  pickle.begin().integer(3).text("|").none().none().none().integer(-1).integer(-1).integer(63);
  pickle.tuple().state().boolean(false).list().begin();
  add(pickle);
  pickle.append().tuple().state();
  return array(name, "|O", "()", pickle.take());
}

// The buffers of the published program's codebooks. Only `embed` is read.
ZipEntry codebook_entry(const std::string& name, const ResidualCodebook& codebook) {
  std::vector<NamedTensor> tensors;
  for (std::size_t layer = 0; layer < codebook.layers; ++layer) {
    const std::string prefix = fmt::format("layers.{}._codebook.", layer);
    const float* const begin = codebook.code(layer, 0);
    Tensor embed{{1, codebook.codes(), codebook.dimensions},
                 {begin, begin + codebook.codes() * codebook.dimensions}};
    tensors.push_back({prefix + "initted", {{1}, {1}}});
    tensors.push_back({prefix + "cluster_size",
                       {{1, codebook.codes()}, std::vector<float>(codebook.codes(), 1)}});
    tensors.push_back({prefix + "embed_avg", embed});
    tensors.push_back({prefix + "embed", std::move(embed)});
  }
  return object_entry(name, [&](PickleWriter& pickle) { add_embedded_tensors(pickle, tensors); });
}

ZipEntry sizes_entry(const ResidualCodebook& codebook) {
  const std::array<std::int64_t, 2> sizes = {static_cast<std::int64_t>(codebook.layers),
                                             codebook.bits};
  return array("rvq_info", "<i8", "(2,)", raw(std::span<const std::int64_t>(sizes)));
}

// A stream of Huffman codes, and its table. Symbols of quantised values are reals there.
void add_huffman(std::vector<ZipEntry>& entries, const std::string& name,
                 std::span<const std::uint16_t> symbols, bool reals) {
  std::vector<std::uint64_t> counts;
  for (const std::uint16_t symbol : symbols) {
    if (symbol >= counts.size()) counts.resize(symbol + std::size_t{1});
    ++counts[symbol];
  }
  const std::vector<HuffmanCode> table = make_huffman_table(counts);
  entries.push_back(bytes_entry(name, huffman_encode(table, symbols)));
  entries.push_back(object_entry("huftable_" + name, [&](PickleWriter& pickle) {
    pickle.dictionary().begin();
    for (const HuffmanCode& code : table) {
      if (code.symbol == kHuffmanEnd) {
        pickle.name("dahuffman.huffmancodec", "_EndOfFileSymbol").make();
      } else if (reals) {
        pickle.real(code.symbol);
      } else {
        pickle.integer(code.symbol);
      }
      pickle.begin().integer(code.bits).integer(static_cast<std::int64_t>(code.value)).tuple();
    }
    pickle.set_items();
  }));
}

void add_quantised(std::vector<ZipEntry>& entries, const std::string& name,
                   const QuantisedValues& values) {
  add_huffman(entries, name, values.numbers, true);
  const std::array bounds = {values.low, values.high};
  entries.push_back(array("minmax_" + name, "<f4", "(2,)", raw(std::span<const float>(bounds))));
}

ZipEntry means_entry(const CompactModel& model) {
  std::vector<float> values;
  values.reserve(3 * model.means.size());
  for (const glm::vec3& mean : model.means) values.insert(values.end(), {mean.x, mean.y, mean.z});
  return array("xyz", "<f2", fmt::format("({}, 3)", model.means.size()), halves_of(values));
}

ZipEntry weights_entry(const CompactModel& model) {
  return array("mlp", "<f2", row_of(model.field.weights.size()), halves_of(model.field.weights));
}

}  // namespace

void write_compact_ply(const CompactModel& model, const std::filesystem::path& path, bool trained) {
  constexpr std::array kNames = {"x",     "y",       "z",       "nx",      "ny",
                                 "nz",    "opacity", "scale_0", "scale_1", "scale_2",
                                 "rot_0", "rot_1",   "rot_2",   "rot_3"};
  std::string header = kPlyStart + ply_element("vertex", model.means.size(), "float", kNames);
  if (trained) header += kTrainedComment;
  write_file(path, [&](std::ostream& file) {
    file << header << "end_header\n";
    for (std::size_t i = 0; i < model.means.size(); ++i) {
      const glm::vec3 &mean = model.means[i], &scale = model.scales[i];
      const glm::vec4& q = model.rotations[i];
      const std::array row = {mean.x,  mean.y,  mean.z,  0.0f, 0.0f, 0.0f, model.opacities[i],
                              scale.x, scale.y, scale.z, q.x,  q.y,  q.z,  q.w};
      file.write(reinterpret_cast<const char*>(row.data()), sizeof row);
    }
  });
  const auto vector = [](const std::vector<float>& values) {
    return Tensor{{values.size()}, values};
  };
  std::filesystem::path weights = path;
  weights.replace_extension(".pth");
  write_torch_file(weights, {{{"0.params", vector(model.field.grid_values)},
                              {"1.params", vector(model.field.weights)}}});
}

void write_compact_npz(const CompactModel& model, const CodedVectors& scales,
                       const CodedVectors& rotations, const std::filesystem::path& path) {
  const auto codes = [](const std::string& name, const CodedVectors& vectors) {
    return bytes_entry(name, pack_bits(vectors.numbers, vectors.codebook.bits));
  };
  write_zip(path,
            {means_entry(model),
             array("opacity", "<f2", fmt::format("({}, 1)", model.opacities.size()),
                   halves_of(model.opacities)),
             codes("scale", scales), codes("rotation", rotations),
             array("hash", "<f2", row_of(model.field.grid_values.size()),
                   halves_of(model.field.grid_values)),
             weights_entry(model), codebook_entry("codebook_scale", scales.codebook),
             codebook_entry("codebook_rotation", rotations.codebook), sizes_entry(scales.codebook)},
            ZipForm::stored);
}

void write_compact_processed(const CompactModel& model, const CodedVectors& scales,
                             const CodedVectors& rotations, const std::filesystem::path& path) {
  std::vector<ZipEntry> entries = {
      means_entry(model), weights_entry(model), codebook_entry("codebook_scale", scales.codebook),
      codebook_entry("codebook_rotation", rotations.codebook), sizes_entry(scales.codebook)};
  add_quantised(entries, "opacity", quantise(model.opacities, 0));
  add_quantised(entries, "hash", quantise(model.field.grid_values, kMostZeroOfGrid));
  add_huffman(entries, "scale", scales.numbers, false);
  add_huffman(entries, "rotation", rotations.numbers, false);
  write_zip(path, entries, ZipForm::deflated);
}

float QuantisedValues::value(std::size_t i) const {
  const auto from = static_cast<double>(low), to = static_cast<double>(high);
  return static_cast<float>((to - from) * numbers[i] / 255.0 + from);
}

QuantisedValues quantise(std::span<const float> values, float most_zero) {
  QuantisedValues quantised;
  if (values.empty()) return quantised;
  const auto [least, largest] = std::ranges::minmax_element(values);
  quantised.low = *least;
  quantised.high = *largest;
  const float range = *largest - *least;
  quantised.numbers.reserve(values.size());
  for (const float value : values) {
    const float kept = std::abs(value) > most_zero ? value : 0;
    const float step = range > 0 ? (kept - quantised.low) / range * 255 : 0;
    quantised.numbers.push_back(
        step > 0 ? static_cast<std::uint16_t>(std::min(std::nearbyint(step), 255.0f)) : 0);
  }
  return quantised;
}

}  // namespace qs
