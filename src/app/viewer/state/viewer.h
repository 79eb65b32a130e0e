// SPDX-License-Identifier: MIT
//
// The whole state of the viewer as plain data. Everything reads it; only actions change it
// (action.h).
#pragma once

#include <algorithm>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/framing/depth_ahead.h"
#include "app/framing/first_view.h"
#include "app/framing/scene_box.h"
#include "app/inspect/comparison_sheet.h"
#include "app/inspect/heatmap_frame.h"
#include "app/inspect/inspection.h"
#include "app/inspect/reference_check.h"
#include "app/measure/camera_path.h"
#include "app/picture/heatmap.h"
#include "app/picture/image_difference.h"
#include "app/picture/value_map.h"
#include "app/remote/remote_run.h"
#include "app/report/bench_report.h"
#include "app/session/levels.h"
#include "app/viewer/state/training.h"
#include "app/viewer/state/view_history.h"
#include "app/viewer/state/zoom_recorder.h"
#include "io/cloud/edits.h"
#include "raster/api/renderer.h"
#include "raster/scene/removal.h"
#include "raster/select/edit_history.h"
#include "raster/select/measures.h"

namespace qs {

// Editing: the scene that was read stays whole; its renderers leave out Gaussians.

/// The user's criteria of removal. Numbers stay while their switch is off.
struct CropWish {
  bool boxed = false, cleans = false;
  CropBox box;
  Floaters floaters;

  bool removes() const { return boxed || cleans; }
  std::optional<CropBox> used_box() const { return boxed ? std::optional(box) : std::nullopt; }
  std::optional<Floaters> used_floaters() const {
    return cleans ? std::optional(floaters) : std::nullopt;
  }
  bool operator==(const CropWish&) const = default;
};

/// The part of the scene that the render thread should show. Sets are of the whole scene.
struct CropRequest {
  std::shared_ptr<const GaussianSet> gone = {};  ///< hidden or removed; null: none
  int steps = 0;                                 ///< that took these
  // Of the rest, these Gaussians are counted and found for the tint:
  CropWish wish = {};
  std::shared_ptr<const GaussianSet> selected = {};         ///< null: none
  std::shared_ptr<const std::vector<EditStep>> pages = {};  ///< see Editing::pages

  bool counts() const { return wish.removes() || selected; }
  bool operator==(const CropRequest&) const = default;
};

/// The answer.
struct ShownCrop {
  std::optional<RemovalCounts> counts = {};      ///< unset unless CropRequest::counts()
  std::shared_ptr<const GaussianSet> tint = {};  ///< selected or wished away; null: none
  EditFacts edits = {};                          ///< of the Gaussians in the window
  std::uint64_t gaussians = 0;                   ///< their number
};

struct Crop {
  CropWish wish;
  bool marks = true;  ///< while the panel is open, the Gaussians to remove are tinted
  CropRequest asked;  ///< the last request
  bool busy = false;  ///< the render thread has not answered it yet
  // Of the last answer:
  std::optional<RemovalCounts> counts;
  std::shared_ptr<const GaussianSet> tint;
};

/// The edits of the scene in the window.
struct Editing {
  EditHistory history;
  std::shared_ptr<const GaussianSet> gone, selected;  ///< of the history's state; null: none
  int steps = 0;                                      ///< that took `gone` or are in `pages`
  /// Of a tree that is not read whole: the steps, which edit each page; null: none. Sets of such a
  /// scene are empty, because nobody knows its Gaussians: `selected` only says that there is one.
  std::shared_ptr<const std::vector<EditStep>> pages;
  std::deque<EditStep> waiting;  ///< are carried out next
  bool busy = false;             ///< the render thread carries a step out
  bool saved = true;             ///< a file that was saved has the edits
  bool kept = true;              ///< the file beside the scene has the edits, see kept_edits_file()
  bool keeps = true;             ///< that file can be written
  bool owns_file = false;        ///< it is of these edits
  double changed = -1e9;         ///< Viewer::now of the last change
};

/// Selecting Gaussians with a tool in the picture.
struct Selecting {
  std::optional<SelectTool> tool;  ///< one of kPictureTools; unset: drags move the camera
  SelectKind kind = SelectKind::visible;
  float weight = kSelectWeight;                               ///< SelectStep::weight
  float brush_px = 30;                                        ///< radius
  float tolerance = 10;                                       ///< of flood and colour, CIELAB
  SelectHow way = SelectHow::replace;                         ///< without a modifier
  ValueRange opacity{0, 0.1}, size{0, 0.01}, distance{0, 1};  ///< of the buttons; world units
  std::vector<glm::dvec2> drawn = {};  ///< pixels of the shape that is being drawn
  SelectHow how = SelectHow::replace;  ///< of that shape
};

/// The box of the selected Gaussians along the axes of the level scene, world units.
struct MeasuredBox {
  std::size_t gaussians = 0;
  glm::dvec3 all{0.0}, core{0.0};  ///< its sides; core: of the middle 90 % of the centres
};

/// Measuring with points of surfaces.
struct PointMeasures : Measures {
  bool picks = false;      ///< a click in the picture sets a point
  bool again = false;      ///< the next click shows the last point in another view
  bool busy = false;       ///< the render thread looks for a point
  Measures kept = {};      ///< in the file beside the scene, see kept_measures_file()
  bool keeps = true;       ///< that file can be written
  bool owns_file = false;  ///< it is of these measures
  std::optional<MeasuredBox> box;
  double known = 1;      ///< the length that the user types
  std::size_t unit = 0;  ///< index into kLengthUnits

  /// The parts of each line of `lines` that are behind a surface, kRulerParts of each leg, for the
  /// view of that version.
  std::vector<std::vector<bool>> hidden = {};
  int hidden_version = -1, asked_version = -1;  ///< Viewer::view_version; -1: none

  /// Null without points.
  SurfacePoint* last_point() {
    for (auto line = lines.rbegin(); line != lines.rend(); ++line)
      if (!line->empty()) return &line->back();
    return nullptr;
  }
};

inline constexpr std::size_t kRulerParts = 48;

/// The tools that act in the picture. A drag draws rectangles, lassos, strokes, and spheres from
/// their centre on a surface; clicks set the corners of a polygon and take a colour.
inline constexpr SelectTool kPictureTools[] = {SelectTool::rectangle, SelectTool::polygon,
                                               SelectTool::lasso,     SelectTool::brush,
                                               SelectTool::sphere,    SelectTool::color};

enum class Navigation { orbit, fly };

/// Facts of the scene in the window; the render thread owns its Gaussians.
struct ViewedScene {
  std::filesystem::path path;
  std::string name, format;
  std::uint64_t gaussians = 0, file_bytes = 0;
  std::uint64_t nodes =
      0;  ///< of a tree that is not read whole, whose `gaussians` are a coarse cut
  int sh_degree = 0;
  bool antialiased = false, white_background = false;
  SceneBox core;                      ///< core_box()
  float smallest_radius = 0;          ///< smallest_framing(), world units
  std::uint64_t huge = 0;             ///< Gaussians that are larger than the scene
  std::uint64_t skipped_huge = 0;     ///< Gaussians that were left out as larger than the scene
  glm::dvec3 up{0, -1, 0};            ///< unit vector in the world
  bool up_is_declared = false;        ///< `up` was given by the user or the file
  Framing framing;                    ///< the view of F
  SceneBox subject;                   ///< subject_box(); size 0: unknown
  std::vector<Framing> candidates;    ///< choose_framings() of a scene without cameras
  std::string axes;                   ///< ReadOptions::axes that the file was read with
  std::string declared_axes = "RDF";  ///< of the file
  EditFacts edits;                    ///< of its Gaussians, crops included
  std::vector<Camera> cameras;        ///< of the data set, may be empty
  std::string cameras_warning;        ///< a sentence about cameras that were left out, or ""
  glm::dvec3 origin{0.0};             ///< GaussianCloud::origin: positions here count from it
  std::filesystem::path cameras_file;
  std::map<int, std::filesystem::path> photographs;  ///< by index into `cameras`
  std::vector<Landmark> landmarks;                   ///< landmarks_of() the scene

  /// Longest side of the core, world units, > 0.
  double extent() const {
    const glm::vec3 size = core.size();
    return static_cast<double>(std::max({size.x, size.y, size.z, 2 * smallest_radius}));
  }
};

/// A second scene: a split window shows both from the same camera.
struct SceneBeside {
  std::filesystem::path path;
  std::uint64_t gaussians = 0;
};

/// Sets framing and, unless it is declared, up from the cameras. No effect without cameras.
void use_cameras(ViewedScene& scene);

/// The switches of the panels: true if the panel is open.
struct Panels {
  bool hud = false, info = false, help = false, cameras = false;
  bool recorder = false, open = false, photograph = false, frusta = false, inspector = false,
       split = false, messages = false, training = false, train = false, crop = false,
       palette = false, measures = false;
  bool all = true;  ///< false hides all of them
};

/// The use of the path that the user chooses in the dialog Open, or in the desktop's dialog. The
/// last two are folders; results are measurements that could not be written below Viewer::out_dir.
enum class Choosing { scene, scene_beside, photographs, results };

inline bool chooses_folder(Choosing choosing) { return choosing >= Choosing::photographs; }

/// Widths of the bars of panels beside the picture, in heights of a letter; 0: not set by the user.
struct Bars {
  float left = 0, right = 0;
};

/// The hints of the first start that are still shown. Each disappears once the user has followed
/// it, and all disappear after kHintSeconds.
struct Hints {
  bool fly = false, modes = false, map = false, zoom = false;
  double since = -1;  ///< Viewer::now of the first tick with a scene; negative: not yet

  bool any() const { return fly || modes || map || zoom; }
};

inline constexpr double kHintSeconds = 90;

/// The button of a toast that does what the toast advises.
enum class ToastOffer { none, skip_huge, next_axes, turn_over, save_results, apply_edits };

struct Toast {
  std::string text = {};
  bool error = false;
  double until = 0;                 ///< Viewer::now at which it disappears
  std::filesystem::path path = {};  ///< of the file that was written, absolute; may be empty
  bool about_opening = false;       ///< gives the reason why a file was not opened
  ToastOffer offer = ToastOffer::none;
};

/// A message in the log.
struct LogEntry {
  double time = 0;  ///< Viewer::now
  std::string text;
  bool error = false;
  std::filesystem::path path = {};  ///< Toast::path
};

/// The ways in which the window shows two variants of the view.
enum class SplitView { sides, whole, difference, tile_pairs };

/// Index = SplitView.
inline constexpr const char* kSplitViews[] = {"side by side", "one at a time", "difference",
                                              "tile pairs"};

/// The split window: the view with the current settings, and another variant of it or another scene
/// with the same settings.
struct Split {
  Variant other{find_culler("3dgs"), kDefaultPipeline, Backend::cpu};
  SplitView view = SplitView::sides;
  float divider = 0.5f;   ///< width left of the divider, as a fraction of the window's, 0 to 1
  bool flipped = false;   ///< shows `other` on the left, or alone
  int amplification = 0;  ///< factor of the difference; 0: chosen from the frames
};

/// The look of heat maps and of their legend.
struct HeatView {
  HeatStyle style;
  std::uint32_t maximum = 0;  ///< upper end of the scale; 0: fits Viewer::baseline in this view
  bool folded = false;        ///< the legend shows its title only
  glm::vec2 shift{0.0f};      ///< of the legend from its usual place, in heights of a letter
  bool operator==(const HeatView&) const = default;
};

/// The frame of Split::other.
struct ShownOther {
  Variant variant;
  std::optional<SceneBeside> scene;  ///< set if the frame shows another scene
  RenderStats stats;
  PixelBox region;         ///< drawn pixels: the reference may cover a part of the view only
  ImageDifference pixels;  ///< inside the region
  std::optional<PairDifference> pairs;  ///< unset for the reference, which has no tiles
  Scale pairs_scale;                    ///< of `pairs`
  std::optional<Heatmap> heatmap;       ///< as ShownFrame::heatmap, with the same scale
};

/// The pictures of all modes in the window, one per mode from 1 on.
struct ShownGrid {
  std::vector<RenderStats> stats;     ///< index = CullMode - 1
  std::vector<std::uint64_t> totals;  ///< of the heat maps; empty without maps
};

/// The height of a label in the grid of all modes, as a share of the picture's height.
inline constexpr float kGridLabel = 0.085f;

/// The frame in the window.
struct ShownFrame {
  RenderStats stats;
  CullMode mode = default_mode();
  int version = -1;       ///< Viewer::version that it shows
  int view_version = -1;  ///< Viewer::view_version that it shows
  Camera camera;          ///< of the full-size view
  int divisor = 1;        ///< rendered at 1 / divisor of the full size
  bool interop = false;   ///< reached the window without leaving the GPU
  std::optional<Heatmap> heatmap;
  std::optional<MissedMap> missed;  ///< of the heat map HeatQuantity::missed
  std::optional<ShownOther> other;  ///< in a split window
  std::optional<ShownGrid> grid;    ///< if the picture shows all modes side by side
  std::optional<ValueMap> values;   ///< if the picture shows a quantity instead of colours
  Scale map_scale;                  ///< of all heat maps of this view
  int scale_version = -1;           ///< Viewer::view_version that `map_scale` fits
  /// Frame::mode_pairs of the full-size view; empty if the frame did not count them
  std::vector<ModePairs> mode_pairs;
  glm::ivec2 counted_size{0};  ///< of the view of `mode_pairs`, pixels
};

/// The last counted pairs of all modes; samples.h reads them.
struct ViewCounts {
  int view_version = -1;         ///< Viewer::view_version
  glm::ivec2 size{0};            ///< of the counted picture, pixels
  int frame = 0;                 ///< Viewer::frames of the frame that counted
  std::vector<ModePairs> modes;  ///< index = mode - 1; empty: nothing was counted yet
};

/// A frame of another mode, drawn for its time at the very view and size of a picture in the
/// window.
struct PairedFrame {
  Variant variant;        ///< of the frame
  CullMode shown = 0;     ///< the picture's mode
  double speed = 0;       ///< the picture's time divided by the frame's; processor time on the CPU
  glm::ivec2 size{0};     ///< of both, pixels
  int view_version = -1;  ///< Viewer::view_version
  double at = 0;          ///< Viewer::now when it came
};

/// The time of a picture in the window.
struct ShownTime {
  CullMode mode = 0;
  double ms = 0;
  glm::ivec2 size{0};     ///< as drawn, pixels
  int view_version = -1;  ///< Viewer::view_version
  double at = 0;          ///< Viewer::now
};

/// Times of single frames; samples.h makes the FPS of all modes of them.
struct LiveTimes {
  Variant used;                   ///< of the last picture
  std::deque<ShownTime> shown;    ///< the pictures of a second, newest last
  std::deque<PairedFrame> pairs;  ///< the last of each mode and size, newest last
};

/// The tile pairs of full-size frames relative to the pairs of reduced frames, learned from views
/// that were drawn in both sizes.
struct PairGrowth {
  std::map<int, double> factors{{1, 1.0}};  ///< by the divisor of the reduced frame
  int view_version = -1;                    ///< of `reduced`
  CullMode mode = 0;
  std::map<int, double> reduced;  ///< pairs of the reduced frames of this view, by divisor
};

/// Numbers of all modes for one view. The frames are BenchRow::round_ms.
struct ModeNumbers {
  int version = -1;  ///< Viewer::view_version
  std::vector<BenchRow> rows;
  bool complete = false;  ///< no more frames are measured, even if the numbers are noisy
};

/// A change of the mode that the picture still shows.
struct ModeSwitch {
  CullMode from = 0, to = 0;
  double at = 0;  ///< Viewer::now
};

/// Seconds for which a change of the mode is shown.
inline constexpr double kSwitchSeconds = 2;

struct InspectedView {
  int version = -1;  ///< Viewer::version
  Inspection inspection;
  TileGrid grid;
};

/// The comparison of a view with the fp64 reference.
struct ReferenceComparison {
  int view_version = -1;  ///< Viewer::view_version
  Variant variant;        ///< that was compared
  int tolerance = 0;      ///< of 8-bit values
  ReferenceCheck verdict;
  std::string sentence;
};

/// The view of a camera compared with its photograph, as `eval` does.
struct PhotographQuality {
  int version = -1;  ///< Viewer::version
  double psnr = 0, ssim = 0;
  std::string problem;  ///< the reason why they cannot be compared
};

/// The photograph of the chosen camera.
struct ShownPhotograph {
  std::filesystem::path path;
  std::shared_ptr<const Image> image;  ///< null until it is read
  int compared = -1;                   ///< Viewer::version that was last compared with it
  std::optional<PhotographQuality> quality = {};
};

/// Flying with keys.
struct Flight {
  glm::dvec3 wish{0.0};      ///< right, down, forward, times the factor of the keys; of this turn
  glm::dvec3 velocity{0.0};  ///< in view axes, world units per second
  double factor = 1;         ///< set by the wheel
  double distance = 0;       ///< smoothed distance of the scene in front, world units; 0: unknown
  int frame = -1;            ///< Viewer::frames of the picture that the user sees
  double room = 0;           ///< the way that remains until the next picture, world units
};

/// A moment's move to another view.
struct Travel {
  Camera from, to;
  double seconds = 0;       ///< since it began
  int dataset_camera = -1;  ///< Viewer::dataset_camera at its end
};

/// The strip of pictures from which the user chooses the first view of a scene.
struct ViewChoice {
  bool wanted = false;  ///< opens as soon as the pictures are drawn
  bool asked = false;   ///< the render thread draws the pictures
  /// of ViewedScene::candidates, side by side and equally wide; null while the strip is closed
  std::shared_ptr<const Image> pictures = {};
};

struct Playback {
  bool running = false;
  double time = 0;  ///< seconds on the path
};

/// Views that the user named: name, camera as JSON.
using Bookmarks = std::vector<std::pair<std::string, std::string>>;

/// Loading::what of a film and of a bench.
inline constexpr const char *kFilming = "filming", *kBenching = "benching";

struct Loading {
  std::filesystem::path path;
  std::string what;    ///< "reading", "uploading"
  float fraction = 0;  ///< done, 0 to 1
  double began = 0;    ///< Viewer::now, set by action::show_progress
};

/// The keyframes before and after the changes that Ctrl+Z takes back.
struct KeyframeHistory {
  std::vector<std::vector<Keyframe>> earlier, later;
  std::ptrdiff_t dragged = -1;  ///< the keyframe whose time the last change set; -1: another change
  double changed = 0;           ///< Viewer::now of the last change
};

/// The picture size at which all modes and zooms are measured. Panels do not change it.
struct MeasuredSize {
  const char* name;
  glm::ivec2 pixels;  ///< 0: of the window or of the camera
};

/// The first is the window without its side bars, the last the size of the camera at the view.
inline constexpr MeasuredSize kMeasuredSizes[] = {{"window", {0, 0}},
                                                  {"1280 x 720", {1280, 720}},
                                                  {"1600 x 1200", {1600, 1200}},
                                                  {"1920 x 1080", {1920, 1080}},
                                                  {"3840 x 2160", {3840, 2160}},
                                                  {"camera", {0, 0}}};

/// Seconds after the last motion of the camera: it counts as moving up to the first, as still from
/// the second.
inline constexpr double kMovingSeconds = 0.2, kStillSeconds = 0.25;

/// The facts that the loop passes at every turn.
struct Turn {
  double now = 0;          ///< seconds since the start
  glm::dvec2 cursor{-1};   ///< pixels of the picture
  bool measuring = false;  ///< the render thread measures now
  double display_fps = 0;  ///< new pictures in the window per second, 0 while it rests
  float present_ms = 0;    ///< GPU time of drawing the frame into the window
  float screen_scale = 1;  ///< guessed_scale() of the screen
  std::uint64_t process_bytes = 0, gpu_bytes = 0;  ///< memory in use, 0 = unknown
  glm::ivec2 bare_size{0};                         ///< of the picture without side bars, pixels
  std::string drawn_status = {};                   ///< hud_status() when the window was drawn last
  std::vector<std::string> drawn_columns = {};     ///< of the table of modes, likewise
};

struct Viewer : Turn {
  std::filesystem::path out_dir = ".";  ///< screenshots, zooms and benches are written below it
  bool is_remote = false;  ///< the user sees a copy of the picture at another machine: files go
                           ///< there, none is kept here, and changes over the picture draw it again
  std::optional<ViewedScene> scene;
  std::optional<LevelFacts> levels;     ///< the last cut of a tree that is streamed
  std::optional<SceneBeside> beside;    ///< the split window shows it instead of Split::other
  Choosing choosing = Choosing::scene;  ///< in the dialog Open
  TrainForm train_form;                 ///< of the dialog Train

  Camera camera;  ///< at the window's size
  Camera home;
  glm::dvec3 pivot{0.0};
  Navigation navigation = Navigation::orbit;
  Flight flight;
  std::optional<Travel> travel;
  bool animates_moves = false;  ///< else views change immediately, as scripts need it
  int dataset_camera = -1;      ///< index of the camera at the view, else -1
  double last_motion = -1e9;    ///< Viewer::now
  ViewHistory history;          ///< of this scene
  ViewChoice view_choice;
  bool offers_views = false;  ///< a scene without cameras offers its views when it is new
  std::map<std::string, std::string> first_views;  ///< scene file -> chosen camera as JSON
  std::map<std::string, std::string> last_views;   ///< scene file -> camera as JSON
  std::map<std::string, std::string> ups;          ///< scene file -> up direction X,Y,Z
  std::map<std::string, std::string> axes;         ///< scene file -> ReadOptions::axes, if chosen
  std::vector<std::string> axes_to_try;            ///< the frames that Y tries, in order
  bool restores_views = true;                      ///< a scene opens at its last view
  std::map<std::string, std::string> kept_paths;   ///< work_name() -> format_camera_path()
  std::map<std::string, Bookmarks> bookmarks;      ///< by work_name()
  bool keeps_work = true;                          ///< a preferences file keeps these
  std::string unsaved_results;  ///< "zoom and a bench" that could not be written; empty: none
  /// The user is asked what to do with unsaved work before this file is opened, or, if it is empty,
  /// the window closes.
  std::optional<std::filesystem::path> leaving;

  bool skips_huge = false;  ///< scenes are read with FrameOptions::skip_huge
  RenderSettings settings;
  CullMode previous_mode = default_mode();
  bool peeking = false;                   ///< shows the previous mode while a key is held
  std::optional<ModeSwitch> mode_switch;  ///< the last switch, for kSwitchSeconds
  bool shows_badge = false;               ///< the mode's name and numbers stay over the picture
  Backend backend = Backend::cpu;
  std::optional<HeatQuantity> heatmap;
  HeatQuantity last_heatmap = HeatQuantity::pairs;
  HeatView heat_view;
  Quantity quantity = Quantity::color;  ///< for other quantities `heatmap` is unset
  Quantity last_quantity = Quantity::depth;
  Split split;              ///< used while panels.split
  bool shows_grid = false;  ///< the pictures of all modes; the split rests meanwhile

  bool vsync = true, on_demand = true, reduce_when_moving = true;
  bool occlusion = true;  ///< pictures may leave out hidden Gaussians, see may_occlude()
  ShownPhotograph photograph;
  float photograph_opacity = 0.5f;
  float photograph_wipe = 1;  ///< the photograph covers the picture left of it, 0 to 1 of its width
  Panels panels;
  Bars bars;
  float interface_scale = 0;  ///< of letters and lines, as the user chose it; 0: screen_scale
  bool light_theme = false;
  Hints hints;
  std::vector<Toast> toasts;
  bool toasts_held = false;                   ///< the mouse is over one, so all of them stay
  std::deque<LogEntry> log;                   ///< the last messages, newest last
  std::vector<std::filesystem::path> recent;  ///< scenes, newest first

  std::optional<Loading> loading;
  ShownFrame shown;
  int frames = 0;  ///< counts changes of `shown`
  ViewCounts counts;
  LiveTimes live;
  PairGrowth pair_growth;
  ModeNumbers numbers;
  CullMode baseline = find_culler("3dgs");  ///< the mode to which ratios are relative
  std::size_t measured_size = 0;            ///< index into kMeasuredSizes
  std::deque<float> frame_ms;               ///< render times of the last full-size frames
  ZoomRecorder zoom;
  std::optional<InspectedView> inspected;
  int inspections = 0;  ///< counts changes of `inspected`
  std::optional<ReferenceComparison> comparison;
  std::optional<Training> training;  ///< the run in the window, also after its end
  std::optional<RemoteRun> remote;   ///< the window shows a training in another program: there is
                                     ///< no scene to draw, measure or save here
  Crop crop;
  Editing editing;
  Selecting selecting;
  PointMeasures measures;
  std::optional<glm::dvec2> cross;  ///< pixel that the arrow keys move, for tools in the picture
  bool cross_is_used = false;       ///< Enter has taken the pixel
  std::vector<Keyframe> keyframes;
  KeyframeHistory keyframe_history;  ///< of this scene
  bool loops_path = false;           ///< after the last keyframe the path returns to the first
  Playback playback;

  /// `version` counts changes of the picture. `view_version` counts changes that affect the numbers
  /// of all modes: all changes except changes of the mode.
  int version = 0, view_version = 0;
  int mode_changes = 0;  ///< the changes of `version` that changed the mode only

  /// The time at which a path of at least two keyframes ends.
  double path_end() const {
    return loops_path ? keyframes.front().time + closed_length(keyframes) : keyframes.back().time;
  }

  /// True if a dialog takes the keyboard.
  bool has_dialog() const { return panels.open || panels.palette || leaving; }

  /// True if a click in the picture is of a tool.
  bool has_tool() const { return selecting.tool || measures.picks; }

  /// The mode of the next frame.
  CullMode mode() const { return peeking ? previous_mode : settings.mode; }
  Variant variant() const { return {mode(), settings.pipeline, backend}; }
  bool moving() const { return now - last_motion < kMovingSeconds; }
  bool still() const { return now - last_motion > kStillSeconds; }
};

}  // namespace qs
