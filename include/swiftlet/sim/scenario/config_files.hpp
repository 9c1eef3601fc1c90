// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace swiftlet::sim {

/// Source of configuration, assets and the files they name. Tests and fuzzers may provide their own.
class ConfigFiles {
 public:
  virtual ~ConfigFiles() = default;
  virtual bool is_file(const std::filesystem::path& path) const = 0;
  /// Contents of a file; throws std::runtime_error with path and reason.
  virtual std::string read(const std::filesystem::path& path) const = 0;
  /// Names (with extension) in a folder, sorted; empty when the folder does not exist.
  virtual std::vector<std::string> list(const std::filesystem::path& folder) const = 0;
  /// Searched in this order for assets/<folder>/<name>.yaml and for files named by assets.
  virtual std::vector<std::filesystem::path> asset_roots() const = 0;
  /// Searched in this order for scenarios named by `base:`.
  virtual std::vector<std::filesystem::path> scenario_roots() const = 0;
};

/// The file system. Assets are searched in this order:
/// - the folders in the environment variable SWIFTLET_ASSETS, separated by colons;
/// - share/swiftlet/assets relative to the installed program;
/// - the source tree;
/// - the installation folder of the library.
const ConfigFiles& system_files();

}  // namespace swiftlet::sim
