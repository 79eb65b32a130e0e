// SPDX-License-Identifier: MIT
#include "io/scene/usd/usd_stage.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "base/fail.h"
#include "base/text.h"
#include "io/bytes/byte_text.h"
#include "io/scene/usd/usda_text.h"

namespace qs {
namespace {

constexpr std::size_t kMostPrims = 1 << 18, kDeepestPrim = 128;
constexpr std::string_view kOp = "xformOp:", kTimes = ".timeSamples";

struct ArrayRow {
  std::string_view name;  // with an "h" behind it: halves
  std::size_t components;
};
constexpr std::array<ArrayRow, kUsdArrays> kArrayRows = {
    {{"positions", 3},
     {"orientations", 4},
     {"scales", 3},
     {"opacities", 1},
     {"radiance:sphericalHarmonicsCoefficients", 3}}};

// 4 for quatf, 3 for point3f and float3, 1 for float.
std::size_t components_of(std::string_view type) {
  if (type.starts_with("quat")) return 4;
  const std::size_t digit = type.find_first_of("234");
  return digit == type.npos ? 1 : static_cast<std::size_t>(type[digit] - '0');
}

// "rotateXYZ" of "xformOp:rotateXYZ:name".
std::string_view kind_of_op(std::string_view name) {
  name.remove_prefix(kOp.size());
  return name.substr(0, name.find(':'));
}

// The axes of a rotation, "" for other operations.
std::string_view axes_of(std::string_view kind) {
  constexpr std::string_view kRotate = "rotate";
  return kind.starts_with(kRotate) ? kind.substr(kRotate.size()) : "";
}

// The numbers of an operation; 0 for an unknown one.
std::size_t numbers_of(std::string_view kind) {
  if (kind == "translate" || kind == "scale") return 3;
  if (kind == "orient") return 4;
  if (kind == "transform") return 16;
  constexpr std::string_view kRotations[] = {"X",   "Y",   "Z",   "XYZ", "XZY",
                                             "YXZ", "YZX", "ZXY", "ZYX"};
  return std::ranges::count(kRotations, axes_of(kind)) > 0 ? axes_of(kind).size() : 0;
}

// The matrix for column vectors of an operation that is known.
glm::dmat4 matrix_of(std::string_view kind, const std::vector<double>& v) {
  glm::dmat4 matrix(1);
  if (kind == "translate") return glm::translate(matrix, glm::dvec3(v[0], v[1], v[2]));
  if (kind == "scale") return glm::scale(matrix, glm::dvec3(v[0], v[1], v[2]));
  if (kind == "orient") return glm::mat4_cast(glm::normalize(glm::dquat(v[0], v[1], v[2], v[3])));
  // The rows of a matrix for row vectors.
  for (std::size_t i = 0; kind == "transform" && i < 16; ++i)
    matrix[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = v[i];
  for (std::size_t i = 0; i < axes_of(kind).size(); ++i) {  // the first axis is applied first
    glm::dvec3 axis(0);
    axis[axes_of(kind)[i] - 'X'] = 1;
    matrix = glm::rotate(glm::dmat4(1), glm::radians(v[i]), axis) * matrix;
  }
  return matrix;
}

// Values are parts of the stage's text.
struct Property {
  std::string_view type, value;
  bool is_list = false;
};

struct Prim {
  std::string path, type;
  std::size_t parent = 0;  // 0: the stage
  bool is_shown = true;
  std::map<std::string_view, std::string_view> metadata;
  std::map<std::string_view, Property> properties;
  glm::dmat4 world{1};

  // "" if there is no such property.
  std::string_view value(std::string_view name) const {
    const auto found = properties.find(name);
    return found == properties.end() ? "" : found->second.value;
  }
};

class StageParser {
 public:
  StageParser(std::string_view text, const std::string& source, const Progress& progress)
      : text_(text, source, progress) {}

  UsdStage parse() {
    prims_.emplace_back().metadata = read_metadata();
    for (std::vector<std::size_t> open = {0}; open.size() > 1 || !text_.at_end();) {
      if (open.size() > 1 && text_.accept('}')) {
        open.pop_back();
        continue;
      }
      const std::string_view word = text_.word();
      if (word == "def" || word == "over" || word == "class") {
        if (open.size() > kDeepestPrim) text_.complain("more than {} nested prims", kDeepestPrim);
        begin_prim(word == "def", open.back());
        open.push_back(prims_.size() - 1);
      } else if (open.size() == 1 && word != "reorder") {
        text_.complain("a prim is expected, there is '{}'", printable(word));
      } else {
        read_property(word, prims_[open.back()]);
      }
    }
    for (Prim& prim : prims_) use(prim);
    add_warnings();
    return std::move(stage_);
  }

 private:
  static bool is_list_edit(std::string_view word) {
    constexpr std::string_view kEdits[] = {"prepend", "append", "delete", "add", "reorder"};
    return std::ranges::count(kEdits, word) > 0;
  }

  // "(key = value ...)", if it comes next.
  std::map<std::string_view, std::string_view> read_metadata() {
    std::map<std::string_view, std::string_view> metadata;
    if (!text_.accept('(')) return metadata;
    while (!text_.accept(')')) {
      if (text_.peek() == '"' || text_.peek() == '\'') {
        text_.string();
        continue;
      }
      if (text_.accept(';')) continue;
      std::string_view key = text_.word();
      if (is_list_edit(key)) key = text_.word();
      // A dictionary may have a type before its name.
      if (text_.peek() != '=') key = text_.word();
      text_.expect('=');
      metadata[key] = text_.skip_value();
    }
    return metadata;
  }

  void begin_prim(bool is_definition, std::size_t parent) {
    if (prims_.size() > kMostPrims) text_.complain("more than {} prims", kMostPrims);
    Prim prim;
    prim.parent = parent;
    prim.is_shown = is_definition;
    if (text_.peek() != '"' && text_.peek() != '\'') prim.type = text_.word();
    prim.path = prims_[parent].path + "/" + printable(text_.string());
    prim.metadata = read_metadata();
    text_.expect('{');
    prims_.push_back(std::move(prim));
  }

  void read_property(std::string_view word, Prim& prim) {
    if (word == "variantSet") {
      text_.string();
      text_.expect('=');
      prim.metadata["variants"] = text_.skip_value();
      return;
    }
    while (word == "custom" || word == "uniform" || word == "varying" || is_list_edit(word))
      word = text_.word();
    Property property{word, {}, text_.accept('[')};
    if (property.is_list) text_.expect(']');
    // A list edit of names, such as "reorder properties = [..]", has no type.
    const std::string_view name = text_.peek() == '=' ? word : text_.word();
    if (text_.accept('=')) property.value = text_.skip_value();
    // None blocks a value.
    if (!property.value.empty() && property.value != "None") prim.properties[name] = property;
    if (text_.peek() == '(') text_.skip_value();
  }

  // Its parent was used before.
  void use(Prim& prim) {
    for (const auto& [key, value] : prim.metadata) {
      constexpr std::string_view kComposed[] = {"references",  "payload",  "inherits",
                                                "specializes", "variants", "subLayers"};
      if (std::ranges::count(kComposed, key) > 0 && value != "None" && value != "[]")
        add_new(composed_, lower_case(std::string(key)));
      if (key == "active" && value == "false") prim.is_shown = false;
      if (key == "upAxis") {
        text_.move_to(value);
        stage_.z_is_up = value == "\"Z\"" || value == "'Z'";
        if (!stage_.z_is_up && value != "\"Y\"" && value != "'Y'")
          text_.complain("upAxis is {}, but must be \"Y\" or \"Z\"", printable(value));
      }
    }
    if (prim.value("visibility").find("invisible") != std::string_view::npos) prim.is_shown = false;
    prim.is_shown = prim.is_shown && prims_[prim.parent].is_shown;
    prim.world = world_of(prim);
    const std::string_view schemas = prim.metadata["apiSchemas"];
    const bool has_kernel = schemas.find("ParticleFieldKernel") != schemas.npos;
    if (prim.type != "ParticleField3DGaussianSplat" &&
        !(prim.type == "ParticleField" && has_kernel))
      return;
    if (schemas.find("SurfletAPI") == schemas.npos)
      return prim.is_shown ? read_splats(prim) : void(++hidden_);
    text_.move_to(schemas);
    text_.complain("{} has a kernel of flat surflets, which cannot be read", prim.path);
  }

  glm::dmat4 world_of(const Prim& prim) {
    std::map<std::string_view, glm::dmat4> ops;
    for (const auto& [name, property] : prim.properties) {
      if (!name.starts_with(kOp)) continue;
      if (name.ends_with(kTimes)) add_new(timed_, std::string(name.substr(0, name.find('.'))));
      if (name.find('.') != name.npos) continue;
      const std::string_view kind = kind_of_op(name);
      text_.move_to(property.value);
      if (numbers_of(kind) == 0) text_.complain("{} is not known", printable(name));
      const std::vector<double> numbers = text_.numbers(numbers_of(kind));
      if (!std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); }))
        text_.complain("{} is not finite", printable(name));
      ops[name] = matrix_of(kind, numbers);
    }
    glm::dmat4 world = prims_[prim.parent].world;
    if (prim.value("xformOpOrder").empty()) return world;
    text_.move_to(prim.value("xformOpOrder"));
    for (std::string_view name : text_.strings()) {
      constexpr std::string_view kInvert = "!invert!";
      if (name == "!resetXformStack!") world = glm::dmat4(1);
      const bool is_inverse = name.starts_with(kInvert);
      if (is_inverse) name.remove_prefix(kInvert.size());
      const auto op = ops.find(name);
      if (op == ops.end()) continue;  // it changes over time, or has no value
      world = world * (is_inverse ? glm::inverse(op->second) : op->second);
    }
    return world;
  }

  void read_splats(const Prim& prim) {
    UsdSplats splats{.prim = prim.path, .world = prim.world};
    for (const auto& [name, property] : prim.properties)
      if (name.ends_with(kTimes)) add_new(timed_, std::string(name.substr(0, name.find('.'))));
    if (prim.value("projectionModeHint").find("tangential") != std::string_view::npos)
      is_tangential_ = true;
    if (const auto value = prim.value("radiance:sphericalHarmonicsDegree"); !value.empty()) {
      text_.move_to(value);
      const double degree = text_.number();
      if (degree != std::floor(degree) || degree < 0 || degree > 4)
        text_.complain("{}: SH degree {}, 0 to 4 can be read", prim.path, degree);
      splats.sh_degree = static_cast<int>(degree);
    }
    for (std::size_t i = 0; i < kUsdArrays; ++i) {
      const auto& [name, components] = kArrayRows[i];
      auto found = prim.properties.find(name);
      // Floats are preferred to halves.
      if (found == prim.properties.end()) found = prim.properties.find(fmt::format("{}h", name));
      if (found == prim.properties.end()) continue;
      const Property& property = found->second;
      text_.move_to(property.value);
      if (!property.is_list || components_of(property.type) != components)
        text_.complain("{}: {} is no list of {} numbers each, but of type {}", prim.path, name,
                       components, printable(property.type));
      splats.values[i] = text_.array(components);
    }
    stage_.splats.push_back(std::move(splats));
  }

  void add_warnings() {
    const auto warn = [this]<class... Args>(fmt::format_string<Args...> sentence, Args&&... args) {
      stage_.warnings.push_back(fmt::format(sentence, std::forward<Args>(args)...));
    };
    if (!composed_.empty())
      warn("The stage is composed of more than this text; not read: {}.", joined(composed_, ", "));
    if (!timed_.empty())
      warn("Values that change over time are not read: {}.", joined(timed_, ", "));
    if (hidden_ > 0)
      warn("Prims with Gaussians that are invisible, inactive or not defined were left out: {}.",
           hidden_);
    if (is_tangential_)
      warn("The file asks for a tangential projection; it is drawn in perspective.");
  }

  UsdaText text_;
  UsdStage stage_;
  std::vector<Prim> prims_;  // the first one is the stage
  std::vector<std::string> composed_, timed_;
  std::size_t hidden_ = 0;
  bool is_tangential_ = false;
};

}  // namespace

UsdStage parse_usda(std::string_view text, const std::string& source, const Progress& progress) {
  return StageParser(text, source, progress).parse();
}

}  // namespace qs
