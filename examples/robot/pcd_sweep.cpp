// SPDX-License-Identifier: BSD-3-Clause
#include "pcd_sweep.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>
#include <stdexcept>

namespace {

struct Header {
  std::map<std::string, std::size_t> offset;  // of each field within a point
  std::size_t point_bytes = 0, num_points = 0;
};

Header read_header(std::istream& in) {
  Header header;
  std::vector<std::string> fields;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string key, value;
    words >> key;
    if (key == "FIELDS") {
      while (words >> value) fields.push_back(value);
    } else if (key == "SIZE") {
      for (const std::string& field : fields) {
        std::size_t bytes = 0;
        words >> bytes;
        header.offset[field] = header.point_bytes;
        header.point_bytes += bytes;
      }
    } else if (key == "POINTS") {
      words >> header.num_points;
    } else if (key == "DATA") {
      words >> value;
      if (value != "binary") throw std::runtime_error("expected DATA binary, found " + value);
      return header;
    }
  }
  throw std::runtime_error("expected a PCD file");
}

template <class Number>
Number number_at(const char* point, std::size_t offset) {
  Number number;
  std::memcpy(&number, point + offset, sizeof(number));
  return number;
}

}  // namespace

swiftlet::Scan read_sweep(const std::filesystem::path& file, swiftlet::TimeNs stamp, swiftlet::TimeNs duration) try {
  std::ifstream in(file, std::ios::binary);
  const Header header = read_header(in);
  for (const char* field : {"x", "y", "z", "t"}) {
    if (!header.offset.contains(field)) throw std::runtime_error(std::string("expected a field ") + field);
  }
  std::vector<char> data(header.point_bytes * header.num_points);
  if (!in.read(data.data(), static_cast<std::streamsize>(data.size()))) throw std::runtime_error("it ends too early");

  // A column of one beam for each point, in the order of their times.
  std::vector<std::size_t> order(header.num_points);
  std::iota(order.begin(), order.end(), 0);
  const auto time_s = [&](std::size_t i) {
    return 1e-9 * number_at<std::uint32_t>(&data[i * header.point_bytes], header.offset.at("t"));
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return time_s(a) < time_s(b); });
  auto beams = std::make_shared<swiftlet::BeamTable>();
  swiftlet::Scan scan;
  for (const std::size_t i : order) {
    const char* point = &data[i * header.point_bytes];
    const Eigen::Vector3f p_lidar_m(number_at<float>(point, header.offset.at("x")),
                                    number_at<float>(point, header.offset.at("y")),
                                    number_at<float>(point, header.offset.at("z")));
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
