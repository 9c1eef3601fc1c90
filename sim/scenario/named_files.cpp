// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/named_files.hpp"

namespace swiftlet::sim {
namespace {

/// Visits a configuration and collects its files and destinations.
class FileLister final : public ConfigVisitor {
 public:
  std::vector<NamedFile> take_files() { return std::move(files_); }
  std::vector<NamedPlace> take_destinations() { return std::move(destinations_); }

  void field(const char*, bool&, const char*) override {}
  void field(const char*, int&, const char*, Range) override {}
  void field(const char*, std::uint64_t&, const char*) override {}
  void field(const char*, double&, const char*, Range) override {}
  void field(const char*, std::string&, const char*) override {}
  void field(const char*, Eigen::Vector2d&, const char*, Range) override {}
  void field(const char*, Eigen::Vector3d&, const char*, Range) override {}
  void field(const char*, std::vector<double>&, const char*, Range) override {}
  void field(const char*, std::vector<std::string>&, const char*) override {}
  void field(const char*, std::vector<Eigen::Vector3d>&, const char*, Range) override {}
  void choice(const char*, std::string&, std::span<const char* const>, const char*) override {}
  void model(const char*, std::string&, const char*, const char*) override {}
  void check(bool, const char*, const std::string&) override {}

  void file(const char* key, std::string& path, const char*) override {
    if (!path.empty()) files_.push_back({at(key), path});
  }
  void module(const char* key, Module& value, std::span<const ModuleType>, const char*) override {
    if (!value.config) return;
    begin_object(key, "");
    value.config->visit(*this);
    end_object();
  }
  void modules(const char* key, std::vector<Module>& values, std::span<const ModuleType>, const char*) override {
    std::size_t size = values.size();
    begin_list(key, size, "");
    for (std::size_t i = 0; i < size; ++i) {
      begin_element(i);
      if (values[i].config) values[i].config->visit(*this);
      end_element();
    }
    end_list();
  }

 protected:
  bool begin_object(const char* key, const char*) override {
    places_.push_back(at(key));
    return true;
  }
  void end_object() override { places_.pop_back(); }
  bool begin_list(const char* key, std::size_t&, const char*) override { return begin_object(key, ""); }
  void end_list() override { end_object(); }
  void begin_element(std::size_t index) override {
    places_.push_back(places_.back() + "[" + std::to_string(index) + "]");
  }
  void end_element() override { end_object(); }
  void destination(const std::string& key, const Eigen::Vector3d& place_world_m) override {
    destinations_.push_back({at(key), place_world_m});
  }

 private:
  std::string at(const std::string& key) const { return places_.empty() ? key : places_.back() + "." + key; }

  std::vector<std::string> places_;  ///< open objects, lists and elements
  std::vector<NamedFile> files_;
  std::vector<NamedPlace> destinations_;
};

}  // namespace

std::vector<NamedFile> named_files(const Scenario& scenario) {
  Scenario visited = scenario;  // copy, since a visit may write
  FileLister lister;
  visited.visit(lister);
  return lister.take_files();
}

std::vector<NamedPlace> destinations_of(const VehicleConfig& vehicle) {
  Module visited = vehicle.agent;
  FileLister lister;
  lister.module("agent", visited, {}, "");
  return lister.take_destinations();
}

}  // namespace swiftlet::sim
