// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/yaml_reader.hpp"

#include <algorithm>
#include <charconv>
#include <deque>
#include <map>
#include <stdexcept>

#include "sim/scenario/changes.hpp"
#include "sim/scenario/config_errors.hpp"
#include "sim/scenario/node_values.hpp"
#include "sim/scenario/retired_keys.hpp"
#include "swiftlet/sim/scenario/document.hpp"
#include "swiftlet/sim/scenario/loader.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"
#include "swiftlet/sim/scenario/units.hpp"

namespace swiftlet::sim {
namespace {

using Kind = Node::Kind;

// [-] Largest number of objects of a configuration. Limits time and memory for malicious input.
constexpr std::size_t kMaxObjects = 100'000;

std::vector<std::string> names_of(std::span<const ModuleType> types) {
  std::vector<std::string> names;
  for (const ModuleType& type : types) names.emplace_back(type.name);
  return names;
}

Node scalar_node(const std::string& text, const Place& place) {
  Node node;
  node.kind = Kind::kScalar;
  node.text = text;
  node.place = place;
  return node;
}

Node to_node(double value, const Place& place) { return scalar_node(yaml_number(value), place); }

Node to_node(const std::string& value, const Place& place) {
  Node node = scalar_node(value, place);
  node.quoted = true;
  return node;
}

Node to_node(const Eigen::Vector3d& value, const Place& place) {
  Node node;
  node.kind = Kind::kList;
  node.place = place;
  for (const double x : value) node.items.push_back(to_node(x, place));
  return node;
}

template <class Values>
Node list_node(const Values& values, const Place& place) {
  Node node;
  node.kind = Kind::kList;
  node.place = place;
  for (const auto& value : values) node.items.push_back(to_node(value, place));
  return node;
}

Node list_of_maps(std::size_t size, const Place& place) {
  Node list;
  list.kind = Kind::kList;
  list.items.resize(size);
  for (Node& item : list.items) {
    item.kind = Kind::kMap;
    item.place = place;
  }
  return list;
}

/// The value below a node at a path such as "start.yaw_deg" or "vehicles[1].name"; `place` becomes the nearest known
/// location.
const Node* find_node(const Node* node, std::string_view path, Place& place) {
  while (node != nullptr && !path.empty()) {
    const std::size_t end = std::min(path.find_first_of(".[]"), path.size());
    const std::string_view part = path.substr(0, end);
    std::size_t index = 0;
    if (node->is_list() && std::from_chars(part.data(), part.data() + part.size(), index).ec == std::errc()) {
      node = index < node->items.size() ? &node->items[index] : nullptr;
    } else {
      node = node->find(part);
    }
    if (node != nullptr) place = node->place;
    path.remove_prefix(end);
    while (!path.empty() && path.find_first_of(".[]") == 0) path.remove_prefix(1);
  }
  return node;
}

/// Adds an error for each key of a map that is not known.
void add_unknown_keys(const Node& map, const std::vector<std::string>& known, const std::string& path,
                      ConfigErrors& errors) {
  for (const Entry& entry : map.entries) {
    if (std::find(known.begin(), known.end(), entry.key) != known.end()) continue;
    const std::string full_path = join_path(path, entry.key);
    std::string hint = replacement_hint(full_path);
    if (hint.empty()) hint = did_you_mean(entry.key, known);
    const std::string expected = hint.empty() ? one_of(known) : "a known key";
    errors.add(entry.place, full_path, "expected " + expected + ", found " + quote(entry.key) + hint);
  }
}

/// Adds an error unless the node names one of the known types.
bool is_known_type(const Node& type, const std::string& path, const std::vector<std::string>& known,
                   ConfigErrors& errors) {
  if (type.is_scalar() && std::find(known.begin(), known.end(), type.text) != known.end()) return true;
  const std::string hint = type.is_scalar() ? did_you_mean(type.text, known) : "";
  errors.add(type.place, path, "expected " + one_of(known) + ", found " + describe(type) + hint);
  return false;
}

/// Throws InputError when an asset builds on another one by `key`, or has another type than the object.
void require_fitting_asset(const Node& asset, const Node* object, const std::string& key, const std::string& name,
                           const Place& place, const std::string& path) {
  if (const Node* chain = asset.find(key))
    fail(chain->place, path, "expected an asset that builds on another one by `base:`, found " + quote(key));
  const Node* type = object == nullptr ? nullptr : object->find("type");
  const Node* asset_type = asset.find("type");
  if (type == nullptr || asset_type == nullptr || asset_type->text == type->text) return;
  fail(place, path,
       "expected an asset of type " + quote(type->text) + ", found " + quote(name) + ", which is of type " +
           quote(asset_type->text));
}

class YamlReader final : public ConfigVisitor, public PlaceProvider {
 public:
  YamlReader(const Node& root, Loader& loader) : loader_(loader), errors_(root.place) { push(&root, root.place, ""); }

  void finish() {
    pop();
    errors_.report();
  }

  // --- leaves ---

  void field(const char* key, bool& value, const char*) override {
    if (const Node* node = take(key)) values_.read(*node, at(key), value);
    show(key, value ? "true" : "false");
  }
  void field(const char* key, int& value, const char*, Range range) override {
    if (const Node* node = take(key)) values_.read(*node, at(key), key, value, range);
    show(key, std::to_string(value));
  }
  void field(const char* key, std::uint64_t& value, const char*) override {
    if (const Node* node = take(key)) values_.read(*node, at(key), value);
    show(key, std::to_string(value));
  }
  void field(const char* key, double& value, const char*, Range range) override {
    if (const Node* node = take(key)) values_.read(*node, at(key), key, value, range);
    show(key, yaml_number(value));
  }
  void field(const char* key, std::string& value, const char*) override {
    if (const Node* node = take(key)) values_.read(*node, at(key), value);
    show(key, value);
  }
  void field(const char* key, Eigen::Vector2d& value, const char*, Range range) override {
    read_fixed(key, value, range);
  }
  void field(const char* key, Eigen::Vector3d& value, const char*, Range range) override {
    read_fixed(key, value, range);
  }

  void field(const char* key, std::vector<double>& value, const char*, Range range) override {
    read_list(key, value, "a list of numbers",
              [&](const Node& item, const std::string& path, double& x) { values_.read(item, path, key, x, range); });
  }
  void field(const char* key, std::vector<std::string>& value, const char*) override {
    read_list(key, value, "a list of words",
              [&](const Node& item, const std::string& path, std::string& x) { values_.read(item, path, x); });
  }
  void field(const char* key, std::vector<Eigen::Vector3d>& value, const char*, Range range) override {
    read_list(key, value, "a list of lists of 3 numbers",
              [&](const Node& item, const std::string& path, Eigen::Vector3d& x) {
                values_.read(item, path, key, x, range);
              });
  }

  void choice(const char* key, std::string& value, std::span<const char* const> words, const char*) override {
    if (const Node* node = take(key)) {
      const std::vector<std::string> known(words.begin(), words.end());
      if (node->is_scalar() && std::find(known.begin(), known.end(), node->text) != known.end()) {
        value = node->text;
      } else {
        errors_.add_value(*node, at(key), one_of(known), node->is_scalar() ? did_you_mean(node->text, known) : "");
      }
    }
    show(key, value);
  }

  void changes(const char* key, ConfigChanges& value, const char*) override {
    const Node* node = take(key);
    if (node == nullptr) return;
    if (!node->is_map()) return errors_.add_value(*node, at(key), "a map of keys");
    value = changes_of(*node);
  }

  // --- other files ---

  void file(const char* key, std::string& path, const char*) override {
    const Node* node = take(key);
    if (node != nullptr && !values_.read(*node, at(key), path)) return;
    show(key, path);
    if (path.empty()) return;
    const Place place = node != nullptr ? node->place : Place{};
    errors_.attempt(place, [&] { path = loader_.find_file(path, place, at(key)).string(); });
  }

  void model(const char* key, std::string& name, const char* folder, const char*) override {
    const Node* node = take(key);
    if (node != nullptr && !values_.read(*node, at(key), name)) return;
    show(key, name);
    if (name.empty()) return;
    const Place place = node != nullptr ? node->place : top().place;
    errors_.attempt(place, [&] { lay_on_asset(key, name, folder, place); });
  }

  // --- modules ---

  void module(const char* key, Module& value, std::span<const ModuleType> types, const char*) override {
    const Node* node = take(key);
    const Place place = node != nullptr ? node->place : top().place;
    read_module(value, node, place, at(key), types, false);
  }

  void modules(const char* key, std::vector<Module>& values, std::span<const ModuleType> types, const char*) override {
    std::size_t size = values.size();
    begin_list(key, size, "");
    const List list = std::move(lists_.back());
    lists_.pop_back();
    if (list.fresh) values.clear();
    values.resize(size);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Node* node = list.elements[i];
      const std::string path = list.path + "[" + std::to_string(i) + "]";
      read_module(values[i], node, node != nullptr ? node->place : list.place, path, types, list.fresh);
    }
  }

  // --- checks ---

  void check(bool ok, const char* key, const std::string& expected) override {
    // Reports no consequences of earlier errors.
    if (ok || !errors_.empty()) return;
    Place place = top().place;
    const Node* node = find_node(top().node, key, place);
    std::string found;
    if (node != nullptr && node->is_scalar()) found = ", found " + quote(node->text);
    if (const auto shown = top().shown.find(key); node == nullptr && shown != top().shown.end()) {
      found = ", found " + quote(shown->second) + " by default";
    }
    const std::size_t hint = std::min(expected.find("; did you mean"), expected.size());
    errors_.add(place, at(key), "expected " + expected.substr(0, hint) + found + expected.substr(hint));
  }

  std::string place_of(const char* key) const override {
    Place place = frames_.back().place;
    find_node(frames_.back().node, key, place);
    return error_line(place, at(key), "");
  }

 protected:
  bool begin_object(const char* key, const char*) override {
    const Node* node = take(key);
    push(node, node != nullptr ? node->place : top().place, at(key));
    return true;
  }
  void end_object() override { pop(); }

  bool begin_list(const char* key, std::size_t& size, const char*) override {
    const Node* node = take(key);
    List list{node != nullptr ? node->place : top().place, at(key), {}, node != nullptr && node->is_list()};
    if (list.fresh) {
      for (const Node& item : node->items) list.elements.push_back(&item);
    } else {
      list.elements.assign(size, nullptr);
      if (node != nullptr && node->kind == Kind::kElements) {
        change_default_elements(list, *node);
      } else if (node != nullptr) {
        errors_.add_value(*node, at(key), "a list");
      }
    }
    size = list.elements.size();
    lists_.push_back(std::move(list));
    return true;
  }
  bool starts_afresh() const override { return lists_.back().fresh; }

  void begin_element(std::size_t index) override {
    const List& list = lists_.back();
    const Node* node = list.elements[index];
    push(node, node != nullptr ? node->place : list.place, list.path + "[" + std::to_string(index) + "]");
  }
  void end_element() override { pop(); }
  void end_list() override { lists_.pop_back(); }

 private:
  struct Frame {
    const Node* node = nullptr;  ///< null: no value given, all defaults
    Place place;
    std::string path;
    std::vector<std::string> known;            ///< keys visited so far
    std::map<std::string, std::string> shown;  ///< values of leaves, for check()
  };
  struct List {
    Place place;
    std::string path;
    std::vector<const Node*> elements;  ///< null: the element keeps its default
    bool fresh = false;                 ///< the text gives the whole list, not changes to the default
  };
  Frame& top() { return frames_.back(); }
  std::string at(const std::string& key) const { return join_path(frames_.back().path, key); }
  void show(const char* key, std::string value) { top().shown[key] = std::move(value); }

  /// The value of a key of the current object; null when it is not given.
  const Node* take(const char* key) {
    top().known.emplace_back(key);
    return top().node == nullptr ? nullptr : top().node->find(key);
  }

  void push(const Node* node, const Place& place, const std::string& path) {
    if (++num_objects_ > kMaxObjects) {
      fail(place, path, "expected at most " + std::to_string(kMaxObjects) + " objects, found more");
    }
    if (node != nullptr && !node->is_map()) {
      errors_.add(node->place, path, "expected a map of keys, found " + describe(*node));
      node = nullptr;
    }
    frames_.push_back({node, place, path, {}, {}});
  }

  void pop() {
    if (top().node != nullptr) add_unknown_keys(*top().node, top().known, top().path, errors_);
    frames_.pop_back();
  }

  // --- values ---

  template <class Vector>
  void read_fixed(const char* key, Vector& value, const Range& range) {
    const Node* node = take(key);
    if (node == nullptr) return;
    const Node whole = with_default(*node, list_node(value, node->place), key);
    values_.read(whole, at(key), key, value, range);
  }

  template <class T, class ReadItem>
  void read_list(const char* key, std::vector<T>& values, const char* expected, const ReadItem& read_item) {
    const Node* node = take(key);
    if (node == nullptr) return;
    const Node whole = with_default(*node, list_node(values, node->place), key);
    if (!whole.is_list()) return errors_.add_value(whole, at(key), expected);
    values.assign(whole.items.size(), T{});
    for (std::size_t i = 0; i < values.size(); ++i) {
      read_item(whole.items[i], at(key) + "[" + std::to_string(i) + "]", values[i]);
    }
  }

  /// Applies changes to single elements to the default; any other node replaces it.
  Node with_default(const Node& node, Node defaults, const char* key) {
    if (node.kind != Kind::kElements) return node;
    try {
      merge(defaults, node, at(key));
    } catch (const InputError& problem) {
      errors_.attempt(node.place, [&] { throw problem; });
    }
    return defaults;
  }

  // --- objects ---

  /// Applies `[0]` and `[*]` to a list that exists only as the struct's default.
  void change_default_elements(List& list, const Node& changes) {
    Node elements = list_of_maps(list.elements.size(), changes.place);
    errors_.attempt(changes.place, [&] {
      merge(elements, changes, list.path);
      owned_.push_back(std::move(elements));
      for (std::size_t i = 0; i < list.elements.size(); ++i) list.elements[i] = &owned_.back().items[i];
    });
  }

  void read_module(Module& value, const Node* node, const Place& place, const std::string& path,
                   std::span<const ModuleType> types, bool type_required) {
    const Node* type = node;  // `detector: vofod` is short for `detector: {type: vofod}`
    if (node != nullptr && node->is_map()) type = node->find("type");
    if (type == nullptr && type_required)
      return errors_.add(place, join_path(path, "type"), "expected " + one_of(names_of(types)) + ", found nothing");
    if (type != nullptr) {
      if (!is_known_type(*type, type == node ? path : join_path(path, "type"), names_of(types), errors_)) return;
      if (value.type != type->text || !value.config) value = Module(types, type->text);
    }
    if (!value.config && !types.empty()) value = Module(types, types.front().name);
    if (!value.config) return;
    push(type == node ? nullptr : node, place, path);
    top().known.emplace_back("type");
    value.config->visit(*this);
    pop();
  }

  /// Merges the asset's keys under those of the current object.
  void lay_on_asset(const std::string& key, std::string& name, const char* folder, const Place& place) {
    const std::string path = at(key);
    const Node& asset = loader_.load_asset(name, folder, place, path);
    const Node* node = top().node;
    require_fitting_asset(asset, node, key, name, place, path);
    num_asset_nodes_ += num_nodes(asset);
    if (num_asset_nodes_ > 2 * kMaxNodes) fail(place, path, "expected smaller assets, found too many values in all");
    owned_.push_back(asset);
    if (node != nullptr) merge(owned_.back(), *node, top().path);
    top().node = &owned_.back();
    // The full path is kept, so that the resolved configuration is independent of its location.
    if (name.ends_with(".yaml") || name.ends_with(".yml")) name = loader_.find_file(name, place, path).string();
  }

  Loader& loader_;
  std::deque<Frame> frames_;
  std::vector<List> lists_;
  std::deque<Node> owned_;  ///< trees created here: objects merged with assets
  ConfigErrors errors_;
  NodeValues values_{errors_};
  std::size_t num_objects_ = 0;
  std::size_t num_asset_nodes_ = 0;
};

void read(Node document, Loader& loader, const ConfigVisit& visit, const Overrides& overrides) {
  for (const auto& [path, value] : overrides) merge(document, parse_override(path, value));
  expand_team(document);
  YamlReader reader(document, loader);
  try {
    visit(reader);
  } catch (const std::invalid_argument& problem) {
    fail({document.place.source, 0, 0}, "", problem.what());
  }
  reader.finish();
}

}  // namespace

void read_config(const std::filesystem::path& file, const ConfigVisit& visit, const Overrides& overrides,
                 const ConfigFiles& files) {
  Loader loader(files);
  read(loader.load(file), loader, visit, overrides);
}

void read_config_text(const std::string& text, const std::filesystem::path& name, const ConfigVisit& visit,
                      const Overrides& overrides, const ConfigFiles& files) {
  Loader loader(files);
  read(loader.load_text(text, name), loader, visit, overrides);
}

}  // namespace swiftlet::sim
