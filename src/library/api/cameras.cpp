// SPDX-License-Identifier: MIT
//
// The cameras of a file.
#include "io/camera/cameras.h"

#include <vector>

#include "library/check/call.h"
#include "library/check/structs.h"
#include "library/check/view_arguments.h"
#include "quadsplat/quadsplat.h"

struct QsCameras {
  std::vector<qs::Camera> list;
};

using namespace qs;
using namespace qs::library;

int32_t qs_cameras_open(const char* path, QsCameras** cameras, uint64_t* count, char* message) {
  return library::call(message, [&] {
    constexpr const char* kCall = "qs_cameras_open";
    require(cameras, {kCall, "cameras"});
    *cameras = nullptr;
    require_text(path, {kCall, "path"});
    require(count, {kCall, "count"});
    *cameras = new QsCameras{read_cameras(path)};
    *count = (*cameras)->list.size();
  });
}

int32_t qs_cameras_get(const QsCameras* cameras, uint64_t number, QsCamera* camera,
                       const char** name, char* message) {
  return library::call(message, [&] {
    constexpr const char* kCall = "qs_cameras_get";
    require(cameras, {kCall, "cameras"});
    if (number >= cameras->list.size())
      refuse({kCall, "number"}, "{} is not below {}", number, cameras->list.size());
    const Camera& found = cameras->list[number];
    write_struct(camera_struct(found), camera, {kCall, "camera"});
    if (name != nullptr) *name = found.name.c_str();
  });
}

void qs_cameras_close(QsCameras* cameras) { delete cameras; }
