// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numbers>

#include "tests/support/synthetic_run.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

template <class Number>
Number number_at(const ByteBuffer& bytes, std::size_t offset) {
  Number value;
  std::memcpy(&value, bytes.bytes().data() + offset, sizeof value);
  return value;
}

class FrameTest : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  SyntheticRun run{directory.path()};
  std::shared_ptr<LabeledScan> scan = run.make_scan("os1", run.make_beams(8, 16), 1'000, true);
  ContentConfig content;
  Frame frame;
};

TEST_F(FrameTest, StoresReturnsInThePublishedLayout) {
  encode_frame(*scan, content, frame);
  std::size_t k = 0;
  for (int i = 0; i < scan->scan.size(); ++i) {
    if (!scan->scan.hit(i)) continue;
    const Eigen::Vector3f p = scan->scan.point_lidar(i);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(number_at<float>(frame.velodyne, 16 * k + 4 * static_cast<std::size_t>(axis)), p[axis]);
    }
    EXPECT_EQ(number_at<float>(frame.velodyne, 16 * k + 12), scan->scan.reflectivity[i]);
    const auto label = number_at<std::uint32_t>(frame.labels, 4 * k);
    EXPECT_EQ(label & 0xFFFF, scan->truth.surface_class[i]);
    EXPECT_EQ(label >> 16, scan->truth.instance[i]);
    EXPECT_EQ(number_at<std::uint32_t>(frame.point_truth, 16 * k), scan->scan.time_of(i) - scan->scan.stamp);
    EXPECT_EQ(number_at<std::uint16_t>(frame.point_truth, 16 * k + 4), i / 16);
    EXPECT_EQ(number_at<std::uint16_t>(frame.point_truth, 16 * k + 6), i % 16);
    EXPECT_EQ(number_at<float>(frame.point_truth, 16 * k + 8), scan->truth.range_m[i]);
    EXPECT_EQ(number_at<float>(frame.point_truth, 16 * k + 12), scan->truth.incidence_rad[i]);
    ++k;
  }
  EXPECT_EQ(static_cast<std::size_t>(frame.num_points), k);
  EXPECT_EQ(frame.velodyne.size(), 16 * k);
  EXPECT_EQ(frame.labels.size(), 4 * k);
  EXPECT_EQ(frame.point_truth.size(), 16 * k);
}

TEST_F(FrameTest, StoresRawIntensityOnRequest) {
  content.remission = ContentConfig::Remission::kIntensity;
  encode_frame(*scan, content, frame);
  EXPECT_EQ(number_at<float>(frame.velodyne, 12), scan->scan.intensity[0]);
}

TEST_F(FrameTest, DeskewsPointsToTheSweepStart) {
  content.deskew = true;
  encode_frame(*scan, content, frame);
  std::size_t k = 0;
  for (int i = 0; i < scan->scan.size(); ++i) {
    if (!scan->scan.hit(i)) continue;
    const Vector3 p_world =
        scan->truth.T_world_lidar[static_cast<std::size_t>(i % 16)] * scan->scan.point_lidar(i).cast<double>();
    const Vector3 expected = scan->truth.T_world_lidar[0].inverse() * p_world;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(number_at<float>(frame.velodyne, 16 * k + 4 * static_cast<std::size_t>(axis)), expected[axis], 2e-5);
    }
    ++k;
  }
}

TEST_F(FrameTest, ImagesHoldRangeAndIntensityUnits) {
  content.range_unit_m = 0.004;
  content.intensity_unit = 0.001;
  std::vector<std::uint16_t> range, intensity;
  encode_images(*scan, content, range, intensity);
  for (int i = 0; i < scan->scan.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!scan->scan.hit(i)) {
      EXPECT_EQ(range[k], 0);
      EXPECT_EQ(intensity[k], 0);
      continue;
    }
    // The maker counts from the axis, the beam from its origin.
    const Eigen::Vector3f& origin_m = scan->scan.beams->origins_lidar[k];
    EXPECT_NEAR(0.004 * range[k], scan->scan.range_m[i] + std::hypot(origin_m.x(), origin_m.y()), 0.0021);
    EXPECT_NEAR(0.001 * intensity[k], scan->scan.intensity[i], 0.00051);
  }
  for (const auto& [range_m, gray] : {std::pair(1e-4F, 1), std::pair(40000.0F, 65535)}) {
    std::fill(scan->scan.range_m.begin(), scan->scan.range_m.end(), range_m);
    content.range_unit_m = 0.5;
    encode_images(*scan, content, range, intensity);
    EXPECT_EQ(range[0], gray) << "a return is never 0, which stands for none";
  }
}

TEST_F(FrameTest, RowTimesDifferUnlessFrozen) {
  auto beams = std::make_shared<BeamTable>(*scan->scan.beams);
  for (int row = 0; row < 8; ++row) beams->row_offset_s.push_back(1e-5F * static_cast<float>(row));
  scan->scan.beams = beams;
  for (const bool frozen : {false, true}) {
    if (frozen) scan->scan.duration = 0;
    encode_frame(*scan, content, frame);
    std::size_t k = 0;
    for (int i = 0; i < scan->scan.size(); ++i) {
      if (!scan->scan.hit(i)) continue;
      const TimeNs t = scan->scan.time_of(i) - scan->scan.stamp;
      EXPECT_EQ(number_at<std::uint32_t>(frame.point_truth, 16 * k++), t);
      EXPECT_EQ(t == 0, frozen || i == 0);
    }
  }
}

TEST(Frames, HaveAtMost65536RowsAndColumns) {
  for (const auto& [rows, cols, fits] : {std::tuple(65536, 1, true), std::tuple(1, 65536, true),
                                         std::tuple(65537, 1, false), std::tuple(1, 65537, false)}) {
    auto beams = std::make_shared<BeamTable>();
    beams->rows = rows;
    beams->cols = cols;
    beams->column_offset_s.assign(static_cast<std::size_t>(cols), 0.0F);
    LabeledScan scan;
    scan.scan.beams = beams;
    scan.scan.range_m.assign(static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols), 0.0F);
    Frame frame;
    if (fits) {
      EXPECT_NO_THROW(encode_frame(scan, ContentConfig(), frame));
      EXPECT_EQ(frame.num_points, 0);
    } else {
      EXPECT_THROW(encode_frame(scan, ContentConfig(), frame), std::runtime_error);
    }
  }
}

TEST(PixelShift, UndoesTheStaggeringOfRows) {
  for (const double direction : {-1.0, 1.0}) {  // an Ouster turns clockwise
    BeamTable beams;
    beams.rows = 5;
    beams.cols = 180;
    const std::vector<int> shifts = {0, 3, -2, 20, -20};
    for (const int shift : shifts) {
      for (int column = 0; column < 180; ++column) {
        const double azimuth = (179.0 + direction * 2.0 * (column + shift)) * std::numbers::pi / 180.0;
        beams.directions_lidar.emplace_back(std::cos(azimuth), std::sin(azimuth), 0.0);
      }
    }
    EXPECT_EQ(pixel_shift_by_row(beams), shifts) << direction;
  }
}

}  // namespace
}  // namespace swiftlet::sim
