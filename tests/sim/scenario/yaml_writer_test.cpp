// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/yaml_writer.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <limits>

#include "swiftlet/core/math/random.hpp"
#include "tests/sim/scenario/example_config.hpp"

namespace swiftlet::sim {
namespace {

std::string written(FleetConfig fleet) {
  return write_config([&](ConfigVisitor& v) { fleet.visit(v); });
}

FleetConfig read_back(const std::string& text) {
  FleetConfig fleet;
  const MemoryFiles files = example_files();
  read_config_text(
      text, "/in/fleet.yaml", [&](ConfigVisitor& v) { fleet.visit(v); }, {}, files);
  return fleet;
}

TEST(YamlWriter, WritesEveryKeyWithItsDefault) {
  FleetConfig fleet;
  fleet.boats.resize(1);
  fleet.boats[0].crew = {Module(pilot_types(), "sail")};
  EXPECT_EQ(written(fleet),
            "racing: false\n"
            "seed: 1\n"
            "title: fleet\n"
            "sky: clear\n"
            "chart: \"\"\n"
            "low: 0\n"
            "high: 1\n"
            "size_m: [10, 20]\n"
            "times_s: [1, 2, 3]\n"
            "tags: []\n"
            "buoys_m: []\n"
            "boats:\n"
            "  - model: \"\"\n"
            "    name: \"\"\n"
            "    rate_hz: 10\n"
            "    tilt_deg: 0\n"
            "    speed_mps: 1\n"
            "    drag_N_per_mps: 0.5\n"
            "    width_px: 640\n"
            "    position_m: [1, 2, 3]\n"
            "    noise:\n"
            "      sigma_range_m: 0.02\n"
            "      drop_probability: 0\n"
            "    crew:\n"
            "      - type: sail\n"
            "        area_m2: 12\n"
            "    drive:\n"
            "      type: engine\n"
            "      power_kW: 1.5\n"
            "      cylinders: 4\n");
}

TEST(YamlWriter, AnyTextComesBack) {
  for (const char* const text :
       {"",     " ",  "true", "null",      "~",    "1",   "0x1",   "a: b", "- a", "#no",
        "a #b", "'",  "\"",   "\\",        "\n\n", "\t",  "\x7F",  "[a]",  "{",   "*a",
        "&a",   "!a", "%",    "trailing ", "no",   "---", "C:\\x", ".inf", "<<",  "\xC2\x85"}) {
    FleetConfig fleet;
    fleet.title = text;
    fleet.tags = {text, "x", text};
    const FleetConfig back = read_back(written(fleet));
    EXPECT_EQ(back.title, text);
    EXPECT_EQ(back.tags, fleet.tags);
  }
}

TEST(YamlWriter, WritesNumbersThatRoundTripExactly) {
  const Random random(1, "test.yaml_writer");
  FleetConfig fleet;
  fleet.times_s = {
      0.1,  1.0 / 3.0,           5e-324, std::numeric_limits<double>::max(), std::numeric_limits<double>::min(),
      1e22, 123456789012345680.0};
  for (std::uint32_t i = 0; i < 20000; ++i) {
    // Any bit pattern of a positive finite double, then numbers of everyday size.
    const auto bits = (static_cast<std::uint64_t>(random.uniform(0, i) * 4294967296.0) << 32) |
                      static_cast<std::uint64_t>(random.uniform(1, i) * 4294967296.0);
    const double any = std::bit_cast<double>(bits & 0x7FFFFFFFFFFFFFFFU);
    if (std::isfinite(any)) fleet.times_s.push_back(any);
    fleet.times_s.push_back(random.uniform(2, i) * 1000.0);
  }
  const FleetConfig back = read_back(written(fleet));
  ASSERT_EQ(back.times_s.size(), fleet.times_s.size());
  for (std::size_t i = 0; i < fleet.times_s.size(); ++i) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(back.times_s[i]), std::bit_cast<std::uint64_t>(fleet.times_s[i]));
  }
  FleetConfig zero;
  zero.low = -0.0;
  EXPECT_TRUE(std::signbit(read_back(written(zero)).low));
}

/// A fleet in which every value is drawn.
FleetConfig random_fleet(std::uint32_t n) {
  const Random random(2, "test.random_fleet");
  std::uint32_t index = 0;
  const auto uniform = [&](double min, double max) { return min + (max - min) * random.uniform(n, index++); };
  const auto flip = [&] { return uniform(0, 1) < 0.5; };
  const auto count = [&](int most) { return static_cast<std::size_t>(uniform(0, most + 0.999)); };
  const auto vector = [&] { return Eigen::Vector3d(uniform(-9, 9), uniform(-9, 9), uniform(-9, 9)); };
  const auto drive = [&] {
    Module module(drive_types(), flip() ? "engine" : "sail");
    if (module.type == "sail") {
      module.as<SailConfig>().area_m2 = uniform(1, 9);
    } else {
      module.as<EngineConfig>().cylinders = static_cast<int>(uniform(1, 16));
    }
    return module;
  };

  FleetConfig fleet;
  fleet.racing = flip();
  fleet.seed = static_cast<std::uint64_t>(uniform(0, 1.8e19));
  fleet.sky = flip() ? "cloudy" : "overcast";
  fleet.low = uniform(-5, 0);
  fleet.high = uniform(0.1, 5);
  fleet.size_m = {uniform(1, 9), uniform(1, 9)};
  fleet.times_s.clear();
  for (std::size_t i = count(3); i > 0; --i) fleet.times_s.push_back(uniform(0, 9));
  for (std::size_t i = count(3); i > 0; --i) fleet.buoys_m.push_back(vector());
  fleet.boats.resize(count(3));
  for (std::size_t i = 0; i < fleet.boats.size(); ++i) {
    BoatConfig& boat = fleet.boats[i];
    if (flip()) boat.model = "dinghy";
    boat.name = "boat" + std::to_string(i);
    boat.position_m = vector();
    boat.noise.sigma_range_m = uniform(0, 1);
    boat.drive = drive();
    for (std::size_t k = count(3); k > 0; --k) {
      boat.crew.emplace_back(pilot_types(), flip() ? "pilot" : "sail");
      if (boat.crew.back().type != "pilot") continue;
      if (flip()) boat.crew.back().as<PilotConfig>().model = "ann";
      boat.crew.back().as<PilotConfig>().drive = drive();
    }
  }
  return fleet;
}

TEST(YamlWriter, RoundTripsItsOutput) {
  for (std::uint32_t n = 0; n < 300; ++n) {
    const std::string text = written(random_fleet(n));
    ASSERT_EQ(written(read_back(text)), text);
  }
}

TEST(YamlWriter, KeepsNameAndChangesOfAssets) {
  const std::string text =
      written(read_back("boats: [{model: dinghy, drive: {type: engine}, crew: []}, {model: own.yaml}]"));
  const FleetConfig back = read_back(text);
  EXPECT_EQ(written(back), text);
  EXPECT_EQ(back.boats[0].model, "dinghy");
  EXPECT_EQ(back.boats[0].rate_hz, 20.0);
  EXPECT_EQ(back.boats[0].drive.type, "engine");
  EXPECT_TRUE(back.boats[0].crew.empty());
  EXPECT_EQ(back.boats[1].model, "/in/own.yaml");
}

struct NothingConfig {
  void visit(ConfigVisitor&) {}
};

TEST(YamlWriter, ObjectsWithoutKeysAreMaps) {
  NothingConfig nothing;
  std::vector<NothingConfig> several(2);
  const auto visit = [&](ConfigVisitor& v) {
    v.object("nothing", nothing, "");
    v.list("several", several, "");
  };
  const std::string text = write_config(visit);
  EXPECT_EQ(text, "nothing: {}\nseveral:\n  - {}\n  - {}\n");
  EXPECT_NO_THROW(read_config_text(text, "x.yaml", visit, {}, example_files()));
}

}  // namespace
}  // namespace swiftlet::sim
