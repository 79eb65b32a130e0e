// SPDX-License-Identifier: MIT
//
// Scenes as files.
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <glm/gtc/type_ptr.hpp>

#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/writer.h"
#include "library/api/scene.h"
#include "library/check/structs.h"
#include "raster/scene/cloud_order.h"
#include "raster/scene/removal.h"

using namespace qs::library;

namespace {

QsConversion conversion_of(const QsConversion* given, const Where& where) {
  if (given == nullptr) return QS_CONVERSION;
  const QsConversion conversion = read_struct(given, where);
  if (conversion.overwrite > 1) refuse(where / "overwrite", "is {}", conversion.overwrite);
  if (conversion.reserved != 0) refuse(where / "reserved", "is not 0");
  if (conversion.sh_degree < 0 || conversion.sh_degree > kMaxShDegree)
    refuse(where / "sh_degree", "{} is not between 0 and {}", conversion.sh_degree, kMaxShDegree);
  if (conversion.reserved2 != 0) refuse(where / "reserved2", "is not 0");
  if (conversion.drops_floaters > 1)
    refuse(where / "drops_floaters", "is {}", conversion.drops_floaters);
  for (int axis = 0; axis < 3; ++axis) {
    const float low = conversion.crop_low[axis], high = conversion.crop_high[axis];
    if (!(std::isfinite(low) && std::isfinite(high) && low <= high))
      refuse(where / "crop_low", "{} is not at most crop_high {} and finite", low, high);
  }
  return conversion;
}

/// The box of the conversion, if it has one.
std::optional<CropBox> box_of(const QsConversion& conversion) {
  const CropBox box{glm::make_vec3(conversion.crop_low), glm::make_vec3(conversion.crop_high)};
  return box == CropBox{} ? std::nullopt : std::optional(box);
}

void write_converted(const OpenScene& scene, const std::filesystem::path& path,
                     const QsConversion& conversion, const Use& use) {
  const FileGuard guard(conversion.overwrite == 1, kOverwriteOption, GuardScope::thread);
  if (!scene.path().empty()) note_input(scene.path());
  check_targets({path});
  const std::string format = conversion.format != nullptr ? conversion.format : "";
  const Progress progress{{}, use.stop()};
  const std::optional<CropBox> box = box_of(conversion);
  GaussianCloud rest;
  if (box || conversion.drops_floaters == 1) {
    const Removal removal = find_removal(
        scene.cloud(), box,
        conversion.drops_floaters == 1 ? std::optional(Floaters()) : std::nullopt, progress);
    if (removal.staying() == 0)
      refuse({"qs_convert", "conversion"}, "leaves out all {} Gaussians", removal.all());
    rest = keep_rest(scene.cloud(), removal);
  }
  const GaussianCloud& cloud = rest.empty() ? scene.cloud() : rest;
  const bool all = conversion.keep_largest == 0 || conversion.keep_largest >= cloud.size();
  if (all && cloud.sh_degree <= conversion.sh_degree) {
    write_scene(cloud, path, use.pool(), progress, format);
    return;
  }
  GaussianCloud less = with_sh_degree(cloud, conversion.sh_degree);
  if (!all) less = keep_largest(std::move(less), conversion.keep_largest);
  write_scene(less, path, use.pool(), progress, format);
}

}  // namespace

int32_t qs_convert(QsSceneHandle* scene, const char* path, const QsConversion* conversion,
                   char* message) {
  return library::call(__func__, message, "scene", scene, [&](const char* function) {
    require_text(path, {function, "path"});
    const QsConversion chosen = conversion_of(conversion, {function, "conversion"});
    const Use use(scene->scene.context(), {function, "scene"});
    if (scene->scene.cloud().empty()) refuse({function, "scene"}, "has no Gaussian to write");
    write_converted(scene->scene, path, chosen, use);
  });
}
