// SPDX-License-Identifier: MIT
//
// The cameras of a file.
#include "io/camera/cameras.h"

#include <vector>

#include "library/check/call.h"
#include "library/check/stage_arguments.h"
#include "library/check/structs.h"
#include "quadsplat/quadsplat.h"

struct QsCameras {
  std::vector<qs::LensCamera> list;
};

using namespace qs::library;

namespace {

int32_t get(const QsCameras* cameras, std::uint64_t number, QsCamera* camera, const char** name,
            char* message, const char* function, bool with_lens) {
  return library::call(function, message, [&](const char* name_of_call) {
    require(cameras, {name_of_call, "cameras"});
    if (number >= cameras->list.size())
      refuse({name_of_call, "number"}, "{} is not below {}", number, cameras->list.size());
    const LensCamera& found = cameras->list[number];
    const DrawnCamera drawn =
        with_lens ? DrawnCamera{found.taken(), found.lens} : DrawnCamera{found.camera};
    write_struct(camera_struct(drawn), camera, {name_of_call, "camera"});
    if (name != nullptr) *name = found.camera.name.c_str();
  });
}

}  // namespace

int32_t qs_cameras_open(const char* path, QsCameras** cameras, uint64_t* count, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require(cameras, {function, "cameras"});
    *cameras = nullptr;
    require_text(path, {function, "path"});
    require(count, {function, "count"});
    *cameras = new QsCameras{read_camera_set(path).cameras};
    *count = (*cameras)->list.size();
  });
}

int32_t qs_cameras_get(const QsCameras* cameras, uint64_t number, QsCamera* camera,
                       const char** name, char* message) {
  return get(cameras, number, camera, name, message, __func__, false);
}

int32_t qs_cameras_lens(const QsCameras* cameras, uint64_t number, QsCamera* camera,
                        const char** name, char* message) {
  return get(cameras, number, camera, name, message, __func__, true);
}

void qs_cameras_close(QsCameras* cameras) { delete cameras; }
