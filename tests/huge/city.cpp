// SPDX-License-Identifier: MIT
#include "huge/city.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>

#include "io/cloud/cloud_memory.h"
#include "raster/kernel/constants.h"

namespace qs {
namespace {

constexpr double kPerBlock = 200'000;
constexpr double kPitch = 80;   // from street to street
constexpr double kWire = 0.02;  // two standard deviations
constexpr double kFloor = 3, kWindow = 2.4;
constexpr std::size_t kCycle = 50;  // the kinds repeat
constexpr std::size_t kWires = 6, kTrees = 12, kHouses = 4, kFaces = 5;
constexpr std::array<std::size_t, 5> kEnds = {1, 5, 7, 20, kCycle};  // of each kind in a cycle

// Splitmix64: a hash, and a generator of 0..1.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream) : state_(seed * 0x9e3779b97f4a7c15 + stream) {
    next();
  }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  double normal() {
    return std::sqrt(-2 * std::log(1 - unit())) * std::cos(2 * std::numbers::pi * unit());
  }
  glm::dvec3 direction() {
    const double z = between(-1, 1), angle = between(0, 2 * std::numbers::pi);
    return {std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z};
  }

 private:
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

// Entry i of the sequences that cover the unit square and the unit cube evenly (Roberts, 2018).
glm::dvec2 even_in_square(std::size_t i) {
  constexpr double kRoot = 1.3247179572447460;  // of x^3 = x + 1
  return glm::fract(static_cast<double>(i + 1) / glm::dvec2(kRoot, kRoot * kRoot));
}
glm::dvec3 even_in_cube(std::size_t i) {
  constexpr double kRoot = 1.2207440846057596;  // of x^4 = x + 1
  return glm::fract(static_cast<double>(i + 1) /
                    glm::dvec3(kRoot, kRoot * kRoot, kRoot * kRoot * kRoot));
}

// A Gaussian before it is stored.
struct Made {
  glm::dvec3 position{0}, sigma{1};
  glm::dvec3 normal{0, 0, 1}, along{1, 0, 0};  // axes z and x of its own
  glm::dvec3 color{0};
  double opacity = 0.95, gloss = 0;  // gloss: change of the colour with the direction of sight
};

glm::dvec3 any_tangent(const glm::dvec3& n) {
  return glm::normalize(
      glm::cross(n, std::abs(n.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0)));
}

void store(const Made& made, Random& random, GaussianCloud& cloud, std::size_t k) {
  cloud.positions[k] = made.position;
  cloud.log_scales[k] = glm::log(made.sigma);
  cloud.rotations[k] = glm::quat(glm::normalize(
      glm::quat_cast(glm::dmat3(made.along, glm::cross(made.normal, made.along), made.normal))));
  cloud.opacity_logits[k] = static_cast<float>(std::log(made.opacity / (1 - made.opacity)));
  glm::vec3* const sh = sh_of(cloud, k);
  sh[0] = (made.color - 0.5) / static_cast<double>(kSh0);
  for (std::size_t j = 1; j < sh_count(cloud); ++j)
    sh[j] = glm::vec3(static_cast<float>(0.02 * random.normal()));
  if (cloud.sh_degree == 0 || made.gloss == 0) return;
  const glm::dvec3 n = made.gloss / std::sqrt(0.75 / std::numbers::pi) * made.normal;
  sh[1] -= glm::vec3(static_cast<float>(n.y));
  sh[2] += glm::vec3(static_cast<float>(n.z));
  sh[3] -= glm::vec3(static_cast<float>(n.x));
}

}  // namespace

// A house: walls and a roof.
struct City::Box {
  glm::dvec3 center{0}, half{0};  // the centre of its ground
  double height = 0;
  glm::dvec3 color{0};

  // Width and height of face 0 to 3, a wall, or 4, the roof.
  glm::dvec2 size(std::size_t face) const {
    if (face == 4) return {2 * half.x, 2 * half.z};
    return {face % 2 == 0 ? 2 * half.z : 2 * half.x, height};
  }
};

struct City::Block {
  std::size_t number = 0, begin = 0, end = 0;  // of its Gaussians
  glm::dvec3 corner{0};
  std::array<Box, kHouses> houses{};
  std::array<double, kHouses * kFaces> areas{};  // sums of the faces' areas
  std::array<glm::dvec3, kTrees> trees{};
};

City::City(std::size_t count, int sh_degree, std::uint64_t seed)
    : count_(count), degree_(sh_degree), seed_(seed) {
  const double blocks = std::sqrt(static_cast<double>(count) / kPerBlock);
  side_ = static_cast<std::size_t>(std::max(1.0, std::round(blocks)));
  side_ = std::min(side_, static_cast<std::size_t>(std::sqrt(static_cast<double>(count))));
}

std::size_t City::block_of(std::size_t i) const {
  std::size_t block = i * block_count() / count_;
  while (block_begin(block) > i) --block;
  while (block + 1 < block_count() && block_begin(block + 1) <= i) ++block;
  return block;
}

CityKind City::kind(std::size_t i) const {
  const std::size_t place = (i - block_begin(block_of(i))) % kCycle;
  return static_cast<CityKind>(std::ranges::upper_bound(kEnds, place) - kEnds.begin());
}

City::Block City::make_block(std::size_t number) const {
  Random random(seed_, (std::uint64_t{1} << 40) + number);
  Block block{number, block_begin(number), block_begin(number + 1)};
  const double start = -0.5 * kPitch * static_cast<double>(side_);
  block.corner = {start + kPitch * static_cast<double>(number % side_), 0,
                  start + kPitch * static_cast<double>(number / side_)};
  double area = 0;
  for (std::size_t i = 0; i < kHouses; ++i) {
    Box& house = block.houses[i];
    house.center = block.corner + glm::dvec3(i % 2 == 0 ? 26 : 54, 0, i < 2 ? 26 : 54);
    house.half = {random.between(9, 12.5), 0, random.between(9, 12.5)};
    house.height = kFloor * std::floor(random.between(3, 16));
    house.color = {random.between(0.5, 0.9), random.between(0.45, 0.8), random.between(0.4, 0.7)};
    for (std::size_t face = 0; face < kFaces; ++face) {
      const glm::dvec2 size = house.size(face);
      block.areas[i * kFaces + face] = area += size.x * size.y;
    }
  }
  for (std::size_t i = 0; i < kTrees; ++i) {
    const double place = 12 + 56 * (static_cast<double>(i / 4) + random.between(0.2, 0.8)) / 3;
    const double edge = i % 2 == 0 ? 9 : kPitch - 9;
    block.trees[i] =
        block.corner + (i % 4 < 2 ? glm::dvec3(edge, -5, place) : glm::dvec3(place, -5, edge));
  }
  return block;
}

void City::make_gaussian(std::size_t i, const Block& block, GaussianCloud& cloud,
                         std::size_t k) const {
  Random random(seed_, i);
  const std::size_t place = (i - block.begin) % kCycle, cycle = (i - block.begin) / kCycle;
  const auto kind =
      static_cast<std::size_t>(std::ranges::upper_bound(kEnds, place) - kEnds.begin());
  const std::size_t first = kind == 0 ? 0 : kEnds[kind - 1], width = kEnds[kind] - first;
  const std::size_t own = cycle * width + place - first;  // index among its kind in the block
  const auto kin = static_cast<double>((block.end - block.begin) * width) / kCycle;
  const auto spread = [&](double area, double number) { return 0.7 * std::sqrt(area / number); };
  Made made;
  switch (static_cast<CityKind>(kind)) {
    case CityKind::sky: {
      const double radius = kPitch * static_cast<double>(side_) + 300;
      const glm::dvec2 s = even_in_square(own * block_count() + block.number);
      const double up = 2 * s.x - 1, angle = 2 * std::numbers::pi * s.y;
      const double flat = std::sqrt(1 - up * up);
      made.normal = {flat * std::cos(angle), -up, flat * std::sin(angle)};
      made.position = radius * made.normal;
      made.along = any_tangent(made.normal);
      const double sigma =
          spread(4 * std::numbers::pi * radius * radius, kin * static_cast<double>(block_count()));
      made.sigma = {sigma, sigma, 0.01 * sigma};
      made.color =
          glm::mix(glm::dvec3(0.85, 0.9, 0.95),
                   up > 0 ? glm::dvec3(0.3, 0.5, 0.85) : glm::dvec3(0.5, 0.5, 0.45), std::abs(up));
      made.opacity = 0.99;
      break;
    }
    case CityKind::ground: {
      const glm::dvec2 t = even_in_square(own);
      made.position = block.corner + glm::dvec3(kPitch * t.x, 0, kPitch * t.y);
      made.normal = {0, -1, 0};
      const double sigma = spread(kPitch * kPitch, kin);
      made.sigma = {sigma, sigma, 0.01};
      const double edge =
          kPitch / 2 - std::max(std::abs(kPitch * (t.x - 0.5)), std::abs(kPitch * (t.y - 0.5)));
      made.color = edge < 6    ? glm::dvec3(0.25)             // street
                   : edge < 10 ? glm::dvec3(0.6, 0.58, 0.55)  // pavement
                               : glm::dvec3(0.3, 0.42, 0.2);  // grass
      break;
    }
    case CityKind::wire: {
      const std::size_t wire = own % kWires;
      const double along = (static_cast<double>(own / kWires) + 0.5) * kWires / kin;
      const double sag = 4 * along * (1 - along);
      const double height = 7 + 0.4 * static_cast<double>(wire / 2) - 0.8 * sag;
      const double slope = 3.2 * (1 - 2 * along) / kPitch;  // of the sag
      const bool is_x = wire % 2 == 0;
      const double place_along = kPitch * std::min(along, 1.0);
      made.position = block.corner + (is_x ? glm::dvec3(place_along, -height, 7)
                                           : glm::dvec3(7, -height, place_along));
      made.along = glm::normalize(is_x ? glm::dvec3(1, slope, 0) : glm::dvec3(0, slope, 1));
      made.normal = any_tangent(made.along);
      made.sigma = {0.7 * kPitch * kWires / kin, kWire / 2, kWire / 2};
      made.color = glm::dvec3(0.05);
      made.opacity = 0.98;
      break;
    }
    case CityKind::leaf: {
      const glm::dvec3 out = random.direction();
      made.position = block.trees[own % kTrees] + 2.5 * std::cbrt(random.between(0.3, 1)) * out;
      made.normal = random.direction();
      made.along = any_tangent(made.normal);
      const double sigma = random.between(0.03, 0.07);
      made.sigma = {1.6 * sigma, sigma, 0.1 * sigma};
      made.color = glm::dvec3(0.2, 0.45, 0.12) * random.between(0.5, 1.4);
      made.opacity = random.between(0.6, 0.98);
      break;
    }
    case CityKind::facade: {
      const glm::dvec3 t = even_in_cube(own);
      const auto face_of_block = static_cast<std::size_t>(
          std::ranges::upper_bound(block.areas, t.x * block.areas.back()) - block.areas.begin());
      const Box& house = block.houses[std::min(face_of_block / kFaces, kHouses - 1)];
      const std::size_t face = face_of_block % kFaces;
      const glm::dvec2 size = house.size(face), at = size * glm::dvec2(t.y, t.z);
      const double sigma = spread(block.areas.back(), kin);
      made.sigma = {sigma, sigma, 0.01};
      made.color = house.color * random.between(0.92, 1.05);
      const double side = face < 2 ? 1 : -1;
      if (face == 4) {
        made.normal = {0, -1, 0};
        made.position =
            house.center + glm::dvec3(at.x - house.half.x, -house.height, at.y - house.half.z);
        made.color = glm::dvec3(0.45, 0.25, 0.2);
        break;
      }
      const glm::dvec3 across = face % 2 == 0 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
      made.normal = side * (face % 2 == 0 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1));
      made.along = across;
      made.position = house.center + made.normal * house.half + (at.x - size.x / 2) * across -
                      glm::dvec3(0, at.y, 0);
      const glm::dvec2 cell = glm::fract(at / glm::dvec2(kWindow, kFloor));
      if (cell.x > 0.25 && cell.x < 0.75 && cell.y > 0.3 && cell.y < 0.8) {
        made.color = {0.12, 0.17, 0.26};
        made.gloss = 0.15;
      }
      break;
    }
  }
  store(made, random, cloud, k);
}

GaussianCloud City::part(std::size_t begin, std::size_t end, ThreadPool& pool) const {
  GaussianCloud cloud;
  cloud.resize(end - begin, degree_);
  pool.for_chunks(end - begin, 4096, [&](std::size_t from, std::size_t to, int) {
    Block block;
    for (std::size_t k = from; k < to; ++k) {
      if (begin + k >= block.end) block = make_block(block_of(begin + k));
      make_gaussian(begin + k, block, cloud, k);
    }
  });
  return cloud;
}

std::vector<Camera> City::cameras() const {
  const double side = static_cast<double>(side_) * kPitch;
  const double street =
      kPitch * (std::floor(static_cast<double>(side_) / 2) - 0.5 * static_cast<double>(side_));
  const auto look = [](const char* name, glm::dvec3 from, glm::dvec3 to) {
    Camera camera = look_at(from, to, {0, -1, 0}, glm::radians(50.0), 800, 600);
    camera.name = name;
    return camera;
  };
  return {look("street_z", {street + 1, -1.7, -side / 2 + 2}, {street + 3, -4, side / 2}),
          look("street_x", {-side / 2 + 2, -1.7, street + 1}, {side / 2, -4, street + 3}),
          look("roofs", {street + 4, -30, -side / 2 - 5}, {street - 20, -12, side / 2}),
          look("air", {-side / 2, -45 - side / 8, -side / 2}, {0, 0, 0})};
}

}  // namespace qs
