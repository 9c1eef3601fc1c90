// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::testing {

/// Visits a configuration and records the ranges of its numbers and the paths of keys whose checks fail.
class ConfigChecks : public ConfigVisitor {
 public:
  template <class Config>
  explicit ConfigChecks(Config config) {
    config.visit(*this);
  }

  bool refuses(const std::string& path) const {
    return std::find(refused_.begin(), refused_.end(), path) != refused_.end();
  }
  bool refuses_nothing() const { return refused_.empty(); }
  const Range& range(const std::string& path) const { return ranges_.at(path); }

  using ConfigVisitor::choice;
  void field(const char*, bool&, const char*) override {}
  void field(const char* key, int& value, const char*, Range range) override { note(key, value, range); }
  void field(const char*, std::uint64_t&, const char*) override {}
  void field(const char* key, double& value, const char*, Range range) override { note(key, value, range); }
  void field(const char*, std::string&, const char*) override {}
  void field(const char* key, Eigen::Vector2d& value, const char*, Range range) override {
    for (const double v : value) note(key, v, range);
  }
  void field(const char* key, Eigen::Vector3d& value, const char*, Range range) override {
    for (const double v : value) note(key, v, range);
  }
  void field(const char* key, std::vector<double>& value, const char*, Range range) override {
    for (const double v : value) note(key, v, range);
  }
  void field(const char*, std::vector<std::string>&, const char*) override {}
  void field(const char*, std::vector<Eigen::Vector3d>&, const char*, Range) override {}
  void choice(const char*, std::string&, std::span<const char* const>, const char*) override {}
  void file(const char*, std::string&, const char*) override {}
  void model(const char*, std::string&, const char*, const char*) override {}
  void module(const char*, Module&, std::span<const ModuleType>, const char*) override {}
  void modules(const char*, std::vector<Module>&, std::span<const ModuleType>, const char*) override {}
  void check(bool ok, const char* key, const std::string&) override {
    if (!ok) refused_.push_back(prefix_ + key);
  }

 protected:
  bool begin_object(const char* key, const char*) override {
    prefixes_.push_back(prefix_);
    prefix_ += std::string(key) + ".";
    return true;
  }
  void end_object() override {
    prefix_ = prefixes_.back();
    prefixes_.pop_back();
  }
  bool begin_list(const char* key, std::size_t&, const char* doc) override { return begin_object(key, doc); }
  void begin_element(std::size_t) override {}
  void end_element() override {}
  void end_list() override { end_object(); }

 private:
  void note(const char* key, double value, const Range& range) {
    ranges_[prefix_ + key] = range;
    const bool ok = (range.min_excluded ? value > range.min : value >= range.min) &&
                    (range.max_excluded ? value < range.max : value <= range.max);
    if (!ok) refused_.push_back(prefix_ + key);
  }

  std::string prefix_;
  std::vector<std::string> prefixes_, refused_;
  std::map<std::string, Range> ranges_;
};

}  // namespace swiftlet::testing
