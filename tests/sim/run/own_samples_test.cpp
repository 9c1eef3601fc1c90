// SPDX-License-Identifier: BSD-3-Clause
// A sensor whose kind of sample is unknown to all parts of Swiftlet.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/recorders/csv.hpp"
#include "swiftlet/sim/recorders/mcap.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct GasSample {
  static constexpr const char* kName = "gas";
  TimeNs t = 0;
  double concentration_ppm = 0.0;
  Matrix6 unseen = Matrix6::Zero();  // shown only in part by a table

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] when it was drawn in");
    v.field("concentration_ppm", s.concentration_ppm, "[-] parts per million");
    v.covariance("cov_*", s.unseen, "[-] of something");
  }
};

struct GasConfig : SensorConfigOf<GasConfig> {
  double concentration_ppm = 3.5;
  double unseen = 0.0;
  void visit(ConfigVisitor& v) override {
    visit_common(v);
    v.field("concentration_ppm", concentration_ppm, "[-] parts per million, everywhere");
  }
};

class GasSensor final : public Sensor {
 public:
  GasSensor(const GasConfig& config, SensorSetup setup) : Sensor(std::move(setup)), config_(config) {}
  void measure(TimeNs now, const StateHistory&, Observation& out) override {
    GasSample sample{now, config_.concentration_ppm};
    sample.unseen(5, 4) = config_.unseen;
    samples_of<GasSample>(out).push_back(sample);
  }

 private:
  GasConfig config_;
};

std::unique_ptr<Sensor> make_gas_sensor(const ModuleConfig& config, SensorSetup setup) {
  return std::make_unique<GasSensor>(dynamic_cast<const GasConfig&>(config), std::move(setup));
}

Scenario sniffer(const GasConfig& config = {}) {
  static const bool added = [] {
    sensor_registry().add({{"gas", "smells", make_module_config<GasConfig>}, make_gas_sensor, sample_table<GasSample>});
    return true;
  }();
  EXPECT_TRUE(added);
  Scenario scenario;
  scenario.duration_s = 0.02;  // five ticks
  scenario.vehicles[0].sensors.emplace_back(sensor_module_types(), "gas");
  scenario = validated(scenario);
  scenario.vehicles[0].sensors.front().as<GasConfig>() = config;
  return scenario;
}

std::uint64_t hash_with(const GasConfig& config) {
  Simulation simulation(sniffer(config));
  while (!simulation.finished()) simulation.tick();
  return simulation.state_hash();
}

TEST(OwnSamples, ReachTheSoftwareAndEveryRecorder) {
  const TemporaryDirectory folder;
  Scenario scenario = sniffer();
  scenario.recorders.emplace_back(recorder_module_types(), "csv").as<CsvConfig>().topics = {"gas"};
  scenario.recorders.emplace_back(recorder_module_types(), "mcap").as<McapConfig>().topics = {"gas"};
  Simulation simulation(scenario);
  simulation.attach_recorders(folder.path());
  while (!simulation.finished()) simulation.tick();
  const Observation& observation = simulation.view().observations[0];
  ASSERT_EQ(samples_of<GasSample>(observation).size(), 1U) << "those of the last tick";
  EXPECT_EQ(samples_of<GasSample>(observation)[0].concentration_ppm, 3.5);
  simulation.finish();
  EXPECT_THAT(read_whole_file(folder.path() / "csv/uav1/gas.csv"), StartsWith("t_s,concentration_ppm,cov_xx,"));
  EXPECT_THAT(read_whole_file(folder.path() / "csv/uav1/gas.csv"), HasSubstr("\n0.020000000,3.5,0,"));
  EXPECT_NE(read_whole_file(folder.path() / "record.mcap").find("/uav1/gas"), std::string::npos);
}

TEST(OwnSamples, EnterStateHashWithEveryField) {
  EXPECT_EQ(hash_with({}), hash_with({}));
  GasConfig stronger, hidden;
  stronger.concentration_ppm = 3.6;
  hidden.unseen = 1e-9;
  EXPECT_NE(hash_with(stronger), hash_with({}));
  EXPECT_NE(hash_with(hidden), hash_with({})) << "a field that no table shows";
}

TEST(OwnSamples, EndTheRunWhenNonFinite) {
  GasConfig broken;
  broken.unseen = std::numeric_limits<double>::infinity();
  try {
    hash_with(broken);
    FAIL();
  } catch (const ContractViolation& violation) {
    EXPECT_THAT(violation.what(), HasSubstr("sensor = \"gas\""));
  }
}

TEST(OwnSamples, AreCopiedWithTheObservation) {
  Observation one;
  samples_of<GasSample>(one).resize(2);
  Observation two = one;
  one.clear();
  EXPECT_TRUE(samples_of<GasSample>(one).empty());
  EXPECT_EQ(samples_of<GasSample>(two).size(), 2U);
  const Observation nothing;
  EXPECT_TRUE(samples_of<GasSample>(nothing).empty());
}

}  // namespace
}  // namespace swiftlet::sim
