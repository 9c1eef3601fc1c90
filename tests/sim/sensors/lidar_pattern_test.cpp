// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/lidar_pattern.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "sim/sensors/lidar_tiles.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

double elevation_deg(const Eigen::Vector3f& d) { return std::asin(static_cast<double>(d.z())) * kDegPerRad; }
double azimuth_deg(const Eigen::Vector3f& d) { return std::atan2(d.y(), d.x()) * kDegPerRad; }
double wrapped_deg(double angle) { return std::remainder(angle, 360.0); }

BeamTable beams_of(const Module& module, double sweep_s = 0.1, std::uint32_t sweep = 0) {
  BeamTable beams;
  make_lidar_pattern(module, sweep_s)->fill(sweep, beams);
  return beams;
}

template <class Config>
Module module_of(const char* type, const Config& config) {
  Module module(lidar_pattern_types(), type);
  module.as<Config>() = config;
  return module;
}

TEST(LidarPattern, HasUnitDirectionsAndSweepTimes) {
  for (const char* type : {"ouster", "livox_mid360", "velodyne_puck", "uniform"}) {
    for (const double sweep_s : {0.1, 0.05}) {
      const BeamTable beams = beams_of(Module(lidar_pattern_types(), type), sweep_s);
      ASSERT_EQ(beams.directions_lidar.size(), static_cast<std::size_t>(beams.size()));
      ASSERT_EQ(beams.origins_lidar.size(), static_cast<std::size_t>(beams.size()));
      ASSERT_EQ(beams.column_offset_s.size(), static_cast<std::size_t>(beams.cols));
      for (int i = 0; i < beams.size(); ++i) {
        ASSERT_NEAR(beams.directions_lidar[i].norm(), 1.0, 2e-6) << type << i;
        ASSERT_GE(beams.offset_s(i), 0.0) << type << i;
        ASSERT_LT(beams.offset_s(i), sweep_s) << type << i;
      }
    }
  }
}

TEST(LidarPattern, Os1MatchesItsDatasheet) {
  const BeamTable beams = beams_of(Module(lidar_pattern_types(), "ouster"));
  EXPECT_EQ(beams.rows, 128);
  EXPECT_EQ(beams.cols, 1024);
  EXPECT_EQ(beams.size() * 10, 1310720);  // points per second
  EXPECT_NEAR(elevation_deg(beams.directions_lidar[0]), 21.3, 1e-4);
  EXPECT_NEAR(elevation_deg(beams.directions_lidar[127 * 1024]), -21.8, 1e-4);
  // Rows 0..3 look 4.2, 1.4, -1.4, -4.2 deg clockwise of the encoder; the encoder of column c has turned c steps.
  for (const int c : {0, 1, 256, 1000}) {
    const double encoder_deg = 180.0 - 360.0 * c / 1024;
    for (int r = 0; r < 8; ++r) {
      const double offset_deg = std::array{4.2, 1.4, -1.4, -4.2}[r % 4];
      EXPECT_NEAR(wrapped_deg(azimuth_deg(beams.directions_lidar[r * 1024 + c]) - (encoder_deg - offset_deg)), 0.0,
                  1e-4);
      EXPECT_NEAR(beams.origins_lidar[r * 1024 + c].norm(), 0.015806, 1e-7);
      EXPECT_NEAR(wrapped_deg(azimuth_deg(beams.origins_lidar[r * 1024 + c]) - encoder_deg), 0.0, 1e-3);
    }
    EXPECT_NEAR(beams.column_offset_s[c], 0.1 * c / 1024, 1e-8);
  }
}

TEST(LidarPattern, ColumnShiftUndoesTheStaggering) {
  const Module module(lidar_pattern_types(), "ouster");
  const auto pattern = make_lidar_pattern(module, 0.1);
  // The maker's own table for 1024 columns.
  EXPECT_EQ(pattern->column_shift(0), 12);
  EXPECT_EQ(pattern->column_shift(1), 4);
  EXPECT_EQ(pattern->column_shift(2), -4);
  EXPECT_EQ(pattern->column_shift(7), -12);
  const BeamTable beams = beams_of(module);
  for (int r = 0; r < 128; ++r) {
    const int column = 500 - pattern->column_shift(r);
    EXPECT_NEAR(wrapped_deg(azimuth_deg(beams.directions_lidar[r * 1024 + column]) - 180.0 + 360.0 * 500 / 1024), 0.0,
                0.5 * 360.0 / 1024);
  }
}

TEST(LidarPattern, OusterSweepsStartAtRearConnector) {
  OusterConfig config;
  config.azimuths_deg = {0.0};
  const BeamTable beams = beams_of(module_of("ouster", config));
  EXPECT_NEAR(wrapped_deg(azimuth_deg(beams.directions_lidar[0]) - 180.0), 0.0, 1e-4);
  EXPECT_NEAR(azimuth_deg(beams.directions_lidar[512]), 0.0, 1e-4) << "half a turn later it looks forward";
  EXPECT_NEAR(azimuth_deg(beams.directions_lidar[256]), 90.0, 1e-4)
      << "the sweep turns clockwise from the rear over the left";
}

TEST(LidarPattern, FewerOusterRowsThinTheTable) {
  OusterConfig config;
  config.rows = 2;
  config.elevations_deg = {30.0, 10.0, -10.0, -30.0};
  config.azimuths_deg = {1.0, 2.0, 3.0, 4.0};
  const BeamTable beams = beams_of(module_of("ouster", config));
  EXPECT_NEAR(elevation_deg(beams.directions_lidar[0]), 30.0, 1e-4);
  EXPECT_NEAR(elevation_deg(beams.directions_lidar[1024]), -10.0, 1e-4);
  EXPECT_NEAR(wrapped_deg(azimuth_deg(beams.directions_lidar[1024]) - (180.0 - 3.0)), 0.0, 1e-4);
}

TEST(LidarPattern, Mid360CoversItsFieldOfView) {
  const Module module(lidar_pattern_types(), "livox_mid360");
  double lowest = 90, highest = -90;
  std::set<int> sectors;
  for (std::uint32_t sweep = 0; sweep < 10; ++sweep) {
    const BeamTable beams = beams_of(module, 0.1, sweep);
    ASSERT_EQ(beams.size(), 20000);
    ASSERT_EQ(beams.rows, 4);
    for (const auto& d : beams.directions_lidar) {
      lowest = std::min(lowest, elevation_deg(d));
      highest = std::max(highest, elevation_deg(d));
      sectors.insert(static_cast<int>(std::floor(azimuth_deg(d))));
    }
    EXPECT_NEAR(beams.column_offset_s[1], 20e-6, 1e-9);
  }
  EXPECT_NEAR(lowest, -7.2, 0.15);
  EXPECT_NEAR(highest, 52.2, 0.15);
  EXPECT_GE(sectors.size(), 360U);
}

TEST(LidarPattern, Mid360ContinuesWithoutRepetition) {
  const Module module(lidar_pattern_types(), "livox_mid360");
  const BeamTable first = beams_of(module, 0.1, 0);
  const BeamTable second = beams_of(module, 0.1, 1);
  const BeamTable both = beams_of(module, 0.2, 0);
  int same = 0;
  for (int line = 0; line < 4; ++line) {
    for (int c = 0; c < 5000; ++c) {
      const auto& a = first.directions_lidar[line * 5000 + c];
      const auto& b = second.directions_lidar[line * 5000 + c];
      EXPECT_LT((both.directions_lidar[line * 10000 + c] - a).norm(), 1e-5);
      EXPECT_LT((both.directions_lidar[line * 10000 + 5000 + c] - b).norm(), 1e-5);
      same += std::acos(std::min(1.0F, a.dot(b))) * kDegPerRad < 5.0 ? 1 : 0;
    }
  }
  EXPECT_LT(same, 200);  // 20000 shots per frame; successive frames are rotated by about 85 deg

  // Ever more of the sphere is seen: cells of 1 deg in the field of view that some shot of the first n frames met.
  std::set<std::pair<int, int>> cells;
  std::array<std::size_t, 10> seen{};
  for (std::uint32_t sweep = 0; sweep < 10; ++sweep) {
    for (const auto& d : beams_of(module, 0.1, sweep).directions_lidar) {
      cells.emplace(static_cast<int>(std::floor(azimuth_deg(d))), static_cast<int>(std::floor(elevation_deg(d))));
    }
    seen[sweep] = cells.size();
  }
  constexpr double kCells = 360.0 * 59.4;
  EXPECT_LT(seen[0], 0.7 * kCells);
  EXPECT_GT(seen[1], 1.2 * seen[0]);
  EXPECT_GT(seen[9], 0.98 * kCells);
}

TEST(LidarPattern, PuckFiresItsLasersInTurn) {
  const BeamTable beams = beams_of(Module(lidar_pattern_types(), "velodyne_puck"));
  EXPECT_EQ(beams.rows, 16);
  EXPECT_EQ(beams.cols, 1808);
  EXPECT_NEAR(beams.size() / 0.1, 289344.0, 0.001 * 289344.0);  // points per second by the manual
  for (int r = 0; r < 16; ++r) EXPECT_NEAR(elevation_deg(beams.directions_lidar[r * 1808]), 15.0 - 2.0 * r, 1e-4);
  // Laser 0 points to -15 deg, laser 1 to 1 deg, laser 2 to -13 deg ...
  const double order_deg[] = {-15, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15};
  for (int laser = 0; laser < 16; ++laser) {
    const int row = static_cast<int>(std::lround((15.0 - order_deg[laser]) / 2.0));
    EXPECT_NEAR(beams.offset_s(row * 1808 + 10), 10 * 55.296e-6 + laser * 2.304e-6, 1e-9);
    EXPECT_NEAR(wrapped_deg(azimuth_deg(beams.directions_lidar[row * 1808 + 10]) +
                            3600.0 * (10 * 55.296e-6 + laser * 2.304e-6)),
                0.0, 1e-4);
  }
  EXPECT_NEAR(beams.origins_lidar[0].z(), -0.0112, 1e-7);
  EXPECT_NEAR(beams.origins_lidar[15 * 1808].z(), 0.0112, 1e-7);
}

TEST(LidarPattern, UniformStepsEquallyOverDistinctColumns) {
  const BeamTable beams = beams_of(Module(lidar_pattern_types(), "uniform"));
  for (int r = 0; r < 128; ++r) {
    EXPECT_NEAR(elevation_deg(beams.directions_lidar[r * 1024]), 22.5 - r * 45.0 / 127, 1e-4);
  }
  for (int c = 0; c < 1024; ++c) {
    EXPECT_NEAR(wrapped_deg(azimuth_deg(beams.directions_lidar[c]) - 360.0 * c / 1024), 0.0, 1e-4);
  }
  UniformConfig narrow;
  narrow.columns = 3;
  narrow.rows = 1;
  narrow.fov_horizontal_deg = 40.0;
  narrow.elevation_center_deg = -10.0;
  const BeamTable three = beams_of(module_of("uniform", narrow));
  EXPECT_NEAR(azimuth_deg(three.directions_lidar[0]), -20.0, 1e-4);
  EXPECT_NEAR(azimuth_deg(three.directions_lidar[2]), 20.0, 1e-4);
  EXPECT_NEAR(elevation_deg(three.directions_lidar[1]), -10.0, 1e-4);
}

TEST(LidarPattern, UniformFullTurnsEndBeforeStart) {
  UniformConfig turn;
  turn.columns = 4;
  turn.rows = 1;
  for (const double fov_deg : {360.0, 359.0}) {
    turn.fov_horizontal_deg = fov_deg;
    const BeamTable beams = beams_of(module_of("uniform", turn), 0.2);
    for (int c = 0; c < 4; ++c) {
      const double expected_deg = fov_deg == 360.0 ? 90.0 * c : 359.0 / 3.0 * c - 179.5;
      EXPECT_NEAR(wrapped_deg(azimuth_deg(beams.directions_lidar[static_cast<std::size_t>(c)]) - expected_deg), 0.0,
                  1e-3);
      EXPECT_NEAR(beams.column_offset_s[static_cast<std::size_t>(c)], 0.05 * c, 1e-7);
    }
  }
}

CsvPatternConfig csv_config(const std::string& file) {
  CsvPatternConfig config;
  config.file = file;
  return config;
}

class CsvFile {
 public:
  explicit CsvFile(const std::string& text) : path_(folder_.path() / "pattern.csv") { std::ofstream(path_) << text; }
  Module module() const { return module_of("csv", csv_config(path_.string())); }

 private:
  TemporaryDirectory folder_;
  std::filesystem::path path_;
};

TEST(LidarPattern, CsvIsReadShotByShot) {
  const CsvFile file("azimuth_deg,elevation_deg,time_s\n0,0,0\n90,0,0.01\n# comment\n\n-45,30,0.02\r\n");
  const BeamTable beams = beams_of(file.module());
  ASSERT_EQ(beams.size(), 3);
  EXPECT_EQ(beams.rows, 1);
  EXPECT_NEAR(azimuth_deg(beams.directions_lidar[1]), 90.0, 1e-4);
  EXPECT_NEAR(elevation_deg(beams.directions_lidar[2]), 30.0, 1e-4);
  EXPECT_NEAR(beams.offset_s(2), 0.02, 1e-8);
}

TEST(LidarPattern, ReportsTheLineOfCsvErrors) {
  const auto message = [](const std::string& text) -> std::string {
    const CsvFile file(text);
    try {
      beams_of(file.module());
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const std::pair<const char*, const char*> refused[] = {
      {"0,0,0\nroot:x,0\n", ".csv:2: expected three numbers azimuth_deg,elevation_deg,time_s, found something else"},
      {"0,0,0\n1,2\n", ".csv:2:"},
      {"0,0,0\n1,2,0,5\n", ".csv:2:"},
      {"0,0,0\nnan,0,0\n", ".csv:2:"},
      {"0,0,0\n1;2;0\n", ".csv:2:"},
      {"a,b,c\nd,e,f\n", ".csv:2: expected three numbers azimuth_deg"},
      {"0,0,0.05\n1,2,0.01\n", "ascending"},
      {"0,0,0.2\n", "within the sweep"},
      {"0,0,-0.001\n", "within the sweep"},
      {"0,95,0\n", "-90..90"},
      {"0,-91,0\n", "-90..90"},
      {"azimuth,elevation,time\n", "at least one shot"},
  };
  for (const auto& [text, expected] : refused) EXPECT_NE(message(text).find(expected), std::string::npos) << text;
  EXPECT_EQ(message("0,90,0\n1,-90,0\n2,0,0.1\n3,0,0.1\n"), "") << "the ends are included, and two at one time";
  EXPECT_EQ(message("0,0,0\n1,+2.5e0,\t0.05 \r\n"), "") << "blanks, signs and powers of ten";
  EXPECT_THROW(beams_of(module_of("csv", csv_config("/nonexistent.csv"))), InputError);
}

TEST(LidarTiler, PutsEveryBeamIntoOneTile) {
  for (const auto& [type, widest_deg] : {std::pair{"ouster", 2.5}, std::pair{"velodyne_puck", 5.0},
                                         std::pair{"uniform", 2.5}, std::pair{"livox_mid360", 180.0}}) {
    const auto pattern = make_lidar_pattern(Module(lidar_pattern_types(), type), 0.1);
    BeamTable beams;
    pattern->fill(3, beams);
    LidarTiler tiler(*pattern, beams, true);
    std::vector<LidarTile> tiles;
    tiler.arrange(beams, tiles);
    std::vector<int> count(beams.size());
    for (LidarTile& tile : tiles) {
      tiler.load(beams, tile);
      for (int i = 0; i < kPacketSize; ++i) {
        if (tile.beam[i] < 0) continue;
        ++count[tile.beam[i]];
        const auto& d = beams.directions_lidar[tile.beam[i]];
        EXPECT_EQ(tile.beams.direction_y[i], d.y());
        if (tile.beam[0] < 0) continue;
        EXPECT_LT(std::acos(std::min(1.0F, d.dot(beams.directions_lidar[tile.beam[0]]))) * kDegPerRad, widest_deg)
            << type;
      }
    }
    for (const int n : count) ASSERT_EQ(n, 1) << type;
  }
}

TEST(LidarTiler, NamesTheFiringOfEveryBeam) {
  const auto pattern = make_lidar_pattern(Module(lidar_pattern_types(), "ouster"), 0.1);
  BeamTable beams;
  pattern->fill(0, beams);
  for (const bool by_column : {true, false}) {
    LidarTiler tiler(*pattern, beams, by_column);
    std::vector<LidarTile> tiles;
    tiler.arrange(beams, tiles);
    for (LidarTile& tile : tiles) {
      tiler.load(beams, tile);
      for (int i = 0; i < kPacketSize; ++i) {
        EXPECT_EQ(tile.beams.firing[i], by_column ? tile.beam[i] % 1024 : tile.beam[i]);
        const Eigen::Vector3f d(tile.beams.direction_x[i], tile.beams.direction_y[i], tile.beams.direction_z[i]);
        EXPECT_EQ(d, beams.directions_lidar[tile.beam[i]]);
      }
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
