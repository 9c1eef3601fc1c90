// SPDX-License-Identifier: BSD-3-Clause
// Kinds of data: one `visit` that names each field.
#include "swiftlet/core/base/fields.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/finite.hpp"
#include "swiftlet/core/base/observation.hpp"
#include "tests/support/field_coverage.hpp"

namespace swiftlet {
namespace {

using ::testing::ElementsAre;

struct Gust {
  enum class Side { kLeft, kRight };
  TimeNs t = 0;
  bool known = true;
  VehicleId vehicle = kNoVehicle;
  Vector3 v_world_mps = Vector3::Zero();
  Pose T_world_gust = Pose::Identity();
  Matrix6 covariance = Matrix6::Identity();
  Side side = Side::kRight;
  int count = 0;
  std::string note;

  static void visit(auto& g, auto& v) {
    static constexpr const char* kSides[] = {"left", "right"};
    v.time("t_s", g.t, "[s] when");
    v.valid("known", g.known, "[-] is it known?");
    v.vehicle("vehicle", g.vehicle, "[-] who met it");
    v.field("v*_mps", g.v_world_mps, "[m/s] in world axes");
    v.field("*", g.T_world_gust, "[m, -] pose");
    v.covariance("cov_*_m2", g.covariance, "[m^2] of the position");
    v.choice("side", g.side, kSides, "[-] from where");
    v.field("count", g.count, "[-] so far");
    v.field("note", g.note, "[-] more");
  }
};

struct Forgetful {
  TimeNs t = 0;
  double height_m = 0.0;
  bool crashed = false;

  static void visit(auto& f, auto& v) {
    v.time("t_s", f.t, "[s] when");
    v.field("height_m", f.height_m, "[m] above ground");
  }
};

std::vector<std::string> names_of(const std::vector<Column>& columns) {
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  return names;
}

/// The fields of a row as text.
class TextRow final : public ColumnSink {
 public:
  void time(const ColumnName&, TimeNs t) override { values.push_back(std::to_string(t) + "ns"); }
  void number(const ColumnName&, double value) override { values.push_back(std::to_string(value)); }
  void integer(const ColumnName&, std::int64_t value) override { values.push_back(std::to_string(value)); }
  void flag(const ColumnName&, bool value) override { values.push_back(value ? "yes" : "no"); }
  void text(const ColumnName&, std::string_view value) override { values.emplace_back(value); }
  void vehicle(const ColumnName&, VehicleId id) override { values.push_back("vehicle " + std::to_string(id)); }
  void missing(const ColumnName&) override { values.emplace_back("missing"); }
  std::vector<std::string> values;
};

TEST(Fields, NamesColumnsByFieldAndUnit) {
  EXPECT_THAT(names_of(columns_of<Gust>()),
              ElementsAre("t_s", "vehicle", "vx_mps", "vy_mps", "vz_mps", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw",
                          "cov_xx_m2", "cov_xy_m2", "cov_xz_m2", "cov_yy_m2", "cov_yz_m2", "cov_zz_m2", "side", "count",
                          "note"));
}

TEST(Fields, ListsRowValuesInColumnOrder) {
  Gust gust;
  gust.t = 5;
  gust.vehicle = 2;
  gust.v_world_mps = {1, 2, 3};
  gust.T_world_gust.translation() = Vector3(4, 5, 6);
  gust.covariance(0, 2) = 0.5;
  gust.note = "hello";
  TextRow row;
  put_columns(gust, row);
  EXPECT_EQ(row.values.size(), columns_of<Gust>().size());
  EXPECT_THAT(std::vector(row.values.begin(), row.values.begin() + 6),
              ElementsAre("5ns", "vehicle 2", "1.000000", "2.000000", "3.000000", "4.000000"));
  EXPECT_EQ(row.values[14], "0.500000");
  EXPECT_THAT(std::vector(row.values.end() - 3, row.values.end()), ElementsAre("right", "0", "hello"));
}

TEST(Fields, MarksValuesAfterAnUnknownMissing) {
  Gust gust;
  gust.known = false;
  TextRow row;
  put_columns(gust, row);
  EXPECT_EQ(row.values[0], "0ns");
  for (std::size_t i = 1; i < row.values.size(); ++i) EXPECT_EQ(row.values[i], "missing") << i;
}

TEST(Fields, APrefixStandsBeforeEveryName) {
  ColumnList list;
  put_columns(Reference{}, list, "ref_");
  EXPECT_EQ(list.columns().front().name, "ref_x_m");
  EXPECT_EQ(list.columns().back().name, "ref_yaw_rate_radps");
}

TEST(Fields, BeginsEachColumnDescriptionWithUnit) {
  const Observation nothing;
  Observation::each_samples(nothing, []<class Sample>(const std::vector<Sample>&) {
    for (const Column& column : columns_of<Sample>()) {
      EXPECT_EQ(column.doc.front(), '[') << Sample::kName << " " << column.name;
      EXPECT_NE(column.doc.find("] "), std::string::npos) << Sample::kName << " " << column.name;
    }
  });
}

// Hash, tables, bytes: all come from `visit`, so nothing may be missing there.
TEST(Fields, VisitsEveryByteExceptPadding) {
  const Observation nothing;
  Observation::each_samples(
      nothing, []<class Sample>(const std::vector<Sample>&) { EXPECT_TRUE(forgets<Sample>(0)) << Sample::kName; });
  EXPECT_TRUE(forgets<Detection>(0));
  EXPECT_TRUE(forgets<Track>(0));
  EXPECT_TRUE(forgets<RelativeEstimate>(0));
  EXPECT_TRUE(forgets<StateEstimate>(0));
  EXPECT_TRUE(forgets<Reference>(0));
  EXPECT_TRUE(forgets<Message>(0));
  EXPECT_TRUE(forgets<StampedPose>(0));
  EXPECT_TRUE(forgets<Gust>(0));
}

TEST(Fields, VisitsScansExceptTheirBeamTable) { EXPECT_TRUE(forgets<Scan>(static_cast<int>(sizeof(Scan::beams)))); }

TEST(Fields, DetectsAForgottenField) { EXPECT_TRUE(forgets<Forgetful>(1)); }

TEST(Fields, FindsAnyNonFiniteNumber) {
  const auto is_found = [](const auto& spoil) {
    Gust gust;
    spoil(gust);
    return !is_finite(gust);
  };
  EXPECT_FALSE(is_found([](Gust& g) { g.count = 7; }));
  EXPECT_TRUE(is_found([](Gust& g) { g.v_world_mps.z() = std::nan(""); }));
  EXPECT_TRUE(is_found([](Gust& g) { g.T_world_gust.translation().x() = HUGE_VAL; }));
  EXPECT_TRUE(is_found([](Gust& g) { g.T_world_gust.linear()(2, 1) = std::nan(""); }));
  EXPECT_TRUE(is_found([](Gust& g) { g.covariance(5, 4) = -HUGE_VAL; }));
}

TEST(Observation, ClearEmptiesEverySampleList) {
  Observation observation;
  Observation::each_samples(observation, [](auto& samples) { samples.emplace_back(); });
  observation.clear();
  Observation::each_samples(observation, [](const auto& samples) { EXPECT_TRUE(samples.empty()); });
}

TEST(Observation, SamplesAreFoundByTheirKind) {
  Observation observation;
  observation.compass.emplace_back().yaw_rad = 0.25;
  EXPECT_EQ(samples_of<CompassSample>(observation).front().yaw_rad, 0.25);
  EXPECT_TRUE(samples_of<ImuSample>(observation).empty());
}

}  // namespace
}  // namespace swiftlet
