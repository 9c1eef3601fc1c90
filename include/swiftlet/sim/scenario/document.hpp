// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/sim/errors.hpp"

/// A YAML text as a tree in which every value knows its place, and the merging of such trees. Hides yaml-cpp, which
/// accepts duplicate keys in silence, resolves aliases without bounds and converts loosely.
namespace swiftlet::sim {

/// A text that configuration is read from.
struct Source {
  std::string name;                 ///< as shown in messages
  std::filesystem::path directory;  ///< what relative paths in it refer to
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
  bool quoted = false;  ///< scalars
  Place place;
  std::string text;            ///< scalars
  std::vector<Node> items;     ///< lists
  std::vector<Entry> entries;  ///< maps and changes to elements, in the order of the text; lists: changes that wait

  const Node* find(std::string_view key) const;
  Node* find(std::string_view key);
  bool is_scalar() const { return kind == Kind::kScalar; }
  bool is_list() const { return kind == Kind::kList; }
  bool is_map() const { return kind == Kind::kMap; }
};

struct Entry {
  std::string key;
  Place place;  ///< of the key
  Node value;
};

/// Bounds that no sensible configuration reaches; they keep hostile input from eating memory or stack.
inline constexpr std::size_t kMaxFileBytes = 16'000'000;
inline constexpr std::size_t kMaxNodes = 1'000'000;  ///< aliases counted as often as they are used
inline constexpr std::size_t kMaxKeys = 4'096;       ///< of one map
inline constexpr std::size_t kMaxItems = 100'000;    ///< of one list
inline constexpr int kMaxDepth = 64;

/// One YAML document. Throws InputError on anything that is not exactly that, and on duplicate keys. A key such as
/// `vehicles[0]` becomes a change of an element of `vehicles`.
Node parse_document(const std::string& text, Source source);

/// Lays `over` on `base`: maps merge, anything else is replaced. A map whose `type` differs is replaced as well, since
/// its other keys belong to another module. Changes to elements are made where `base` is a list and wait where it is
/// not there yet. `path` is the key path of both, for messages.
void merge(Node& base, const Node& over, const std::string& path = "");

/// Replaces each vehicle that has a `count` by so many vehicles, with numbered names and starts in a row or a grid.
/// Then makes the changes to single vehicles that waited for this. Vehicles without a `count` stay as they are.
void expand_team(Node& document);

/// The document that one override asks for: ("vehicles[0].start.yaw_deg", "90") -> {vehicles: {[0]: {start: ...}}}.
Node parse_override(const std::string& path, const std::string& value);

/// Where a map of changes names the key "vehicles[0].start.yaw_deg", whether nested or in one word; null: nowhere.
const Place* place_of_key(const Node& changes, const std::string& key);

/// Values in the tree, the root included.
std::size_t num_nodes(const Node& node);

/// "a map", "a list of 3 values", "nothing", or the scalar in quotes.
std::string describe(const Node& node);
/// In quotes, control characters escaped, shortened when long.
std::string quote(std::string_view text);
/// The one line of an error.
std::string error_line(const Place& place, const std::string& path, const std::string& message);
[[noreturn]] void fail(const Place& place, const std::string& path, const std::string& message);

/// "a.b" from "a" and "b"; "b" from "" and "b".
std::string join_path(const std::string& path, std::string_view key);

}  // namespace swiftlet::sim
