// SPDX-License-Identifier: MIT
#include "io/scene/usd/usd_stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "base/fail.h"
#include "base/text.h"
#include "io/bytes/byte_text.h"
#include "io/scene/usd/usda_text.h"

namespace qs {
namespace {

constexpr std::size_t kMostPrims = 1 << 18, kDeepestPrim = 128, kMostOps = 64;

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

// The matrix for column vectors. `kind` is the second part of "xformOp:rotateXYZ:name".
glm::dmat4 matrix_of(std::string_view kind, const std::vector<double>& v) {
  const glm::dmat4 one(1);
  const auto axis = [](char letter) {
    glm::dvec3 direction(0);
    direction[letter - 'X'] = 1;
    return direction;
  };
  if (kind == "translate") return glm::translate(one, glm::dvec3(v[0], v[1], v[2]));
  if (kind == "scale") return glm::scale(one, glm::dvec3(v[0], v[1], v[2]));
  if (kind == "orient") return glm::mat4_cast(glm::normalize(glm::dquat(v[0], v[1], v[2], v[3])));
  glm::dmat4 matrix(1);
  if (kind == "transform") {  // rows of a matrix for row vectors
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = v[static_cast<std::size_t>(i)];
  } else {  // the first axis is applied first
    const std::string_view axes = kind.substr(std::string_view("rotate").size());
    for (std::size_t i = 0; i < axes.size(); ++i)
      matrix = glm::rotate(one, glm::radians(v[i]), axis(axes[i])) * matrix;
  }
  return matrix;
}

// The numbers of an operation; 0 for an unknown one.
std::size_t numbers_of(std::string_view kind) {
  if (kind == "translate" || kind == "scale") return 3;
  if (kind == "orient") return 4;
  if (kind == "transform") return 16;
  constexpr std::string_view kRotations[] = {"X",   "Y",   "Z",   "XYZ", "XZY",
                                             "YXZ", "YZX", "ZXY", "ZYX"};
  if (!kind.starts_with("rotate")) return 0;
  kind.remove_prefix(std::string_view("rotate").size());
  return std::ranges::count(kRotations, kind) > 0 ? kind.size() : 0;
}

std::string_view kind_of_op(std::string_view name) {
  name.remove_prefix(std::string_view("xformOp:").size());
  return name.substr(0, name.find(':'));
}

struct Prim {
  std::string name;
  std::size_t parent = 0;  // 0: the stage
  bool is_shown = true;
  std::map<std::string, glm::dmat4, std::less<>> ops;
  std::vector<std::string> op_order;
  std::optional<UsdSplats> splats;
};

class StageParser {
 public:
  StageParser(std::string_view text, const std::string& source, const Progress& progress)
      : source_(source), text_(text, source, progress) {}

  UsdStage parse() {
    prims_.emplace_back();
    read_stage_metadata();
    std::vector<std::size_t> open = {0};
    while (open.size() > 1 || !text_.at_end()) {
      if (open.size() > 1 && text_.accept('}')) {
        open.pop_back();
        continue;
      }
      const std::string_view word = text_.word();
      if (word == "def" || word == "over" || word == "class") {
        if (open.size() > kDeepestPrim) text_.complain("more than {} nested prims", kDeepestPrim);
        open.push_back(begin_prim(word == "def", open.back()));
      } else if (open.size() == 1 && word != "reorder") {
        text_.complain("a prim is expected, there is '{}'", printable(word));
      } else {
        read_property(word, open.back());
      }
    }
    place_splats();
    add_warnings();
    return std::move(stage_);
  }

 private:
  // Calls use(key, value) for each entry of "(key = value ...)", with the texts of the values.
  template <class Use>
  void read_metadata(const Use& use) {
    if (!text_.accept('(')) return;
    while (!text_.accept(')')) {
      const char next = text_.peek();
      if (next == '"' || next == '\'') {
        text_.string();
        continue;
      }
      if (text_.accept(';')) continue;
      std::string_view key = text_.word();
      if (is_list_edit(key)) key = text_.word();
      // A dictionary may have a type before its name.
      if (text_.peek() != '=') key = text_.word();
      text_.expect('=');
      use(key, text_.skip_value());
    }
  }

  static bool is_list_edit(std::string_view word) {
    constexpr std::string_view kEdits[] = {"prepend", "append", "delete", "add", "reorder"};
    return std::ranges::count(kEdits, word) > 0;
  }

  void read_stage_metadata() {
    read_metadata([&](std::string_view key, std::string_view value) {
      if (key == "upAxis") {
        stage_.z_is_up = value == "\"Z\"" || value == "'Z'";
        if (!stage_.z_is_up && value != "\"Y\"" && value != "'Y'")
          text_.complain("upAxis is {}, but must be \"Y\" or \"Z\"", printable(value));
      }
      if (key == "subLayers" && value != "[]") add_new(composed_, "sublayers");
    });
  }

  std::size_t begin_prim(bool is_definition, std::size_t parent) {
    if (prims_.size() > kMostPrims) text_.complain("more than {} prims", kMostPrims);
    Prim prim;
    prim.parent = parent;
    const char next = text_.peek();
    const std::string type(next == '"' || next == '\'' ? "" : text_.word());
    prim.name = printable(text_.string());
    std::string schemas;
    read_metadata([&](std::string_view key, std::string_view value) {
      if (key == "apiSchemas") schemas = value;
      if (key == "active" && value == "false") prim.is_shown = false;
      for (const char* composed : {"references", "payload", "inherits", "specializes", "variants"})
        if (key == composed && value != "None") add_new(composed_, std::string(composed));
    });
    text_.expect('{');
    const bool has_kernel = schemas.find("ParticleFieldKernel") != schemas.npos;
    const bool is_splats =
        type == "ParticleField3DGaussianSplat" || (type == "ParticleField" && has_kernel);
    if (is_splats && schemas.find("SurfletAPI") != schemas.npos)
      text_.complain("{}/{} has a kernel of flat surflets, which cannot be read", path_of(parent),
                     prim.name);
    if (!is_definition) prim.is_shown = false;
    if (is_splats) prim.splats.emplace();
    prims_.push_back(std::move(prim));
    return prims_.size() - 1;
  }

  std::string path_of(std::size_t prim) const {
    std::string path;
    for (; prim != 0; prim = prims_[prim].parent) path.insert(0, "/" + prims_[prim].name);
    return path;
  }

  void read_property(std::string_view word, std::size_t prim) {
    if (word == "variantSet") {
      text_.string();
      text_.expect('=');
      text_.skip_value();
      add_new(composed_, std::string("variants"));
      return;
    }
    while (word == "custom" || word == "uniform" || word == "varying" || is_list_edit(word))
      word = text_.word();
    const std::string_view type = word;
    const bool is_list = text_.accept('[');
    if (is_list) text_.expect(']');
    // A list edit of names, such as "reorder properties = [..]", has no type.
    const std::string name(text_.peek() == '=' ? type : text_.word());
    if (text_.accept('=')) read_value(type, is_list, name, prim);
    if (text_.peek() == '(') text_.skip_value();
  }

  void read_value(std::string_view type, bool is_list, const std::string& name,
                  std::size_t number) {
    if (is_none()) return;
    Prim& prim = prims_[number];
    if (name.ends_with(".timeSamples")) {
      const bool matters = prim.splats || name.starts_with("xformOp:");
      if (matters) add_new(timed_, name.substr(0, name.find('.')));
    } else if (name.find('.') != name.npos) {  // a connection
    } else if (name.starts_with("xformOp:")) {
      return read_op(name, prim);
    } else if (name == "xformOpOrder") {
      prim.op_order = text_.strings();
      if (prim.op_order.size() > kMostOps) text_.complain("more than {} xformOps", kMostOps);
      return;
    } else if (name == "visibility" || name == "projectionModeHint") {
      const std::string_view value = text_.string();
      if (value == "invisible") prim.is_shown = false;
      if (value == "tangential" && prim.splats) is_tangential_ = true;
      return;
    } else if (prim.splats && read_splat_value(type, is_list, name, number)) {
      return;
    }
    text_.skip_value();
  }

  // "None" blocks a value.
  bool is_none() {
    if (text_.peek() != 'N') return false;
    text_.skip_value();
    return true;
  }

  void read_op(const std::string& name, Prim& prim) {
    const std::string_view kind = kind_of_op(name);
    const std::size_t count = numbers_of(kind);
    if (count == 0) text_.complain("{} is not known", printable(name));
    const std::vector<double> numbers = text_.numbers(count);
    for (const double number : numbers)
      if (!std::isfinite(number)) text_.complain("{} is not finite", printable(name));
    if (prim.ops.size() >= kMostOps) text_.complain("more than {} xformOps", kMostOps);
    prim.ops[name] = matrix_of(kind, numbers);
  }

  bool read_splat_value(std::string_view type, bool is_list, const std::string& name,
                        std::size_t prim) {
    UsdSplats& splats = *prims_[prim].splats;
    if (name == "radiance:sphericalHarmonicsDegree") {
      const double degree = text_.number();
      if (degree != std::floor(degree) || degree < 0 || degree > 4)
        text_.complain("{}: SH degree {}, 0 to 4 can be read", path_of(prim), degree);
      splats.sh_degree = static_cast<int>(degree);
      return true;
    }
    for (std::size_t i = 0; i < kUsdArrays; ++i) {
      const ArrayRow& row = kArrayRows[i];
      const bool is_half = name == fmt::format("{}h", row.name);
      if (!is_half && name != row.name) continue;
      if (!is_list || components_of(type) != row.components)
        text_.complain("{}: {} is no list of {} numbers each, but of type {}", path_of(prim), name,
                       row.components, printable(type));
      Array<float> values = text_.array(row.components);
      if (splats.values[i] && is_half) return true;  // floats are preferred
      splats.values[i] = std::move(values);
      splats.is_half[i] = is_half;
      return true;
    }
    return false;
  }

  void place_splats() {
    std::vector<glm::dmat4> worlds(prims_.size(), glm::dmat4(1));
    for (std::size_t i = 1; i < prims_.size(); ++i) {  // parents come first
      Prim& prim = prims_[i];
      const Prim& parent = prims_[prim.parent];
      prim.is_shown = prim.is_shown && parent.is_shown;
      worlds[i] = worlds[prim.parent];
      for (std::string_view name : prim.op_order) {
        if (name == "!resetXformStack!") {
          worlds[i] = glm::dmat4(1);
          continue;
        }
        constexpr std::string_view kInvert = "!invert!";
        const bool is_inverse = name.starts_with(kInvert);
        if (is_inverse) name.remove_prefix(kInvert.size());
        const auto op = prim.ops.find(name);
        if (op == prim.ops.end()) continue;  // it changes over time, or has no value
        worlds[i] = worlds[i] * (is_inverse ? glm::inverse(op->second) : op->second);
      }
      if (!prim.splats) continue;
      if (!prim.is_shown) {
        ++hidden_;
        continue;
      }
      prim.splats->world = worlds[i];
      prim.splats->prim = path_of(i);
      stage_.splats.push_back(std::move(*prim.splats));
    }
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

  std::string source_;
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
