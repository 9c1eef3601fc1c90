// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace swiftlet::sim {

/// Where configuration, assets and the files they name come from. A test or fuzzer may give its own.
class ConfigFiles {
 public:
  virtual ~ConfigFiles() = default;
  virtual bool is_file(const std::filesystem::path& path) const = 0;
  /// Contents of a file; throws std::runtime_error with path and reason.
  virtual std::string read(const std::filesystem::path& path) const = 0;
  /// Names (with extension) in a folder, sorted; empty when there is no such folder.
  virtual std::vector<std::string> list(const std::filesystem::path& folder) const = 0;
  /// Searched in this order for assets/<folder>/<name>.yaml and for the files that assets name.
  virtual std::vector<std::filesystem::path> asset_roots() const = 0;
  /// Searched in this order for the scenarios that `base:` names.
  virtual std::vector<std::filesystem::path> scenario_roots() const = 0;
};

/// The file system. Assets are looked for in this order:
/// - the folders in the environment variable SWIFTLET_ASSETS, separated by colons;
/// - share/swiftlet/assets beside the folder of the running program, when it is installed;
/// - the source tree;
/// - where the library was installed.
const ConfigFiles& system_files();

}  // namespace swiftlet::sim
