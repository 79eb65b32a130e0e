// SPDX-License-Identifier: MIT
//
// Lenses in JSON files. transforms.json has the keys of nerfstudio and instant-ngp: camera_model, a
// name of lens_models.h or PERSPECTIVE; is_fisheye; latlong, equirectangular; k1 and so on.
// cameras.json has an object "lens" with model (default: OPENCV), fx, fy, cx, cy and the model's
// coefficients; of a face also face, photograph, and width and height of the photograph.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include "io/bytes/byte_text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/camera/camera_formats.h"

namespace qs {
namespace {

using nlohmann::json;

// Keys with which instant-ngp and nerfstudio mark projections that are not known.
constexpr const char* kUnknownLenses[] = {"ftheta_p0", "ftheta_p1", "ftheta_p2",   "ftheta_p3",
                                          "ftheta_p4", "ortho",     "orthographic"};
// Coefficients that no lens may ignore.
constexpr const char* kCoefficients[] = {"k1", "k2", "k3", "k4", "k5", "k6",
                                         "p1", "p2", "s1", "s2", "s3", "s4"};
constexpr int kLastOpencv = 4;  // COLMAP's models 0 to 4 are cases of OPENCV

// True unless the value is absent, false, 0, or a list of such values.
bool is_set(const json& value) {
  if (value.is_array()) return std::ranges::any_of(value, is_set);
  if (value.is_string()) {
    const std::string word = lower_case(value.get<std::string>());
    return !word.empty() && word != "false" && word != "0";
  }
  if (value.is_number()) return !(std::abs(value.get<double>()) <= kNoDistortion);
  return !value.is_null() && value != json(false);
}

bool has_set(const FrameEntry& frame, const char* key) {
  return frame.has(key) && is_set(frame.with(key).get(key));
}

std::string shown(const FrameEntry& frame, const char* key) {
  return printable(json_line(frame.with(key).get(key)), 40);
}

const LensModel* model_named(const FrameEntry& frame) {
  if (!frame.has("camera_model")) return nullptr;
  const std::string& named = frame.with("camera_model").text("camera_model");
  std::string name = named;
  for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  const LensModel* const model = find_lens_model(name == "PERSPECTIVE" ? "OPENCV" : name);
  if (model == nullptr)
    fail("{}: camera_model {} is no lens that is known; undistort the photographs first",
         frame.frame.where, named.substr(0, 40));
  return model;
}

const LensModel& model_of(const FrameEntry& frame) {
  const LensModel* const named = model_named(frame);
  const LensModel* model = named;
  const struct {
    const char* key;
    const char* model;
  } kFlags[] = {{"is_fisheye", "OPENCV_FISHEYE"},
                {"latlong", "EQUIRECTANGULAR"},
                {"equirectangular", "EQUIRECTANGULAR"}};
  for (const auto& [key, name] : kFlags) {
    if (!has_set(frame, key)) continue;
    const LensModel* const meant = find_lens_model(name);
    if (model == nullptr) model = meant;
    if (model->plane != meant->plane)
      fail("{}: {} is {}, but its lens is {}", frame.frame.where, key, shown(frame, key),
           model->name);
  }
  if (model == nullptr) model = find_lens_model("OPENCV");
  // k3 belongs to r^6, as in nerfstudio.
  if (0 <= model->id && model->id <= kLastOpencv)
    model = find_lens_model(has_set(frame, "k3") ? "FULL_OPENCV" : "OPENCV");
  // Its k4 would be in the denominator, which OPENCV does not mean.
  for (const char* key : {"k4", "k5", "k6"})
    if (model->name == "FULL_OPENCV" && model != named && has_set(frame, key))
      fail("{}: {} is {}, but a lens with k3 has it as FULL_OPENCV alone", frame.frame.where, key,
           shown(frame, key));
  return *model;
}

// FISHEYE624 has its coefficients in a list.
void set_from_list(const FrameEntry& frame, Lens& lens) {
  const char* const key = "distortion_params";
  if (!has_set(frame, key)) return;
  const json& list = frame.with(key).get(key);
  const auto count = static_cast<std::size_t>(lens.model->coefficients());
  if (count != lens.coefficients.size() || !list.is_array() || list.size() != count)
    fail("{}: {} is {}: a list of {} numbers is read for FISHEYE624 alone", frame.frame.where, key,
         shown(frame, key), lens.coefficients.size());
  for (std::size_t i = 0; i < count; ++i)
    lens.coefficients[i] = frame.with(key).number(list[i], key);
}

void set_coefficients(const FrameEntry& frame, Lens& lens) {
  const LensModel& model = *lens.model;
  set_from_list(frame, lens);
  std::vector<std::string> known;
  for (int i = 0; i < model.coefficients(); ++i) {
    known.emplace_back(model.coefficient(i));
    const char* const key = known.back().c_str();
    if (frame.has(key)) lens.coefficients[static_cast<std::size_t>(i)] = frame.number(key);
  }
  for (const char* key : kCoefficients)
    if (frame.has(key) && std::abs(frame.number(key)) > kNoDistortion &&
        std::ranges::find(known, key) == known.end())
      fail("{}: {} is {}, which a lens {} does not have; undistort the photographs first",
           frame.frame.where, key, shown(frame, key), model.name);
}

}  // namespace

Lens lens_of_transforms(const FrameEntry& frame) {
  for (const char* key : kUnknownLenses)
    if (has_set(frame, key))
      fail("{}: {} is {}: no lens that is known; undistort the photographs first",
           frame.frame.where, key, shown(frame, key));
  Lens lens{&model_of(frame)};
  set_coefficients(frame, lens);
  return lens;
}

std::optional<Lens> lens_of_cameras_json(const JsonEntry& camera, glm::dvec2 size) {
  const Lens outside = lens_of_transforms({camera, camera});
  if (outside.model->name != "OPENCV")
    fail("{}: a lens {} is not read outside the object lens", camera.where, outside.model->name);
  if (!camera.has("lens")) return std::nullopt;
  const JsonEntry entry = camera.child("lens");
  const std::string model = entry.has("model") ? entry.text("model") : "OPENCV";
  Lens lens{find_lens_model(model)};
  if (lens.model == nullptr)
    fail("{}: model {} is no lens that is known", entry.where, model.substr(0, 40));
  if (!entry.has("model")) lens_of_transforms({entry, entry});  // refuses keys of other lenses
  lens.size_px = size;
  if (entry.has("face")) {
    const Face* const face = find_face(entry.text("face"));
    if (face == nullptr) fail("{}: {} is no face", entry.where, entry.text("face").substr(0, 40));
    lens.face = face->name;
    lens.size_px = {entry.positive("width"), entry.positive("height")};
  }
  lens.focal_px = {entry.positive("fx"), entry.positive("fy")};
  lens.center_px = {entry.number("cx") - 0.5, entry.number("cy") - 0.5};
  for (int i = 0; i < lens.model->coefficients(); ++i)
    lens.coefficients[static_cast<std::size_t>(i)] =
        entry.number(std::string(lens.model->coefficient(i)).c_str());
  return checked_lens(lens, entry.where);
}

json lens_json(const LensCamera& camera) {
  const Lens& lens = *camera.lens;
  json object = {{"fx", lens.focal_px.x},
                 {"fy", lens.focal_px.y},
                 {"cx", lens.center_px.x + 0.5},
                 {"cy", lens.center_px.y + 0.5}};
  if (lens.model->name != "OPENCV") object["model"] = lens.model->name;
  for (int i = 0; i < lens.model->coefficients(); ++i)
    object[std::string(lens.model->coefficient(i))] =
        lens.coefficients[static_cast<std::size_t>(i)];
  if (!lens.face.empty()) {
    object["face"] = lens.face;
    object["photograph"] = camera.photograph;
    object["width"] = lens.size_px.x;
    object["height"] = lens.size_px.y;
  }
  return object;
}

}  // namespace qs
