// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/scan_files.hpp"

#include <fmt/core.h>

#include <limits>
#include <map>
#include <utility>

#include "sim/recorders/selection.hpp"
#include "swiftlet/sim/io/output_file.hpp"
#include "swiftlet/sim/io/text_row.hpp"

namespace swiftlet::sim {
namespace {

using Type = PointField::Type;
constexpr PointField kFields[] = {
    {"x", Type::kFloat32, 4},
    {"y", Type::kFloat32, 4},
    {"z", Type::kFloat32, 4},
    {"intensity", Type::kFloat32, 4},
    {"reflectivity", Type::kFloat32, 4},
    {"ring", Type::kUint16, 2},
    {"column", Type::kUint32, 4},
    {"t", Type::kUint32, 4},
    {"class", Type::kUint16, 2},
    {"instance", Type::kUint16, 2},
    {"part", Type::kUint8, 1},
    {"range_true", Type::kFloat32, 4},
    {"incidence", Type::kFloat32, 4},
};

constexpr std::size_t point_size() {
  std::size_t size = 0;
  for (const PointField& field : kFields) size += static_cast<std::size_t>(field.size_bytes);
  return size;
}

template <class Number>
std::byte* append(std::byte* at, Number value) {
  std::memcpy(at, &value, sizeof value);
  return at + sizeof value;
}

constexpr const char* kIndexHeader =
    "file,stamp_s,duration_s,rows,columns,points,x_m,y_m,z_m,qx,qy,qz,qw,est_x_m,est_y_m,est_z_m,est_qx,est_qy,est_qz,"
    "est_qw\n";

class ScanFilesRecorder : public Recorder {
 public:
  ScanFilesRecorder(ScanFilesConfig config, CloudFormat format) : config_(std::move(config)), format_(format) {}

  void begin(const RunInfo& info) override {
    directory_ = info.directory;
    names_ = info.vehicle_names;
    start_time_ = info.start_time;
    selected_ = select_vehicles(config_.vehicles, names_);
    estimates_.resize(names_.size());
  }

  void write(const TickView& tick) override {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (!selected_[i]) continue;
      const Action* action = tick.actions[i];
      if (action && action->estimate.valid) estimates_[i].push(action->estimate.t, action->estimate.T_world_body());
      if (tick.scans.empty()) continue;
      for (const auto& scan : tick.scans[i]) {
        if (selects(config_.sensors, scan->scan.sensor)) write_scan(static_cast<VehicleId>(i), *scan);
      }
    }
  }

  std::vector<std::filesystem::path> finish() override {
    std::vector<std::filesystem::path> paths;
    for (auto& [key, stream] : streams_) {
      stream.index.finish();
      paths.push_back(stream.folder);
    }
    return paths;
  }

 private:
  struct Stream {
    std::filesystem::path folder;  ///< relative to the run directory
    OutputFile index;
    int num_scans = 0;
    int num_files = 0;
  };

  Stream& stream_of(VehicleId vehicle, const std::string& sensor) {
    const auto [entry, is_new] = streams_.try_emplace({vehicle, sensor});
    Stream& stream = entry->second;
    if (is_new) {
      stream.folder = std::filesystem::path(config_.folder) / (names_[vehicle] + "_" + sensor);
      stream.index = OutputFile(directory_ / stream.folder / (std::string(format_.extension) + "_index.csv"));
      stream.index.append(kIndexHeader);
    }
    return stream;
  }

  void write_scan(VehicleId vehicle, const LabeledScan& scan) {
    Stream& stream = stream_of(vehicle, scan.scan.sensor);
    if (stream.num_scans++ % config_.every != 0) return;

    // Points first, since the header contains their number.
    body_.clear();
    const int num_points = put_points(scan, poses_of(vehicle, scan), format_.organized, body_);
    const char* frame = ScanFilesConfig::kFrames[static_cast<std::size_t>(config_.frame)];
    const TimeNs stamp = start_time_ + scan.scan.stamp;
    CloudLayout layout{num_points, 1, frame, stamp};
    if (format_.organized) layout = {scan.scan.cols(), scan.scan.rows(), frame, stamp};

    const std::string name = fmt::format("{:06}.{}", stream.num_files++, format_.extension);
    OutputFile file(directory_ / stream.folder / name, 0);
    file.append(format_.header(layout));
    file.append(body_.bytes());
    file.finish();
    append_index(stream.index, name, num_points, vehicle, scan);
  }

  /// Transforms of each column's points into the frame of the file. Empty: points stay in the lidar frame.
  std::span<const Pose> poses_of(VehicleId vehicle, const LabeledScan& scan) {
    if (config_.frame == ScanFilesConfig::Frame::kLidar) return {};
    if (config_.frame == ScanFilesConfig::Frame::kWorld) return scan.truth.T_world_lidar;
    const PoseHistory& estimate = estimates_[vehicle];
    poses_.clear();
    for (int column = 0; column < scan.scan.cols(); ++column) {
      const Pose T_world_body = estimate.empty() ? Pose::Identity() : estimate.at(scan.scan.time_of(column));
      poses_.push_back(T_world_body * scan.scan.T_body_lidar);
    }
    return poses_;
  }

  void append_index(OutputFile& index, const std::string& name, int num_points, VehicleId vehicle,
                    const LabeledScan& scan) {
    row_.clear();
    row_.add(name).add_seconds(start_time_ + scan.scan.stamp).add_seconds(scan.scan.duration);
    row_.add(scan.scan.rows()).add(scan.scan.cols()).add(num_points);
    add_pose(scan.truth.T_world_lidar.front());
    if (estimates_[vehicle].empty()) {
      for (int i = 0; i < 7; ++i) row_.add(std::numeric_limits<double>::quiet_NaN());
    } else {
      add_pose(estimates_[vehicle].at(scan.scan.stamp) * scan.scan.T_body_lidar);
    }
    index.append(row_.line());
  }

  void add_pose(const Pose& pose) { row_.add(pose.translation()).add(Eigen::Quaterniond(pose.linear()).coeffs()); }

  ScanFilesConfig config_;
  CloudFormat format_;
  std::filesystem::path directory_;
  std::vector<std::string> names_;
  std::vector<bool> selected_;
  TimeNs start_time_ = 0;
  std::vector<PoseHistory> estimates_;  // indexed by VehicleId
  std::map<std::pair<VehicleId, std::string>, Stream> streams_;
  std::vector<Pose> poses_;
  ByteBuffer body_;
  TextRow row_{','};
};

}  // namespace

void ScanFilesConfig::visit_common(ConfigVisitor& v) {
  v.field("vehicles", vehicles, "[-] names of the vehicles whose scans are written; empty: all");
  v.field("sensors", sensors, "[-] names of the LiDARs on those vehicles; empty: all");
  v.field("every", every, "[-] every n-th scan is written", Range{1, 1e9, false, false});
  v.choice("frame", frame, kFrames,
           "[-] frame of the points: as measured, the world by the true poses, the world as the vehicle estimates it");
  v.field("folder", folder, "[-] folder in the run directory; two recorders of the same format need two");
}

std::span<const PointField> point_fields() { return kFields; }

int put_points(const LabeledScan& labeled, std::span<const Pose> T_frame_lidar, bool organized, ByteBuffer& out) {
  const Scan& scan = labeled.scan;
  const ScanTruth& truth = labeled.truth;
  const std::size_t start = out.size();
  std::byte* at = out.extend(static_cast<std::size_t>(scan.size()) * point_size());
  const std::byte* const first = at;
  int num_points = 0;
  for (int row = 0, i = 0; row < scan.rows(); ++row) {
    for (int column = 0; column < scan.cols(); ++column, ++i) {
      if (!scan.hit(i) && !organized) continue;
      ++num_points;
      Eigen::Vector3f point = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
      if (scan.hit(i)) {
        point = scan.point_lidar(i);
        if (!T_frame_lidar.empty()) {
          const Pose& pose = T_frame_lidar[T_frame_lidar.size() == 1 ? 0 : static_cast<std::size_t>(column)];
          point = (pose * point.cast<double>()).cast<float>();
        }
      }
      at = append(append(append(at, point.x()), point.y()), point.z());
      at = append(append(at, scan.intensity[i]), scan.reflectivity[i]);
      at = append(append(at, static_cast<std::uint16_t>(row)), static_cast<std::uint32_t>(column));
      at = append(at, static_cast<std::uint32_t>(scan.time_of(i) - scan.stamp));
      at = append(append(append(at, truth.surface_class[i]), truth.instance[i]), truth.part[i]);
      at = append(append(at, truth.range_m[i]), truth.incidence_rad[i]);
    }
  }
  out.shrink_to(start + static_cast<std::size_t>(at - first));
  return num_points;
}

std::unique_ptr<Recorder> make_scan_files_recorder(const ScanFilesConfig& config, const CloudFormat& format) {
  return std::make_unique<ScanFilesRecorder>(config, format);
}

}  // namespace swiftlet::sim
