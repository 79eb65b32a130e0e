// SPDX-License-Identifier: MIT
//
// Metashape's cameras as it exports them (Agisoft XML): document, chunk, and in it
//   sensors     each with a type, and a calibration in pixels: f, cx and cy from the picture's
//               middle, b1 and b2 (fx = f + b1, skew = b2 / fx), k1 to k4, p1, p2. The adjusted
//               calibration counts. A spherical sensor needs none
//   components  each with a transform of its own: rotation by rows, translation, scale
//   cameras     each with a label, a sensor, a component, and unless it was not aligned its
//               transform: component_from_view by rows, x right, y down, z forward. Groups have
//               cameras too
// A camera is named as its label, which is its photograph's name.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/fail.h"
#include "base/text.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/json_text.h"
#include "io/camera/camera_formats.h"

namespace qs {
namespace {

constexpr double kMaxSensorSide = 65535;
constexpr std::string_view kXmlSpace = " \t\r\n";

struct XmlElement {
  std::string_view name = "";
  std::map<std::string_view, std::string> attributes = {};
  std::string text = {};  // its own, not of its children
  std::vector<XmlElement> children = {};

  const XmlElement* child(std::string_view wanted) const {
    const auto found = std::ranges::find(children, wanted, &XmlElement::name);
    return found == children.end() ? nullptr : &*found;
  }
  std::string attribute(std::string_view key) const {
    const auto found = attributes.find(key);
    return found == attributes.end() ? "" : found->second;
  }
};

std::string without_entities(std::string text) {
  constexpr std::pair<std::string_view, const char*> kEntities[] = {
      {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&amp;", "&"}};
  for (const auto& [entity, character] : kEntities)
    for (std::size_t at = 0; (at = text.find(entity, at)) != std::string::npos; ++at)
      text.replace(at, entity.size(), character);
  return text;
}

// The end of a tag that begins `text`: its '>', which is not in quotes.
std::size_t end_of_tag(std::string_view text) {
  char quote = 0;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (quote == 0 && text[i] == '>') return i;
    if (quote == 0 ? text[i] == '"' || text[i] == '\'' : text[i] == quote)
      quote = quote == 0 ? text[i] : 0;
  }
  return std::string_view::npos;
}

// The element of a tag without its brackets. Attributes without quotes are left out.
XmlElement element_of(std::string_view tag) {
  const auto take = [&](std::string_view ends) {
    const std::string_view taken = tag.substr(0, tag.find_first_of(ends));
    tag.remove_prefix(std::min(taken.size() + 1, tag.size()));
    return taken;
  };
  XmlElement element{take(" \t\r\n/")};
  for (;;) {
    tag.remove_prefix(std::min(tag.find_first_not_of(kXmlSpace), tag.size()));
    const std::string_view key = take(" \t\r\n=");
    tag.remove_prefix(std::min(tag.find_first_of("\"'"), tag.size()));
    if (tag.empty()) return element;
    const std::string_view quote = tag.substr(0, 1);
    tag.remove_prefix(1);
    element.attributes[key] = without_entities(std::string(take(quote)));
  }
}

// The document: its child is the root element. Names are parts of the text.
XmlElement parse_xml(std::string_view text, const std::string& source) {
  constexpr std::size_t kMostLevels = 64;
  std::string_view rest = text;
  const auto damaged = [&](const char* what) {
    const auto line = std::ranges::count(text.substr(0, text.size() - rest.size()), '\n') + 1;
    fail("{}: not valid XML: line {}: {}", source, line, what);
  };
  std::vector<XmlElement> open(1);
  for (std::size_t at; (at = rest.find('<')) != std::string_view::npos;) {
    open.back().text += without_entities(std::string(rest.substr(0, at)));
    rest.remove_prefix(at);
    const bool is_comment = rest.starts_with("<!--");
    const std::size_t end = is_comment ? rest.find("-->", 4) : end_of_tag(rest);
    if (end == std::string_view::npos) damaged("the file ends too early");
    const std::string_view tag = rest.substr(1, end - 1);
    const bool is_end = tag.starts_with('/');
    if (is_end && tag.substr(1, tag.find_last_not_of(kXmlSpace)) != open.back().name)
      damaged("an element ends that did not begin last");
    if (!is_end && !is_comment && !tag.starts_with('?') && !tag.starts_with('!')) {
      open.push_back(element_of(tag));
      if (open.size() > kMostLevels) damaged("more than 64 nested levels");
    } else if (!is_end) {
      rest.remove_prefix(end + (is_comment ? 3 : 1));
      continue;
    }
    rest.remove_prefix(end + 1);
    if (!is_end && !tag.ends_with('/')) continue;
    if (open.size() == 1) damaged("an element ends that did not begin last");
    XmlElement ended = std::move(open.back());
    open.pop_back();
    open.back().children.push_back(std::move(ended));
  }
  if (open.size() > 1) damaged("the file ends too early");
  return std::move(open[0]);
}

// Metashape's names of projections, and the models that they are.
constexpr std::pair<std::string_view, std::string_view> kSensorTypes[] = {
    {"frame", "METASHAPE"},
    {"fisheye", "METASHAPE_FISHEYE"},
    {"equidistant_fisheye", "METASHAPE_FISHEYE"},
    {"spherical", "EQUIRECTANGULAR"}};

// A part of the file, and its name in messages.
struct XmlPart {
  const XmlElement& element;
  std::string where;

  template <std::size_t kCount>
  std::array<double, kCount> numbers(std::string_view text, const char* what) const {
    std::array<double, kCount> result;
    for (double& value : result) {
      text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
      const std::string_view word = text.substr(0, text.find_first_of(" \t\r\n"));
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (is_not_finite(word)) fail_not_finite("{}: {} is {}", where, what, printable(word));
      if (word.empty() || error != std::errc() || end != word.data() + word.size())
        fail("{}: {} has '{}' in place of a number", where, what, printable(word, 40));
      text.remove_prefix(word.size());
    }
    if (text.find_first_not_of(" \t\r\n") != std::string_view::npos)
      fail("{}: {} has more than {} numbers", where, what, kCount);
    return result;
  }

  // The numbers of a child, or the values that stand for none.
  template <std::size_t kCount>
  std::array<double, kCount> child(const char* name, std::array<double, kCount> absent) const {
    const XmlElement* const found = element.child(name);
    return found == nullptr ? absent : numbers<kCount>(found->text, name);
  }

  double number(const char* name) const { return child<1>(name, {0})[0]; }

  XmlPart required(const char* name) const {
    const XmlElement* const found = element.child(name);
    if (found == nullptr) fail("{}: {} is missing", where, name);
    return {*found, where};
  }
};

// The rotation of a matrix by rows.
template <std::size_t kCount>
glm::dmat3 rotation_of(const std::array<double, kCount>& rows, const std::string& where) {
  constexpr std::size_t kColumns = kCount == 9 ? 3 : 4;
  glm::dmat3 result;
  for (std::size_t i = 0; i < 9; ++i)
    result[static_cast<int>(i % 3)][static_cast<int>(i / 3)] = rows[i / 3 * kColumns + i % 3];
  if (const double error = rotation_error(result); !(error < kMaxRotationError))
    fail("{}: its transform holds no rotation (off by {:.2g})", where, error);
  return result;
}

// The place of a component, or of a chunk, in the world.
struct Similarity {
  glm::dmat3 rotation{1.0};
  glm::dvec3 translation{0.0};
  double scale = 1;

  static Similarity of(const XmlPart& part) {
    if (part.element.child("transform") == nullptr) return {};
    const XmlPart own = part.required("transform");
    const auto moved = own.child<3>("translation", {0, 0, 0});
    const auto turned = own.child<9>("rotation", {1, 0, 0, 0, 1, 0, 0, 0, 1});
    const double scale = own.child<1>("scale", {1})[0];
    if (!(scale > 0)) fail("{}: its scale is {}, but is above 0", part.where, scale);
    return {rotation_of(turned, part.where), {moved[0], moved[1], moved[2]}, scale};
  }
};

Lens lens_of_sensor(const XmlPart& sensor) {
  const std::string type = sensor.element.attribute("type");
  const auto* const known =
      std::ranges::find(kSensorTypes, type, [](const auto& row) { return row.first; });
  if (known == std::end(kSensorTypes))
    fail("{}: its type is '{}', which is no lens that is known", sensor.where, printable(type));
  Lens lens{find_lens_model(known->second)};
  const XmlElement* calibration = nullptr;
  for (const XmlElement& each : sensor.element.children)
    if (each.name == "calibration" &&
        (calibration == nullptr || each.attribute("class") == "adjusted"))
      calibration = &each;
  const XmlPart own{calibration != nullptr ? *calibration : sensor.element, sensor.where};
  const XmlPart sized =
      own.element.child("resolution") != nullptr ? own : XmlPart{sensor.element, sensor.where};
  const XmlPart resolution = sized.required("resolution");
  const auto side = [&](const char* key) {
    const double pixels = resolution.numbers<1>(resolution.element.attribute(key), key)[0];
    if (!(pixels >= 1 && pixels <= kMaxSensorSide && pixels == std::floor(pixels)))
      fail("{}: its {} is {}, but is a whole number from 1 to {}", sensor.where, key, pixels,
           kMaxSensorSide);
    return pixels;
  };
  lens.size_px = {side("width"), side("height")};
  if (lens.model->focal_lengths == 0) return lens;
  if (calibration == nullptr)
    fail("{}: has no calibration: align the photographs before the export", sensor.where);
  const double f = own.number("f");
  lens.focal_px = {f + own.number("b1"), f};
  lens.center_px = 0.5 * lens.size_px - 0.5 + glm::dvec2(own.number("cx"), own.number("cy"));
  for (int i = 0; i < lens.model->coefficients(); ++i)
    lens.coefficients[static_cast<std::size_t>(i)] =
        own.number(std::string(lens.model->coefficient(i)).c_str());
  if (own.number("b2") != 0)
    lens.coefficients[static_cast<std::size_t>(lens.model->coefficients()) - 1] =
        own.number("b2") / lens.focal_px.x;  // skew
  return lens;
}

class MetashapeChunk {
 public:
  MetashapeChunk(const XmlElement& chunk, CameraSet& set) : set_(set), path_(set.file.string()) {
    for_each(chunk, "sensors", "sensor",
             [&](const XmlElement& each, const std::string& id) { sensors_.emplace(id, &each); });
    whole_ = Similarity::of({chunk, path_ + ": chunk"});
    for_each(chunk, "components", "component", [&](const XmlElement& each, const std::string& id) {
      const Similarity place = Similarity::of({each, fmt::format("{}: component {}", path_, id)});
      components_.emplace(id, each.child("transform") != nullptr ? place : whole_);
    });
    const XmlElement* const cameras = chunk.child("cameras");
    if (cameras == nullptr) fail("{}: its chunk has no cameras", path_);
    add(*cameras);
    warn_of(not_aligned_, "not aligned, so left out");
    warn_of(disabled_, "not enabled, so left out");
    warn_of(turned_, "turned by Exif's orientation, which is not used");
    if (used_components_.size() > 1)
      set_.warnings.push_back(fmt::format(
          "{}: its cameras are of {} components, which Metashape did not align to each other",
          path_, used_components_.size()));
  }

 private:
  template <class Use>
  static void for_each(const XmlElement& chunk, const char* list, const char* name,
                       const Use& use) {
    const XmlElement* const found = chunk.child(list);
    if (found == nullptr) return;
    for (const XmlElement& each : found->children)
      if (each.name == name) use(each, each.attribute("id"));
  }

  void warn_of(std::size_t count, const char* what) {
    if (count > 0)
      set_.warnings.push_back(fmt::format("{}: {}: {}", path_, what, counted(count, "camera")));
  }

  void add(const XmlElement& list) {
    for (const XmlElement& each : list.children) {
      if (each.name == "group") add(each);
      if (each.name != "camera") continue;
      const bool is_off = each.attribute("enabled") == "false" || each.attribute("enabled") == "0";
      if (is_off)
        ++disabled_;
      else if (each.child("transform") == nullptr)
        ++not_aligned_;
      else
        add_camera(set_, each.attribute("label"), [&] { return camera_of(each); });
    }
  }

  LensCamera camera_of(const XmlElement& element) {
    const std::string label = element.attribute("label"),
                      sensor_id = element.attribute("sensor_id"),
                      component_id = element.attribute("component_id");
    const XmlPart camera{element, fmt::format("{}: camera '{}'", path_, printable(label))};
    const auto sensor = sensors_.find(sensor_id);
    if (sensor == sensors_.end())
      fail("{}: there is no sensor '{}'", camera.where, printable(sensor_id));
    const auto component = components_.find(component_id);
    const Similarity& place = component == components_.end() ? whole_ : component->second;
    used_components_.emplace(component_id, 0);
    const XmlElement* const orientation = element.child("orientation");
    if (orientation != nullptr && orientation->text != "1") ++turned_;

    const std::string where = fmt::format("{}: sensor {}", path_, printable(sensor_id));
    LensCamera result = lens_camera(lens_of_sensor({*sensor->second, where}), where);
    const auto rows = camera.child<16>("transform", {});
    const glm::dmat3 turn = place.rotation * rotation_of(rows, camera.where);
    const glm::dvec3 position =
        place.scale * (place.rotation * glm::dvec3(rows[3], rows[7], rows[11])) + place.translation;
    const glm::dmat3 view = glm::transpose(turn);
    result.camera.view_from_world = glm::dmat4x3(view[0], view[1], view[2], -(view * position));
    result.camera.name = photograph_name(label);
    result.photograph = label;
    return result;
  }

  CameraSet& set_;
  std::string path_;
  Similarity whole_;
  std::map<std::string, const XmlElement*> sensors_;
  std::map<std::string, Similarity> components_;
  std::map<std::string, int> used_components_;
  std::size_t not_aligned_ = 0, disabled_ = 0, turned_ = 0;
};

}  // namespace

CameraSet read_metashape_xml(const std::filesystem::path& file) {
  const std::string text = read_text_file(file, kMaxCameraFileBytes);
  const XmlElement whole = parse_xml(text, file.string());
  const XmlElement* const document = whole.child("document");
  const XmlElement* const chunk = document == nullptr ? nullptr : document->child("chunk");
  if (chunk == nullptr)
    fail("{}: not Metashape's cameras: there is no document with a chunk", file.string());
  CameraSet set{file};
  if (std::ranges::count(document->children, "chunk", &XmlElement::name) > 1)
    set.warnings.push_back(fmt::format("{}: only its first chunk is used", file.string()));
  const MetashapeChunk read(*chunk, set);
  if (set.cameras.empty() && set.left_out.empty())
    fail("{}: no camera of its chunk is aligned and enabled", file.string());
  return set;
}

}  // namespace qs
