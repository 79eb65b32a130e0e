// SPDX-License-Identifier: MIT
//
// A cut of a tree with levels of detail: the nodes that are drawn in the place of all leaves. Every
// merged node has a gain, which is never larger than its parent's. The nodes whose gain is above
// the limit of a cut are *open*: their children are drawn in their place. The nodes of a tree are
// in pages, of which some are in memory. A node with a child in a missing page is drawn itself, so
// a missing page makes a picture coarser and never leaves a hole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/mat4x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "raster/pages/lod_node.h"
#include "raster/pages/surfaces.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"
#include "raster/scene/gaussian_set.h"
#include "raster/scene/transform.h"

namespace qs {

/// Consecutive nodes, as they are drawn without a filter.
struct LodPage {
  GaussianCloud cloud;
  std::vector<LodFacts> nodes = {};
  /// By node: the number of a leaf in the sources of the file, kNoNumber for merged nodes. Empty if
  /// the file does not know it.
  std::vector<std::uint32_t> numbers = {};
  /// The rows that edits select; of size 0: none.
  GaussianSet selected = GaussianSet();
  /// Edits chose single leaves, so their merged nodes follow them, see PageStream::edit_pages().
  bool follows_leaves = false;
  /// The nodes and opacities before edits, without the rest; null: not edited.
  std::shared_ptr<const LodPage> as_read = {};

  std::size_t bytes() const;  ///< of memory
};

/// An instance of a tree within a tree.
struct LodPlacement : Placement {
  glm::mat4x3 matrix{1};   ///< of the transform
  float scale = 1;         ///< of the transform
  std::uint32_t base = 0;  ///< the number of the instance's first node; its children count from it

  glm::vec3 at(const glm::vec3& point) const { return matrix * glm::vec4(point, 1); }
};

/// The pages from `first` on belong to instances of one tree, which has `each` pages. They share
/// its pages in memory, and their nodes are placed when they are used.
struct LodInstances {
  std::size_t first = 0, each = 1;
  std::vector<LodPlacement> placements;
};

/// A tree, of which some pages are in memory. Node 0 is the root; children are consecutive and come
/// after their parent.
struct LodPages {
  std::uint64_t count = 0;           ///< nodes
  std::uint64_t page_nodes = 65536;  ///< of a page; the last one may have less
  float footprint = 0;               ///< the smallest one, world units; 0: the nodes have no gains
  std::vector<std::shared_ptr<const LodPage>> pages = {};  ///< null: not in memory
  std::vector<bool> dead = {};  ///< pages that will never come: the nodes above them are leaves
  std::shared_ptr<const LodInstances> instances = {};  ///< or null

  /// The instance to which a page belongs, or null.
  const LodPlacement* placement(std::size_t page) const {
    return !instances || page < instances->first
               ? nullptr
               : &instances->placements[(page - instances->first) / instances->each];
  }
  /// The first page with the same content in memory.
  std::size_t content(std::size_t page) const {
    return !instances || page < instances->first
               ? page
               : instances->first + (page - instances->first) % instances->each;
  }
};

/// The ball of a node: the centre and the radius. `placement`: of its page, or null.
std::pair<glm::vec3, float> lod_ball(const LodPage& page, std::size_t row,
                                     const LodPlacement* placement);

/// The part of a picture in which a node is seen.
struct LodSight {
  float footprint = 1;  ///< at the nearest point of the ball around the node's leaves, world units
  float share = 1;      ///< of its gain that counts: less than 1 outside, and behind surfaces
};

/// The picture of a wide lens, whose camera has pixels per radian as its focal lengths.
struct LodReach {
  double angle = 0;  ///< from the axis, radians; 0: the picture is the camera's
  double eye = 0;    ///< from the camera to each of two eyes, world units
  bool operator==(const LodReach&) const = default;
};

/// Sees balls in the picture of a camera.
struct LodView {
  LodView(const Camera& of_camera, float share_outside, const LodReach& of_lens = {});

  LodSight operator()(const glm::vec3& center, float radius) const;

  /// The same for `count` balls: their centres, radii, footprints and shares.
  void see(std::size_t count, const float* x, const float* y, const float* z, const float* radius,
           float* footprint, float* share) const;

  Camera camera;
  float outside;  ///< LodSight::share of nodes outside of the picture
  LodReach reach;
  std::shared_ptr<const LodSurfaces> surfaces = {};  ///< null: not known

 private:
  float footprint_of_depth_, footprint_, near_depth_;
  glm::dvec3 eye_;
  glm::mat3 turn_;  ///< of the world's axes
  /// Planes right, left, below and above: the normal along x or y, and z; the distance from the
  /// eye. Of a wide lens the first plane, through a line from the eye, is turned about the axis.
  glm::vec3 sides_[4];
};

/// A view in which all nodes have the same footprint.
LodView even_view(float footprint);

/// The error that a merged node adds per Gaussian that it saves, colour^2 times square pixels.
float lod_gain(const LodFacts& node, float smallest, float footprint);

/// Opens a merged node before all others while the ball around its leaves is larger than a pixel.
void open_first(LodFacts& node, float smallest);

struct LodLimit {
  std::size_t budget = std::numeric_limits<std::size_t>::max();  ///< nodes; one is always drawn
  float gain = 0;  ///< nodes with at most this gain stay closed; 0: all leaves are drawn
};

/// Nodes of one page, and the largest gain of a parent of them.
struct LodPart {
  std::uint32_t page = 0, count = 0;
  float gain = 0;
  GaussianSet mask = GaussianSet();  ///< rows of the page that are drawn

  template <class Visit>
  void for_each(const Visit& visit) const {  ///< in increasing order
    mask.for_each(visit);
  }
};

struct LodCut {
  std::size_t count = 0;
  float limit = 0;                    ///< the largest gain of a node that stays closed
  std::vector<LodPart> parts = {};    ///< by page
  std::vector<LodPart> missing = {};  ///< pages that the cut lacks, the largest gain first
};

/// A merged node whose gain is asked for.
struct LodAsked {
  const LodPage* page;
  const LodPlacement* placement;  ///< of the page, or null
  std::uint32_t row;
  float gain;
};

inline constexpr std::size_t kLodBatch = 256;

/// The gains of merged nodes, at most kLodBatch at a time. Several threads may ask.
class LodGain {
 public:
  using OfNodes = std::function<void(std::span<LodAsked> nodes)>;

  explicit LodGain(OfNodes of_nodes) : of_nodes_(std::move(of_nodes)) {}

  /// `of_node(page, row)`: the gain of one node, in all instances.
  template <class OfNode>
  requires std::is_invocable_r_v<float, OfNode, const LodPage&, std::size_t> LodGain(OfNode of_node)
      : of_nodes_([of_node = std::move(of_node)](std::span<LodAsked> nodes) {
          for (LodAsked& node : nodes) node.gain = of_node(*node.page, node.row);
        }) {}

  void operator()(std::span<LodAsked> nodes) const { of_nodes_(nodes); }

 private:
  OfNodes of_nodes_;
};

/// The gains in a view. `smallest`: LodPages::footprint; if that is 0, a node gains the square of
/// its radius in pixels.
LodGain gain_in(const LodView& view, float smallest);

/// The sums of the gains in several views.
LodGain gain_in(std::span<const LodView> views, float smallest);

/// A node on the way down the tree.
struct LodVisit {
  std::uint32_t node, parent;  ///< parent: the number of its visit
  std::uint32_t first_child;
  float gain;  ///< 0: it stays closed, as leaves do
  float parent_gain;
  std::uint16_t children;
  bool is_awaited;  ///< it was opened, and its children are missing

  std::uint32_t added() const { return children - 1u; }
};

/// The cut with the smallest limit that the budget allows. If the budget does not hold all nodes of
/// one gain, the first nodes of the tree are open. Page 0 is in memory. `guess`: the limit of a
/// similar cut, which saves time and changes nothing. `kept`: memory of a cut before, which saves
/// the time of getting it again. Throws Error(input) if a node is the child of several nodes.
LodCut cut_of(const LodPages& tree, const LodGain& gain, const LodLimit& limit, ThreadPool& pool,
              float guess = 0, Array<LodVisit>* kept = nullptr);

}  // namespace qs
