// SPDX-License-Identifier: BSD-3-Clause
// Usage: read_pcd FILE. Reads a PCD file with the Point Cloud Library and writes x, y, z and intensity of every point
// as float32 to standard output.
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <cstdio>
#include <iostream>

int main(int argc, char** argv) {
  pcl::PointCloud<pcl::PointXYZI> cloud;
  if (argc != 2 || pcl::io::loadPCDFile(argv[1], cloud) != 0) {
    std::cerr << "PCL cannot read it\n";
    return 1;
  }
  for (const auto& point : cloud) {
    const float row[4] = {point.x, point.y, point.z, point.intensity};
    std::fwrite(row, sizeof row, 1, stdout);
  }
  return std::fflush(stdout) == 0 ? 0 : 1;
}
