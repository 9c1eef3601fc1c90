// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

/// Configuration without a file format: every module has one struct whose `visit` names its fields, once.
/// The strict YAML reader, the writer of resolved scenarios and the generated reference page are visitors
/// (sim/scenario).
///
/// Rules:
/// - Defaults are given in the struct and nowhere else, and a default-constructed config is valid.
/// - A key carries its unit as a suffix (`_m`, `_s`, `_hz`, `_deg`, `_mps`, `_kg`, ...). The value is stored in that
///   unit.
namespace swiftlet {

/// Closed interval by default; the ends can be excluded.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_excluded = false;
  bool max_excluded = false;

  static Range any() { return {}; }
  static Range positive() { return {0.0, std::numeric_limits<double>::infinity(), true, false}; }
  static Range non_negative() { return {0.0, std::numeric_limits<double>::infinity(), false, false}; }
  static Range probability() { return {0.0, 1.0, false, false}; }
  static Range between(double min, double max) { return {min, max, false, false}; }
};

class ConfigVisitor;

/// Enum value of a word; `words` are in the order of the values.
template <class Enum>
std::optional<Enum> enum_named(std::string_view word, std::span<const char* const> words) {
  const auto found = std::find(words.begin(), words.end(), word);
  if (found == words.end()) return std::nullopt;
  return static_cast<Enum>(found - words.begin());
}

/// Base of a configuration that is selected by name (world generator, sensor, guidance, recorder ...).
struct ModuleConfig {
  virtual ~ModuleConfig() = default;
  virtual void visit(ConfigVisitor& visitor) = 0;
  virtual std::unique_ptr<ModuleConfig> clone() const = 0;
};

/// Implements clone() for a module config: struct ForestConfig : ModuleConfigOf<ForestConfig> { ... };
template <class Derived>
struct ModuleConfigOf : ModuleConfig {
  std::unique_ptr<ModuleConfig> clone() const override {
    return std::make_unique<Derived>(static_cast<const Derived&>(*this));
  }
};

/// Configuration part of a row of a registry.
struct ModuleType {
  const char* name;
  const char* doc;  ///< one line, for `swiftlet list` and the reference
  std::unique_ptr<ModuleConfig> (*make_config)();
};

template <class Config>
std::unique_ptr<ModuleConfig> make_module_config() {
  return std::make_unique<Config>();
}

/// A module selected by name with its own configuration; has value semantics. `types` is the registry of the module's
/// kind (a view with static lifetime). The first type is the default unless a type is given.
struct Module {
  std::string type;
  std::unique_ptr<ModuleConfig> config;

  Module() = default;
  Module(std::span<const ModuleType> types, std::string_view type_name);
  Module(const Module& other) : type(other.type), config(other.config ? other.config->clone() : nullptr) {}
  Module& operator=(const Module& other) {
    type = other.type;
    config = other.config ? other.config->clone() : nullptr;
    return *this;
  }
  Module(Module&&) = default;
  Module& operator=(Module&&) = default;

  template <class Config>
  const Config& as() const {
    return dynamic_cast<const Config&>(*config);
  }
  template <class Config>
  Config& as() {
    return dynamic_cast<Config&>(*config);
  }
};

/// Changes to another configuration: ("vehicles[0].start.yaw_deg", "90"), key path and YAML value, applied in this
/// order.
using ConfigChanges = std::vector<std::pair<std::string, std::string>>;

class ConfigVisitor {
 public:
  virtual ~ConfigVisitor() = default;

  // Leaves. `doc` is one line and starts with the unit in brackets: "[m] standard deviation of the range noise".
  virtual void field(const char* key, bool& value, const char* doc) = 0;
  virtual void field(const char* key, int& value, const char* doc, Range range = {}) = 0;
  virtual void field(const char* key, std::uint64_t& value, const char* doc) = 0;
  virtual void field(const char* key, double& value, const char* doc, Range range = {}) = 0;
  virtual void field(const char* key, std::string& value, const char* doc) = 0;
  /// Fixed-length vectors; `range` applies to each element.
  virtual void field(const char* key, Eigen::Vector2d& value, const char* doc, Range range = {}) = 0;
  virtual void field(const char* key, Eigen::Vector3d& value, const char* doc, Range range = {}) = 0;
  /// Lists of any length.
  virtual void field(const char* key, std::vector<double>& value, const char* doc, Range range = {}) = 0;
  virtual void field(const char* key, std::vector<std::string>& value, const char* doc) = 0;
  virtual void field(const char* key, std::vector<Eigen::Vector3d>& value, const char* doc, Range range = {}) = 0;
  /// One of the given words.
  virtual void choice(const char* key, std::string& value, std::span<const char* const> words, const char* doc) = 0;
  /// `words` lists all enum values in their order.
  template <class Enum>
  requires std::is_enum_v<Enum>
  void choice(const char* key, Enum& value, std::span<const char* const> words, const char* doc) {
    std::string word = words[static_cast<std::size_t>(value)];
    choice(key, word, words, doc);
    value = *enum_named<Enum>(word, words);
  }
  void choice(const char* key, auto& value, std::initializer_list<const char*> words, const char* doc) {
    choice(key, value, std::span<const char* const>(words.begin(), words.size()), doc);
  }
  /// Path of an input file; empty means none. The reader resolves it relative to the file that contains it and checks
  /// that it exists.
  virtual void file(const char* key, std::string& path, const char* doc) = 0;
  /// Name of an asset (`assets/<folder>/<value>.yaml`, or a path) whose content is the default of the other keys of
  /// this object. Must be the first call of a visit. Empty: none.
  virtual void model(const char* key, std::string& name, const char* folder, const char* doc) = 0;

  /// A map of arbitrary keys, nested or as paths: changes to another configuration.
  virtual void changes(const char* /*key*/, ConfigChanges& /*value*/, const char* /*doc*/) {}

  /// A nested object with a `void visit(ConfigVisitor&)`.
  template <class T>
  void object(const char* key, T& value, const char* doc) {
    if (!begin_object(key, doc)) return;
    value.visit(*this);
    end_object();
  }

  /// A list of objects. The reader resizes it; the reference shows one default-constructed element.
  template <class T>
  void list(const char* key, std::vector<T>& values, const char* doc) {
    std::size_t size = values.size();
    if (!begin_list(key, size, doc)) return;
    if (starts_afresh()) values.clear();
    values.resize(size);
    for (std::size_t i = 0; i < values.size(); ++i) {
      begin_element(i);
      values[i].visit(*this);
      end_element();
    }
    if (wants_example() && values.empty()) {
      T example{};
      begin_element(0);
      example.visit(*this);
      end_element();
    }
    end_list();
  }

  /// An object whose key `type` selects one of `types`; the other keys belong to that type.
  virtual void module(const char* key, Module& value, std::span<const ModuleType> types, const char* doc) = 0;
  /// A list of such objects.
  virtual void modules(const char* key, std::vector<Module>& values, std::span<const ModuleType> types,
                       const char* doc) = 0;

  /// Constraint between fields: `ok` is false when the field `key` contradicts another one. The reader reports it at
  /// the position of `key`: "<place>: <key>: expected <expected>". Call it after the fields.
  virtual void check(bool ok, const char* key, const std::string& expected) = 0;

  /// Positions in the field `key`, world frame, that the vehicle is meant to reach. A run rejects positions inside an
  /// obstacle, as it rejects such starts. Call it after the field.
  void destinations(const char* key, const Eigen::Vector3d& place_world_m) { destination(key, place_world_m); }
  void destinations(const char* key, const std::vector<Eigen::Vector3d>& places_world_m) {
    for (std::size_t i = 0; i < places_world_m.size(); ++i) {
      destination(std::string(key) + "[" + std::to_string(i) + "]", places_world_m[i]);
    }
  }

 protected:
  virtual bool begin_object(const char* key, const char* doc) = 0;
  virtual void end_object() = 0;
  virtual bool begin_list(const char* key, std::size_t& size, const char* doc) = 0;
  virtual void begin_element(std::size_t index) = 0;
  virtual void end_element() = 0;
  virtual void end_list() = 0;
  virtual bool wants_example() const { return false; }
  /// True if the list that has just begun replaces the default elements.
  virtual bool starts_afresh() const { return false; }
  /// One of destinations(): key, as "goals_m[2]", and position.
  virtual void destination(const std::string& /*key*/, const Eigen::Vector3d& /*place_world_m*/) {}
};

}  // namespace swiftlet
