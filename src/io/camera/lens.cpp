// SPDX-License-Identifier: MIT
#include "io/camera/lens.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/fail.h"
#include "raster/lens/lens_view.h"

namespace qs {
namespace {

constexpr double kHalfTurn = std::numbers::pi;
constexpr double kLeastFactor = 0.5, kMostFactor = 2;
constexpr int kBorderPoints = 64;  // per side
// Wider photographs are divided into faces.
constexpr double kWidestPinhole = kHalfTurn * 100 / 180;
constexpr double kHalfFace = kHalfTurn * 48 / 180;
constexpr double kLeastShare = 0.1;  // of a face's pixels

const std::array kFaces = {Face{"front", kCubeAxes[0]}, Face{"right", kCubeAxes[1]},
                           Face{"back", kCubeAxes[2]},  Face{"left", kCubeAxes[3]},
                           Face{"up", kCubeAxes[4]},    Face{"down", kCubeAxes[5]}};

glm::dvec2 scaled_center(glm::dvec2 center, glm::dvec2 factor) {
  return (center + 0.5) * factor - 0.5;  // distances from the pixel corner are scaled
}

// Calls visit(pixel) for points on the photograph's border.
template <class Visit>
void for_each_border_point(glm::dvec2 size, const Visit& visit) {
  const glm::dvec2 low(-0.5), high = size - 0.5;
  for (int i = 0; i <= kBorderPoints; ++i) {
    const glm::dvec2 at = low + (high - low) * (static_cast<double>(i) / kBorderPoints);
    for (const glm::dvec2 point : {glm::dvec2(at.x, low.y), glm::dvec2(at.x, high.y),
                                   glm::dvec2(low.x, at.y), glm::dvec2(high.x, at.y)})
      visit(point);
  }
}

// The share of points of the picture for which test(pixel) holds. They are a Fibonacci lattice,
// because rows and columns of a grid would be in or out as a whole.
template <class Test>
double share_of(glm::dvec2 size, const Test& test) {
  constexpr int kPoints = 2584;
  int count = 0;
  for (int i = 0; i < kPoints; ++i) {
    const glm::dvec2 place((i + 0.5) / kPoints, glm::fract(i / std::numbers::phi));
    count += test(place * size - 0.5) ? 1 : 0;
  }
  return static_cast<double>(count) / kPoints;
}

glm::dvec2 size_of(const Camera& camera) { return {camera.width, camera.height}; }

LensCamera one_pinhole(const Lens& lens, double factor) {
  LensCamera result{{}, lens};
  result.camera.focal_px = lens.focal_px * factor;
  result.camera.center_px = lens.center_px;
  result.camera.width = static_cast<int>(std::lround(lens.size_px.x));
  result.camera.height = static_cast<int>(std::lround(lens.size_px.y));
  return result;
}

// True if every pixel of the pinhole camera is inside the photograph, and no direction is shown
// twice.
bool fills(const LensCamera& view) {
  bool inside = true;
  for_each_border_point(size_of(view.camera), [&](glm::dvec2 point) {
    inside = inside && view.source_of(point).has_value();
  });
  return inside;
}

// True if the photograph shows more than kWidestPinhole from side to side, or if a side's middle
// shows nothing.
bool is_wide(const Lens& lens) {
  if (lens.model->plane == LensPlane::perspective) return false;  // fills() decides
  const glm::dvec2 low(-0.5), high = lens.size_px - 0.5, middle = 0.5 * (low + high);
  const auto angle_at = [&](double x, double y) {
    const auto seen = lens.direction({x, y});
    return seen ? std::atan2(glm::length(glm::dvec2(*seen)), seen->z) : kHalfTurn;
  };
  return angle_at(low.x, middle.y) + angle_at(high.x, middle.y) > kWidestPinhole ||
         angle_at(middle.x, low.y) + angle_at(middle.x, high.y) > kWidestPinhole;
}

// The largest number of the photograph's pixels per radian, away from the axis, in a face.
double densest(const Lens& lens) {
  double most = 1;
  if (lens.model->plane != LensPlane::panorama) {
    constexpr int kRings = 32;
    const bool is_slope = lens.model->plane == LensPlane::perspective;
    // Formulas may grow without limit beyond the photograph's corners.
    double farthest = 0;
    for (const double x : {-0.5, lens.size_px.x - 0.5})
      for (const double y : {-0.5, lens.size_px.y - 0.5}) {
        const auto seen = lens.direction({x, y});
        farthest =
            std::max(farthest, seen ? glm::length(to_plane(lens.model->plane, *seen)) : lens.limit);
      }
    const double edge =
        std::min({lens.limit, farthest, is_slope ? std::tan(kHalfFace) : kHalfTurn});
    for (int ring = 0; ring < kRings; ++ring) {
      const double radius = edge * ring / kRings;
      const glm::dvec2 slope =
          bend_derivative(*lens.model, {radius, 0}, lens.coefficients.data()).by_x;
      most = std::max(most, glm::length(slope));
    }
  }
  constexpr double kMost = 4;  // next to a pole of a formula no pixel is worth it
  return std::min(most, kMost) * std::max(lens.focal_px.x, lens.focal_px.y);
}

// One face of a divided photograph; `taken` has the lens's pose.
LensCamera face_of(const LensCamera& taken, const Face& face) {
  constexpr double kMostPixels = 16384;
  LensCamera view = taken;
  Camera& camera = view.camera;
  const double focal = densest(*taken.lens);
  const double side = std::clamp(std::ceil(2 * focal * std::tan(kHalfFace)), 2.0, kMostPixels);
  camera.width = camera.height = static_cast<int>(side);
  camera.focal_px = glm::dvec2(0.5 * side / std::tan(kHalfFace));
  camera.center_px = glm::dvec2(0.5 * (side - 1));
  const glm::dmat3 turn = glm::transpose(face.lens_from_face);
  camera.view_from_world = turn * taken.camera.view_from_world;
  if (!camera.name.empty()) camera.name += "_" + std::string(face.name);
  view.lens->face = face.name;
  return view;
}

void check_range(std::string_view name, double value, const std::string& where) {
  const auto refuse = [&](const char* range) {
    fail("{}: {} is {}, but must be {}", where, name, value, range);
  };
  if (name == "omega" && !(value > 0 && value < kHalfTurn)) refuse("between 0 and pi");
  if (name == "alpha" && !(value >= 0 && value <= 1)) refuse("from 0 to 1");
  if (name == "beta" && !(value > 0)) refuse("above 0");
}

void set_panorama(Lens& lens, const std::string& where) {
  const glm::dvec2 sides = lens.size_px;
  if (std::abs(sides.x - 2 * sides.y) > 1)
    fail("{}: a panorama of {} x {} pixels is not twice as wide as high", where, sides.x, sides.y);
  lens.focal_px = {sides.x / (2 * kHalfTurn), sides.y / kHalfTurn};
  lens.center_px = 0.5 * sides - 0.5;
}

}  // namespace

const Face* find_face(std::string_view name) {
  const auto found = std::ranges::find(kFaces, name, &Face::name);
  return found == kFaces.end() ? nullptr : &*found;
}

std::optional<glm::dvec2> Lens::project(glm::dvec3 direction) const {
  const glm::dvec2 point = to_plane(model->plane, direction);
  if (!(glm::dot(point, point) <= limit * limit)) return std::nullopt;
  return focal_px * model->bend(point, coefficients.data()) + center_px;
}

std::optional<glm::dvec3> Lens::direction(glm::dvec2 pixel) const {
  constexpr int kSteps = 200, kMostStops = 4;
  constexpr double kExact = 1e-11;
  const glm::dvec2 wanted = (pixel - center_px) / focal_px;
  if (model->plane == LensPlane::panorama) {
    if (!(std::abs(wanted.x) <= kHalfTurn && std::abs(wanted.y) <= 0.5 * kHalfTurn))
      return std::nullopt;
    return from_plane(model->plane, wanted);
  }
  glm::dvec2 at = wanted;
  int stops = 0;  // at the limit, which a direction outside of it passes again and again
  for (int step = 0; step < kSteps; ++step) {
    if (const double length = glm::length(at); length > limit) {
      if (++stops > kMostStops) return std::nullopt;
      at *= limit / length;
    }
    const glm::dvec2 error = model->bend(at, coefficients.data()) - wanted;
    const auto [by_x, by_y] = bend_derivative(*model, at, coefficients.data());
    glm::dvec2 change = glm::inverse(glm::dmat2(by_x, by_y)) * error;
    const double size = glm::length(change), most = std::max(0.1, 0.1 * glm::length(at));
    if (!std::isfinite(size)) return std::nullopt;
    if (size > most) change *= most / size;
    at -= change;
    if (size <= 1e-15 * (1 + glm::length(at))) break;
  }
  const glm::dvec2 error = model->bend(at, coefficients.data()) - wanted;
  const bool is_found = glm::length(error) <= kExact * (1 + glm::length(wanted));
  if (!is_found || !(glm::length(at) <= limit)) return std::nullopt;
  return from_plane(model->plane, at);
}

bool Lens::has_pixel(glm::dvec2 pixel, double margin) const {
  constexpr double kRounding = 1e-9;
  const glm::dvec2 low(margin - 0.5 - kRounding), high = size_px - 1.0 - low;
  return pixel.x >= low.x && pixel.y >= low.y && pixel.x <= high.x && pixel.y <= high.y;
}

Lens Lens::scaled(glm::dvec2 factor) const {
  Lens result = *this;
  result.size_px *= factor;
  result.focal_px *= factor;
  result.center_px = scaled_center(center_px, factor);
  return result;
}

LensCamera LensCamera::scaled(int width, int height) const {
  const glm::dvec2 factor(static_cast<double>(width) / camera.width,
                          static_cast<double>(height) / camera.height);
  LensCamera result = *this;
  result.camera.focal_px *= factor;
  result.camera.center_px = scaled_center(camera.center_px, factor);
  result.camera.width = width;
  result.camera.height = height;
  if (result.lens) result.lens = lens->scaled(factor);
  return result;
}

glm::dvec2 LensCamera::photograph_size() const { return lens ? lens->size_px : size_of(camera); }

Camera LensCamera::taken() const {
  Camera result = camera;
  if (!lens) return result;
  if (const Face* const face = find_face(lens->face))
    result.view_from_world = face->lens_from_face * camera.view_from_world;
  result.focal_px = lens->focal_px;
  result.center_px = lens->center_px;
  result.width = static_cast<int>(std::lround(lens->size_px.x));
  result.height = static_cast<int>(std::lround(lens->size_px.y));
  return result;
}

std::optional<glm::dvec2> LensCamera::source_of(glm::dvec2 pixel) const {
  constexpr double kMargin = 1.5;  // bicubic interpolation needs two pixels on each side
  glm::dvec3 direction((pixel - camera.center_px) / camera.focal_px, 1);
  const Face* const face = find_face(lens->face);
  if (face != nullptr) direction = face->lens_from_face * direction;
  const std::optional<glm::dvec2> source = lens->project(direction);
  const bool ends = face != nullptr && lens->model->plane != LensPlane::panorama;
  return source && lens->has_pixel(*source, ends ? kMargin : 0) ? source : std::nullopt;
}

Lens checked_lens(Lens lens, const std::string& where) {
  const LensModel& model = *lens.model;
  if (model.plane == LensPlane::panorama) set_panorama(lens, where);
  const glm::dvec2 focal = lens.focal_px, center = lens.center_px;
  const auto is_finite = [](double value) { return std::isfinite(value); };
  if (!std::ranges::all_of(std::array{focal.x, focal.y, center.x, center.y}, is_finite) ||
      !std::ranges::all_of(lens.coefficients, is_finite))
    fail_not_finite("{}: a parameter is not finite", where);
  if (!(focal.x > 0 && focal.y > 0)) fail("{}: the focal length is not above 0", where);
  for (int i = 0; i < model.coefficients(); ++i)
    check_range(model.coefficient(i), lens.coefficients[static_cast<std::size_t>(i)], where);
  lens.limit = fold_radius(model, lens.coefficients.data());
  return lens;
}

bool distorts(const Lens& lens) {
  return !lens.model->pinhole || std::ranges::any_of(lens.coefficients, [](double value) {
    return std::abs(value) > kNoDistortion;
  });
}

LensCamera lens_camera(const Lens& lens, const std::string& where) {
  const Lens checked = checked_lens(lens, where);
  if (!distorts(checked)) return {one_pinhole(checked, 1).camera, std::nullopt};
  return undistorted_camera(checked, where);
}

LensCamera undistorted_camera(const Lens& lens, const std::string& where) {
  const auto at = [&](double factor) { return one_pinhole(lens, factor); };
  double low = kLeastFactor, high = kMostFactor;
  if (!is_wide(lens) && fills(at(high))) {
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (fills(at(middle)) ? high : low) = middle;
    }
    return at(high);
  }
  LensCamera all = face_of({{}, lens}, kFaces[0]);
  all.lens->face = kAllFaces;
  if (views_of(all).empty())
    fail("{}: the lens distorts too strongly: its photograph shows less than a tenth of every face",
         where);
  return all;
}

std::vector<LensCamera> views_of(const LensCamera& camera) {
  if (!camera.lens || camera.lens->face != kAllFaces) return {camera};
  std::vector<LensCamera> views;
  for (const Face& face : kFaces) {
    const LensCamera view = face_of(camera, face);
    const auto is_shown = [&](glm::dvec2 pixel) { return view.source_of(pixel).has_value(); };
    if (share_of(size_of(view.camera), is_shown) >= kLeastShare) views.push_back(view);
  }
  return views;
}

Camera compared_camera(Camera camera, const std::optional<Lens>& lens) {
  if (lens && find_face(lens->face) != nullptr) camera.projection = Projection::face;
  return camera;
}

bool is_next_face(const std::vector<LensCamera>& cameras, std::size_t i) {
  return i > 0 && cameras[i].is_face() && cameras[i - 1].is_face() &&
         cameras[i].photograph == cameras[i - 1].photograph;
}

double used_share(const LensCamera& camera) {
  if (!camera.lens) return 1;
  const std::vector<LensCamera> views = views_of(camera);
  return share_of(camera.lens->size_px, [&](glm::dvec2 pixel) {
    const auto direction = camera.lens->direction(pixel);
    return direction && std::ranges::any_of(views, [&](const LensCamera& view) {
             const Face* const face = find_face(view.lens->face);
             const glm::dvec3 turned =
                 face == nullptr ? *direction : glm::transpose(face->lens_from_face) * *direction;
             if (!(turned.z > 0)) return false;
             const glm::dvec2 at =
                 view.camera.focal_px * glm::dvec2(turned) / turned.z + view.camera.center_px;
             const glm::dvec2 size = size_of(view.camera);
             return at.x >= -0.5 && at.y >= -0.5 && at.x <= size.x - 0.5 && at.y <= size.y - 0.5;
           });
  });
}

void sort_by_name(std::vector<LensCamera>& cameras) {
  const auto name_of = [](const LensCamera& camera) {
    std::string_view name = camera.camera.name;
    const std::string ending = camera.is_face() ? "_" + std::string(camera.lens->face) : "";
    if (name.ends_with(ending)) name.remove_suffix(ending.size());
    return name;
  };
  std::ranges::stable_sort(cameras, {}, name_of);
}

std::vector<Camera> pinhole_cameras(const std::vector<LensCamera>& cameras) {
  std::vector<Camera> result(cameras.size());
  std::ranges::transform(cameras, result.begin(), &LensCamera::camera);
  return result;
}

}  // namespace qs
