// SPDX-License-Identifier: MIT
//
// The whole state of the viewer as plain data. Panels read it and return actions; apply() in
// actions.h is the only thing that changes it. What must happen outside of the state (read a file,
// render, write a picture, quit) is left in `requests` for the window's loop.
#pragma once

#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "app/inspect/inspection.h"
#include "app/inspect/missed_contributions.h"
#include "app/inspect/reference_check.h"
#include "app/inspect/variant.h"
#include "app/measure/camera_path.h"
#include "app/picture/heatmap.h"
#include "app/picture/image_difference.h"
#include "app/report/bench_report.h"
#include "app/session/scene_box.h"
#include "raster/renderer.h"

namespace qs {

enum class Navigation { orbit, fly };

/// What the viewer knows of the scene on show; the cloud itself belongs to the render thread.
struct ViewedScene {
  std::filesystem::path path;
  std::string name, format;
  std::uint64_t gaussians = 0, file_bytes = 0;
  int sh_degree = 0;
  bool antialiased = false, white_background = false;
  SceneBox core;                ///< core_box()
  float smallest_radius = 0;    ///< framed at least, world units
  glm::dvec3 up{0, -1, 0};      ///< of the world
  std::string axes;             ///< that overruled the file's, one of kAxes; empty: none did
  std::vector<Camera> cameras;  ///< of the data set, may be empty
  std::filesystem::path cameras_file;
  std::map<int, std::filesystem::path> photographs;  ///< by position in `cameras`

  double extent() const;  ///< longest side of the core, world units, > 0
};

/// Which windows are open. Each is a row of kBindings too.
struct Panels {
  bool hud = true, info = false, help = false, cameras = false, settings = false;
  bool recorder = false, open = false, photograph = false, frusta = false, inspector = false,
       split = false;
  bool all = true;  ///< false: nothing but the picture
};

struct Toast {
  std::string text;
  bool error = false;
  double until = 0;  ///< seconds of Viewer::now
};

/// What the window shows of two variants of the view.
enum class SplitView { sides, whole, difference, tile_pairs };

/// Index = SplitView.
inline constexpr const char* kSplitViews[] = {"side by side", "one at a time", "difference",
                                              "tile pairs"};
inline constexpr int kMostAmplification = 128;

/// How the view is set beside another variant of it. The first one is the view's own.
struct Split {
  Variant other{find_culler("3dgs"), kDefaultPipeline, Backend::cpu};
  SplitView view = SplitView::sides;
  float divider = 0.5f;    ///< share of the width left of it, 0 to 1
  bool flipped = false;    ///< the other one is the left one, or the one at a time
  int amplification = 16;  ///< of the difference, 1 to kMostAmplification
};

/// The other one of the frame in the window.
struct ShownOther {
  Variant variant;
  RenderStats stats;
  PixelBox region;         ///< where it was drawn: the reference may be there for a part only
  ImageDifference pixels;  ///< inside the region
  std::optional<PairDifference> pairs;  ///< unset beside the reference, which has no tiles
};

/// The frame in the window.
struct ShownFrame {
  RenderStats stats;
  CullMode mode = kDefaultMode;
  int version = -1;  ///< Viewer::version that it shows
  Camera camera;     ///< of the full-size view; rendered at 1 / divisor of its size
  int divisor = 1;
  bool interop = false;  ///< it reached the window without leaving the GPU
  std::optional<Heatmap> heatmap;
  std::optional<MissedMap> missed;  ///< of its heat map HeatQuantity::missed
  std::optional<ShownOther> other;  ///< in a split window
};

/// Rows of all modes for one view, and of which view they are.
struct ModeNumbers {
  int version = -1;  ///< Viewer::view_version
  std::vector<BenchRow> rows;
};

/// A zoom that is being recorded, or was.
struct ZoomRecording {
  bool running = false;
  int steps = 0;
  std::vector<BenchRow> rows;  ///< of the steps so far, by step, within it by mode
  std::filesystem::path folder;
};

/// What the inspector shows, of the view that was on show then.
struct InspectedView {
  int version = -1;  ///< Viewer::version
  Inspection inspection;
  Image construction;  ///< draw_construction() of the picked Gaussian; empty without one
};

/// What the reference says of a view.
struct OracleAnswer {
  int version = -1;  ///< Viewer::version
  ReferenceCheck verdict;
  std::string sentence;
};

struct Playback {
  bool running = false;
  double time = 0;  ///< seconds on the path
};

struct Loading {
  std::filesystem::path path;
  std::string what;  ///< "reading", "uploading"
  float fraction = 0;
};

// ---- requests ---------------------------------------------------------------------------------
namespace request {
struct Open {
  std::filesystem::path path;
  std::string axes;  ///< one of kAxes, overrules the file; empty: it is right
};
struct CancelLoading {};
struct Pick {  ///< answers with SetPivot, or starts the zoom recorder towards the point
  glm::dvec2 pixel;
  bool record = false;
};
struct Screenshot {
  bool with_ui = false;
};
struct CopyText {
  std::string text;
};
struct PasteText {};
struct StopRecording {};
struct Bench {};
struct Inspect {
  glm::dvec2 pixel;
  std::optional<std::uint32_t> gaussian;  ///< the one to pick, else the pixel's heaviest
};
struct AskOracle {
  bool around_cursor = false;
};
struct SwitchBackend {
  Backend backend;
};
struct ReadPhotograph {
  std::filesystem::path path;
};
struct SavePath {
  std::filesystem::path path;
};
struct Fullscreen {};
struct Quit {};
}  // namespace request

using Request =
    std::variant<request::Open, request::CancelLoading, request::Pick, request::Screenshot,
                 request::CopyText, request::PasteText, request::StopRecording, request::Bench,
                 request::Inspect, request::AskOracle, request::SwitchBackend,
                 request::ReadPhotograph, request::SavePath, request::Fullscreen, request::Quit>;

struct Viewer {
  double now = 0;  ///< seconds since the start, set by the loop
  std::optional<ViewedScene> scene;

  Camera camera;  ///< at the window's size
  Camera home;
  glm::dvec3 pivot{0.0};
  Navigation navigation = Navigation::orbit;
  int dataset_camera = -1;    ///< that the view stands at; -1 after it moved
  double last_motion = -1e9;  ///< when the camera last changed, seconds

  RenderSettings settings;
  CullMode previous_mode = kDefaultMode;
  bool peeking = false;  ///< the previous mode is shown while a key is held
  Backend backend = Backend::cpu;
  std::optional<HeatQuantity> heatmap;
  HeatQuantity last_heatmap = HeatQuantity::pairs;
  Split split;  ///< shown while panels.split

  bool vsync = true, on_demand = true, reduce_when_moving = true;
  float photograph_opacity = 0.5f;
  Panels panels;
  std::vector<Toast> toasts;
  std::vector<std::filesystem::path> recent;

  std::optional<Loading> loading;
  ShownFrame shown;
  ModeNumbers numbers;
  bool measuring = false;
  std::deque<float> frame_ms;  ///< of the last frames in the window, for the plot
  double display_fps = 0;      ///< of the window, 0 while it rests
  float present_ms = 0;        ///< GPU time of the window's own drawing of the frame
  std::uint64_t process_bytes = 0, gpu_bytes = 0;  ///< memory in use, 0 = unknown
  ZoomRecording zoom;
  std::optional<InspectedView> inspected;
  std::optional<OracleAnswer> oracle;
  std::vector<Keyframe> keyframes;
  Playback playback;

  /// Counts changes of the picture, and of what the modes' numbers depend on (not the mode).
  int version = 0, view_version = 0;

  std::vector<Request> requests;

  /// The mode in the window: the chosen one, or while peeking the one before.
  CullMode mode() const { return peeking ? previous_mode : settings.mode; }
  Variant variant() const { return {mode(), settings.pipeline, backend}; }
  bool moving() const { return now - last_motion < 0.2; }
};

/// Why the numbers of the frame in the window are no measurement; empty when they are one.
std::vector<std::string> not_a_measurement(const Viewer& viewer);

}  // namespace qs
