// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/sim/errors/errors.hpp"

/// A YAML text as a tree of values with their source locations, and the merging of such trees. Hides yaml-cpp, which
/// accepts duplicate keys silently, resolves aliases without bounds and converts loosely.
namespace swiftlet::sim {

/// A configuration text.
struct Source {
  std::string name;                 ///< as shown in messages
  std::filesystem::path directory;  ///< base folder of relative paths
};

struct Place {
  std::shared_ptr<const Source> source;
  int line = 0;  ///< 1-based; 0: the source as a whole
  int column = 0;

  std::string str() const;  ///< "forest.yaml:12:7"
};

struct Entry;

struct Node {
  /// kElements holds changes to single elements of a list: entries "[0]", "[*]", "[name]", "[beginning*]" (see merge).
  enum class Kind { kNull, kScalar, kList, kMap, kElements };

  Kind kind = Kind::kNull;
  bool quoted = false;  ///< kScalar only
  Place place;
  std::string text;            ///< kScalar only
  std::vector<Node> items;     ///< kList only
  std::vector<Entry> entries;  ///< kMap and kElements, in the order of the text; kList: pending changes to elements

  const Node* find(std::string_view key) const;
  Node* find(std::string_view key);
  bool is_scalar() const { return kind == Kind::kScalar; }
  bool is_list() const { return kind == Kind::kList; }
  bool is_map() const { return kind == Kind::kMap; }
};

struct Entry {
  std::string key;
  Place place;  ///< location of the key
  Node value;
};

/// Limits far above any sensible configuration; they bound memory and stack for malicious input.
inline constexpr std::size_t kMaxFileBytes = 16'000'000;
inline constexpr std::size_t kMaxNodes = 1'000'000;  ///< aliases counted at every use
inline constexpr std::size_t kMaxKeys = 4'096;       ///< per map
inline constexpr std::size_t kMaxItems = 100'000;    ///< per list
inline constexpr int kMaxDepth = 64;                 ///< nested maps and lists

/// Parses one YAML document. Throws InputError on anything else and on duplicate keys. A key such as `vehicles[0]`
/// becomes a change of an element of `vehicles`.
Node parse_document(const std::string& text, Source source);

/// Merges `over` into `base`: maps are merged, other values are replaced. A map whose `type` differs is replaced as
/// well, since its other keys belong to another module. Changes to elements are applied where `base` is a list,
/// otherwise kept pending. `path` is the key path of both, for messages.
void merge(Node& base, const Node& over, const std::string& path = "");

/// Replaces each vehicle with a `count` by that many vehicles, with numbered names and starts in a row or a grid. Then
/// applies the pending changes to single vehicles. Vehicles without a `count` are unchanged.
void expand_team(Node& document);

/// The document equivalent to one override: ("vehicles[0].start.yaw_deg", "90") -> {vehicles: {[0]: {start: ...}}}.
Node parse_override(const std::string& path, const std::string& value);

/// Location of the key "vehicles[0].start.yaw_deg" in a map of changes, nested or as one word; null: not there.
const Place* place_of_key(const Node& changes, const std::string& key);

/// Number of values in the tree, including the root.
std::size_t num_nodes(const Node& node);

/// "a map", "a list of 3 values", "nothing", or the scalar in quotes.
std::string describe(const Node& node);
/// Quoted, with control characters escaped, shortened when long.
std::string quote(std::string_view text);
/// Formats an error message as one line.
std::string error_line(const Place& place, const std::string& path, const std::string& message);
[[noreturn]] void fail(const Place& place, const std::string& path, const std::string& message);

/// "a.b" from "a" and "b"; "b" from "" and "b".
std::string join_path(const std::string& path, std::string_view key);

}  // namespace swiftlet::sim
