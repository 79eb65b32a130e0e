// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <system_error>

#include "base/fail.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/mapped_file.h"
#include "io/scene/compact/compact_model.h"
#include "io/scene/ply/ply_file.h"
#include "io/tensor/torch_tensor.h"

namespace qs {
namespace {

constexpr const char* kGrid = "0.params";
constexpr const char* kNetwork = "1.params";

void read_gaussians(const PlyRows& rows, const std::string& path, CompactModel& model) {
  std::vector<PlyColumn> columns;
  for (const char* name : {"x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1",
                           "rot_2", "rot_3", "opacity"})
    columns.push_back(rows.of_vertices(name, path));
  model.means.resize(rows.count);
  model.scales.resize(rows.count);
  model.rotations.resize(rows.count);
  model.opacities.resize(rows.count);
  for (std::size_t i = 0; i < rows.count; ++i) {
    const auto value = [&](std::size_t column) {
      return static_cast<float>(rows.value(i, columns[column]));
    };
    model.means[i] = {value(0), value(1), value(2)};
    model.scales[i] = {value(3), value(4), value(5)};
    model.rotations[i] = {value(6), value(7), value(8), value(9)};
    model.opacities[i] = value(10);
  }
}

// The header does not say what the values are.
void find_activated(CompactModel& model) {
  // No sigmoid has a value outside of 0..1, and hardly any training has all its logits inside.
  const auto is_unit = [](float value) { return !(value < 0 || value > 1); };
  model.activated_opacities = std::all_of(model.opacities.begin(), model.opacities.end(), is_unit);
  if (model.activated_opacities) return;
  // Logarithms in 0..1 are standard deviations of 1 to 2.7 units: most Gaussians are smaller.
  const auto inside =
      std::count_if(model.scales.begin(), model.scales.end(), [&](const glm::vec3& scale) {
        return is_unit(scale.x) && is_unit(scale.y) && is_unit(scale.z);
      });
  model.activated_shapes = 2 * static_cast<std::size_t>(inside) > model.scales.size();
}

FilePart tensor_part(const char* name, const Tensor& tensor) {
  return {fmt::format(".pth: {}", name), tensor.values.size() * sizeof(float),
          fmt::format("{} values of 32 bits", tensor.values.size())};
}

}  // namespace

CompactModel read_compact_ply(ByteSpan content, const std::filesystem::path& path,
                              const Progress& progress) {
  std::filesystem::path weights = path;
  weights.replace_extension(".pth");
  std::error_code error;
  if (!std::filesystem::is_regular_file(weights, error))
    fail(
        "{}: its Gaussians have no colours (f_dc); Compact-3DGS keeps them in a network, but {} "
        "is not beside it",
        path.string(), weights.filename().string());
  const PlyHeader header = parse_ply_header(content, path);
  PlyBody body(content, header, path, progress);
  const PlyRows rows = body.rows("vertex");
  CompactModel model;
  read_gaussians(rows, path.string(), model);
  model.warnings = body.leftovers();
  find_activated(model);

  const MappedFile file(weights);
  const TorchFile torch(file.content(), weights);
  Tensor grid = torch.tensor(kGrid), network = torch.tensor(kNetwork);
  model.file_bytes = content.size() + file.content().size();
  const std::uint64_t row_bytes = rows.count * header.find("vertex")->row_bytes;
  model.parts = {{".ply: vertices", row_bytes,
                  fmt::format("{} rows of {} values", rows.count, rows.columns.size())},
                 tensor_part(kGrid, grid),
                 tensor_part(kNetwork, network)};
  model.form = model.activated_opacities ? ".ply and .pth"
               : model.activated_shapes  ? ".ply and .pth, of the first release"
                                         : ".ply and .pth, before the last iteration";
  model.field =
      make_color_field(std::move(grid.values), std::move(network.values), weights.string());
  return model;
}

}  // namespace qs
