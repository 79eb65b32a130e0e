// SPDX-License-Identifier: MIT
#include "learn/lod/instance_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/fail.h"
#include "io/bytes/mapped_file.h"
#include "io/cloud/axes.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/linear_values.h"
#include "io/scene/instances.h"
#include "io/scene/rad/rad_pages.h"
#include "learn/lod/bucket_files.h"
#include "learn/lod/section.h"
#include "raster/kernel/half.h"
#include "raster/pages/page_stream.h"
#include "raster/scene/cloud_order.h"
#include "raster/scene/place.h"

namespace qs {
namespace {

// `name(i)`: names Gaussian `i` in a sentence.
template <class Name>
void require_drawable(GaussianCloud& cloud, const Name& name) {
  ThreadPool alone(1);
  const auto flawed = fill_drawable(cloud, alone, {}, [](std::size_t, std::size_t) {});
  if (!flawed.empty()) fail("{} cannot be drawn", name(flawed[0]));
}

class InstanceTree {
 public:
  InstanceTree(const InstanceList& list, RadPages file, const ReadOptions& options)
      : file_(std::move(file)),
        name_(list.path.string()),
        shared_(file_.header().chunks.size()),
        mutexes_(shared_.size()) {
    const std::uint64_t count = list.instances.size();
    page_nodes_ = std::min(file_.header().chunk_nodes, file_.header().count);
    const LodPage first = file_.read(0);
    const GaussianCloud root = select(first.cloud, std::array{0u});
    glm::dvec3 origin(0);
    if (!options.keeps_place)
      origin = origin_of(count, [&](std::size_t i) {
        return glm::dvec3(matrix_of(list.instances[i], root.origin) *
                          glm::dvec4(root.positions[0], 1));
      });
    const glm::dmat4 turn(options.axes.empty() ? glm::dmat3(1) : rdf_from(options.axes));
    for (const Instance& instance : list.instances) {
      const glm::dmat4 matrix = turn * matrix_of(instance, root.origin, origin);
      instances_->placements.push_back({{Transform(matrix), instance.tint},
                                        glm::mat4x3(matrix),
                                        static_cast<float>(instance.scale),
                                        0});
    }
    GaussianCloud roots = make_cloud(count, root.sh_degree);
    roots.antialiased = root.antialiased;
    for (std::size_t i = 0; i < count; ++i) {
      copy_gaussian(root, 0, roots, i);
      instances_->placements[i].apply(roots, i);
    }
    require_drawable(roots,
                     [&](std::size_t i) { return fmt::format("{}: instance {}", name_, i); });
    const LodSection top = top_of(roots, first.nodes[0]);
    nodes_ = top.tree.nodes.size() + count * (file_.header().count - 1);
    instances_->first = (top.tree.nodes.size() + page_nodes_ - 1) / page_nodes_;
    instances_->each = shared_.size();
    if (pages() > 0xffffffff / page_nodes_)
      fail("{}: {} pages of {} nodes, but a tree has at most 2^32 nodes", name_, pages(),
           page_nodes_);
    // The root of an instance is in the tree above, its children are in the pages of the instance.
    for (std::size_t i = 0; i < count; ++i)
      instances_->placements[i].base =
          static_cast<std::uint32_t>((instances_->first + i * instances_->each) * page_nodes_);
    make_pages(top, roots, first.nodes[0], turn * glm::dvec4(origin, 1));
  }

  LodPages tree() const {
    LodPages tree{nodes_, page_nodes_, file_.header().footprint};
    tree.pages.resize(pages());
    tree.pages[0] = top_[0];
    tree.instances = instances_;
    return tree;
  }

  PageSource source(const std::shared_ptr<InstanceTree>& self) const {
    PageSource source{name_, [self](std::size_t page) { return self->read(page); },
                      [self] { return self->file_.is_unchanged(); }};
    source.stored_bytes.resize(pages());
    for (std::size_t page = instances_->first; page < pages(); ++page)
      source.stored_bytes[page] =
          file_.header().chunks[(page - instances_->first) % instances_->each].bytes;
    return source;
  }

 private:
  std::size_t pages() const {
    return instances_->first + instances_->placements.size() * instances_->each;
  }

  // A page of all instances is read once.
  std::shared_ptr<const LodPage> read(std::size_t page) {
    if (page < instances_->first) return top_[page];
    const std::size_t own = (page - instances_->first) % instances_->each;
    const std::lock_guard lock(mutexes_[own]);
    std::shared_ptr<const LodPage> result = shared_[own].lock();
    if (!result) shared_[own] = result = std::make_shared<const LodPage>(file_.read(own));
    return result;
  }

  // The tree over the roots of the instances. A tree of another size has its gains and errors at
  // footprints of another size. They are areas, and steps count from the square of the smallest
  // footprint.
  LodSection top_of(const GaussianCloud& roots, const LodFacts& facts) const {
    const float footprint = file_.header().footprint;
    LodItems items;
    for (std::size_t i = 0; i < instances_->placements.size(); ++i) {
      const LodPlacement& placement = instances_->placements[i];
      const float octaves = std::log2(placement.scale);
      const auto place_steps = [&](LodSteps& steps) {
        const LodSteps old = steps;
        for (std::size_t k = 0; k < kLodFootprints; ++k) {
          const float at =
              std::clamp(static_cast<float>(k) - octaves / 2, 0.0f, kLodFootprints - 1.0f);
          steps[k] = static_cast<std::uint8_t>(
              std::lround(std::clamp(lod_step_at(old, at) + 8 * octaves, 0.0f, 255.0f)));
        }
      };
      LodFacts node = facts;
      place_steps(node.gains);
      place_steps(node.errors);
      node.radius *= placement.scale;
      items.add(roots, i, node, footprint);
    }
    return make_section(std::move(items), 1, {footprint, roots.antialiased});
  }

  void make_pages(const LodSection& top, const GaussianCloud& roots, const LodFacts& facts,
                  const glm::dvec3& origin) {
    const std::size_t values = top.tree.sh.size() / top.tree.nodes.size();
    LinearValues linear;
    for (std::size_t begin = 0; begin < top.tree.nodes.size(); begin += page_nodes_) {
      const std::size_t size = std::min<std::size_t>(page_nodes_, top.tree.nodes.size() - begin);
      const auto page = std::make_shared<LodPage>();
      page->cloud = make_cloud(size, roots.sh_degree);
      page->cloud.antialiased = roots.antialiased;
      page->cloud.origin = origin;
      for (std::size_t k = 0; k < size; ++k) {
        const LodNode& node = top.tree.nodes[begin + k];
        page->nodes.push_back(node);
        if (const std::uint32_t item = top.items[begin + k]; item != ~0u) {
          copy_gaussian(roots, item, page->cloud, k);
          page->nodes[k].first_child = facts.first_child + instances_->placements[item].base;
          continue;
        }
        page->cloud.positions[k] = node.center;
        page->cloud.log_scales[k] = linear.log_scale(node.scales);
        page->cloud.rotations[k] = node.rotation;
        page->cloud.opacity_logits[k] = linear.logit(static_cast<double>(node.alpha));
        glm::vec3* const sh = sh_of(page->cloud, k);
        for (std::size_t v = 0; v < values; ++v)
          sh[v / 3][static_cast<int>(v % 3)] = float_of_half(top.tree.sh[(begin + k) * values + v]);
      }
      require_drawable(page->cloud, [&](std::size_t k) {
        return fmt::format("{}: node {} of the tree over its instances", name_, begin + k);
      });
      top_.push_back(page);
    }
  }

  RadPages file_;
  std::string name_;
  std::uint64_t page_nodes_ = 0, nodes_ = 0;
  std::shared_ptr<LodInstances> instances_ = std::make_shared<LodInstances>();
  std::vector<std::shared_ptr<const LodPage>> top_;   // pages
  std::vector<std::weak_ptr<const LodPage>> shared_;  // pages of the file
  std::vector<std::mutex> mutexes_;                   // of these
};

}  // namespace

bool stream_instances(const ReadOptions& options, ThreadPool& pool, Scene& scene) {
  if (options.streams == StreamedTrees::none || !scene.path.string().ends_with(".json"))
    return false;
  const MappedFile content(scene.path);
  if (!recognises_instances(content.content(), scene.path)) return false;
  InstanceList list = read_instance_list(content.content(), scene.path);
  if (!is_rad_file(list.scene)) return false;
  RadPages file(list.scene);
  const RadHeader& header = file.header();
  const std::uint64_t instances = list.instances.size();
  if (!header.has_tree || header.footprint == 0 || !is_streamed(options, instances * header.count))
    return false;
  scene.format = "instances of rad";
  scene.file_bytes = content.content().size() + file.file_bytes();
  scene.warnings = list.warnings;
  scene.parts.push_back(
      {list.scene.filename().string(), file.file_bytes(),
       fmt::format("{} of {}", counted(instances, "instance"), counted(header.count, "node"))});
  const auto tree = std::make_shared<InstanceTree>(list, std::move(file), options);
  set_stream(tree->tree(), tree->source(tree), options, pool, scene);
  return true;
}

}  // namespace qs
