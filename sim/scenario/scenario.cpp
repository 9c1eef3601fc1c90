// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/scenario.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/base/time.hpp"
#include "swiftlet/sim/plugin/plugin.hpp"
#include "swiftlet/sim/recorders/ros_config.hpp"
#include "swiftlet/sim/recorders/scan_files_config.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/scenario/named_files.hpp"
#include "swiftlet/sim/scenario/recorder_paths.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"
#include "swiftlet/sim/scenario/units.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"
#include "swiftlet/sim/scenario/yaml_writer.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {
namespace {

/// Least ratio of the rotors' maximum thrust to the weight. Smaller values leave no thrust for climbing or tilting.
constexpr double kMinThrustRatio = 1.1;

constexpr const char* kNameRule = "a name of letters, digits, '_', '-' and '.' (it becomes a file name)";

std::string element(const char* list, std::size_t index, const char* key) {
  return std::string(list) + "[" + std::to_string(index) + "]." + key;
}

/// Checks that a name is valid and unique; `key` is its location for messages.
void check_name(ConfigVisitor& v, const std::string& name, const std::vector<std::string>& earlier,
                const std::string& key) {
  v.check(is_file_name(name), key.c_str(), kNameRule);
  v.check(!contains(earlier, name), key.c_str(), "a name that is not taken yet");
}

void check_exists(ConfigVisitor& v, const std::string& name, const std::vector<std::string>& known,
                  const std::string& key) {
  if (name.empty() || contains(known, name)) return;
  v.check(false, key.c_str(), one_of(known) + did_you_mean(name, known));
}

/// X configuration with the default arm length, numbered as in x500.yaml.
std::vector<Rotor> quad_rotors(const Airframe& airframe) {
  const double reach_m = airframe.arm_length_m * 0.70710678118654752;
  const double height_m = 0.5 * airframe.body_height_m;
  return {{{reach_m, -reach_m, height_m}, Rotor::Spin::kCcw},
          {{-reach_m, reach_m, height_m}, Rotor::Spin::kCcw},
          {{reach_m, reach_m, height_m}, Rotor::Spin::kCw},
          {{-reach_m, -reach_m, height_m}, Rotor::Spin::kCw}};
}

std::string sensor_name(const Module& sensor) {
  const auto* config = dynamic_cast<const SensorConfig*>(sensor.config.get());
  return config == nullptr ? "" : config->name;
}

bool carries(const VehicleConfig& vehicle, std::string_view sensor_type) {
  return std::any_of(vehicle.sensors.begin(), vehicle.sensors.end(),
                     [&](const Module& sensor) { return sensor.type == sensor_type; });
}

/// Gives unnamed sensors the name of their type; checks that names are unique.
void name_sensors(ConfigVisitor& v, std::vector<Module>& sensors) {
  std::vector<std::string> names;
  bool unique = true;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const std::string name = sensor_name(sensors[i]);
    if (name.empty()) continue;
    check_name(v, name, names, element("sensors", i, "name"));
    unique = unique && !contains(names, name);
    names.push_back(name);
  }
  if (!unique) return;
  names = sensor_names(sensors);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (auto* config = dynamic_cast<SensorConfig*>(sensors[i].config.get())) config->name = names[i];
  }
}

/// Gives unnamed vehicles the names uav1, uav2, ... by their position in the list.
std::vector<std::string> name_vehicles(ConfigVisitor& v, std::vector<VehicleConfig>& vehicles) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    if (vehicles[i].name.empty()) vehicles[i].name = "uav" + std::to_string(i + 1);
    check_name(v, vehicles[i].name, names, element("vehicles", i, "name"));
    names.push_back(vehicles[i].name);
  }
  return names;
}

/// Names of the LiDARs available to a camera: those of its vehicle, by default the first.
std::vector<std::string> lidars_of(const CameraConfig& camera, const std::vector<VehicleConfig>& vehicles) {
  std::vector<std::string> names;
  for (const VehicleConfig& vehicle : vehicles) {
    if (!camera.vehicle.empty() && vehicle.name != camera.vehicle) continue;
    for (const Module& sensor : vehicle.sensors) {
      if (sensor.type == "lidar") names.push_back(sensor_name(sensor));
    }
    break;
  }
  return names;
}

/// Names of all overlays that the agents may draw, as "NAME" and "uav1/NAME"; empty when an agent does not list its
/// own.
OverlayNames drawn_by(const std::vector<VehicleConfig>& vehicles) {
  std::vector<std::string> names = {"*"};
  for (const VehicleConfig& vehicle : vehicles) {
    const OverlayNames drawn = overlays_of(vehicle.agent);
    if (!drawn) return std::nullopt;
    for (const std::string& name : *drawn) {
      if (!contains(names, name)) names.push_back(name);
      names.push_back(vehicle.name + "/" + name);
    }
  }
  return names;
}

void check_overlays(ConfigVisitor& v, const std::vector<std::string>& overlays, const std::vector<std::string>& drawn,
                    const std::string& key) {
  for (std::size_t i = 0; i < overlays.size(); ++i) {
    if (contains(drawn, overlays[i])) continue;
    v.check(false, (key + "[" + std::to_string(i) + "]").c_str(),
            "what an agent draws (swiftlet list overlays)" + did_you_mean(overlays[i], drawn));
  }
}

void check_cameras(ConfigVisitor& v, const Scenario& scenario, const std::vector<std::string>& vehicle_names) {
  std::vector<std::string> names;
  const OverlayNames drawn = drawn_by(scenario.vehicles);
  for (std::size_t i = 0; i < scenario.snapshots.size(); ++i) {
    const CameraConfig& camera = scenario.snapshots[i];
    check_name(v, camera.name, names, element("snapshots", i, "name"));
    check_exists(v, camera.vehicle, vehicle_names, element("snapshots", i, "vehicle"));
    if (camera.looks_through_lidar())
      check_exists(v, camera.sensor, lidars_of(camera, scenario.vehicles), element("snapshots", i, "sensor"));
    if (drawn) check_overlays(v, camera.overlays, *drawn, element("snapshots", i, "overlays"));
    names.push_back(camera.name);
  }
}

/// Folder of the file in "folder/a.yaml:3:9: plugins: "; empty when it is no file.
std::filesystem::path folder_of(const std::string& place) {
  std::string file = place.substr(0, place.find(": plugins"));
  for (int numbers = 0; numbers < 2; ++numbers) {
    const std::size_t colon = file.rfind(':');
    if (colon == std::string::npos) return {};
    file.resize(colon);
  }
  return std::filesystem::path(file).parent_path();
}

void read_plugins(ConfigVisitor& v) {
  std::vector<std::string> plugins = loaded_plugins();
  v.field("plugins", plugins, "[-] shared libraries with additional modules; loading requires --allow-plugins");
  const auto* provider = dynamic_cast<const PlaceProvider*>(&v);
  if (provider == nullptr) return;
  for (const std::string& plugin : plugins) {
    const std::string expected = load_plugin(plugin, folder_of(provider->place_of("plugins")));
    // Immediately: without the plugin's modules, the rest would be rejected as well.
    if (!expected.empty()) throw InputError(provider->place_of("plugins") + "expected " + expected);
  }
}

bool is_selected(const std::vector<std::string>& selection, const std::string& name) {
  return selection.empty() || contains(selection, name);
}

bool is_lidar_of(const std::vector<std::string>& selection, const Module& sensor) {
  return sensor.type == "lidar" && is_selected(selection, sensor_name(sensor));
}

/// Checks the names of a vehicle's LiDARs as ROS frames, together with the vehicle's own frames.
void check_ros_lidars(ConfigVisitor& v, const RosConfig& ros, const VehicleConfig& vehicle, const std::string& place) {
  std::map<std::string, std::string> frames = {{"body", "body"}, {"local", "local"}};
  for (std::size_t i = 0; i < vehicle.sensors.size(); ++i) {
    if (!is_lidar_of(ros.sensors, vehicle.sensors[i])) continue;
    const std::string expected = expected_ros_name(sensor_name(vehicle.sensors[i]), frames);
    v.check(expected.empty(), (place + element("sensors", i, "name")).c_str(), expected);
  }
}

/// Checks that the names of ROS topics and frames are valid and distinct.
void check_ros_names(ConfigVisitor& v, const Scenario& scenario) {
  for (const Module& recorder : scenario.recorders) {
    const auto* const ros = dynamic_cast<const RosConfig*>(recorder.config.get());
    if (ros == nullptr) continue;
    std::map<std::string, std::string> names;
    for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
      const VehicleConfig& vehicle = scenario.vehicles[i];
      if (!is_selected(ros->vehicles, vehicle.name)) continue;
      const std::string expected = expected_ros_name(vehicle.name, names);
      v.check(expected.empty(), element("vehicles", i, "name").c_str(), expected);
      check_ros_lidars(v, *ros, vehicle, "vehicles[" + std::to_string(i) + "].");
    }
  }
}

/// Checks for distinct names of the folders VEHICLE_LIDAR of scan file recorders.
void check_scan_folders(ConfigVisitor& v, const Scenario& scenario) {
  for (const Module& recorder : scenario.recorders) {
    const auto* const files = dynamic_cast<const ScanFilesConfig*>(recorder.config.get());
    if (files == nullptr) continue;
    std::set<std::string> folders;
    for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
      const VehicleConfig& vehicle = scenario.vehicles[i];
      for (std::size_t k = 0; is_selected(files->vehicles, vehicle.name) && k < vehicle.sensors.size(); ++k) {
        if (!is_lidar_of(files->sensors, vehicle.sensors[k])) continue;
        const std::string folder = vehicle.name + "_" + sensor_name(vehicle.sensors[k]);
        v.check(folders.insert(folder).second,
                ("vehicles[" + std::to_string(i) + "]." + element("sensors", k, "name")).c_str(),
                "a name whose folder of scans no other LiDAR has; " + folder + " is taken");
      }
    }
  }
}

/// Formats a mass in grams' resolution; `round` is std::floor for an upper and std::ceil for a lower limit.
std::string kilograms(double mass_kg, double (*round)(double)) {
  return yaml_number(round(mass_kg * 1e3) / 1e3) + " kg";
}

/// Checks that the rotors can lift the vehicle, and that it can descend.
void check_thrust(ConfigVisitor& v, const Scenario& scenario) {
  const double gravity_mps2 = scenario.physics.gravity_world_mps2.norm();
  for (std::size_t i = 0; gravity_mps2 > 0.0 && i < scenario.vehicles.size(); ++i) {
    const VehicleConfig& vehicle = scenario.vehicles[i];
    const Airframe& airframe = vehicle.airframe;
    if (airframe.rotors.empty() || vehicle.agent.type == "none") continue;  // without an agent it does not fly
    const std::string key = element("vehicles", i, "airframe.mass_kg");
    const double most_kg = airframe.max_thrust_N() / (kMinThrustRatio * gravity_mps2);
    const double ratio = airframe.rotor_speed_min_radps / airframe.rotor_speed_max_radps;
    const double least_kg = airframe.max_thrust_N() * ratio * ratio / gravity_mps2;
    v.check(airframe.mass_kg <= most_kg, key.c_str(),
            "at most " + kilograms(most_kg, std::floor) +
                ", because a vehicle flies only when its rotors can carry 1.1 times its weight");
    v.check(airframe.mass_kg >= least_kg, key.c_str(),
            "at least " + kilograms(least_kg, std::ceil) +
                ", because lighter than that the vehicle climbs even at rotor_speed_min_radps");
  }
}

void check_time(ConfigVisitor& v, const Scenario& scenario) {
  const TimeNs step = from_seconds(scenario.physics.step_s);
  const TimeNs tick = from_seconds(scenario.tick_s);
  v.check(step > 0 && tick >= step && tick % step == 0, "tick_s", "a whole multiple of physics.step_s");
  v.check(from_seconds(scenario.duration_s) >= tick, "duration_s", "at least one tick_s");
}

}  // namespace

void StartConfig::visit(ConfigVisitor& v) {
  v.field("position_m", position_m,
          "[m] position of the center of mass, world frame; on legs, z is airframe.leg_height_m above the ground",
          Range::between(-1e5, 1e5));
  v.field("above_ground", above_ground, "[-] z is relative to the ground below");
  v.field("yaw_deg", yaw_deg, "[deg] heading, counter-clockwise from east");
  v.field("velocity_mps", velocity_mps, "[m/s] velocity, world frame", Range::between(-200.0, 200.0));
  v.field("flying", flying, "[-] rotors turn at hover speed at the start");
  v.choice("known", known, {"pose", "position", "nothing"},
           "[-] start state known to the vehicle's software: position_m and yaw_deg, position_m, or nothing");
  v.field("spacing_m", spacing_m, "[m] distance along x and y between the vehicles of a count",
          Range::between(-1e4, 1e4));
  v.field("columns", columns, "[-] vehicles of a count in a row along x, before the next row; 0: all of them",
          Range::between(0, kMaxVehicles));
}

VehicleConfig::VehicleConfig() : agent(agent_module_types(), agent_module_types().front().name) {
  airframe.rotors = quad_rotors(airframe);
}

void VehicleConfig::visit(ConfigVisitor& v) {
  v.model("model", model, "vehicles", "[-] airframe and controller gains");
  v.field("name", name, "[-] unique; empty: uav1, uav2, ...");
  v.field("count", count, "[-] number of copies NAME1, NAME2, ..., with starts in a row or a grid (docs/scenarios.md)",
          Range::between(1, kMaxVehicles));
  v.object("airframe", airframe, "physical data, normally from the model");
  v.object("markers", markers, "retro-reflective markers detectable by other vehicles' LiDARs");
  v.object("start", start, "state at time 0");
  v.modules("sensors", sensors, sensor_module_types(), "[-] sensors aboard");
  v.module("agent", agent, agent_module_types(), "[-] software of the vehicle");
  if (const auto* provider = dynamic_cast<const PlaceProvider*>(&v)) {
    for (const char* key : {"start.position_m", "agent"}) places[key] = provider->place_of(key);
    for (const NamedPlace& place : destinations_of(*this)) places[place.key] = provider->place_of(place.key.c_str());
  }
  name_sensors(v, sensors);
  v.check(!airframe.rotors.empty(), "airframe.rotors", "at least one rotor");
}

Scenario::Scenario() : world(world_module_types(), "field"), vehicles(1) { vehicles[0].name = "uav1"; }

void Scenario::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] name of the run and of its directory");
  v.field("description", description, "[-] one sentence about the scenario");
  read_plugins(v);  // the following keys may name modules of plugins
  v.field("seed", seed, "[-] random seed of the run; equal seeds give equal results");
  v.field("world_seed", world_seed, "[-] random seed of the world, for equal worlds at different seeds; 0: as seed");
  v.field("duration_s", duration_s, "[s] simulated time at which the run ends at the latest", Range{0.0, 1e7, true});
  v.field("tick_s", tick_s, "[s] period of sensing and control; a whole multiple of physics.step_s",
          Range{0.0, 1.0, true});
  v.field("start_time_s", start_time_s,
          "[s] added to every time in recordings, such as 1700000000 for seconds since 1970; replays, pictures and "
          "summaries count from 0",
          Range::between(0.0, 2e9));
  v.object("physics", physics, "simulated physical effects");
  v.module("world", world, world_module_types(), "[-] the static world, from a generator");
  v.object("wind", wind, "mean wind and gusts");
  v.object("radio", radio, "messages between vehicles");
  v.list("vehicles", vehicles, "the team, in the order of their numbers");
  v.modules("recorders", recorders, recorder_module_types(), "[-] recorders that write into the run directory");
  v.list("snapshots", snapshots, "cameras that take pictures");
  if (const auto* provider = dynamic_cast<const PlaceProvider*>(&v)) snapshots_place = provider->place_of("snapshots");
  v.object("metrics", metrics, "settings of the metrics, and conditions that end the run");

  v.check(is_file_name(name), "name", kNameRule);
  check_time(v, *this);
  v.check(vehicles.size() <= std::size_t{kMaxVehicles}, "vehicles",
          "at most " + std::to_string(kMaxVehicles) + " vehicles");
  const std::vector<std::string> vehicle_names = name_vehicles(v, vehicles);
  check_thrust(v, *this);
  check_recorders(v, recorders, &vehicle_names);
  check_ros_names(v, *this);
  check_scan_folders(v, *this);
  check_cameras(v, *this, vehicle_names);
}

Scenario load_scenario(const std::filesystem::path& file,
                       const std::vector<std::pair<std::string, std::string>>& overrides) {
  Scenario scenario;
  read_config(
      file, [&](ConfigVisitor& v) { scenario.visit(v); }, overrides);
  return scenario;
}

Scenario with_truth_sensors(Scenario scenario) {
  for (VehicleConfig& vehicle : scenario.vehicles) {
    const AgentNeeds needs = needs_of(vehicle.agent);
    if (needs.true_pose && !carries(vehicle, "pose")) vehicle.sensors.emplace_back(sensor_module_types(), "pose");
    if (needs.true_neighbors && !carries(vehicle, "neighbors")) {
      vehicle.sensors.emplace_back(sensor_module_types(), "neighbors").as<NeighborsConfig>().ideal = true;
    }
  }
  return scenario;
}

std::string write_scenario(const Scenario& scenario) {
  Scenario copy = with_truth_sensors(scenario);
  const auto write = [&] { return write_config([&](ConfigVisitor& v) { copy.visit(v); }); };
  (void)write();  // the visit fills in empty names
  return write();
}

Scenario validated(const Scenario& scenario) {
  Scenario checked;
  read_config_text(write_scenario(scenario), scenario.name, [&](ConfigVisitor& v) { checked.visit(v); });
  checked.snapshots_place = scenario.snapshots_place;
  if (checked.vehicles.size() != scenario.vehicles.size()) return checked;  // some vehicles had a `count`
  for (std::size_t i = 0; i < checked.vehicles.size(); ++i) checked.vehicles[i].places = scenario.vehicles[i].places;
  return checked;
}

}  // namespace swiftlet::sim
