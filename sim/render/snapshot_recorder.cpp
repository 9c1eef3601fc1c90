// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/render/snapshot_recorder.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "sim/render/cameras.hpp"
#include "sim/render/captions.hpp"
#include "sim/render/picture_scene.hpp"
#include "sim/render/png.hpp"
#include "sim/render/range_image.hpp"
#include "sim/render/renderer.hpp"
#include "sim/render/video.hpp"
#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

constexpr float kAreaOpacity = 0.3F;         // of areas in the vehicle's color
constexpr TimeNs kHistoryStep = 20'000'000;  // trails and follow cameras look at the vehicles this often

bool of_all_vehicles(const CameraConfig& camera) {
  return camera.vehicle.empty() &&
         (camera.type == CameraConfig::Type::kFollow || camera.type == CameraConfig::Type::kTop);
}

/// One camera at work.
struct Station {
  CameraConfig config;
  VehicleId vehicle = kNoVehicle;
  Cameraman cameraman;
};

class SnapshotRecorder : public Recorder {
 public:
  /// @param video_frames_per_s  above 0: the pictures of each camera become a video
  SnapshotRecorder(std::vector<CameraConfig> cameras, double video_frames_per_s)
      : cameras_(std::move(cameras)), video_frames_per_s_(video_frames_per_s) {}

  void begin(const RunInfo& info) override;
  void write(const TickView& tick) override;
  std::vector<std::filesystem::path> finish() override;

 private:
  using ScanKey = std::pair<VehicleId, std::string>;  // vehicle and sensor

  VehicleId vehicle_of(const CameraConfig& camera, std::size_t index) const;
  void remember(const TickView& tick);
  void fill_clouds(const TickView& tick);
  void keep_frame(const Station& station, const Image& frame);
  Image take(const Station& station, const std::filesystem::path& stem);
  Image take_of_scan(const Station& station) const;
  Image take_of_depth(const Station& station, const std::filesystem::path& stem);
  Image take_of_world(const Station& station);
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
  std::map<std::string, std::unique_ptr<VideoWriter>> videos_;  // by camera
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
    stations_.push_back({camera, vehicle, Cameraman(camera, vehicle, radii_m, info_.scene->bounds_m)});
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
    std::filesystem::create_directories(folder);
    for (const Station& station : stations_) {
      if (!station.config.is_due(previous_, tick.t)) continue;
      const std::filesystem::path stem = folder / fmt::format("{}_{:08.3f}s", station.config.name, to_seconds(tick.t));
      if (video_frames_per_s_ > 0.0) {
        keep_frame(station, take(station, stem));
        continue;
      }
      const std::filesystem::path path = stem.string() + ".png";
      write_png(path, take(station, stem));
      written_.push_back(path.lexically_relative(info_.directory));
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
  for (Station& station : stations_) station.cameraman.update(tick.t, tick.states);
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

Image SnapshotRecorder::take(const Station& station, const std::filesystem::path& stem) {
  Image image = station.config.looks_through_lidar()                ? take_of_scan(station)
                : station.config.type == CameraConfig::Type::kDepth ? take_of_depth(station, stem)
                                                                    : take_of_world(station);
  draw_caption(image, caption_of(station), fmt::format("t = {:.3f} s", to_seconds(picture_.t)));
  return image;
}

std::string SnapshotRecorder::caption_of(const Station& station) const {
  std::string text = info_.scenario;
  text += (text.empty() ? "" : "  /  ") + station.config.name;
  if (station.vehicle != kNoVehicle) text += "  /  " + info_.vehicle_names[static_cast<std::size_t>(station.vehicle)];
  return text;
}

Image SnapshotRecorder::take_of_scan(const Station& station) const {
  const CameraConfig& camera = station.config;
  const auto quantity =
      camera.type == CameraConfig::Type::kLidarRange ? ScanQuantity::kRange : ScanQuantity::kIntensity;
  for (const auto& [key, scan] : latest_scans_) {
    if (key.first != station.vehicle || (!camera.sensor.empty() && camera.sensor != key.second)) continue;
    return draw_range_image(scan->scan, quantity, camera.width_px, camera.height_px, camera.max_range_m);
  }
  Image image(camera.width_px, camera.height_px, Rgb::Constant(0.05F));
  draw_text(image, 0.5F * static_cast<float>(image.width), 0.5F * static_cast<float>(image.height), "no scan yet",
            {.height_px = 1.5F * caption_height_px(image), .align = Align::kCenter});
  return image;
}

Image SnapshotRecorder::take_of_depth(const Station& station, const std::filesystem::path& stem) {
  PictureStyle style = style_of(station.config);
  style.hidden_vehicle = station.vehicle;
  const DepthImage depth = renderer().draw_depth(station.cameraman.view(picture_), picture_, style);
  if (video_frames_per_s_ > 0.0) return draw_depth_image(depth, station.config.max_range_m);
  std::vector<std::uint16_t> millimeters(depth.depth_m.size());
  std::transform(depth.depth_m.begin(), depth.depth_m.end(), millimeters.begin(),
                 [](float d) { return static_cast<std::uint16_t>(std::min(65535.0F, std::round(1000.0F * d))); });
  const std::filesystem::path path = stem.string() + ".mm.png";
  write_png16(path, depth.width, depth.height, millimeters);
  written_.push_back(path.lexically_relative(info_.directory));
  return draw_depth_image(depth, station.config.max_range_m);
}

Image SnapshotRecorder::take_of_world(const Station& station) {
  const CameraConfig& camera = station.config;
  PictureStyle style = style_of(camera);
  if (camera.type == CameraConfig::Type::kOnboard) style.hidden_vehicle = station.vehicle;
  if (camera.type == CameraConfig::Type::kFollow) {
    for (VehicleId v = 0; v < std::ssize(picture_.states); ++v) {
      if (station.vehicle == kNoVehicle || station.vehicle == v) style.watched.push_back(v);
    }
  }
  const View view = station.cameraman.view(picture_);
  Image image = renderer().draw(view, picture_, style);
  if (camera.names && camera.type != CameraConfig::Type::kOnboard) {
    draw_names(image, view, picture_, info_.vehicle_names, camera.vehicle_scale);
  }
  if (view.orthographic) draw_scale_bar(image, view);
  std::vector<Overlay::Key> keys;
  for (const Overlay& overlay : picture_.overlays) {
    if (is_chosen(overlay, camera.overlays)) keys.insert(keys.end(), overlay.legend.begin(), overlay.legend.end());
  }
  draw_legend(image, keys);
  if (camera.cloud == CloudColors::kHeight && !picture_.clouds.empty()) {
    const HeightScale scale = height_scale_of(picture_.clouds);
    draw_color_bar(image, {height_color, scale.low_m, scale.high_m, "z [m]"});
  }
  return image;
}

}  // namespace

std::unique_ptr<Recorder> make_snapshot_recorder(std::vector<CameraConfig> cameras) {
  return std::make_unique<SnapshotRecorder>(std::move(cameras), 0.0);
}

std::unique_ptr<Recorder> make_video_recorder(std::vector<CameraConfig> cameras, double frames_per_s) {
  return std::make_unique<SnapshotRecorder>(std::move(cameras), frames_per_s);
}

}  // namespace swiftlet::sim
