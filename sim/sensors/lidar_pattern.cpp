// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/lidar_pattern.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/elementary_lanes.hpp"
#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {
namespace {

constexpr float kRadPerDegF = static_cast<float>(kRadPerDeg);

Eigen::Vector3f direction(double azimuth_rad, double elevation_rad) {
  return Eigen::Vector3d(elementary::cos(elevation_rad) * elementary::cos(azimuth_rad),
                         elementary::cos(elevation_rad) * elementary::sin(azimuth_rad), elementary::sin(elevation_rad))
      .cast<float>();
}

void resize(int rows, int cols, BeamTable& beams) {
  beams.rows = rows;
  beams.cols = cols;
  beams.directions_lidar.resize(static_cast<std::size_t>(rows) * cols);
  beams.origins_lidar.resize(static_cast<std::size_t>(rows) * cols, Eigen::Vector3f::Zero());
  beams.column_offset_s.resize(cols);
}

// ---- Ouster ----

// [deg] Azimuth of the connector, at which column 0 and the sweep begin.
constexpr double kConnector_deg = 180.0;

/// The sensor's own arithmetic (Ouster firmware manual, "lidar data to XYZ"): encoder and beam azimuth both count
/// clockwise.
class Ouster final : public LidarPattern {
 public:
  Ouster(const OusterConfig& config, double sweep_s) : config_(config), sweep_s_(sweep_s) {}

  void fill(std::uint32_t /*sweep*/, BeamTable& beams) const override {
    resize(config_.rows, config_.columns, beams);
    for (int c = 0; c < beams.cols; ++c) {
      const double encoder = kConnector_deg * kRadPerDeg - 2.0 * kPi * c / beams.cols;
      beams.column_offset_s[c] = static_cast<float>(sweep_s_ * c / beams.cols);
      const Eigen::Vector3f origin = Eigen::Vector3d(config_.beam_origin_m * elementary::cos(encoder),
                                                     config_.beam_origin_m * elementary::sin(encoder), 0.0)
                                         .cast<float>();
      for (int r = 0; r < beams.rows; ++r) {
        const std::size_t i = static_cast<std::size_t>(r) * beams.cols + c;
        beams.directions_lidar[i] = direction(encoder - azimuth_deg(r) * kRadPerDeg, elevation_deg(r) * kRadPerDeg);
        beams.origins_lidar[i] = origin;
      }
    }
  }

  int column_shift(int row) const override {
    return static_cast<int>(std::lround(azimuth_deg(row) / 360.0 * config_.columns));
  }

 private:
  double azimuth_deg(int row) const {
    const std::size_t size = config_.azimuths_deg.size();
    if (size == 0) return 0.0;
    return config_.azimuths_deg[size == config_.elevations_deg.size() ? row * row_step() : row % size];
  }
  double elevation_deg(int row) const {
    if (!config_.elevations_deg.empty()) return config_.elevations_deg[row * row_step()];
    if (config_.rows == 1) return config_.elevation_top_deg;
    return config_.elevation_top_deg +
           row * (config_.elevation_bottom_deg - config_.elevation_top_deg) / (config_.rows - 1);
  }

  // Sensors with fewer rows use every second, fourth ... row of the table.
  std::size_t row_step() const { return config_.elevations_deg.size() / config_.rows; }

  OusterConfig config_;
  double sweep_s_;
};

// ---- Livox ----

// Beams fired at once, and [s] interval of the shots.
constexpr int kLivoxLines = 4;
constexpr double kLivoxStep_s = 20e-6;
constexpr double kLivoxPeriod = 4962.0;  // steps per period of the slow elevation sweep

class LivoxMid360 final : public LidarPattern {
 public:
  LivoxMid360(const LivoxMid360Config&, double sweep_s)
      : steps_(static_cast<int>(std::lround(sweep_s / kLivoxStep_s))) {}

  void fill(std::uint32_t sweep, BeamTable& beams) const override {
    resize(kLivoxLines, steps_, beams);
    for (int k = 0; k < steps_; ++k) beams.column_offset_s[k] = static_cast<float>(k * kLivoxStep_s);
    for (int k = 0; k < steps_; k += 4) fire(static_cast<double>(sweep) * steps_, k, beams);
  }
  bool repeats() const override { return false; }
  bool is_image() const override { return false; }

 private:
  using Four = std::array<float, 4>;
  struct SinCos {
    Four sin, cos;
  };
  static SinCos sincos_of(const Four& angle_rad) {
    const auto [sine, cosine] = sincos(Lanes4d{angle_rad[0], angle_rad[1], angle_rad[2], angle_rad[3]});
    SinCos result;
    for (int i = 0; i < 4; ++i) {
      result.sin[i] = static_cast<float>(sine[i]);
      result.cos[i] = static_cast<float>(cosine[i]);
    }
    return result;
  }

  // Four shots of each line, from this column on. Least-squares fit to 60 shots of a public table, all angles in
  // degrees: a small circle of four beams moves on a fast circle, whose axis slowly sweeps the elevation.
  void fire(double first_step, int column, BeamTable& beams) const {
    std::array<double, 4> s;
    Four phi, zenith_center, zenith_center_rad, azimuth_center, psi, depth, width;
    for (int i = 0; i < 4; ++i) {
      s[i] = first_step + (column + i);
      phi[i] = static_cast<float>(remainder(s[i], kLivoxPeriod) * (2.0 * kPi / kLivoxPeriod));
    }
    const SinCos of_phi = sincos_of(phi);
    for (int i = 0; i < 4; ++i) {
      const float cos_phi = of_phi.cos[i], sin_phi = of_phi.sin[i];
      zenith_center[i] = 68.12F - 26.10F * cos_phi + sin_phi * sin_phi * (1.95F + 9.48F * cos_phi);
      zenith_center_rad[i] = zenith_center[i] * kRadPerDegF;
      const double turned = 1.31299 * s[i] - 0.03581 * (kLivoxPeriod / (2.0 * kPi)) * sin_phi;
      azimuth_center[i] = static_cast<float>(remainder(269.0 - turned, 360.0)) * kRadPerDegF;
      psi[i] = static_cast<float>(remainder(1.002 * turned, 360.0)) * kRadPerDegF;
    }
    const SinCos of_psi = sincos_of(psi), of_center = sincos_of(zenith_center_rad);
    for (int i = 0; i < 4; ++i) {
      const float cos_phi = of_phi.cos[i], sin2 = of_phi.sin[i] * of_phi.sin[i], cos2 = cos_phi * cos_phi;
      depth[i] = (1.387F + 1.019F * cos2 * cos2 + 0.402F * cos2 * cos_phi) * of_psi.cos[i];
      width[i] = (1.427F + 0.710F * sin2) * of_psi.sin[i] / of_center.sin[i];
    }
    for (int line = 0; line < kLivoxLines; ++line) {
      const float u = static_cast<float>(line) - 1.5F;
      Four zenith, azimuth;
      for (int i = 0; i < 4; ++i) {
        zenith[i] = (zenith_center[i] + u * depth[i]) * kRadPerDegF;
        azimuth[i] = azimuth_center[i] - u * width[i] * kRadPerDegF;
      }
      const SinCos of_zenith = sincos_of(zenith), of_azimuth = sincos_of(azimuth);
      for (int i = 0; i < std::min(4, steps_ - column); ++i) {
        const float across = of_zenith.sin[i];
        beams.directions_lidar[static_cast<std::size_t>(line) * beams.cols + column + i] = {
            across * of_azimuth.cos[i], across * of_azimuth.sin[i], of_zenith.cos[i]};
      }
    }
  }

  // As std::remainder: exact, but without its loop, for x below 2^50 periods.
  static double remainder(double x, double period) {
    double rest = std::fma(-std::rint(x / period), period, x);
    if (std::abs(rest) > 0.5 * period) rest -= std::copysign(period, rest);
    return std::copysign(std::abs(rest), rest == 0.0 ? x : rest);
  }

  int steps_;
};

// ---- Velodyne ----

// Lasers, [s] interval of their shots, and [s] cycle of all lasers with the recharge.
constexpr int kPuckLasers = 16;
constexpr double kPuckShot_s = 2.304e-6;
constexpr double kPuckCycle_s = 55.296e-6;

class VelodynePuck final : public LidarPattern {
 public:
  VelodynePuck(const VelodynePuckConfig&, double sweep_s)
      : sweep_s_(sweep_s), cycles_(static_cast<int>(sweep_s / kPuckCycle_s)) {}

  void fill(std::uint32_t /*sweep*/, BeamTable& beams) const override {
    // Even-numbered lasers point down, odd-numbered ones up; the shot's height (mm) corrects for the curved optics.
    constexpr std::array<double, 8> kHeight_mm = {0.7, 2.2, 3.7, 5.1, 6.6, 8.1, 9.7, 11.2};
    resize(kPuckLasers, cycles_, beams);
    beams.row_offset_s.resize(kPuckLasers);
    for (int r = 0; r < kPuckLasers; ++r) {
      const int elevation_deg = 15 - 2 * r;
      const int laser = elevation_deg > 0 ? elevation_deg : 15 + elevation_deg;
      const double height_m = (elevation_deg > 0 ? -1e-3 : 1e-3) * kHeight_mm[std::abs(elevation_deg) / 2];
      beams.row_offset_s[r] = static_cast<float>(laser * kPuckShot_s);
      for (int c = 0; c < cycles_; ++c) {
        const double offset_s = c * kPuckCycle_s + laser * kPuckShot_s;
        const std::size_t i = static_cast<std::size_t>(r) * cycles_ + c;
        beams.directions_lidar[i] = direction(-2.0 * kPi * offset_s / sweep_s_, elevation_deg * kRadPerDeg);
        beams.origins_lidar[i] = {0.0F, 0.0F, static_cast<float>(height_m)};
      }
    }
    for (int c = 0; c < cycles_; ++c) beams.column_offset_s[c] = static_cast<float>(c * kPuckCycle_s);
  }

 private:
  double sweep_s_;
  int cycles_;
};

// ---- uniform ----

class Uniform final : public LidarPattern {
 public:
  Uniform(const UniformConfig& config, double sweep_s) : config_(config), sweep_s_(sweep_s) {}

  void fill(std::uint32_t /*sweep*/, BeamTable& beams) const override {
    resize(config_.rows, config_.columns, beams);
    // A full turn ends one step before its start (in the papers' simulator, first and last column coincide).
    const bool full_turn = config_.fov_horizontal_deg >= 360.0;
    const double steps = full_turn ? config_.columns : std::max(config_.columns - 1, 1);
    const double first_deg = full_turn || config_.columns == 1 ? 0.0 : -0.5 * config_.fov_horizontal_deg;
    const double step_elevation_deg = config_.rows > 1 ? config_.fov_vertical_deg / (config_.rows - 1) : 0.0;
    const double top_deg = config_.elevation_center_deg + 0.5 * step_elevation_deg * (config_.rows - 1);
    for (int c = 0; c < beams.cols; ++c) {
      const double azimuth_deg = first_deg + config_.fov_horizontal_deg * c / steps;
      beams.column_offset_s[c] = static_cast<float>(sweep_s_ * c / beams.cols);
      for (int r = 0; r < beams.rows; ++r) {
        beams.directions_lidar[static_cast<std::size_t>(r) * beams.cols + c] =
            direction(azimuth_deg * kRadPerDeg, (top_deg - r * step_elevation_deg) * kRadPerDeg);
      }
    }
  }

 private:
  UniformConfig config_;
  double sweep_s_;
};

// ---- CSV ----

/// The fewest digits that parse to the same number, in any locale.
std::string text_of(double value) {
  std::array<char, 32> digits;
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

class CsvPattern final : public LidarPattern {
 public:
  CsvPattern(const CsvPatternConfig& config, double sweep_s) { read(config.file, sweep_s); }

  void fill(std::uint32_t /*sweep*/, BeamTable& beams) const override {
    resize(1, static_cast<int>(directions_.size()), beams);
    beams.directions_lidar = directions_;
    beams.column_offset_s = offsets_s_;
  }
  bool is_image() const override { return false; }

 private:
  /// Parses azimuth, elevation and time: three comma-separated numbers with optional blanks.
  static std::optional<std::array<double, 3>> shot_of(std::string_view line) {
    std::array<double, 3> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t end = i + 1 < values.size() ? line.find(',') : line.size();
      if (end == std::string_view::npos) return std::nullopt;
      std::string_view word = line.substr(0, end);
      word.remove_prefix(std::min(word.find_first_not_of(" \t"), word.size()));
      if (word.starts_with('+')) word.remove_prefix(1);
      while (word.ends_with(' ') || word.ends_with('\t')) word.remove_suffix(1);
      const auto [stop, problem] = std::from_chars(word.data(), word.data() + word.size(), values[i]);
      if (problem != std::errc() || stop != word.data() + word.size()) return std::nullopt;
      line.remove_prefix(std::min(end + 1, line.size()));
    }
    return values;
  }

  void read(const std::string& path, double sweep_s) {
    std::ifstream in(path);
    if (!in) throw InputError(path + ": cannot be read");
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (line.empty() || line[0] == '#') continue;
      const auto shot = shot_of(line);
      if (!shot) {
        if (directions_.empty() && number == 1) continue;  // a header
        // The line is not quoted: the file may be of another kind.
        throw InputError(path + ":" + std::to_string(number) +
                         ": expected three numbers azimuth_deg,elevation_deg,time_s, found something else");
      }
      const auto [azimuth_deg, elevation_deg, time_s] = *shot;
      const auto fail = [&](const std::string& expected) {
        throw InputError(path + ":" + std::to_string(number) + ": expected " + expected + ", found \"" +
                         line.substr(0, 60) + "\"");
      };
      if (!std::isfinite(azimuth_deg) || !(std::abs(elevation_deg) <= 90.0)) fail("an elevation in -90..90 deg");
      if (!(time_s >= 0.0 && time_s <= sweep_s)) fail("a time within the sweep, 0.." + text_of(sweep_s) + " s");
      if (!offsets_s_.empty() && static_cast<float>(time_s) < offsets_s_.back()) fail("times in ascending order");
      directions_.push_back(direction(azimuth_deg * kRadPerDeg, elevation_deg * kRadPerDeg));
      offsets_s_.push_back(static_cast<float>(time_s));
    }
    if (directions_.empty()) throw InputError(path + ": expected at least one shot, found none");
  }

  std::vector<Eigen::Vector3f> directions_;
  std::vector<float> offsets_s_;
};

template <class Pattern, class Config>
std::unique_ptr<LidarPattern> make(const ModuleConfig& config, double sweep_s) {
  return std::make_unique<Pattern>(dynamic_cast<const Config&>(config), sweep_s);
}

constexpr LidarPatternType kPatterns[] = {
    {{"ouster", "spinning columns of beams with staggered azimuths", make_module_config<OusterConfig>},
     make<Ouster, OusterConfig>},
    {{"livox_mid360", "non-repetitive scan of the Livox Mid-360", make_module_config<LivoxMid360Config>},
     make<LivoxMid360, LivoxMid360Config>},
    {{"velodyne_puck", "16 lasers fired in turn (Puck, Puck LITE)", make_module_config<VelodynePuckConfig>},
     make<VelodynePuck, VelodynePuckConfig>},
    {{"uniform", "equal steps in elevation and azimuth", make_module_config<UniformConfig>},
     make<Uniform, UniformConfig>},
    {{"csv", "azimuth, elevation and time of every shot from a file", make_module_config<CsvPatternConfig>},
     make<CsvPattern, CsvPatternConfig>},
};

Registry<LidarPatternType>& patterns() {
  static Registry<LidarPatternType> table("LiDAR pattern", kPatterns);
  return table;
}

}  // namespace

void OusterConfig::visit(ConfigVisitor& v) {
  v.field("columns", columns, "[-] firings per turn: 512, 1024 or 2048", Range::between(16, 8192));
  v.field("rows", rows, "[-] beams per firing", Range::between(1, 256));
  v.field("elevation_top_deg", elevation_top_deg, "[deg] elevation of the first row", Range::between(-90, 90));
  v.field("elevation_bottom_deg", elevation_bottom_deg, "[deg] elevation of the last row, with equal steps between",
          Range::between(-90, 90));
  v.field("elevations_deg", elevations_deg, "[deg] explicit elevation of every row, top to bottom; empty: equal steps",
          Range::between(-90, 90));
  v.field("azimuths_deg", azimuths_deg,
          "[deg] azimuth of the beams relative to the encoder, clockwise; repeats over the rows",
          Range::between(-180, 180));
  v.field("beam_origin_m", beam_origin_m, "[m] distance of the beams' origin from the axis", Range::non_negative());
  v.check(rows < 1 || elevations_deg.size() % rows == 0, "elevations_deg",
          "as many elevations as rows, or a multiple of which every second, third ... row is taken");
}

void LivoxMid360Config::visit(ConfigVisitor&) {}

void VelodynePuckConfig::visit(ConfigVisitor&) {}

void UniformConfig::visit(ConfigVisitor& v) {
  v.field("columns", columns, "[-] firings per sweep", Range::between(1, 16384));
  v.field("rows", rows, "[-] beams per firing", Range::between(1, 4096));
  v.field("fov_vertical_deg", fov_vertical_deg, "[deg] elevation angle between the first and the last row",
          Range::between(0, 180));
  v.field("elevation_center_deg", elevation_center_deg, "[deg] elevation of the middle of the rows",
          Range::between(-90, 90));
  v.field("fov_horizontal_deg", fov_horizontal_deg,
          "[deg] horizontal field of view; 360: a full turn from +x; less: symmetric to +x",
          Range{0.0, 360.0, true, false});
}

void CsvPatternConfig::visit(ConfigVisitor& v) {
  v.file("file", file, "lines of azimuth_deg,elevation_deg,time_s in ascending time");
}

std::span<const ModuleType> lidar_pattern_types() { return patterns().modules(); }

std::unique_ptr<LidarPattern> make_lidar_pattern(const Module& config, double sweep_s) {
  return patterns().make(config, sweep_s);
}

}  // namespace swiftlet::sim
