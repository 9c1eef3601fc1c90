// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <concepts>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::test {

/// Visits a configuration and lists each value out of its range, failed check and key that comes twice, as
/// "path.0.key: problem".
class ConfigChecks : public ConfigVisitor {
 public:
  template <class Config>
  requires(!std::derived_from<std::remove_cvref_t<Config>, ConfigVisitor>) explicit ConfigChecks(Config&& config) {
    config.visit(*this);
  }

  const std::vector<std::string>& problems() const { return problems_; }
  bool refuses(const std::string& path) const {
    return std::ranges::any_of(problems_, [&](const std::string& p) { return p.starts_with(path + ":"); });
  }

  using ConfigVisitor::choice;
  void field(const char* key, bool&, const char*) override { add_key(key); }
  void field(const char* key, int& value, const char*, Range range) override { add_value(key, value, range); }
  void field(const char* key, std::uint64_t&, const char*) override { add_key(key); }
  void field(const char* key, double& value, const char*, Range range) override { add_value(key, value, range); }
  void field(const char* key, std::string&, const char*) override { add_key(key); }
  void field(const char* key, Eigen::Vector2d& value, const char*, Range range) override {
    add_list(key, value, range);
  }
  void field(const char* key, Eigen::Vector3d& value, const char*, Range range) override {
    add_list(key, value, range);
  }
  void field(const char* key, std::vector<double>& value, const char*, Range range) override {
    add_list(key, value, range);
  }
  void field(const char* key, std::vector<std::string>&, const char*) override { add_key(key); }
  void field(const char* key, std::vector<Eigen::Vector3d>&, const char*, Range) override { add_key(key); }
  void choice(const char* key, std::string& value, std::span<const char* const> words, const char*) override {
    add_key(key);
    if (std::find(words.begin(), words.end(), value) == words.end()) add_problem(key, "not a choice");
  }
  void file(const char* key, std::string&, const char*) override { add_key(key); }
  void model(const char* key, std::string&, const char*, const char*) override { add_key(key); }
  void module(const char* key, Module&, std::span<const ModuleType>, const char*) override { add_key(key); }
  void modules(const char* key, std::vector<Module>&, std::span<const ModuleType>, const char*) override {
    add_key(key);
  }
  void check(bool ok, const char* key, const std::string& expected) override {
    if (!ok) add_problem(key, "expected " + expected);
  }

 protected:
  bool begin_object(const char* key, const char*) override {
    add_key(key);
    path_ += std::string(key) + ".";
    return true;
  }
  void end_object() override { leave(); }
  bool begin_list(const char* key, std::size_t&, const char*) override { return begin_object(key, ""); }
  void begin_element(std::size_t index) override { path_ += std::to_string(index) + "."; }
  void end_element() override { leave(); }
  void end_list() override { leave(); }

 private:
  void leave() { path_.erase(path_.size() < 2 ? 0 : path_.rfind('.', path_.size() - 2) + 1); }
  void add_problem(const char* key, const std::string& problem) { problems_.push_back(path_ + key + ": " + problem); }
  void add_key(const char* key) {
    if (!keys_.insert(path_ + key).second) add_problem(key, "the key comes twice");
  }
  void add_value(const char* key, double value, const Range& range) {
    add_key(key);
    check_range(key, value, range);
  }
  template <class List>
  void add_list(const char* key, const List& values, const Range& range) {
    add_key(key);
    for (const double value : values) check_range(key, value, range);
  }
  void check_range(const char* key, double value, const Range& range) {
    const bool low = range.min_excluded ? value > range.min : value >= range.min;
    const bool high = range.max_excluded ? value < range.max : value <= range.max;
    if (!low || !high) add_problem(key, "out of range");
  }

  std::string path_;
  std::vector<std::string> problems_;
  std::set<std::string> keys_;
};

}  // namespace swiftlet::test
