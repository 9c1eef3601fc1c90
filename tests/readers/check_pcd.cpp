// SPDX-License-Identifier: BSD-3-Clause
// Usage: check_pcd DIR. Reads the PCD files of write_recordings with the Point Cloud Library and compares every value.
#include <pcl/PCLPointCloud2.h>
#include <pcl/io/pcd_io.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

namespace {

using nlohmann::json;

int num_failures = 0;
int num_compared = 0;

void expect(bool ok, const std::string& what) {
  ++num_compared;
  if (ok) return;
  if (++num_failures < 20) std::cerr << "differs: " << what << "\n";
}

template <class Number>
Number value(const pcl::PCLPointCloud2& cloud, const std::string& name, std::size_t point) {
  for (const auto& field : cloud.fields) {
    if (field.name != name) continue;
    if (pcl::getFieldSize(field.datatype) != sizeof(Number)) throw std::runtime_error("size of field " + name);
    Number number;
    std::memcpy(&number, &cloud.data[point * cloud.point_step + field.offset], sizeof number);
    return number;
  }
  throw std::runtime_error("no field " + name);
}

Eigen::Vector3d vector_of(const json& v) { return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()}; }
Eigen::Isometry3d pose_of(const json& pose) {
  const json& q = pose["q"];
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(q[3].get<double>(), q[0].get<double>(), q[1].get<double>(), q[2].get<double>())
                   .toRotationMatrix();
  T.translation() = vector_of(pose["p"]);
  return T;
}

void check_point(const pcl::PCLPointCloud2& cloud, std::size_t point, const json& scan, int i, bool world,
                 const std::string& file) {
  const int cols = scan["cols"];
  const std::string where = file + " beam " + std::to_string(i);
  const bool hit = scan["range"][i].get<float>() > 0.0F;
  const Eigen::Vector3d found(value<float>(cloud, "x", point), value<float>(cloud, "y", point),
                              value<float>(cloud, "z", point));
  if (hit) {
    Eigen::Vector3d p =
        vector_of(scan["origins"][i]) + scan["range"][i].get<double>() * vector_of(scan["directions"][i]);
    const json& poses = scan["T_world_lidar"];
    if (world) p = pose_of(poses.size() == 1 ? poses[0] : poses[i % cols]) * p;
    expect((found - p).norm() < 5e-6, where + " position");
  } else {
    expect(std::isnan(found.x()) && std::isnan(found.y()) && std::isnan(found.z()), where + " empty return");
  }
  expect(value<float>(cloud, "intensity", point) == scan["intensity"][i].get<float>(), where + " intensity");
  expect(value<float>(cloud, "reflectivity", point) == scan["reflectivity"][i].get<float>(), where + " reflectivity");
  expect(value<std::uint16_t>(cloud, "ring", point) == i / cols, where + " ring");
  expect(value<std::uint32_t>(cloud, "column", point) == static_cast<unsigned>(i % cols), where + " column");
  const double firing_s =
      scan["column_offset_s"][i % cols].get<double>() + scan["row_offset_s"][i / cols].get<double>();
  const double offset_s = scan["duration_ns"] == 0 ? 0.0 : firing_s;
  expect(std::abs(value<std::uint32_t>(cloud, "t", point) - offset_s * 1e9) <= 1.0, where + " t");
  expect(value<std::uint16_t>(cloud, "class", point) == scan["class"][i], where + " class");
  expect(value<std::uint16_t>(cloud, "instance", point) == scan["instance"][i], where + " instance");
  expect(value<std::uint8_t>(cloud, "part", point) == scan["part"][i], where + " part");
  expect(value<float>(cloud, "range_true", point) == scan["range_true"][i].get<float>(), where + " range_true");
  expect(value<float>(cloud, "incidence", point) == scan["incidence"][i].get<float>(), where + " incidence");
}

void check_scan(const std::string& file, const json& scan, bool organized) {
  pcl::PCLPointCloud2 cloud;
  if (pcl::io::loadPCDFile(file, cloud) != 0) throw std::runtime_error("PCL cannot read " + file);
  const int rows = scan["rows"], cols = scan["cols"];
  std::size_t point = 0;
  for (int i = 0; i < rows * cols; ++i) {
    if (!organized && scan["range"][i].get<float>() == 0.0F) continue;
    check_point(cloud, point++, scan, i, !organized, file);
  }
  expect(point == static_cast<std::size_t>(cloud.width) * cloud.height, file + " number of points");
  expect(cloud.height == (organized ? static_cast<unsigned>(rows) : 1U), file + " height");
}

// The file holds only occupied voxels.
void check_map(const std::string& file, const json& map) {
  pcl::PCLPointCloud2 cloud;
  if (pcl::io::loadPCDFile(file, cloud) != 0) throw std::runtime_error("PCL cannot read " + file);
  std::size_t point = 0;
  for (const json& voxel : map["voxels"]) {
    if (voxel[3] < map["occupied_from"]) continue;
    const std::string where = file + " voxel " + std::to_string(point);
    for (int k = 0; k < 3; ++k) {
      const char* const names[] = {"x", "y", "z"};
      expect(value<float>(cloud, names[k], point) == voxel[k].get<float>(), where + " position");
    }
    expect(value<std::uint8_t>(cloud, "state", point) == voxel[3], where + " state");
    const float found = value<float>(cloud, "value", point);
    expect(voxel[4].is_string() ? std::isinf(found) : found == voxel[4].get<float>(), where + " value");
    ++point;
  }
  expect(point == cloud.width && point > 0, file + " number of voxels");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::string directory = argv[1];
  const json expected = json::parse(std::ifstream(directory + "/expected.json"));
  std::map<std::string, int> num_files;
  for (const json& tick : expected["ticks"]) {
    for (std::size_t v = 0; v < tick["vehicles"].size(); ++v) {
      for (const json& scan : tick["vehicles"][v]["scans"]) {
        const std::string stream = expected["vehicles"][v].get<std::string>() + "_" + scan["sensor"].get<std::string>();
        char name[32];
        std::snprintf(name, sizeof name, "/%06d.pcd", num_files[stream]++);
        check_scan(directory + "/scans_organized/" + stream + name, scan, true);
        check_scan(directory + "/scans/" + stream + name, scan, false);
      }
    }
  }
  for (const json& map : expected["maps"]) {
    if (map["name"] == "detector") check_map(directory + "/maps/uav1_detector_end.pcd", map);
  }
  std::cout << "PCL read " << num_compared << " values in " << num_files.size() << " streams, " << num_failures
            << " differ\n";
  return num_failures == 0 && num_compared > 10000 ? 0 : 1;
}
