// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/tum.hpp"

#include "sim/recorders/selection.hpp"
#include "swiftlet/sim/io/output_file.hpp"
#include "swiftlet/sim/io/text_row.hpp"

namespace swiftlet::sim {
namespace {

constexpr const char* kHeader = "# t_s x_m y_m z_m qx qy qz qw\n";

class TumRecorder : public Recorder {
 public:
  explicit TumRecorder(TumConfig config) : config_(std::move(config)), gate_(config_.rate_hz) {}

  void begin(const RunInfo& info) override {
    directory_ = info.directory;
    start_time_ = info.start_time;
    const std::vector<bool> selected = select_vehicles(config_.vehicles, info.vehicle_names);
    for (std::size_t i = 0; i < selected.size(); ++i) {
      if (!selected[i]) continue;
      const std::string stem = "trajectories/" + info.vehicle_names[i];
      vehicles_.push_back({static_cast<VehicleId>(i), open(stem + ".tum"), {}, kNeverWritten});
      if (config_.estimate) vehicles_.back().estimate = open(stem + ".estimate.tum");
    }
  }

  void write(const TickView& tick) override {
    if (!gate_.due(tick.t)) return;
    for (Vehicle& vehicle : vehicles_) {
      const VehicleState& state = tick.states[vehicle.id];
      append(vehicle.truth, tick.t, state.p_world_m, state.q_world_body);
      const Action* action = tick.actions[vehicle.id];
      if (!config_.estimate || !action || !action->estimate.valid || action->estimate.t == vehicle.last_estimate) {
        continue;
      }
      const StateEstimate& estimate = action->estimate;
      append(vehicle.estimate, estimate.t, estimate.T_world_body().translation(),
             Eigen::Quaterniond(estimate.T_world_body().linear()));
      vehicle.last_estimate = estimate.t;
    }
  }

  std::vector<std::filesystem::path> finish() override {
    for (Vehicle& vehicle : vehicles_) {
      vehicle.truth.finish();
      if (config_.estimate) vehicle.estimate.finish();
    }
    return paths_;
  }

 private:
  static constexpr TimeNs kNeverWritten = -1;
  struct Vehicle {
    VehicleId id;
    OutputFile truth;
    OutputFile estimate;
    TimeNs last_estimate;
  };

  OutputFile open(const std::string& name) {
    paths_.push_back(name);
    OutputFile file(directory_ / name);
    file.append(kHeader);
    return file;
  }

  void append(OutputFile& file, TimeNs t, const Vector3& position, const Eigen::Quaterniond& rotation) {
    row_.clear();
    row_.add_seconds(start_time_ + t).add(position).add(rotation.coeffs());  // Eigen stores x, y, z, w
    file.append(row_.line());
  }

  TumConfig config_;
  RateGate gate_;
  std::filesystem::path directory_;
  TimeNs start_time_ = 0;
  std::vector<Vehicle> vehicles_;
  std::vector<std::filesystem::path> paths_;
  TextRow row_{' '};
};

}  // namespace

void TumConfig::visit(ConfigVisitor& v) {
  v.field("vehicles", vehicles, "[-] names of the vehicles to write; empty: all");
  v.field("rate_hz", rate_hz, "[Hz] poses per second; 0: every tick", Range::between(0.0, 1e5));
  v.check(rate_hz == 0.0 || rate_hz >= 1e-3, "rate_hz", "0, or at least 0.001");
  v.field("estimate", estimate, "[-] whether the vehicles' estimates are written too");
}

std::unique_ptr<Recorder> make_tum_recorder(const ModuleConfig& config) {
  return std::make_unique<TumRecorder>(dynamic_cast<const TumConfig&>(config));
}

}  // namespace swiftlet::sim
