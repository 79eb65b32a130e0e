// SPDX-License-Identifier: MIT
#include "support/planted_renderer.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace qs::test {
namespace {

using Bugs = std::set<std::string>;

struct Spot {
  float x, y, z, distance;
  float a, b, c;  // of the inverse covariance
  float opacity, rgb[3];
};

float clamped(float value, float low, float high) {
  return value < low ? low : value > high ? high : value;
}

class Painter {
 public:
  Painter(const PlantedScene& scene, const Bugs& bugs) : scene_(scene), bugs_(bugs) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j)
        view_[i][j] = has("camera-transposed") ? scene.rotation[j][i] : scene.rotation[i][j];
      eye_[i] = 0;
      for (int j = 0; j < 3; ++j) eye_[i] -= scene.rotation[j][i] * scene.translation[j];
    }
    fx_ = scene.fx;
    fy_ = has("one-focal-length") ? scene.fx : scene.fy;
    for (const auto& row : scene.rows) add(row);
    sort();
  }

  Image paint() const {
    Image image(scene_.width, scene_.height, 3);
    for (int y = 0; y < scene_.height; ++y) {
      for (int x = 0; x < scene_.width; ++x) {
        const int to_x = flipped_x_ ? scene_.width - 1 - x : x;
        const int to_y = flipped_y_ ? scene_.height - 1 - y : y;
        float rgb[3];
        shade(static_cast<float>(x), static_cast<float>(y), rgb);
        for (int c = 0; c < 3; ++c) image.at(to_x, to_y, bgr_ ? 2 - c : c) = transferred(rgb[c]);
      }
    }
    return image;
  }

 private:
  bool has(const char* bug) const { return bugs_.count(bug) != 0; }

  float value(const std::vector<float>& row, const std::string& column) const {
    return row[scene_.columns.at(column)];
  }

  void add(const std::vector<float>& row) {
    const float world[3] = {value(row, "x"), value(row, "y"), value(row, "z")};
    float offset[3], at[3];
    for (int i = 0; i < 3; ++i) offset[i] = world[i] - eye_[i];
    for (int i = 0; i < 3; ++i)
      at[i] = view_[i][0] * offset[0] + view_[i][1] * offset[1] + view_[i][2] * offset[2];
    if (at[2] <= (has("near-plane-missing") ? 0.01f : 0.2f)) return;

    float sigma[3][3];
    world_covariance(row, sigma);
    if (!has("covariance-not-turned")) {
      float turned[3][3];
      multiply(view_, sigma, turned);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          sigma[i][j] = 0;
          for (int k = 0; k < 3; ++k) sigma[i][j] += turned[i][k] * view_[j][k];
        }
      }
    }
    const float limit_x = 1.3f * 0.5f * static_cast<float>(scene_.width) / fx_;
    const float limit_y = 1.3f * 0.5f * static_cast<float>(scene_.height) / fy_;
    float slope_x = at[0] / at[2], slope_y = at[1] / at[2];
    if (!has("fov-clamp-missing")) {
      slope_x = clamped(slope_x, -limit_x, limit_x);
      slope_y = clamped(slope_y, -limit_y, limit_y);
    }
    if (has("jacobian-diagonal")) slope_x = slope_y = 0;
    const float jx = fx_ / at[2], jy = fy_ / at[2], kx = -jx * slope_x, ky = -jy * slope_y;
    float xx = jx * jx * sigma[0][0] + 2 * jx * kx * sigma[0][2] + kx * kx * sigma[2][2];
    float yy = jy * jy * sigma[1][1] + 2 * jy * ky * sigma[1][2] + ky * ky * sigma[2][2];
    float xy = jx * jy * sigma[0][1] + jx * ky * sigma[0][2] + kx * jy * sigma[2][1] +
               kx * ky * sigma[2][2];
    const float before = xx * yy - xy * xy;
    const float blur = has("dilation-missing") ? 0 : has("dilation-0.1") ? 0.1f : 0.3f;
    xx += blur;
    yy += blur;
    float after = xx * yy - xy * xy;
    if (!(after > 0)) return;
    const float compensation = std::sqrt(std::max(before / after, 2.5e-5f));
    if (has("eigenvalue-floor")) {  // as axes of the ellipse, from its angle
      const float half = 0.5f * (xx + yy), spread = std::sqrt(std::max(0.1f, half * half - after));
      const float major = half + spread, minor = half - spread;
      if (minor <= 0) return;
      const bool along_x = std::abs(major - xx) + std::abs(xy) < 1e-5f * xx;
      const float angle = along_x ? 1.5707964f : std::atan2(major - xx, xy);
      const float cosine = std::cos(angle), sine = std::sin(angle);
      xx = major * cosine * cosine + minor * sine * sine;
      yy = major * sine * sine + minor * cosine * cosine;
      xy = (major - minor) * sine * cosine;
      after = major * minor;
    }

    Spot spot;
    spot.opacity = 1 / (1 + std::exp(-value(row, "opacity")));
    const bool compensates =
        has("compensation-always") || (scene_.antialiased && !has("compensation-missing"));
    if (compensates) spot.opacity *= compensation;
    const float center_x = 0.5f * static_cast<float>(scene_.width - 1);
    const float center_y = 0.5f * static_cast<float>(scene_.height - 1);
    const float shift = has("half-pixel-right") ? 0.5f : has("half-pixel-left") ? -0.5f : 0;
    spot.x = fx_ * at[0] / at[2] + center_x + shift;
    spot.y = fy_ * at[1] / at[2] + center_y + shift;
    spot.z = at[2];
    const float length =
        std::sqrt(offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]);
    spot.distance = length;
    spot.a = yy / after;
    spot.b = -xy / after;
    spot.c = xx / after;
    float direction[3];
    for (int i = 0; i < 3; ++i)
      direction[i] =
          (has("sh-view-axes") ? at[i] : offset[i]) * (has("sh-opposite") ? -1.0f : 1.0f) / length;
    for (int c = 0; c < 3; ++c) spot.rgb[c] = color(row, c, direction);
    spots_.push_back(spot);
  }

  static void multiply(const float a[3][3], const float b[3][3], float result[3][3]) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j)
        result[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
    }
  }

  void world_covariance(const std::vector<float>& row, float sigma[3][3]) const {
    float q[4], scale[3];
    for (int i = 0; i < 4; ++i) q[i] = value(row, "rot_" + std::to_string(i));
    for (int i = 0; i < 3; ++i) scale[i] = std::exp(value(row, "scale_" + std::to_string(i)));
    const bool last = has("quaternion-xyzw");
    const float w = last ? q[3] : q[0];
    const float sign = has("quaternion-inverse") ? -1.0f : 1.0f;
    const float x = sign * (last ? q[0] : q[1]), y = sign * (last ? q[1] : q[2]),
                z = sign * (last ? q[2] : q[3]);
    const float r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        sigma[i][j] = 0;
        for (int k = 0; k < 3; ++k) sigma[i][j] += r[i][k] * scale[k] * scale[k] * r[j][k];
      }
    }
  }

  float color(const std::vector<float>& row, int channel, const float d[3]) const {
    const int rest = (scene_.sh_degree + 1) * (scene_.sh_degree + 1) - 1;
    const auto coefficient = [&](int k) {  // k from 1
      const int index = has("sh-interleaved") ? 3 * (k - 1) + channel : channel * rest + k - 1;
      return value(row, "f_rest_" + std::to_string(index));
    };
    int degree = scene_.sh_degree;
    if (has("sh-ignored")) degree = 0;
    if (has("sh-up-to-1")) degree = std::min(degree, 1);
    if (has("sh-up-to-2")) degree = std::min(degree, 2);
    const float m = has("sh-signs") ? 1.0f : -1.0f;
    const float x = d[0], y = d[1], z = d[2], xx = x * x, yy = y * y, zz = z * z;
    const float basis[15] = {m * 0.48860251f * y,
                             0.48860251f * z,
                             m * 0.48860251f * x,
                             1.09254843f * x * y,
                             m * 1.09254843f * y * z,
                             0.31539157f * (3 * zz - 1),
                             m * 1.09254843f * x * z,
                             0.54627422f * (xx - yy),
                             m * 0.59004359f * y * (3 * xx - yy),
                             2.89061144f * x * y * z,
                             m * 0.45704580f * y * (5 * zz - 1),
                             0.37317633f * z * (5 * zz - 3),
                             m * 0.45704580f * x * (5 * zz - 1),
                             1.44530572f * z * (xx - yy),
                             m * 0.59004359f * x * (xx - 3 * yy)};
    float sum = 0.5f + 0.28209479f * value(row, "f_dc_" + std::to_string(channel));
    for (int k = 1; k < (degree + 1) * (degree + 1); ++k) sum += basis[k - 1] * coefficient(k);
    if (!has("dark-not-clamped")) sum = std::max(sum, 0.0f);
    if (has("bright-clamped")) sum = std::min(sum, 1.0f);
    return sum;
  }

  void sort() {
    if (has("ties-reversed")) std::reverse(spots_.begin(), spots_.end());
    if (has("order-file")) return;
    const bool far = has("order-reversed"), distance = has("order-distance");
    std::stable_sort(spots_.begin(), spots_.end(), [&](const Spot& a, const Spot& b) {
      return distance ? a.distance < b.distance : far ? a.z > b.z : a.z < b.z;
    });
  }

  void shade(float x, float y, float rgb[3]) const {
    rgb[0] = rgb[1] = rgb[2] = 0;
    float light = 1;
    for (const Spot& spot : spots_) {
      const float dx = x - spot.x, dy = y - spot.y;
      const float d2 = spot.a * dx * dx + spot.c * dy * dy + 2 * spot.b * dx * dy;
      if (d2 < 0 || d2 > cut_) continue;
      const float alpha = std::min(spot.opacity * std::exp(-falloff_ * d2), most_);
      if (alpha < least_) continue;
      const float behind = light * (1 - alpha);
      const bool ends = behind < end_;
      if (ends && !late_) break;
      for (int c = 0; c < 3; ++c) rgb[c] += spot.rgb[c] * alpha * light;
      light = behind;
      if (ends) break;
    }
    for (int c = 0; c < 3; ++c) rgb[c] += light * behind_[c];
  }

  float transferred(float v) const {
    if (srgb_twice_) {
      v = clamped(v, 0, 1);
      return v < 0.0031308f ? v * 12.92f : 1.055f * std::pow(v, 0.41666667f) - 0.055f;
    }
    if (srgb_removed_) {
      v = clamped(v, 0, 1);
      return v < 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
    }
    return v;
  }

  const PlantedScene& scene_;
  const Bugs& bugs_;
  // Values that every pixel reads.
  const float cut_ = has("cut-3-sigma") ? 9.0f : has("cut-sqrt8-sigma") ? 8.0f : 60.0f;
  const float falloff_ = has("falloff-doubled") ? 1.0f : 0.5f;
  const float most_ = has("alpha-not-limited") ? 1.0f : 0.99f;
  const float least_ = has("alpha-threshold-missing") ? 0.0f : 1.0f / 255;
  const float end_ = has("stop-missing") ? 0.0f : has("stop-early") ? 1.0f / 255 : 1e-4f;
  const bool late_ = has("stop-late");
  const bool flipped_x_ = has("flipped-x"), flipped_y_ = has("flipped-y"), bgr_ = has("bgr");
  const bool srgb_twice_ = has("srgb-twice"), srgb_removed_ = has("srgb-removed");
  const float shown_ = has("background-ignored") ? 0.0f : 1.0f;
  const float behind_[3] = {shown_ * scene_.background[0], shown_* scene_.background[1],
                            shown_* scene_.background[2]};
  float view_[3][3], eye_[3], fx_, fy_;
  std::vector<Spot> spots_;
};

}  // namespace

PlantedScene read_planted(const std::filesystem::path& kit, const nlohmann::json& entry) {
  PlantedScene scene;
  scene.width = entry["width"];
  scene.height = entry["height"];
  scene.fx = entry["fx"];
  scene.fy = entry["fy"];
  scene.sh_degree = entry["sh_degree"];
  scene.antialiased = entry["antialiased"];
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) scene.rotation[i][j] = entry["view_from_world"][i][j];
    scene.translation[i] = entry["view_from_world"][i][3];
    scene.background[i] = entry["background"][i];
  }
  std::ifstream file(kit / entry["scene"].get<std::string>(), std::ios::binary);
  std::string word, line;
  std::size_t count = 0;
  while (std::getline(file, line) && line != "end_header") {
    std::istringstream words(line);
    words >> word;
    if (word == "element") words >> word >> count;
    if (word == "property" && words >> word && word == "float" && words >> word)
      scene.columns.emplace(word, scene.columns.size());
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<float>& row = scene.rows.emplace_back(scene.columns.size());
    file.read(reinterpret_cast<char*>(row.data()),
              static_cast<std::streamsize>(row.size() * sizeof(float)));
  }
  if (!file || count == 0) throw std::runtime_error("not a scene of the kit");
  return scene;
}

Image draw_planted(const PlantedScene& scene, const Bugs& bugs) {
  return Painter(scene, bugs).paint();
}

}  // namespace qs::test
