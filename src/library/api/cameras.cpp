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
  std::vector<qs::Camera> list;
};

using namespace qs::library;

int32_t qs_cameras_open(const char* path, QsCameras** cameras, uint64_t* count, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require(cameras, {function, "cameras"});
    *cameras = nullptr;
    require_text(path, {function, "path"});
    require(count, {function, "count"});
    *cameras = new QsCameras{read_cameras(path)};
    *count = (*cameras)->list.size();
  });
}

int32_t qs_cameras_get(const QsCameras* cameras, uint64_t number, QsCamera* camera,
                       const char** name, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require(cameras, {function, "cameras"});
    if (number >= cameras->list.size())
      refuse({function, "number"}, "{} is not below {}", number, cameras->list.size());
    const Camera& found = cameras->list[number];
    write_struct(camera_struct(found), camera, {function, "camera"});
    if (name != nullptr) *name = found.name.c_str();
  });
}

void qs_cameras_close(QsCameras* cameras) { delete cameras; }
