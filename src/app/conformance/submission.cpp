// SPDX-License-Identifier: MIT
#include <algorithm>

#include "app/conformance/judge.h"
#include "base/fail.h"
#include "io/picture/image_file.h"

namespace qs {

Submission read_submission(const std::filesystem::path& folder) {
  Submission submission;
  bool any = false;
  for (const KitScene& scene : kit_scenes()) {
    Picture8& picture = submission.pictures.emplace_back();
    std::string& problem = submission.problems.emplace_back();
    const std::filesystem::path file = folder / (std::string(scene.name) + ".png");
    if (!std::filesystem::exists(file)) continue;
    any = true;
    const Camera camera = scene.make().camera;
    try {
      const Image image = read_image(file);
      if (image.width == camera.width && image.height == camera.height)
        picture = picture8(image);
      else
        problem = fmt::format("it has {} x {} pixels instead of {} x {}", image.width, image.height,
                              camera.width, camera.height);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::input) throw;
      problem = error.what();
    }
  }
  if (!any) {
    fail("{}: it has no picture of the kit, such as {}.png", folder.string(),
         kit_scenes().front().name);
  }
  return submission;
}

}  // namespace qs
