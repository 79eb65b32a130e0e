// SPDX-License-Identifier: MIT
//
// Distances of points to their nearest neighbours.
#include <vector>

#include "learn/step/nearest.h"
#include "library/check/arrays.h"
#include "library/check/context.h"

using namespace qs::library;

int32_t qs_neighbours(QsContext* context, const QsArray* points, const QsArray* distances2,
                      char* message) {
  return library::call(__func__, message, [&](const char* function) {
    const Where of_points{function, "points"};
    require_all(function, {{"context", context}, {"points", points}, {"distances2", distances2}});
    check_dimensions(*points, of_points, 2);
    const std::int64_t count = points->sizes[0];
    if (count > kMostGaussians) refuse(of_points, "{} points are too many", count);
    check_array(*points, of_points, {count, 3}, kFloat32, Access::reads);
    check_array(*distances2, {function, "distances2"}, {count}, kReals, Access::writes);
    const Use use(*context->context, {function, "context"});
    std::vector<glm::vec3> given(static_cast<std::size_t>(count));
    const auto* const elements = static_cast<const float*>(points->data);
    for (std::int64_t i = 0; i < count; ++i)
      for (int axis = 0; axis < 3; ++axis)
        given[static_cast<std::size_t>(i)][axis] = elements[offset_of(*points, i, axis)];
    const std::vector<double> found = train::neighbour_distances2(given, use.pool());
    with_type(*distances2, [&](auto* to) {
      for (std::int64_t i = 0; i < count; ++i)
        to[i * distances2->strides[0]] =
            static_cast<std::remove_pointer_t<decltype(to)>>(found[static_cast<std::size_t>(i)]);
    });
  });
}
