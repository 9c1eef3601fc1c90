// SPDX-License-Identifier: BSD-3-Clause
#include "records_file.hpp"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "swiftlet/core/localization/imu_check.hpp"

namespace {

using namespace swiftlet;

/// Lines of a text file, and errors that name the present one.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& file) : file_(file), in_(file) {
    if (!in_) throw std::runtime_error(file.string() + ": expected a file, found none");
  }
  bool next(std::string& line) {
    ++number_;
    return static_cast<bool>(std::getline(in_, line));
  }
  [[noreturn]] void reject(const std::string& problem) const {
    throw std::runtime_error(file_.string() + ":" + std::to_string(number_) + ": " + problem);
  }
  double number(const std::string& word) const {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    while (*end == ' ' || *end == '\r') ++end;
    if (end == word.c_str() || *end != '\0') reject("expected a number, found \"" + word + "\"");
    return value;
  }
  /// Cells of the next line of a CSV file; empty at its end.
  std::vector<std::string> next_row(std::size_t num_cells) {
    std::string line;
    if (!next(line) || line.empty()) return {};
    std::vector<std::string> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    if (row.size() < num_cells)
      reject("expected " + std::to_string(num_cells) + " cells, found " + std::to_string(row.size()));
    return row;
  }
  void require_order(TimeNs before, TimeNs t) const {
    if (t < before)
      reject("expected a time from " + std::to_string(to_seconds(before)) + " s on, found " +
             std::to_string(to_seconds(t)) + " s");
  }

 private:
  std::filesystem::path file_;
  std::ifstream in_;
  int number_ = 0;
};

}  // namespace

std::vector<SweepFile> read_index(const std::filesystem::path& folder) {
  Lines lines(folder / "pcd_index.csv");
  std::string header;
  lines.next(header);
  std::vector<SweepFile> sweeps;
  for (auto row = lines.next_row(3); !row.empty(); row = lines.next_row(3)) {
    const TimeNs stamp = from_seconds(lines.number(row[1]));
    if (!sweeps.empty()) lines.require_order(sweeps.back().stamp, stamp);
    sweeps.push_back({folder / row[0], stamp, from_seconds(lines.number(row[2]))});
  }
  return sweeps;
}

std::vector<ImuSample> read_imu(const std::filesystem::path& file) {
  Lines lines(file);
  std::string header;
  lines.next(header);
  std::vector<ImuSample> samples;
  ImuCheck check;
  for (auto row = lines.next_row(7); !row.empty(); row = lines.next_row(7)) {
    const auto vector = [&](std::size_t i) {
      return Vector3(lines.number(row[i]), lines.number(row[i + 1]), lines.number(row[i + 2]));
    };
    const TimeNs t = from_seconds(lines.number(row[0]));
    if (!samples.empty()) lines.require_order(samples.back().t, t);
    samples.push_back({t, vector(1), vector(4)});
    check.add(samples.back());
    if (!check.fault().empty()) lines.reject(check.fault());
  }
  return samples;
}

Pose read_mount(const std::filesystem::path& file) {
  constexpr double kTolerance = 1e-3;  // relative; above the rounding of printed digits
  constexpr double kReach_m = 10.0;    // largest distance from the body; larger ones are usually in millimeters
  Lines lines(file);
  std::vector<double> numbers;
  for (std::string line; lines.next(line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) numbers.push_back(lines.number(word));
  }
  if (numbers.size() == 12) numbers.insert(numbers.end(), {0.0, 0.0, 0.0, 1.0});
  if (numbers.size() != 16)
    lines.reject("expected a matrix of 3 x 4 or 4 x 4 numbers, found " + std::to_string(numbers.size()));
  Pose T_body_lidar = Pose::Identity();
  T_body_lidar.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  const Matrix3 R = T_body_lidar.linear();
  const bool is_rotation = R.determinant() > 0.0 && (R * R.transpose()).isApprox(Matrix3::Identity(), kTolerance);
  if (!is_rotation || T_body_lidar.matrix().row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0))
    lines.reject("expected a rotation and a translation, above a row of 0 0 0 1");
  if (!(T_body_lidar.translation().norm() < kReach_m)) lines.reject("expected a translation in meters");
  return T_body_lidar;
}
