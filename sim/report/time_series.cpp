// SPDX-License-Identifier: BSD-3-Clause
#include "sim/report/time_series.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <set>
#include <string_view>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

const double kNotThere = std::nan("");

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> words;
  for (std::size_t i = 0; i <= line.size();) {
    const std::size_t end = std::min(line.find(separator, i), line.size());
    if (separator != ' ' || end > i) words.push_back(line.substr(i, end - i));
    i = end + 1;
  }
  return words;
}

double number(std::string_view word) {
  double value = kNotThere;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() ? value : kNotThere;
}

/// Distance between two triples of columns; empty when one is missing.
std::vector<double> distance(const NumberTable& table, const char* prefix) {
  const std::string p = prefix;
  std::vector<double> squares;
  for (const char* axis : {"x_m", "y_m", "z_m"}) {
    const auto* a = table.find(axis);
    const auto* b = table.find(p + axis);
    if (a == nullptr || b == nullptr) return {};
    squares.resize(a->size(), 0.0);
    for (std::size_t i = 0; i < a->size(); ++i) squares[i] += ((*a)[i] - (*b)[i]) * ((*a)[i] - (*b)[i]);
  }
  for (double& square : squares) square = std::sqrt(square);
  return squares;
}

std::vector<double> column(const NumberTable& table, const std::string& name) {
  const auto* found = table.find(name);
  return found == nullptr ? std::vector<double>{} : *found;
}

void add_position(VehicleSeries& series, const NumberTable& table) {
  series.t_s = column(table, "t_s");
  series.x_m = column(table, "x_m");
  series.y_m = column(table, "y_m");
  series.z_m = column(table, "z_m");
}

/// Throws when columns are missing, as in a damaged file.
void require_position(const NumberTable& table, const fs::path& file) {
  for (const char* name : {"t_s", "x_m", "y_m", "z_m"}) {
    if (table.find(name) == nullptr)
      throw InputError(file.string() + ": expected a table with a column " + name + ", found none");
  }
}

VehicleSeries from_csv(const fs::path& file, std::size_t most) {
  const NumberTable table = read_number_table(file, ',', most);
  require_position(table, file);
  VehicleSeries series;
  add_position(series, table);
  const auto x = column(table, "vx_mps"), y = column(table, "vy_mps"), z = column(table, "vz_mps");
  for (std::size_t i = 0; i < std::min({x.size(), y.size(), z.size()}); ++i)
    series.speed_mps.push_back(std::hypot(x[i], y[i], z[i]));
  series.clearance_m = column(table, "clearance_m");
  series.estimate_error_m = distance(table, "est_");
  series.tracking_error_m = distance(table, "ref_");
  return series;
}

/// Value of a column at a time, interpolated between adjacent rows.
double at(const NumberTable& table, const std::vector<double>& values, double t_s) {
  const std::vector<double>& t = *table.find("t_s");
  const auto after = std::lower_bound(t.begin(), t.end(), t_s);
  if (after == t.end()) return kNotThere;
  const auto i = static_cast<std::size_t>(after - t.begin());
  if (*after == t_s) return values[i];
  if (i == 0) return kNotThere;
  const double part = (t_s - t[i - 1]) / (t[i] - t[i - 1]);
  return values[i - 1] + part * (values[i] - values[i - 1]);
}

VehicleSeries from_tum(const fs::path& truth_file, const fs::path& estimate_file, std::size_t most) {
  VehicleSeries series;
  const NumberTable truth = read_number_table(truth_file, ' ', most);
  require_position(truth, truth_file);
  add_position(series, truth);
  const std::size_t n = series.t_s.size();
  series.speed_mps.assign(n, kNotThere);
  for (std::size_t i = 1; i < n; ++i) {
    const double length_m = std::hypot(series.x_m[i] - series.x_m[i - 1], series.y_m[i] - series.y_m[i - 1],
                                       series.z_m[i] - series.z_m[i - 1]);
    series.speed_mps[i] = length_m / (series.t_s[i] - series.t_s[i - 1]);
  }
  if (!fs::is_regular_file(estimate_file)) return series;
  const NumberTable estimate = read_number_table(estimate_file, ' ', static_cast<std::size_t>(-1));
  require_position(estimate, estimate_file);
  const auto *x = estimate.find("x_m"), *y = estimate.find("y_m"), *z = estimate.find("z_m");
  for (std::size_t i = 0; i < n; ++i) {
    const double t = series.t_s[i];
    series.estimate_error_m.push_back(std::hypot(
        at(estimate, *x, t) - series.x_m[i], at(estimate, *y, t) - series.y_m[i], at(estimate, *z, t) - series.z_m[i]));
  }
  return series;
}

std::set<std::string> names_in(const fs::path& folder, bool folders) {
  std::set<std::string> names;
  if (!fs::is_directory(folder)) return names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string file = entry.path().filename().string();
    if (folders && entry.is_directory()) names.insert(file);
    if (!folders && file.ends_with(".tum") && !file.ends_with(".estimate.tum"))
      names.insert(entry.path().stem().string());
  }
  return names;
}

}  // namespace

const std::vector<double>* NumberTable::find(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? nullptr : &columns[static_cast<std::size_t>(found - names.begin())];
}

NumberTable read_number_table(const fs::path& file, char separator, std::size_t most) {
  std::ifstream stream = open_to_read(file);
  NumberTable table;
  std::string line;
  std::getline(stream, line);
  std::string_view head = line;
  while (head.starts_with('#') || head.starts_with(' ')) head.remove_prefix(1);
  for (const std::string_view name : split(head, separator)) table.names.emplace_back(name);
  std::vector<std::string> lines;
  while (std::getline(stream, line)) {
    if (!line.empty() && line.front() != '#') lines.push_back(line);
  }
  table.columns.resize(table.names.size());
  const std::size_t stride = most == 0 ? 1 : std::max<std::size_t>(1, (lines.size() + most - 1) / most);
  for (std::size_t i = 0; i < lines.size(); i += stride) {
    const auto words = split(lines[i], separator);
    for (std::size_t c = 0; c < table.columns.size(); ++c)
      table.columns[c].push_back(c < words.size() ? number(words[c]) : kNotThere);
  }
  return table;
}

std::vector<VehicleSeries> read_time_series(const fs::path& run_directory, std::size_t most) {
  std::vector<VehicleSeries> all;
  const fs::path csv = run_directory / "csv", tum = run_directory / "trajectories";
  std::set<std::string> names = names_in(csv, true);
  names.merge(names_in(tum, false));
  for (const std::string& name : names) {
    VehicleSeries series;
    if (const fs::path file = csv / name / "state.csv"; fs::is_regular_file(file)) {
      series = from_csv(file, most);
    } else if (const fs::path truth = tum / (name + ".tum"); fs::is_regular_file(truth)) {
      series = from_tum(truth, tum / (name + ".estimate.tum"), most);
    } else {
      continue;
    }
    series.name = name;
    all.push_back(std::move(series));
  }
  return all;
}

}  // namespace swiftlet::sim
