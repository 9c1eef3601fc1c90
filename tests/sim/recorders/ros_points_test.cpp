// SPDX-License-Identifier: BSD-3-Clause
// Point clouds, read back field by field as PointCloud2 describes itself.
#include "sim/recorders/ros_points.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "swiftlet/core/math/random.hpp"
#include "tests/sim/recorders/ros_reader.hpp"

namespace swiftlet::sim {
namespace {

/// A scan with gaps, dark and bright returns, whose rows may fire in succession.
Scan scan_of(int rows, int cols, bool rows_in_turn) {
  const Random random(static_cast<std::uint64_t>(rows * 1000 + cols), "test");
  auto beams = std::make_shared<BeamTable>();
  beams->rows = rows;
  beams->cols = cols;
  Scan scan;
  scan.sensor = "lidar";
  scan.stamp = 1'700'000'000;
  scan.duration = 100'000'000;
  for (int i = 0; i < rows * cols; ++i) {
    const auto n = static_cast<std::uint32_t>(i);
    Eigen::Vector3f v;
    for (std::uint32_t axis = 0; axis < 3; ++axis) v[axis] = static_cast<float>(random.normal(axis, n));
    beams->directions_lidar.push_back(v.normalized());
    beams->origins_lidar.push_back(0.03F * v);
    const bool hit = random.uniform(3, n) < 0.7;
    scan.range_m.push_back(hit ? static_cast<float>(random.uniform(0.5, 60.0, 4, n)) : 0.0F);
    scan.intensity.push_back(hit ? static_cast<float>(random.uniform(5, n)) : 0.0F);
    scan.reflectivity.push_back(hit ? static_cast<float>(std::pow(10.0, random.uniform(-2.0, 4.0, 6, n))) : 0.0F);
  }
  for (int column = 0; column < cols; ++column)
    beams->column_offset_s.push_back(0.09F * static_cast<float>(column) / static_cast<float>(cols));
  if (rows_in_turn) {
    for (int row = 0; row < rows; ++row) beams->row_offset_s.push_back(1e-5F * static_cast<float>(row * 3 % rows));
  }
  scan.beams = beams;
  return scan;
}

/// The cloud read by its own description.
struct Cloud {
  Cloud(const Scan& scan, PointsLayout layout, float step_m, RosDialect dialect = RosDialect::kRos2) {
    RosEncoder out(dialect);
    encode_points(scan, layout, step_m, 7, "uav/lidar", out);
    const RosReading read(full_definition(kPointCloud2, dialect), out.bytes(), dialect);
    width = static_cast<int>(read.number("width"));
    height = static_cast<int>(read.number("height"));
    step = static_cast<std::size_t>(read.number("point_step"));
    EXPECT_EQ(read.number("is_bigendian"), 0);
    EXPECT_EQ(read.number("is_dense"), 1);
    EXPECT_EQ(read.text("header.frame_id"), "uav/lidar");
    EXPECT_EQ(read.time("header.stamp"), scan.stamp);
    EXPECT_EQ(read.number("row_step"), static_cast<double>(step) * width);
    const std::string& data = read.text("data");
    EXPECT_EQ(data.size(), step * static_cast<std::size_t>(width * height));
    for (std::size_t i = 0; i < read.count("fields"); ++i) {
      const std::string field = "fields[" + std::to_string(i) + "]";
      EXPECT_EQ(read.number(field + ".count"), 1);
      const auto offset = static_cast<std::size_t>(read.number(field + ".offset"));
      const auto type = static_cast<int>(read.number(field + ".datatype"));
      const std::string& name = read.text(field + ".name");
      layout_of.emplace_back(name, offset, type);
      for (std::size_t at = 0; at + step <= data.size(); at += step) {
        if (i == 0) points.emplace_back();
        points[at / step][name] = value_of(type, data.data() + at + offset);
      }
    }
  }
  /// Constants of sensor_msgs/PointField: UINT8 2, UINT16 4, UINT32 6, FLOAT32 7, FLOAT64 8.
  static double value_of(int type, const char* at) {
    const auto as = [&](auto value) {
      std::memcpy(&value, at, sizeof value);
      return static_cast<double>(value);
    };
    switch (type) {
      case 2:
        return as(std::uint8_t{});
      case 4:
        return as(std::uint16_t{});
      case 6:
        return as(std::uint32_t{});
      case 7:
        return as(0.0F);
      case 8:
        return as(0.0);
      default:
        throw std::runtime_error("unknown type of field");
    }
  }

  int width = 0, height = 0;
  std::size_t step = 0;
  std::vector<std::tuple<std::string, std::size_t, int>> layout_of;  // name, offset, type
  std::vector<std::map<std::string, double>> points;
};

/// Beams in the order of their time; of one instant, by row.
std::vector<int> in_order_of_time(const Scan& scan) {
  std::vector<int> order(static_cast<std::size_t>(scan.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    const int column_a = a % scan.cols(), column_b = b % scan.cols();
    return column_a != column_b ? column_a < column_b : scan.beams->offset_s(a) < scan.beams->offset_s(b);
  });
  return order;
}

/// Expected position of one point in any layout.
std::map<std::string, double> place_of(const Scan& scan, int i, float step_m) {
  if (!scan.hit(i)) return {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}};
  Eigen::Vector3f p = scan.point_lidar(i);
  if (step_m > 0.0F) {
    for (float& value : p) value = std::round(value / step_m) * step_m;
  }
  return {{"x", p.x()}, {"y", p.y()}, {"z", p.z()}};
}

double since_start_ns(const Scan& scan, int i) { return static_cast<double>(scan.time_of(i) - scan.stamp); }
void expect_points(const Cloud& cloud, const std::vector<std::map<std::string, double>>& expected) {
  ASSERT_EQ(cloud.points.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    ASSERT_EQ(cloud.points[k].size(), expected[k].size());
    for (const auto& [name, value] : expected[k])
      EXPECT_NEAR(cloud.points[k].at(name), value, 1e-6 * std::abs(value)) << name << " of point " << k;
  }
}

class RosPointsOfScans : public ::testing::TestWithParam<std::tuple<int, bool, float>> {
 protected:
  const float step_m = std::get<2>(GetParam());
  const Scan scan = scan_of(std::get<0>(GetParam()), 5, std::get<1>(GetParam()));
};
INSTANTIATE_TEST_SUITE_P(Rows, RosPointsOfScans,
                         ::testing::Combine(::testing::Values(1, 4, 7), ::testing::Bool(),
                                            ::testing::Values(0.0F, 0.25F)));

TEST_P(RosPointsOfScans, OusterKeepsRowsWithZeroGaps) {
  const Cloud cloud(scan, PointsLayout::kOuster, step_m);
  EXPECT_EQ(cloud.layout_of, (decltype(cloud.layout_of){{"x", 0, 7},
                                                        {"y", 4, 7},
                                                        {"z", 8, 7},
                                                        {"intensity", 16, 7},
                                                        {"t", 20, 6},
                                                        {"reflectivity", 24, 4},
                                                        {"ring", 26, 4},
                                                        {"ambient", 28, 4},
                                                        {"range", 32, 6}}));
  EXPECT_EQ(cloud.step, 48U) << "aligned to 16 bytes, as PCL keeps such points";
  EXPECT_EQ(cloud.width, scan.cols());
  EXPECT_EQ(cloud.height, scan.rows());
  std::vector<std::map<std::string, double>> expected;
  for (int i = 0; i < scan.size(); ++i) {
    auto& point = expected.emplace_back(place_of(scan, i, step_m));
    point["t"] = since_start_ns(scan, i);
    point["ring"] = i / scan.cols();
    point["ambient"] = 0.0;
    point["intensity"] = static_cast<double>(scan.intensity[static_cast<std::size_t>(i)]);
    point["reflectivity"] = scan.hit(i) ? reflectivity_byte(scan.reflectivity[static_cast<std::size_t>(i)], 100) : 0.0;
    point["range"] = scan.hit(i) ? std::round(1000.0F * scan.range_from_axis_m(i)) : 0.0;
  }
  expect_points(cloud, expected);
}

TEST_P(RosPointsOfScans, LivoxOrdersOneRowByTime) {
  const Cloud cloud(scan, PointsLayout::kLivox, step_m);
  EXPECT_EQ(cloud.layout_of, (decltype(cloud.layout_of){{"x", 0, 7},
                                                        {"y", 4, 7},
                                                        {"z", 8, 7},
                                                        {"intensity", 12, 7},
                                                        {"tag", 16, 2},
                                                        {"line", 17, 2},
                                                        {"timestamp", 18, 8}}));
  EXPECT_EQ(cloud.step, 26U) << "packed";
  EXPECT_EQ(cloud.width, scan.size());
  EXPECT_EQ(cloud.height, 1);
  std::vector<std::map<std::string, double>> expected;
  for (const int i : in_order_of_time(scan)) {
    auto& point = expected.emplace_back(place_of(scan, i, step_m));
    point["intensity"] = scan.hit(i) ? reflectivity_byte(scan.reflectivity[static_cast<std::size_t>(i)], 150) : 0.0;
    point["tag"] = 0.0;
    point["line"] = i / scan.cols();
    point["timestamp"] = static_cast<double>(scan.time_of(i));
  }
  expect_points(cloud, expected);
  EXPECT_EQ(cloud.points.back().at("timestamp"), static_cast<double>(scan.time_of(in_order_of_time(scan).back())));
}

TEST_P(RosPointsOfScans, VelodyneSortsByTimeWithRings) {
  const Cloud cloud(scan, PointsLayout::kVelodyne, step_m);
  EXPECT_EQ(cloud.layout_of,
            (decltype(cloud.layout_of){
                {"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}, {"ring", 16, 4}, {"time", 18, 7}}));
  EXPECT_EQ(cloud.step, 22U) << "packed";
  EXPECT_EQ(cloud.height, 1);
  std::vector<std::map<std::string, double>> expected;
  for (const int i : in_order_of_time(scan)) {
    if (!scan.hit(i)) continue;
    auto& point = expected.emplace_back(place_of(scan, i, step_m));
    point["intensity"] = reflectivity_byte(scan.reflectivity[static_cast<std::size_t>(i)], 100);
    point["ring"] = scan.rows() - 1 - i / scan.cols();
    point["time"] = 1e-9 * since_start_ns(scan, i);
  }
  expect_points(cloud, expected);
}

TEST_P(RosPointsOfScans, SmallLayoutKeepsScanOrder) {
  const Cloud cloud(scan, PointsLayout::kSmall, step_m);
  EXPECT_EQ(cloud.layout_of, (decltype(cloud.layout_of){{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}}));
  EXPECT_EQ(cloud.step, 16U);
  EXPECT_EQ(cloud.height, 1);
  std::vector<std::map<std::string, double>> expected;
  for (int i = 0; i < scan.size(); ++i) {
    if (!scan.hit(i)) continue;
    expected.emplace_back(place_of(scan, i, step_m))["intensity"] =
        reflectivity_byte(scan.reflectivity[static_cast<std::size_t>(i)], 100);
  }
  expect_points(cloud, expected);
}

TEST(RosPoints, InferVendorFromRowCount) {
  const auto step_of = [](int rows) { return Cloud(scan_of(rows, 2, false), PointsLayout::kAuto, 0.0F).step; };
  for (const int rows : {1, 3, 5, 15, 17, 31, 33, 64, 128}) EXPECT_EQ(step_of(rows), 48U) << rows;
  EXPECT_EQ(step_of(4), 26U);
  EXPECT_EQ(step_of(16), 22U);
  EXPECT_EQ(step_of(32), 22U);
}

TEST(RosPoints, GiveFrozenScansOneInstant) {
  Scan scan = scan_of(4, 6, true);
  scan.duration = 0;
  for (const auto& point : Cloud(scan, PointsLayout::kLivox, 0.0F).points)
    EXPECT_EQ(point.at("timestamp"), static_cast<double>(scan.stamp));
  for (const auto& point : Cloud(scan, PointsLayout::kOuster, 0.0F).points) EXPECT_EQ(point.at("t"), 0.0);
}

}  // namespace
}  // namespace swiftlet::sim
