// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/clocked_sensor.hpp"

#include <algorithm>
#include <array>

namespace swiftlet::sim {

void ClockConfig::visit(ConfigVisitor& v) {
  v.field("offset_s", offset_s, "[s] stamp minus true time; one sweep for a driver that stamps sweeps at their end",
          Range::between(-10.0, 10.0));
  v.field("jitter_s", jitter_s, "[s] standard deviation of the white error of the stamps", Range::between(0.0, 10.0));
}

void SensorConfig::visit_common(ConfigVisitor& v) {
  v.field("name", name, "[-] name of the sensor, unique on its vehicle; empty: the name of its type");
  v.object("clock", clock, "error of the stamps");
  v.field("latency_s", latency_s, "[s] delay from the time of validity to the delivery", Range::non_negative());
}

namespace {

/// Stamps of the data of one sensor. Equal times, such as those of all neighbors in one sample, have equal stamps.
class Stamps {
 public:
  Stamps() = default;
  Stamps(const ClockConfig& clock, Random random)
      : offset_(from_seconds(clock.offset_s)), jitter_s_(clock.jitter_s), random_(random) {}

  TimeNs of(TimeNs t) {
    if (count_ > 0 && t == last_time_) return last_stamp_;
    const TimeNs jitter = jitter_s_ > 0.0 ? from_seconds(jitter_s_ * random_.normal(count_, 0)) : 0;
    last_stamp_ = std::max(t + offset_ + jitter, last_stamp_ + 1);
    last_time_ = t;
    ++count_;
    return last_stamp_;
  }

 private:
  TimeNs offset_ = 0;
  double jitter_s_ = 0.0;
  Random random_;
  std::uint32_t count_ = 0;
  TimeNs last_time_ = 0, last_stamp_ = -1;
};

class ClockedSensor final : public Sensor {
 public:
  ClockedSensor(std::unique_ptr<Sensor> sensor, const SensorConfig& config, SensorSetup setup)
      : Sensor(std::move(setup)),
        sensor_(std::move(sensor)),
        latency_(from_seconds(config.latency_s)),
        exact_(config.clock.exact()),
        stamps_(config.clock, stream("sensor.clock")) {}

  void measure(TimeNs now, const StateHistory& truth, Observation& out) override {
    std::array<std::size_t, kLists> before{};
    std::size_t list = 0;
    Observation::each_samples(out, [&](auto& samples) { before[list++] = samples.size(); });
    sensor_->measure(now - latency_, truth, out);
    if (exact_) return;
    list = 0;
    Observation::each_samples(out, [&](auto& samples) {
      for (std::size_t i = before[list++]; i < samples.size(); ++i) samples[i].t = stamps_.of(samples[i].t);
    });
    for (const auto& scan : sensor_->scans()) {
      const TimeNs stamp = stamps_.of(scan->scan.stamp);
      scan->truth.clock_error = stamp - scan->scan.stamp;
      scan->scan.stamp = stamp;
    }
  }
  std::span<const std::shared_ptr<LabeledScan>> scans() const override { return sensor_->scans(); }
  bool makes_scan_by(TimeNs now) const override { return sensor_->makes_scan_by(now - latency_); }
  int begin_sweep(TimeNs now, const StateHistory& truth) override {
    return sensor_->begin_sweep(now - latency_, truth);
  }
  void trace_part(int part) override { sensor_->trace_part(part); }
  int heading_of_part(int part) const override { return sensor_->heading_of_part(part); }
  double look_back_s() const override { return sensor_->look_back_s() + to_seconds(latency_); }

 private:
  static constexpr std::size_t kLists = std::tuple_size_v<decltype(Observation::lists())>;

  std::unique_ptr<Sensor> sensor_;
  TimeNs latency_;
  bool exact_;  // stamps are the true times
  Stamps stamps_;
};

}  // namespace

std::unique_ptr<Sensor> with_clock(std::unique_ptr<Sensor> sensor, const SensorConfig& config, SensorSetup setup) {
  if (config.clock.exact() && config.latency_s == 0.0) return sensor;
  return std::make_unique<ClockedSensor>(std::move(sensor), config, std::move(setup));
}

}  // namespace swiftlet::sim
