// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "swiftlet/sim/scenario/config_files.hpp"
#include "swiftlet/sim/scenario/document.hpp"

namespace swiftlet::sim {

/// Finds and parses documents and merges each into its `base:` documents. Caches files.
class Loader {
 public:
  explicit Loader(const ConfigFiles& files) : files_(files) {}

  /// Loads by path, or by name from a scenario root. Throws InputError when the file is missing or malformed, or refers
  /// to itself through `base:`.
  Node load(const std::filesystem::path& file);
  /// Path of that file. Throws InputError.
  std::filesystem::path path_of(const std::filesystem::path& file) const { return find_main(file); }
  /// Parses a text with its `base:` chain.
  Node load_text(const std::string& text, const std::filesystem::path& name);
  /// Loads assets/<folder>/<name>.yaml, or a path relative to the naming file when `name` ends in .yaml. `path` and
  /// `place` locate the naming key.
  const Node& load_asset(const std::string& name, const std::string& folder, const Place& place,
                         const std::string& path);
  /// Path of an input file named at `place`: relative to the naming file, otherwise below an asset root.
  std::filesystem::path find_file(const std::string& name, const Place& place, const std::string& path) const;

 private:
  Node with_base(Node document, std::vector<std::filesystem::path> chain);
  std::filesystem::path find_main(const std::filesystem::path& file) const;
  std::filesystem::path find_base(const Node& base) const;
  std::filesystem::path find_asset(const std::string& name, const std::string& folder, const Place& place,
                                   const std::string& path) const;
  std::string read(const std::filesystem::path& file) const;
  std::string hint(const std::filesystem::path& missing) const;

  const ConfigFiles& files_;
  std::map<std::filesystem::path, Node> assets_;
};

}  // namespace swiftlet::sim
