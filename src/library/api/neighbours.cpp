// SPDX-License-Identifier: MIT
//
// Distances of points to their nearest neighbours.
#include <vector>

#include "learn/step/nearest.h"
#include "library/check/arrays.h"
#include "library/check/context.h"
#include "library/check/stage_arguments.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include "learn/diff/cuda/device.h"
#include "learn/diff/cuda/nearest.h"
#endif

using namespace qs::library;

namespace {

void find_on_host(const QsArray& points, const QsArray& distances2, ThreadPool& pool) {
  const std::int64_t count = points.sizes[0];
  std::vector<glm::vec3> given(static_cast<std::size_t>(count));
  const auto* const elements = static_cast<const float*>(points.data);
  for (std::int64_t i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis)
      given[static_cast<std::size_t>(i)][axis] = elements[offset_of(points, i, axis)];
  const std::vector<double> found = train::neighbour_distances2(given, pool);
  store_numbers(distances2,
                [&](std::int64_t i, std::int64_t) { return found[static_cast<std::size_t>(i)]; });
}

void find_on_gpu([[maybe_unused]] const QsArray& points, [[maybe_unused]] const QsArray& distances2,
                 [[maybe_unused]] const Use& use) {
#ifdef QUADSPLAT_HAVE_CUDA
  const cuda::diff::SelectedGpu selected(use.device());
  const auto count = static_cast<std::size_t>(points.sizes[0]);
  const cuda::diff::Queue queue{use.stream(), use.stop()};
  if (distances2.type == QS_FLOAT64)
    cuda::diff::neighbour_distances2(rows_of<const float>(points), count, queue,
                                     rows_of<double>(distances2));
  else
    cuda::diff::neighbour_distances2(rows_of<const float>(points), count, queue,
                                     rows_of<float>(distances2));
#endif
}

}  // namespace

int32_t qs_neighbours(QsContext* context, const QsArray* points, const QsArray* distances2,
                      char* message) {
  return library::call(__func__, message, [&](const char* function) {
    const Where of_points{function, "points"};
    require_all(function, {{"context", context}, {"points", points}, {"distances2", distances2}});
    check_dimensions(*points, of_points, 2);
    const std::int64_t count = points->sizes[0];
    if (count > kMostGaussians) refuse(of_points, "{} points are too many", count);
    const Place place{points->memory, points->device, "points"};
    check_array(*points, of_points, {count, 3}, kFloat32, Access::reads, place);
    check_array(*distances2, {function, "distances2"}, {count}, kReals, Access::writes, place);
    const Use use(*context->context, {function, "context"});
    if (place.is_gpu()) {
      use.require_gpu(place.device, of_points);
      find_on_gpu(*points, *distances2, use);
    } else {
      find_on_host(*points, *distances2, use.pool());
    }
  });
}
