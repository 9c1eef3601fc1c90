// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/render/snapshot_recorder.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "sim/render/cameras.hpp"
#include "sim/render/captions.hpp"
#include "sim/render/picture_scene.hpp"
#include "sim/render/png.hpp"
#include "sim/render/range_image.hpp"
#include "sim/render/renderer.hpp"
#include "sim/render/sight.hpp"
#include "sim/render/video.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

constexpr float kAreaOpacity = 0.3F;         // opacity of areas drawn in the vehicle's color
constexpr int kMinWidth_px = 32;             // least width of a picture without its legend
constexpr TimeNs kHistoryStep = 20'000'000;  // sampling interval for trails and follow cameras

bool of_all_vehicles(const CameraConfig& camera) {
  return camera.vehicle.empty() &&
         (camera.type == CameraConfig::Type::kFollow || camera.type == CameraConfig::Type::kTop);
}

/// State of one camera.
struct Station {
  CameraConfig config;
  VehicleId vehicle = kNoVehicle;
  Look look;
  std::vector<float> radii_m;  // radii of the vehicles as drawn
  CameraController controller;
  int sidebar_px = 0;  // never shrinks, so that frames of a video keep their layout
};

/// Adds the meaning of a cloud's colors to the sidebar.
void explain_cloud(std::span<const PictureCloud> shown, CloudColors by, std::span<const std::string> names,
                   const std::optional<HeightScale>& heights, Sidebar& sidebar) {
  if (shown.empty()) return;
  if (by == CloudColors::kHeight && heights) sidebar.bar = {height_color, heights->low_m, heights->high_m, "z [m]"};
  if (by == CloudColors::kIntensity) {
    // Square root, since perception follows ratios of reflectivity; the cloud's colors do the same.
    sidebar.bar = {[](float s) { return viridis_like(std::sqrt(std::max(0.0F, s))); }, 0.0, 1.0, "reflectivity [-]"};
  }
  if (by == CloudColors::kLabel) {
    std::set<std::uint16_t> classes;
    for (const PictureCloud& cloud : shown) classes.insert(cloud.surface_class.begin(), cloud.surface_class.end());
    for (const std::uint16_t c : classes)
      sidebar.entries.push_back({name_of(static_cast<SurfaceClass>(c)), class_color(c), Sample::kDot});
  }
  if (by == CloudColors::kVehicle) {
    for (const PictureCloud& cloud : shown) {
      if (!cloud.points_world_m.empty())
        sidebar.entries.push_back(
            {"scan of " + names[static_cast<std::size_t>(cloud.vehicle)], vehicle_color(cloud.vehicle), Sample::kDot});
    }
  }
}

class SnapshotRecorder : public Recorder {
 public:
  /// @param video_frames_per_s  above 0: the pictures of each camera become a video
  SnapshotRecorder(std::vector<CameraConfig> cameras, double video_frames_per_s)
      : cameras_(std::move(cameras)), video_frames_per_s_(video_frames_per_s) {}

  void begin(const RunInfo& info) override;
  // Without overlays of agents: a picture of t = 0 is taken in the first tick
  void write_start(const TickView&) override {}
  void write(const TickView& tick) override;
  std::vector<std::filesystem::path> finish() override;

 private:
  using ScanKey = std::pair<VehicleId, std::string>;  // vehicle and sensor

  VehicleId vehicle_of(const CameraConfig& camera, std::size_t index) const;
  void remember(const TickView& tick);
  void fill_clouds(const TickView& tick);
  void keep_frame(const Station& station, const Image& frame);
  void save(const Station& station, const Figure& figure, const std::filesystem::path& stem);
  Figure take(Station& station, const std::filesystem::path& stem);
  Figure take_of_scan(const Station& station) const;
  Figure take_of_depth(Station& station, const std::filesystem::path& stem);
  Figure take_of_world(Station& station);
  void caption(Canvas& canvas, const Station& station, int width_px) const;
  std::string caption_of(const Station& station) const;
  Renderer& renderer();
  bool needs_scans() const {
    return std::any_of(cameras_.begin(), cameras_.end(),
                       [](const auto& c) { return c.looks_through_lidar() || c.cloud != CloudColors::kNone; });
  }

  std::vector<CameraConfig> cameras_;
  RunInfo info_;
  std::vector<Station> stations_;
  std::unique_ptr<Renderer> renderer_;
  std::map<ScanKey, std::shared_ptr<const LabeledScan>> latest_scans_;
  PictureScene picture_;
  TimeNs previous_ = -1;
  std::optional<TimeNs> remembered_;
  std::vector<std::filesystem::path> written_;
  double video_frames_per_s_ = 0.0;
  std::map<std::string, std::unique_ptr<VideoWriter>> videos_;  // indexed by camera
};

void SnapshotRecorder::begin(const RunInfo& info) {
  info_ = info;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const CameraConfig& camera = cameras_[i];
    const VehicleId vehicle = vehicle_of(camera, i);
    std::vector<float> radii_m;
    for (const auto& shape : info_.vehicle_shapes) {
      radii_m.push_back(shape->circumscribed_radius_m * static_cast<float>(camera.vehicle_scale));
    }
    const BlocksSight blocks =
        camera.type == CameraConfig::Type::kFollow ? sight_in(info_.static_scene) : BlocksSight{};
    stations_.push_back({camera, vehicle, look_of(camera), radii_m,
                         CameraController(camera, vehicle, radii_m, info_.scene->bounds_m, blocks)});
  }
  picture_.trails_m.resize(info_.vehicle_names.size());
}

VehicleId SnapshotRecorder::vehicle_of(const CameraConfig& camera, std::size_t index) const {
  if (of_all_vehicles(camera) || camera.type == CameraConfig::Type::kFixed) return kNoVehicle;
  if (camera.vehicle.empty()) return info_.vehicle_names.empty() ? kNoVehicle : 0;
  const auto found = std::find(info_.vehicle_names.begin(), info_.vehicle_names.end(), camera.vehicle);
  if (found == info_.vehicle_names.end()) {
    throw InputError("snapshots[" + std::to_string(index) + "].vehicle: expected the name of a vehicle, found \"" +
                     camera.vehicle + "\"");
  }
  return static_cast<VehicleId>(found - info_.vehicle_names.begin());
}

void SnapshotRecorder::write(const TickView& tick) {
  const bool due = wants_picture(cameras_, previous_, tick.t);
  if (needs_scans()) {
    for (std::size_t v = 0; v < tick.scans.size(); ++v) {
      for (const auto& scan : tick.scans[v]) latest_scans_[{static_cast<VehicleId>(v), scan->scan.sensor}] = scan;
    }
  }
  if (due || !remembered_ || tick.t - *remembered_ >= kHistoryStep) remember(tick);
  if (due) {
    fill_clouds(tick);
    const std::filesystem::path folder = info_.directory / "snapshots";
    make_inner_directory(folder);
    for (Station& station : stations_) {
      if (!station.config.is_due(previous_, tick.t)) continue;
      const std::filesystem::path stem = folder / fmt::format("{}_{:08.3f}s", station.config.name, to_seconds(tick.t));
      const Figure figure = take(station, stem);
      if (video_frames_per_s_ > 0.0)
        keep_frame(station, figure.pixels(station.look.page));
      else
        save(station, figure, stem);
    }
  }
  previous_ = tick.t;
}

void SnapshotRecorder::keep_frame(const Station& station, const Image& frame) {
  std::unique_ptr<VideoWriter>& video = videos_[station.config.name];
  if (!video) {
    const std::filesystem::path path = info_.directory / "snapshots" / (station.config.name + ".mp4");
    video = std::make_unique<VideoWriter>(path, frame.width, frame.height, video_frames_per_s_);
    written_.push_back(path.lexically_relative(info_.directory));
  }
  video->add(frame);
}

void SnapshotRecorder::save(const Station& station, const Figure& figure, const std::filesystem::path& stem) {
  const bool on_paper = station.config.on_paper();
  const auto keep = [&](const char* extension, const auto& write) {
    const std::filesystem::path path = stem.string() + extension;
    write(path);
    written_.push_back(path.lexically_relative(info_.directory));
  };
  keep(".png", [&](const std::filesystem::path& path) {
    write_png(path, figure.pixels(station.look.page), on_paper ? station.config.dpi : 0.0);
  });
  if (!on_paper) return;
  keep(".svg", [&](const std::filesystem::path& path) {
    write_file(path, figure.svg(station.config.dpi,
                                fmt::format("{}, t = {:.3f} s", caption_of(station), to_seconds(picture_.t))));
  });
}

std::vector<std::filesystem::path> SnapshotRecorder::finish() {
  for (const auto& [camera, video] : videos_) video->finish();
  videos_.clear();
  return std::move(written_);
}

void SnapshotRecorder::remember(const TickView& tick) {
  remembered_ = tick.t;
  for (std::size_t v = 0; v < tick.states.size(); ++v) {
    extend_trail(picture_.trails_m[v], tick.states[v].p_world_m.cast<float>());
  }
  for (Station& station : stations_) station.controller.update(tick.t, tick.states);
}

void SnapshotRecorder::fill_clouds(const TickView& tick) {
  picture_.t = tick.t;
  picture_.states.assign(tick.states.begin(), tick.states.end());
  picture_.overlays.clear();
  for (std::size_t v = 0; v < tick.actions.size(); ++v) {
    for (Overlay overlay : tick.actions[v]->overlays) {
      overlay.name = info_.vehicle_names[v] + "/" + overlay.name;
      if (overlay.colors.empty()) {
        const Rgb rgb = vehicle_color(static_cast<VehicleId>(v));
        overlay.colors = {{rgb[0], rgb[1], rgb[2], overlay.kind == Overlay::Kind::kTriangles ? kAreaOpacity : 1.0F}};
      }
      picture_.overlays.push_back(std::move(overlay));
    }
  }
  picture_.clouds.clear();
  const bool wanted = std::any_of(cameras_.begin(), cameras_.end(), [&](const CameraConfig& camera) {
    return camera.cloud != CloudColors::kNone && camera.is_due(previous_, tick.t);
  });
  if (!wanted) return;
  for (const auto& [key, scan] : latest_scans_) picture_.clouds.push_back(cloud_of(*scan, key.first));
}

Renderer& SnapshotRecorder::renderer() {
  if (!renderer_) renderer_ = std::make_unique<Renderer>(*info_.scene, info_.vehicle_shapes);
  return *renderer_;
}

Figure SnapshotRecorder::take(Station& station, const std::filesystem::path& stem) {
  if (station.config.looks_through_lidar()) return take_of_scan(station);
  if (station.config.type == CameraConfig::Type::kDepth) return take_of_depth(station, stem);
  return take_of_world(station);
}

void SnapshotRecorder::caption(Canvas& canvas, const Station& station, int width_px) const {
  if (!station.look.captions) return;
  draw_caption(canvas, station.look, width_px, caption_of(station),
               fmt::format("t = {:.3f} s", to_seconds(picture_.t)));
}

std::string SnapshotRecorder::caption_of(const Station& station) const {
  std::string text = info_.scenario;
  text += (text.empty() ? "" : "  /  ") + station.config.name;
  if (station.vehicle != kNoVehicle) text += "  /  " + info_.vehicle_names[static_cast<std::size_t>(station.vehicle)];
  return text;
}

Figure SnapshotRecorder::take_of_scan(const Station& station) const {
  const CameraConfig& camera = station.config;
  const auto quantity =
      camera.type == CameraConfig::Type::kLidarRange ? ScanQuantity::kRange : ScanQuantity::kIntensity;
  std::shared_ptr<const LabeledScan> latest;
  for (const auto& [key, scan] : latest_scans_) {
    if (latest || key.first != station.vehicle || (!camera.sensor.empty() && camera.sensor != key.second)) continue;
    latest = scan;
  }
  const Eigen::Vector2i size = camera.size_px();
  return {size.x(), size.y(), [this, &station, latest, quantity](Canvas& canvas) {
            const Eigen::Vector2f corner(static_cast<float>(canvas.width_px()), static_cast<float>(canvas.height_px()));
            canvas.rectangle({0.0F, 0.0F, corner.x(), corner.y()}, station.look.page);
            int width_px = canvas.width_px();
            if (latest) {
              width_px = draw_range_image(canvas, station.look, latest->scan, quantity, station.config.max_range_m);
            } else {
              canvas.text(0.5F * corner, "no scan yet", station.look.text(1.5F, Align::kCenter));
            }
            caption(canvas, station, width_px);
          }};
}

/// The requested number of pixels, with the color scale at the side.
Figure SnapshotRecorder::take_of_depth(Station& station, const std::filesystem::path& stem) {
  PictureStyle style = style_of(station.config);
  style.hidden_vehicle = station.vehicle;
  const DepthImage depth = renderer().draw_depth(station.controller.view(picture_), picture_, style);
  if (video_frames_per_s_ <= 0.0) {
    std::vector<std::uint16_t> millimeters(depth.depth_m.size());
    std::transform(depth.depth_m.begin(), depth.depth_m.end(), millimeters.begin(),
                   [](float d) { return static_cast<std::uint16_t>(std::min(65535.0F, std::round(1000.0F * d))); });
    const std::filesystem::path path = stem.string() + ".mm.png";
    write_png16(path, depth.width, depth.height, millimeters);
    written_.push_back(path.lexically_relative(info_.directory));
  }
  const double end_m = station.config.max_range_m > 0.0 ? station.config.max_range_m : depth_scale_end_m(depth);
  const Sidebar sidebar{{}, ColorBar{turbo_like, 0.0, end_m, "depth [m]"}};
  station.sidebar_px = std::max(station.sidebar_px, sidebar_width_px(sidebar, station.look));
  return {depth.width + station.sidebar_px, depth.height,
          [this, &station, sidebar, image = depth_colors(depth, end_m, station.look.nothing)](Canvas& canvas) {
            canvas.picture(0, 0, image);
            draw_sidebar(canvas, station.look, sidebar, image.width);
            caption(canvas, station, image.width);
          }};
}

Figure SnapshotRecorder::take_of_world(Station& station) {
  const CameraConfig& camera = station.config;
  PictureStyle style = style_of(camera);
  style.line_scale = station.look.line_scale;
  style.quick = video_frames_per_s_ > 0.0;
  if (camera.type == CameraConfig::Type::kOnboard) style.hidden_vehicle = station.vehicle;
  if (camera.type == CameraConfig::Type::kFollow) {
    for (VehicleId v = 0; v < std::ssize(picture_.states); ++v) {
      if (station.vehicle == kNoVehicle || station.vehicle == v) style.watched.push_back(v);
    }
  }

  // The sidebar determines the width of the picture.
  const Eigen::Vector2i size = camera.size_px();
  Sidebar sidebar;
  for (const Overlay& overlay : picture_.overlays) {
    if (overlay.positions.empty() || !is_chosen(overlay, camera.overlays)) continue;
    for (const Overlay::Key& key : overlay.legend)
      sidebar.entries.push_back({key.meaning, key.color.head<3>(), sample_of(overlay.kind, key.dashed)});
  }
  if (camera.cloud != CloudColors::kNone) {
    station.controller.set_size(size.x(), size.y());
    const std::vector<PictureCloud> shown = shown_of(picture_.clouds, station.controller.view(picture_), style);
    style.heights = height_scale_of(shown);
    explain_cloud(shown, camera.cloud, info_.vehicle_names, style.heights, sidebar);
  }
  station.sidebar_px =
      std::min(std::max(station.sidebar_px, sidebar_width_px(sidebar, station.look)), size.x() - kMinWidth_px);
  station.controller.set_size(size.x() - station.sidebar_px, size.y());

  const View view = station.controller.view(picture_);
  return {size.x(), size.y(),
          [this, &station, style, sidebar, view, image = renderer().draw(view, picture_, style)](Canvas& canvas) {
            canvas.picture(0, 0, image);
            VehicleMarks marks;
            const bool onboard = station.config.type == CameraConfig::Type::kOnboard;
            if (station.config.names && !onboard) marks.names = info_.vehicle_names;
            marks.radii_m = station.radii_m;
            marks.min_px = onboard ? 0.0F : static_cast<float>(station.config.vehicle_min_px);
            marks.hidden_vehicle = style.hidden_vehicle;
            draw_vehicle_marks(canvas, station.look, view, picture_, marks);
            if (view.orthographic) draw_scale_bar(canvas, station.look, view);
            if (station.config.axes && !onboard) draw_axes(canvas, station.look, view);
            caption(canvas, station, image.width);
            draw_sidebar(canvas, station.look, sidebar, image.width);
          }};
}

}  // namespace

std::unique_ptr<Recorder> make_snapshot_recorder(std::vector<CameraConfig> cameras) {
  return std::make_unique<SnapshotRecorder>(std::move(cameras), 0.0);
}

std::unique_ptr<Recorder> make_video_recorder(std::vector<CameraConfig> cameras, double frames_per_s) {
  return std::make_unique<SnapshotRecorder>(std::move(cameras), frames_per_s);
}

}  // namespace swiftlet::sim
