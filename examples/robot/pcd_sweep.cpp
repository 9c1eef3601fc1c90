// SPDX-License-Identifier: BSD-3-Clause
#include "pcd_sweep.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace {

struct Field {
  std::string type;  // U, I or F
  std::size_t offset = 0, bytes = 0;
};

struct Header {
  std::map<std::string, Field> fields;  // including padding ("_")
  std::size_t point_bytes = 0, num_points = 0;
};

std::size_t whole_number(const std::string& word) {
  std::size_t number = 0;
  const char* const end = word.data() + word.size();
  const auto [at, problem] = std::from_chars(word.data(), end, number);
  if (problem != std::errc() || at != end || number > 1'000'000'000)
    throw std::runtime_error("expected a whole number, found " + word);
  return number;
}

// Computes type, size and offset of each field in a point from the lines FIELDS, SIZE, TYPE and COUNT.
void place_fields(std::map<std::string, std::vector<std::string>>& lines, Header& header) {
  const std::vector<std::string>& names = lines["FIELDS"];
  if (!lines.contains("COUNT")) lines["COUNT"].assign(names.size(), "1");
  for (const char* key : {"SIZE", "TYPE", "COUNT"}) {
    if (lines[key].size() != names.size())
      throw std::runtime_error(std::string("expected a value of ") + key + " for each field");
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::size_t bytes = whole_number(lines["SIZE"][i]);
    const std::size_t count = whole_number(lines["COUNT"][i]);
    if (count > 0) header.fields[names[i]] = {lines["TYPE"][i], header.point_bytes, bytes};
    header.point_bytes += bytes * count;
  }
}

Header read_header(std::istream& in) {
  std::map<std::string, std::vector<std::string>> lines;  // the words after the first of each line
  while (!lines.contains("DATA")) {
    std::string line, key;
    if (!std::getline(in, line)) throw std::runtime_error("expected a PCD file");
    std::istringstream words(line);
    words >> key;
    lines[key].assign(std::istream_iterator<std::string>(words), {});
  }
  if (lines["DATA"] != std::vector<std::string>{"binary"}) throw std::runtime_error("expected DATA binary");
  if (lines["POINTS"].size() != 1) throw std::runtime_error("expected POINTS with one number");
  Header header;
  header.num_points = whole_number(lines["POINTS"][0]);
  place_fields(lines, header);
  for (const char* axis : {"x", "y", "z"}) {
    const Field& field = header.fields[axis];
    if (field.type != "F" || (field.bytes != 4 && field.bytes != 8))
      throw std::runtime_error(std::string("expected a field ") + axis + " of TYPE F and SIZE 4 or 8");
  }
  const Field& time = header.fields["t"];
  if (time.type != "U" || time.bytes != 4)
    throw std::runtime_error("expected a field t of TYPE U and SIZE 4, in nanoseconds after the start of the sweep");
  return header;
}

template <class Number>
Number number_at(const char* bytes) {
  Number number;
  std::memcpy(&number, bytes, sizeof(number));
  return number;
}

}  // namespace

swiftlet::Scan read_sweep(const std::filesystem::path& file, swiftlet::TimeNs stamp, swiftlet::TimeNs duration) try {
  std::ifstream in(file, std::ios::binary);
  const Header header = read_header(in);
  std::vector<char> data(header.point_bytes * header.num_points);
  if (!in.read(data.data(), static_cast<std::streamsize>(data.size()))) throw std::runtime_error("it ends too early");

  // One column with one beam for each point, sorted by time.
  std::vector<std::size_t> order(header.num_points);
  std::iota(order.begin(), order.end(), 0);
  const auto bytes_of = [&](std::size_t i, const Field& field) { return &data[i * header.point_bytes + field.offset]; };
  const auto time_s = [&](std::size_t i) {
    return 1e-9 * number_at<std::uint32_t>(bytes_of(i, header.fields.at("t")));
  };
  const auto coordinate = [&](std::size_t i, const char* axis) {
    const Field& field = header.fields.at(axis);
    return field.bytes == 4 ? number_at<float>(bytes_of(i, field))
                            : static_cast<float>(number_at<double>(bytes_of(i, field)));
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return time_s(a) < time_s(b); });
  // Times in another unit would corrupt the motion compensation of the sweep.
  if (!order.empty() && time_s(order.back()) > 2.0 * swiftlet::to_seconds(duration)) {
    throw std::runtime_error("expected t in nanoseconds after the start of the sweep, found " +
                             std::to_string(time_s(order.back())) + " s in a sweep of " +
                             std::to_string(swiftlet::to_seconds(duration)) + " s");
  }
  auto beams = std::make_shared<swiftlet::BeamTable>();
  swiftlet::Scan scan;
  for (const std::size_t i : order) {
    const Eigen::Vector3f p_lidar_m(coordinate(i, "x"), coordinate(i, "y"), coordinate(i, "z"));
    const float range_m = p_lidar_m.norm();
    if (!(range_m > 0.0F)) continue;  // NaN: no return
    beams->directions_lidar.push_back(p_lidar_m / range_m);
    beams->origins_lidar.push_back(Eigen::Vector3f::Zero());
    beams->column_offset_s.push_back(static_cast<float>(time_s(i)));
    scan.range_m.push_back(range_m);
  }
  beams->rows = 1;
  beams->cols = static_cast<int>(scan.range_m.size());
  scan.sensor = "lidar";
  scan.stamp = stamp;
  scan.duration = duration;
  scan.range_max_m = 120.0;
  scan.sigma_range_m = 0.02;
  scan.intensity.assign(scan.range_m.size(), 0.0F);
  scan.reflectivity.assign(scan.range_m.size(), 0.0F);
  scan.beams = std::move(beams);
  return scan;
} catch (const std::runtime_error& error) {
  throw std::runtime_error(file.string() + ": " + error.what());
}
