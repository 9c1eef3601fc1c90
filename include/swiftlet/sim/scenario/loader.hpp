// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "swiftlet/sim/scenario/config_files.hpp"
#include "swiftlet/sim/scenario/document.hpp"

namespace swiftlet::sim {

/// Finds and parses documents, each laid on those that its `base:` names. Keeps what it read.
class Loader {
 public:
  explicit Loader(const ConfigFiles& files) : files_(files) {}

  /// By path, or by name from a scenario root. Throws InputError when the file is missing or malformed, or names itself
  /// through `base:`.
  Node load(const std::filesystem::path& file);
  /// Where that file lies. Throws InputError.
  std::filesystem::path path_of(const std::filesystem::path& file) const { return find_main(file); }
  /// A text that is already at hand, with its `base:` chain.
  Node load_text(const std::string& text, const std::filesystem::path& name);
  /// assets/<folder>/<name>.yaml, or a path relative to the file that names it when `name` ends in .yaml.
  /// `path` and `place` are where it is named.
  const Node& load_asset(const std::string& name, const std::string& folder, const Place& place,
                         const std::string& path);
  /// Where an input file lies that `place` names: relative to the naming file, else below an asset root.
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
