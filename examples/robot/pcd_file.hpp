// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// Points of a PCD file by field. Of a field with several values per point the first one is kept.
struct PcdPoints {
  struct Column {
    bool is_whole_number = false;  ///< TYPE I or U
    std::vector<double> values;    ///< one for each point
  };
  std::map<std::string, Column> columns;  ///< name of the field to its values, without padding ("_")
};

/// Reads a PCD file: DATA ascii, binary or binary_compressed, fields of any TYPE, SIZE and COUNT in any order.
/// Throws std::runtime_error with what was expected and found.
PcdPoints read_pcd(const std::filesystem::path& file);
