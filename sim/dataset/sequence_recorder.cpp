// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/sequence_recorder.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/dataset/boxes.hpp"
#include "sim/dataset/frame_writer.hpp"
#include "sim/dataset/free_space.hpp"
#include "swiftlet/sim/io/output_file.hpp"
#include "swiftlet/sim/io/text_row.hpp"
#include "swiftlet/sim/recorders/pose_history.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kHistory_s = 1.5;  // length of the stored truth; longer than any sweep
// [-] Least visible share of the silhouette of a vehicle in view.
constexpr double kInView = 0.1;
// [-] Fewest points of a well detected vehicle.
constexpr int kWell = 5;

constexpr const char* kBoxesHeader =
    "frame,vehicle,instance,t_s,x_m,y_m,z_m,qx,qy,qz,qw,length_m,width_m,height_m,num_points,visible_fraction,range_m,"
    "x_world_m,y_world_m,z_world_m,qx_world,qy_world,qz_world,qw_world,vx_world_mps,vy_world_mps,vz_world_mps\n";

void write_whole(const std::filesystem::path& path, const std::string& text) {
  OutputFile file(path, 0);
  file.append(text);
  file.finish();
}

/// The upper three rows of a pose, row by row, in KITTI's format.
void add_matrix(TextRow& row, const Pose& pose) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) row.add(pose.matrix()(i, j));
  }
}

std::string calibration(const Pose& T_body_lidar) {
  std::string text;
  TextRow row{' '};
  // Poses are those of the LiDAR itself, so all calibration matrices are the identity.
  for (const char* name : {"P0:", "P1:", "P2:", "P3:", "Tr:"}) {
    row.clear();
    row.add(std::string_view(name));
    add_matrix(row, Pose::Identity());
    text += row.line();
  }
  row.clear();
  row.add(std::string_view("T_body_lidar:"));
  add_matrix(row, T_body_lidar);
  return text + std::string(row.line());
}

int bin_of(double range_m) {
  return std::clamp(static_cast<int>(range_m / SequenceStatistics::kRangeBin_m), 0, SequenceStatistics::kRangeBins - 1);
}

class SequenceRecorder : public Recorder {
 public:
  SequenceRecorder(ContentConfig content, VehicleId vehicle, std::string sensor,
                   std::shared_ptr<const StaticScene> world, std::shared_ptr<SequenceStatistics> statistics)
      : content_(std::move(content)),
        vehicle_(vehicle),
        sensor_(std::move(sensor)),
        world_(std::move(world)),
        statistics_(std::move(statistics)) {}

  void begin(const RunInfo& info) override {
    directory_ = info.directory;
    names_ = info.vehicle_names;
    frames_ = std::make_unique<FrameWriter>(content_, directory_);
    boxes_ = std::make_unique<BoxMaker>(world_, info.vehicle_shapes, vehicle_);
    poses_file_ = OutputFile(directory_ / "poses.txt");
    times_file_ = OutputFile(directory_ / "times.txt");
    external_poses_file_ = OutputFile(directory_ / "estimate.tum");
    external_poses_file_.append("# t_s x_m y_m z_m qx qy qz qw\n");
    boxes_file_ = OutputFile(directory_ / "boxes.csv");
    boxes_file_.append(kBoxesHeader);
  }

  void write_start(const TickView&) override {}  // ignored: statistics count ticks
  void write(const TickView& tick) override {
    remember(tick);
    if (tick.scans.empty()) return;
    for (const auto& scan : tick.scans[static_cast<std::size_t>(vehicle_)]) {
      if (scan->scan.sensor != sensor_) continue;
      for (const StampedPose& pose : scan->scan.external_poses) external_poses_.push(pose.t, pose.T_world_body);
      if (num_scans_++ % content_.every != 0) continue;
      frames_->push(scan);
      write_frame(*scan);
    }
  }

  std::vector<std::filesystem::path> finish() override {
    for (OutputFile* file : {&poses_file_, &times_file_, &external_poses_file_, &boxes_file_}) file->finish();
    SequenceStatistics of_frames = frames_->finish();
    statistics_->add(of_frames);
    statistics_->pixel_shift_by_row = std::move(of_frames.pixel_shift_by_row);
    statistics_->rows = of_frames.rows;
    statistics_->columns = of_frames.columns;
    statistics_->files = std::move(of_frames.files);
    statistics_->beside_s = frames_->processor_s();
    return {};
  }

 private:
  // Stores recent truth at tick rate, and the vehicle's estimates.
  void remember(const TickView& tick) {
    const auto n = static_cast<int>(tick.states.size());
    if (truth_.num_vehicles() == 0) {
      truth_ = StateHistory(n, static_cast<int>(kHistory_s / to_seconds(std::max<TimeNs>(tick.t, 1))) + 2);
    } else {
      const Vector3 moved =
          tick.states[static_cast<std::size_t>(vehicle_)].p_world_m - truth_.latest(vehicle_).p_world_m;
      statistics_->flown_m += moved.norm();
    }
    for (VehicleId v = 0; v < n; ++v) truth_.push(v, tick.states[static_cast<std::size_t>(v)]);
    statistics_->duration_s = to_seconds(tick.t);
    if (!tick.clearance_m.empty()) {
      for (const double clearance_m : tick.clearance_m) {
        statistics_->least_clearance_m = std::min(statistics_->least_clearance_m, clearance_m);
      }
    }
    const Action* action = tick.actions[static_cast<std::size_t>(vehicle_)];
    if (action && action->estimate.valid) estimate_.push(action->estimate.t, action->estimate.T_world_body());
  }

  void write_frame(const LabeledScan& labeled) {
    const Scan& scan = labeled.scan;
    if (num_frames_ == 0) write_whole(directory_ / "calib.txt", calibration(scan.T_body_lidar));
    write_poses(labeled);
    write_boxes(labeled);
    ++num_frames_;
  }

  void write_poses(const LabeledScan& labeled) {
    const Scan& scan = labeled.scan;
    row_.clear();
    add_matrix(row_, labeled.truth.T_world_lidar.front());
    poses_file_.append(row_.line());
    if (!is_enclosed(*world_, labeled.truth.T_world_lidar.front().translation())) ++statistics_->frames_outside;
    row_.clear();
    times_file_.append(row_.add_seconds(scan.stamp).line());

    const PoseHistory& belief = external_poses_.empty() ? estimate_ : external_poses_;
    if (belief.empty()) return;
    const Pose T_world_lidar = belief.at(scan.stamp) * scan.T_body_lidar;
    row_.clear();
    row_.add_seconds(scan.stamp).add(T_world_lidar.translation());
    row_.add(Eigen::Quaterniond(T_world_lidar.linear()).coeffs());
    external_poses_file_.append(row_.line());
  }

  void write_boxes(const LabeledScan& labeled) {
    TextRow row{','};
    // Boxes are transformed to the start of the sweep, as the points are.
    const Pose T_start_world = labeled.truth.T_world_lidar.front().inverse();
    for (const VehicleBox& box : boxes_->boxes(labeled, truth_)) {
      const Pose T_lidar_box = content_.deskew ? Pose(T_start_world * box.T_world_box) : box.T_lidar_box;
      row.clear();
      row.add(num_frames_).add(names_[static_cast<std::size_t>(box.vehicle)]).add(box.vehicle + 1).add_seconds(box.t);
      row.add(T_lidar_box.translation()).add(Eigen::Quaterniond(T_lidar_box.linear()).coeffs()).add(box.size_m);
      row.add(box.num_points).add(box.visible_fraction).add(box.range_m);
      row.add(box.T_world_box.translation()).add(Eigen::Quaterniond(box.T_world_box.linear()).coeffs());
      row.add(box.v_world_mps);
      boxes_file_.append(row.line());

      auto& bin = statistics_->vehicles_by_range[static_cast<std::size_t>(bin_of(box.range_m))];
      ++bin.boxes;
      bin.in_view += box.visible_fraction >= kInView ? 1 : 0;
      bin.detected += box.num_points > 0 ? 1 : 0;
      bin.well_detected += box.num_points >= kWell ? 1 : 0;
      bin.points += box.num_points;
    }
  }

  ContentConfig content_;
  VehicleId vehicle_;
  std::string sensor_;
  std::shared_ptr<const StaticScene> world_;
  std::shared_ptr<SequenceStatistics> statistics_;
  std::filesystem::path directory_;
  std::vector<std::string> names_;
  std::unique_ptr<FrameWriter> frames_;
  std::unique_ptr<BoxMaker> boxes_;
  StateHistory truth_;
  PoseHistory estimate_, external_poses_;
  OutputFile poses_file_, times_file_, external_poses_file_, boxes_file_;
  int num_scans_ = 0;
  int num_frames_ = 0;
  TextRow row_{' '};
};

}  // namespace

void SequenceStatistics::add(const SequenceStatistics& other) {
  frames += other.frames;
  points += other.points;
  for (const auto& [label, count] : other.points_by_class) points_by_class[label] += count;
  for (std::size_t i = 0; i < vehicles_by_range.size(); ++i) {
    RangeBin& bin = vehicles_by_range[i];
    const RangeBin& more = other.vehicles_by_range[i];
    bin.boxes += more.boxes;
    bin.in_view += more.in_view;
    bin.detected += more.detected;
    bin.well_detected += more.well_detected;
    bin.points += more.points;
    points_by_range[i] += other.points_by_range[i];
  }
  flown_m += other.flown_m;
  duration_s += other.duration_s;
  least_clearance_m = std::min(least_clearance_m, other.least_clearance_m);
  frames_walled += other.frames_walled;
  frames_outside += other.frames_outside;
}

std::unique_ptr<Recorder> make_sequence_recorder(const ContentConfig& content, VehicleId vehicle,
                                                 const std::string& sensor, std::shared_ptr<const StaticScene> world,
                                                 std::shared_ptr<SequenceStatistics> statistics) {
  return std::make_unique<SequenceRecorder>(content, vehicle, sensor, std::move(world), std::move(statistics));
}

std::string frame_file(const char* folder, int frame, const char* extension) {
  return fmt::format("{}/{:06}.{}", folder, frame, extension);
}

}  // namespace swiftlet::sim
