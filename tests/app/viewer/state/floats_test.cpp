// SPDX-License-Identifier: MIT
#include "app/viewer/state/floats.h"

#include <string>
#include <vector>

#include <glm/common.hpp>
#include <gtest/gtest.h>

#include "app/picture/grid_places.h"
#include "app/support/driven_viewer.h"

namespace qs {
namespace {

using enum FloatKind;

constexpr glm::ivec2 kWindows[] = {{320, 240},   {640, 400},   {1024, 576},
                                   {1280, 720},  {1536, 864},  {1920, 1080},
                                   {2560, 1440}, {3072, 1728}, {3840, 2160}};

// The parts of a state: what can be seen over the picture at one time.
struct Part {
  const char* name;
  void (*add)(std::vector<Floating>& shown, const Rect& picture, float letter);
};

void add_text(std::vector<Floating>& shown, FloatKind kind, float letters, float lines,
              const Rect& picture, float letter, std::optional<glm::vec2> at = {}) {
  const float most = picture.size().x - 1.1f * letter;
  shown.push_back({kind, {std::min(letters * letter, most), lines * letter}, {}, at});
}

constexpr Part kParts[] = {
    {"choice", [](auto& shown, const Rect& p, float l) { add_text(shown, choice, 60, 9, p, l); }},
    {"message",
     [](auto& shown, const Rect& p, float l) { add_text(shown, message, 25, 4.3f, p, l); }},
    {"messages",
     [](auto& shown, const Rect& p, float l) {
       for (const float lines : {2.3f, 4.3f, 6.0f}) add_text(shown, message, 30, lines, p, l);
     }},
    {"progress",
     [](auto& shown, const Rect& p, float l) { add_text(shown, progress, 26, 5.2f, p, l); }},
    {"legend",
     [](auto& shown, const Rect& p, float l) {
       add_text(shown, legend, 46, 7, p, l);
       shown.back().smaller = {shown.back().size.x, 2.9f * l};
     }},
    {"dragged legend",
     [](auto& shown, const Rect& p, float l) {
       add_text(shown, legend, 46, 7, p, l, p.low);
       shown.back().smaller = {shown.back().size.x, 2.9f * l};
     }},
    {"plate", [](auto& shown, const Rect& p, float l) { add_text(shown, plate, 20, 4, p, l); }},
    {"badge", [](auto& shown, const Rect& p, float l) { add_text(shown, badge, 8, 4.5f, p, l); }},
    {"photograph",
     [](auto& shown, const Rect& p, float l) {
       add_text(shown, photograph, 18, 1.6f, p, l, p.low + glm::vec2(l, 0));
     }},
    {"sides",
     [](auto& shown, const Rect& p, float l) {
       const float x = p.center().x;
       add_text(shown, left_name, 10, 1.6f, p, l, glm::vec2(x - l, p.low.y));
       add_text(shown, right_name, 7, 1.6f, p, l, glm::vec2(x + l, p.low.y));
     }},
    {"sides at the edge",
     [](auto& shown, const Rect& p, float l) {
       add_text(shown, left_name, 10, 1.6f, p, l, p.low);
       add_text(shown, right_name, 7, 1.6f, p, l, p.low);
     }},
    {"grid",
     [](auto& shown, const Rect& p, float l) {
       const GridPlaces places = grid_places(culler_count(), kGridLabel);
       for (int i = 0; i < culler_count(); ++i) {
         shown.push_back({cell, places.side * p.size(), {}, p.low + places.low(i) * p.size()});
         const glm::vec2 low = places.low(i) + glm::vec2(0, places.side);
         const float width = p.size().x / static_cast<float>(places.columns) - l;
         shown.push_back({caption,
                          {width, std::min(kGridLabel * p.size().y, 2.5f * l)},
                          {},
                          p.low + low * p.size()});
       }
     }},
    {"way",
     [](auto& shown, const Rect& p, float l) {
       add_text(shown, way, 16, 1.6f, p, l, glm::vec2(p.high.x, p.center().y));
     }},
    {"hints", [](auto& shown, const Rect& p, float l) { add_text(shown, hints, 32, 2.2f, p, l); }},
};
constexpr std::size_t kPartCount = std::size(kParts);

// The states in which the window can be: of two forms of a thing it shows one.
std::vector<std::vector<const Part*>> states() {
  std::vector<std::vector<const Part*>> all;
  for (unsigned bits = 0; bits < 1u << kPartCount; ++bits) {
    std::vector<const Part*> parts;
    bool twice = false;
    for (std::size_t i = 0; i < kPartCount; ++i) {
      if ((bits >> i & 1) == 0) continue;
      const std::string_view name = kParts[i].name;
      for (const Part* other : parts) {
        const std::string_view before = other->name;
        twice |= (name == "messages" && before == "message") ||
                 (name == "dragged legend" && before == "legend") ||
                 ((name == "sides at the edge" || name == "grid") && before.starts_with("sides"));
      }
      parts.push_back(&kParts[i]);
    }
    if (!twice) all.push_back(parts);
  }
  return all;
}

bool shares_area(const Rect& a, const Rect& b) {
  return !a.empty() && !b.empty() && a.low.x < b.high.x && b.low.x < a.high.x &&
         a.low.y < b.high.y && b.low.y < a.high.y;
}

// The picture of a window with and without bars.
std::vector<Rect> pictures_of(glm::ivec2 window, float letter) {
  test::DrivenScene driven(0);
  Viewer viewer = driven.viewer;
  const WindowMetrics metrics{glm::vec2(window), letter, letter + 8};
  std::vector<Rect> pictures = {layout_of(viewer, metrics).picture};
  viewer.panels.hud = viewer.panels.info = true;
  pictures.push_back(layout_of(viewer, metrics).picture);
  return pictures;
}

TEST(Floats, nothing_overlaps_and_all_is_in_the_picture_in_every_state_at_every_size) {
  const std::vector<std::vector<const Part*>> all = states();
  EXPECT_GT(all.size(), 4000u);
  for (const glm::ivec2 window : kWindows) {
    const float letter = window.y >= 1700 ? 26 : 15;
    for (const Rect& picture : pictures_of(window, letter)) {
      for (const std::vector<const Part*>& state : all) {
        std::vector<Floating> shown;
        for (const Part* part : state) part->add(shown, picture, letter);
        const auto words = [&] {
          std::string text = std::to_string(window.x);
          for (const Part* part : state) text += std::string(", ") + part->name;
          return text;
        };
        const std::vector<Rect> places = floats_of(picture, 0.5f * letter, shown);
        ASSERT_EQ(places.size(), shown.size());
        for (std::size_t i = 0; i < places.size(); ++i) {
          if (places[i].empty()) continue;
          const bool inside = glm::all(glm::greaterThanEqual(places[i].low, picture.low - 0.01f)) &&
                              glm::all(glm::lessThanEqual(places[i].high, picture.high + 0.01f));
          ASSERT_TRUE(inside) << words() << ": thing " << i;
          for (std::size_t j = 0; j < i; ++j)
            ASSERT_FALSE(shares_area(places[i], places[j]))
                << words() << ": things " << i << ", " << j;
          if (shown[i].kind != legend && shown[i].kind != badge) continue;
          for (const Floating& other : shown) {
            if (other.kind != cell && other.kind != caption) continue;
            ASSERT_FALSE(shares_area(places[i], {*other.at, *other.at + other.size}))
                << words() << ": thing " << i << " hides a map or its caption";
          }
        }
      }
    }
  }
}

// The places in a window that shows these parts.
std::vector<Rect> places_of(const Rect& picture, std::initializer_list<std::string_view> names,
                            float letter = 15) {
  std::vector<Floating> shown;
  for (const std::string_view name : names) {
    for (const Part& part : kParts) {
      if (name == part.name) part.add(shown, picture, letter);
    }
  }
  return floats_of(picture, 0.5f * letter, shown);
}

TEST(Floats, each_thing_alone_has_a_place_at_every_size) {
  for (const glm::ivec2 window : kWindows) {
    const float letter = window.y >= 1700 ? 26 : 15;
    for (const Rect& picture : pictures_of(window, letter)) {
      for (const Part& part : kParts) {
        const std::string_view name = part.name;
        if (name == "messages" || name == "grid") continue;
        for (const Rect& place : places_of(picture, {name}, letter))
          EXPECT_FALSE(place.empty()) << window.x << " x " << window.y << " " << name;
      }
    }
  }
}

const Rect kSmall{{0, 23}, {640, 377}}, kUsual{{0, 23}, {1024, 553}};

TEST(Floats, the_names_of_a_split_stand_at_the_top_beside_everything_else) {
  for (const Rect& picture : {kSmall, kUsual}) {
    const std::vector<Rect> places =
        places_of(picture, {"sides", "message", "legend", "plate", "hints"});
    EXPECT_FLOAT_EQ(places[0].low.y, picture.low.y + 7.5f);
    EXPECT_FLOAT_EQ(places[1].low.y, picture.low.y + 7.5f);
    EXPECT_GT(places[4].low.y, places[0].high.y) << "the plate is below the names";
  }
}

TEST(Floats, a_legend_leaves_the_captions_of_the_grid_free) {
  const auto captions_are_shown = [](const std::vector<Rect>& places) {
    for (std::size_t i = 1; i + 1 < places.size(); i += 2) EXPECT_FALSE(places[i].empty()) << i;
  };
  const std::vector<Rect> usual = places_of(kUsual, {"grid", "legend"});
  captions_are_shown(usual);
  EXPECT_LT(usual.back().size().y, 7 * 15) << "there is room for its title only";
  EXPECT_GT(usual.back().low.y, usual[usual.size() - 2].high.y) << "it covers no picture";
  const std::vector<Rect> large = places_of({{0, 0}, {1920, 1080}}, {"grid", "legend"});
  captions_are_shown(large);
  EXPECT_FLOAT_EQ(large.back().size().y, 7 * 15);
  const std::vector<Rect> small = places_of(kSmall, {"grid", "legend"});
  captions_are_shown(small);
  EXPECT_FALSE(small.back().empty());
  const std::vector<Rect> smallest = places_of({{0, 23}, {320, 217}}, {"grid", "legend"});
  captions_are_shown(smallest);
  EXPECT_TRUE(smallest.back().empty()) << "it waits";
}

TEST(Floats, what_is_less_important_gives_way) {
  const Rect low{{0, 0}, {400, 110}};
  const std::vector<Rect> places = places_of(low, {"hints", "progress", "message"});
  EXPECT_TRUE(places[0].empty());
  EXPECT_TRUE(places[1].empty());
  EXPECT_FALSE(places[2].empty());
  const std::vector<Rect> stacked = places_of(kUsual, {"messages", "progress", "hints"});
  EXPECT_GT(stacked[0].low.y, stacked[1].high.y) << "the newest is at the bottom";
  EXPECT_LT(stacked[4].high.y, stacked[3].low.y);
}

TEST(Floats, a_dragged_legend_stays_inside_of_the_picture) {
  const std::vector<Rect> places = places_of(kUsual, {"dragged legend"});
  EXPECT_FLOAT_EQ(places[0].low.y, kUsual.low.y + 7.5f);
  EXPECT_FLOAT_EQ(places[0].low.x, kUsual.low.x + 7.5f);
}

}  // namespace
}  // namespace qs
