// SPDX-License-Identifier: BSD-3-Clause
#include "sim/scenario/changes.hpp"

#include <gtest/gtest.h>

#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"
#include "swiftlet/sim/scenario/yaml_writer.hpp"

namespace swiftlet::sim {
namespace {

struct Holder {
  ConfigChanges changes;
  void visit(ConfigVisitor& v) { v.changes("set", changes, "[-] changes"); }
};

ConfigChanges read_changes(const std::string& text) {
  Holder holder;
  read_config_text(text, "test.yaml", [&](ConfigVisitor& v) { holder.visit(v); });
  return holder.changes;
}

Scenario scenario_with(const ConfigChanges& changes) {
  Scenario scenario;
  read_config_text(
      "{name: x, vehicles: [{name: a}, {name: b}]}", "base.yaml", [&](ConfigVisitor& v) { scenario.visit(v); },
      changes);
  return scenario;
}

TEST(Changes, SplitAMapWithTypeFirst) {
  const ConfigChanges expected = {{"world.type", "forest"},
                                  {"world.size_m", "[70, 70]"},
                                  {"wind.gusts", "true"},
                                  {"vehicles[b].name", "\"two: words\""},
                                  // A map for an element comes after the plain keys, as in a scenario.
                                  {"vehicles[0].start.yaw_deg", "90"}};
  EXPECT_EQ(read_changes("set:\n  world: {size_m: [70, 70], type: forest}\n  wind.gusts: true\n"
                         "  vehicles[0]: {start: {yaw_deg: 90}}\n  vehicles[b].name: 'two: words'\n"),
            expected);
}

TEST(Changes, ActLikeTheMapItself) {
  const std::string text =
      "{world: {type: forest, size_m: [70, 60]}, vehicles[*]: {start: {yaw_deg: 0.5 rad}}, "
      "recorders: [{type: tum}, {type: pcd, every: 3}], description: \"a 'b' \\\"c\\\": # d\"}";
  Scenario whole;
  read_config_text("{name: x, vehicles: [{name: a}, {name: b}]}", "base.yaml",
                   [&](ConfigVisitor& v) { whole.visit(v); },
                   {{"vehicles[*].start.yaw_deg", "0.5 rad"},
                    {"world", "{type: forest, size_m: [70, 60]}"},
                    {"recorders", "[{type: tum}, {type: pcd, every: 3}]"},
                    {"description", "\"a 'b' \\\"c\\\": # d\""}});
  const Scenario split = scenario_with(read_changes("set: " + [&] {
    std::string quoted = text;  // `vehicles[*]` is no plain key between braces
    quoted.replace(quoted.find("vehicles[*]"), 11, "\"vehicles[*]\"");
    return quoted;
  }()));
  EXPECT_EQ(write_scenario(split), write_scenario(whole));
  EXPECT_NEAR(split.vehicles[1].start.yaw_deg, 28.6479, 1e-3);
}

TEST(Changes, RoundTripThroughText) {
  Holder holder;
  holder.changes = {
      {"a.b", "1"}, {"vehicles[0].c", "[1, {d: \"x y: z\"}]"}, {"e", "20 cm"}, {std::string(100, 'k'), "long"}};
  EXPECT_EQ(read_changes(write_config([&](ConfigVisitor& v) { holder.visit(v); })), holder.changes);
  holder.changes.clear();
  EXPECT_EQ(read_changes(write_config([&](ConfigVisitor& v) { holder.visit(v); })), holder.changes);
}

TEST(Changes, AnythingButAMapIsRefused) {
  EXPECT_THROW(read_changes("set: [1, 2]"), InputError);
  EXPECT_THROW(read_changes("set: fast"), InputError);
}

TEST(Changes, SeparateWorldSeedFromTheRun) {
  Scenario scenario;
  scenario.seed = 5;
  EXPECT_EQ(scenario.seed_of_world(), 5U);
  scenario.world_seed = 9;
  EXPECT_EQ(scenario.seed_of_world(), 9U);
}

}  // namespace
}  // namespace swiftlet::sim
