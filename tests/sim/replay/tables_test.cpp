// SPDX-License-Identifier: BSD-3-Clause
// Every table of a replay read back and compared with its source.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "sim/replay/block.hpp"
#include "sim/replay/overlay_tables.hpp"
#include "sim/replay/page.hpp"
#include "sim/replay/rows.hpp"
#include "sim/replay/scan_tables.hpp"
#include "sim/replay/world_tables.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/render/colors.hpp"
#include "swiftlet/sim/replay/live_server.hpp"
#include "swiftlet/sim/replay/replay.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"
#include "tests/sim/replay/decode.hpp"
#include "tests/support/synthetic_run.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

using nlohmann::json;

json rgb_of(const Rgb& color) {
  return {std::lround(255.0F * color.x()), std::lround(255.0F * color.y()), std::lround(255.0F * color.z())};
}

TEST(ReplayBlock, DifferencesOfEverySizeReadBack) {
  std::vector<double> values = {0};
  for (int bit = 0; bit < 29; ++bit) {
    const double power = std::ldexp(1.0, bit);
    for (const double value : {power, -power, power - 1, 1 - power, power + 1}) values.push_back(value);
  }
  ReplayTable table("{}", {{"n", 1.0}, {"half", 0.5}});
  for (const double value : values) table.add({value, 0.25 * value});
  EXPECT_EQ(table.rows(), values.size());
  ReplayBlock block("{}");
  EXPECT_TRUE(block.empty());
  block.add(table);
  EXPECT_FALSE(block.empty());
  const ReadTable read = read_block(block.bytes()).tables[0];
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(read["n"][i], values[i]);
    EXPECT_EQ(read["half"][i], 0.5 * std::round(0.5 * values[i])) << values[i];
  }
  table.clear();
  EXPECT_EQ(table.rows(), 0U);
}

TEST(ReplayPage, OnlyTheLivePageMayConnect) {
  EXPECT_EQ(page_head().find("connect-src"), std::string::npos);
  EXPECT_NE(page_head(PageUse::kLive).find("connect-src 'self'"), std::string::npos);
}

class Overlays : public ::testing::Test {
 protected:
  std::vector<ReadTable> write(const std::vector<Overlay>& overlays, int tick) {
    TickView view = run_.tick(tick);
    Action action = *view.actions[0];
    action.overlays = overlays;
    action.estimate = {};
    const Action* const actions[] = {&action};
    view.actions = actions;
    tables_.write(view);
    ReplayBlock block("{}");
    tables_.move_to(block);
    std::vector<ReadTable> own;
    for (ReadTable& table : read_block(block.bytes()).tables) own.push_back(std::move(table));
    return own;
  }
  static Overlay overlay(const std::string& name, Overlay::Kind kind, int count) {
    Overlay made;
    made.name = name;
    made.kind = kind;
    for (int i = 0; i < count; ++i) made.positions.emplace_back(0.01F * static_cast<float>(i), -1.0F, 2.5F);
    return made;
  }
  static const ReadTable* find(const std::vector<ReadTable>& tables, const std::string& name) {
    for (const ReadTable& table : tables) {
      if (table.about["name"] == name) return &table;
    }
    return nullptr;
  }

  TemporaryDirectory folder_;
  SyntheticRun run_{folder_.path()};
  OverlayTables tables_{10 * SyntheticRun::kTick};
};

TEST_F(Overlays, WriteKindSizeColorsAndLegend) {
  const char* kinds[] = {"points", "lines", "polyline", "cubes", "spheres", "triangles"};
  for (int kind = 0; kind < 6; ++kind) {
    Overlay made = overlay(kinds[kind], static_cast<Overlay::Kind>(kind), 6);
    made.size_m = 0.25F;
    made.legend = {{"what it means", {0.2F, 0.4F, 2.0F, -1.0F}}};
    made.colors.assign(1, {1.0F, 0.5F, 0.0F, 0.25F});
    const auto tables = write({made}, 11 + kind);
    const ReadTable* found = find(tables, kinds[kind]);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->about["kind"], kinds[kind]);
    EXPECT_EQ(found->about["size"], 0.25);
    EXPECT_EQ(found->about["of"], 6);
    EXPECT_EQ(found->about["vehicle"], 0);
    EXPECT_NEAR(found->about["t_s"].get<double>(), 0.11 + 0.01 * kind, 1e-9);
    EXPECT_EQ(found->about["palette"], json::parse("[[255,128,0,64]]"));
    EXPECT_EQ(found->about["legend"], json::parse(R"([{"meaning":"what it means","color":[51,102,255,0]}])"));
    EXPECT_EQ(found->names, (std::vector<std::string>{"x_m", "y_m", "z_m"}));
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR((*found)["x_m"][i], 0.01 * i, 1e-6);
      EXPECT_NEAR((*found)["y_m"][i], -1.0, 1e-6);
      EXPECT_NEAR((*found)["z_m"][i], 2.5, 1e-6);
    }
  }
}

TEST_F(Overlays, CountEachOfManyColors) {
  Overlay made = overlay("colored", Overlay::Kind::kPoints, 5);
  const Eigen::Vector4f red(1, 0, 0, 1), blue(0, 0, 1, 1);
  made.colors = {red, blue, blue, red, blue};
  const auto tables = write({made}, 11);
  const ReadTable* found = find(tables, "colored");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->about["palette"], json::parse("[[255,0,0,255],[0,0,255,255]]"));
  EXPECT_EQ((*found)["color"], (std::vector<double>{0, 1, 1, 0, 1}));
  Overlay one = overlay("one", Overlay::Kind::kPoints, 1);
  one.colors = {red};
  const auto second = write({one}, 12);
  EXPECT_EQ(find(second, "one")->names.size(), 3U) << "one color for all";
  EXPECT_TRUE(find(write({overlay("none", Overlay::Kind::kPoints, 2)}, 13), "none")->about["palette"].empty());
}

TEST_F(Overlays, NumberEqualAndOmitReservedNames) {
  const auto tables =
      write({overlay("cells", Overlay::Kind::kCubes, 1), overlay("cells", Overlay::Kind::kCubes, 2),
             overlay("cells", Overlay::Kind::kCubes, 3), overlay("tracks", Overlay::Kind::kPoints, 1),
             overlay("tracks.cov", Overlay::Kind::kPoints, 1), overlay("detections", Overlay::Kind::kPoints, 1)},
            11);
  ASSERT_EQ(tables.size(), 4U) << "three overlays and the map, which is due";
  EXPECT_EQ(find(tables, "cells")->rows(), 1U);
  EXPECT_EQ(find(tables, "cells#1")->rows(), 2U);
  EXPECT_EQ(find(tables, "cells#2")->rows(), 3U);
}

// Groups stay together: both ends of a line, the corners of a triangle.
TEST_F(Overlays, ThinLargeOverlaysInWholeGroups) {
  int tick = 10;
  for (const auto& [kind, group] :
       {std::pair(Overlay::Kind::kLines, 2U), {Overlay::Kind::kTriangles, 3U}, {Overlay::Kind::kCubes, 1U}}) {
    const auto tables = write({overlay("large", kind, 24006)}, tick += 10);
    const ReadTable& large = *find(tables, "large");
    EXPECT_EQ(large.about["of"], 24006);
    EXPECT_LE(large.rows(), 12000U);
    EXPECT_GE(large.rows(), 6000U);
    ASSERT_EQ(large.rows() % group, 0U);
    for (std::size_t row = 0; row < large.rows(); ++row) {
      if (row % group != 0) {
        ASSERT_LT(large["x_m"][row] - large["x_m"][row - 1], 0.03) << row;
      }
    }
    EXPECT_GT(large["x_m"].back(), 239.0) << "evenly, up to the end";
  }
}

TEST_F(Overlays, KeepPolylinesWhole) {
  const auto tables =
      write({overlay("path", Overlay::Kind::kPolyline, 700), overlay("long", Overlay::Kind::kPolyline, 20000)}, 10);
  for (const auto& [name, rows] : {std::pair("path", 700U), {"long", 20000U}}) {
    const ReadTable* found = find(tables, name);
    ASSERT_NE(found, nullptr) << name;
    EXPECT_EQ(found->rows(), rows) << name;
  }
}

TEST_F(Overlays, WriteChangesAndRemovalsOnce) {
  const Overlay path = overlay("path", Overlay::Kind::kPolyline, 5);
  const auto rows_at = [&](const std::vector<Overlay>& overlays, int tick) {
    const auto tables = write(overlays, tick);
    const ReadTable* found = find(tables, "path");
    return found == nullptr ? -1 : static_cast<int>(found->rows());
  };
  EXPECT_EQ(rows_at({path}, 11), 5);
  EXPECT_EQ(rows_at({path}, 12), -1) << "unchanged";
  EXPECT_EQ(rows_at({}, 13), 0);
  EXPECT_EQ(rows_at({}, 14), -1);
  EXPECT_EQ(rows_at({path}, 15), 5);
}

TEST_F(Overlays, ShowMapsExceptThoseOfDetectors) {
  const auto tables = write({}, 10);
  ASSERT_EQ(tables.size(), 1U);
  EXPECT_EQ(tables[0].about["name"], "map.mapping");
  EXPECT_EQ(tables[0].about["kind"], "cubes");
  EXPECT_NEAR(tables[0].about["size"].get<double>(), 0.9 * 0.2, 0.02) << "a gap between cells";
  ASSERT_EQ(tables[0].rows(), 1U);
  EXPECT_NEAR(tables[0]["x_m"][0], 1.1, 0.006);
  EXPECT_NEAR(tables[0]["y_m"][0], 2.3, 0.006);
  EXPECT_NEAR(tables[0]["z_m"][0], -0.7, 0.006);
  OverlayTables never(0);
  never.write(run_.tick(20));
  ReplayBlock block("{}");
  never.move_to(block);
  for (const ReadTable& table : read_block(block.bytes()).tables)
    EXPECT_NE(table.about["name"].get<std::string>().rfind("map.", 0), 0U);
}

TEST(ReplayWorld, MeshesAndTheirPlacesReadBack) {
  Scene scene;
  scene.materials = {{"a", 0.3F, false, {1.0F, 0.5F, 0.2F}}, {"b", 0.3F, false, {0.0F, 0.25F, 1.0F}}};
  const SurfaceClass classes[] = {SurfaceClass::kGround, SurfaceClass::kVegetation, SurfaceClass::kBranch,
                                  SurfaceClass::kWall};
  for (std::uint32_t m = 0; m < 4; ++m) {
    Mesh mesh;
    mesh.material = m % 2;
    mesh.surface_class = classes[m];
    mesh.vertices_mesh_m.emplace_back(99, 99, 99);  // unused vertex
    add_box(mesh, Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 2, 3.5F + static_cast<float>(m)));
    std::reverse(mesh.triangles.begin(), mesh.triangles.end());
    scene.meshes.push_back(mesh);
  }
  scene.meshes.emplace_back();              // empty
  scene.meshes.push_back(scene.meshes[3]);  // nowhere
  Eigen::Affine3f T = Eigen::Affine3f::Identity();
  T.translate(Eigen::Vector3f(10, -20, 3))
      .rotate(Eigen::AngleAxisf(0.7F, Eigen::Vector3f(1, 2, 3).normalized()))
      .scale(1.5F);
  for (std::uint32_t m = 0; m < 5; ++m) scene.instances.push_back({m, T, static_cast<std::uint16_t>(7 + m)});
  scene.instances.push_back({1, Eigen::Affine3f::Identity(), 0});
  ReplayBlock block("{}");
  append_world(scene, 100000, block);
  const ReadBlock read = read_block(block.bytes());
  ASSERT_EQ(read.tables.size(), 12U);
  for (std::size_t m = 0; m < 4; ++m) {
    const ReadTable &vertices = read.tables[3 * m], &triangles = read.tables[3 * m + 1],
                    &places = read.tables[3 * m + 2];
    const Mesh& mesh = scene.meshes[m];
    EXPECT_EQ(vertices.about["table"], "vertices");
    EXPECT_EQ(vertices.about["kind"], m == 0 ? "ground" : m == 1 ? "plant" : "plain");
    EXPECT_EQ(vertices.about["color"], rgb_of(scene.materials[m % 2].color_rgb));
    EXPECT_EQ(vertices.rows(), 8U) << "those that are used";
    ASSERT_EQ(triangles.rows(), mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int c = 0; c < 3; ++c) {
        const auto number = static_cast<std::size_t>(triangles.columns[c][t]);
        const Eigen::Vector3f& p = mesh.vertices_mesh_m[mesh.triangles[t][c]];
        for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(vertices.columns[axis][number], p[axis], 0.0011);
      }
    }
    ASSERT_EQ(places.rows(), m == 1 ? 2U : 1U);
    const char* names[] = {"xx", "yx", "zx", "xy", "yy", "zy", "xz", "yz", "zz", "x_m", "y_m", "z_m"};
    for (int i = 0; i < 12; ++i)
      EXPECT_NEAR(places[names[i]][0], T.matrix()(i % 3, i / 3), i < 9 ? 6e-5 : 6e-4) << names[i];
    EXPECT_EQ(places["instance"][0], static_cast<double>(7 + m));
  }
}

class WholeReplay : public ::testing::Test {
 protected:
  std::vector<ReadBlock> write(const ReplayConfig& config, int ticks, const Scene* scene = nullptr) {
    SyntheticRun run(folder_.path());
    RunInfo info = run.info();
    info.scene = scene;
    auto recorder = make_replay_recorder(config, folder_.path() / "a.html");
    recorder->begin(info);
    for (int k = 0; k <= ticks; ++k) recorder->write(run.tick(k));
    const auto paths = recorder->finish();
    EXPECT_EQ(paths, (std::vector<std::filesystem::path>{"a.html"}));
    return read_page(read_whole_file(folder_.path() / "a.html"));
  }
  static std::vector<double> column(const std::vector<ReadBlock>& blocks, const std::string& table,
                                    const std::string& name) {
    std::vector<double> values;
    for (const ReadBlock& block : blocks) {
      for (const ReadTable& one : block.tables) {
        if (one.about["table"] != table || one.rows() == 0) continue;
        values.insert(values.end(), one[name].begin(), one[name].end());
      }
    }
    return values;
  }

  TemporaryDirectory folder_;
};

TEST_F(WholeReplay, WritesRatesBoundsAndPaletteFirst) {
  Scene scene;
  scene.bounds_m = Eigen::AlignedBox3d(Vector3(-1, -2, -3), Vector3(4, 5, 6));
  scene.materials.resize(1);
  scene.meshes.resize(1);
  add_box(scene.meshes[0], Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 1, 1));
  scene.instances.resize(2);
  ReplayConfig config;
  config.rate_hz = 10.0;
  const auto blocks = write(config, 10, &scene);
  const json& head = blocks.front().about;
  EXPECT_EQ(head["format"], 1);
  EXPECT_EQ(head["bounds_m"], json::parse("[[-1.0,-2.0,-3.0],[4.0,5.0,6.0]]"));
  EXPECT_EQ(head["triangles"], 24);
  EXPECT_EQ(head["rates"]["state_hz"], 10.0);
  const json& palette = head["palette"];
  EXPECT_EQ(palette["vehicles"], json({rgb_of(vehicle_color(0)), rgb_of(vehicle_color(1))}));
  EXPECT_EQ(palette["height"].front(), rgb_of(height_color(0.0F)));
  EXPECT_EQ(palette["intensity"].back(), rgb_of(viridis_like(1.0F)));
  ASSERT_EQ(palette["classes"].size(), static_class_names().size() + 1);
  for (const json& one : palette["classes"])
    EXPECT_EQ(one["color"], rgb_of(class_color(one["number"].get<std::uint16_t>())));
  EXPECT_EQ(blocks[1].about["kind"], "world");
}

TEST_F(WholeReplay, ChunksHaveTwoSecondsEach) {
  const auto blocks = write({}, 450);
  std::vector<double> starts;
  for (const ReadBlock& block : blocks) {
    if (block.about["kind"] != "chunk") continue;
    starts.push_back(block.about["t_s"]);
    for (const ReadTable& table : block.tables) {
      if (table.about["table"] != "detections" || table.rows() == 0) continue;
      EXPECT_GE(table["t_s"].front(), starts.back() - 1e-6);
      EXPECT_LT(table["t_s"].back(), starts.back() + 2.0);
    }
  }
  EXPECT_EQ(starts, (std::vector<double>{0.0, 2.0, 4.0}));
}

TEST_F(WholeReplay, WritesCompleteDetectionsAndTracks) {
  const auto blocks = write({}, 3);
  SyntheticRun again(folder_.path());
  std::size_t d = 0, t = 0;
  const auto detections = [&](const char* name) { return column(blocks, "detections", name); };
  const auto tracks = [&](const char* name) { return column(blocks, "tracks", name); };
  for (int k = 0; k <= 3; ++k) {
    const TickView& tick = again.tick(k);
    for (std::size_t v = 0; v < tick.actions.size(); ++v) {
      for (const Detection& one : tick.actions[v]->detections) {
        EXPECT_NEAR(detections("t_s").at(d), 0.01 * k, 1e-9);
        EXPECT_EQ(detections("vehicle")[d], static_cast<double>(v));
        EXPECT_NEAR(detections("y_m")[d], one.position_m.y(), 0.006);
        EXPECT_NEAR(detections("extent_z_m")[d], one.extent_m.z(), 0.006);
        EXPECT_EQ(detections("points")[d], one.num_points);
        EXPECT_NEAR(detections("confidence")[d], one.confidence, 0.006);
        ++d;
      }
      if (!tick.actions[v]->has_tracks) continue;
      for (const Track& one : tick.actions[v]->tracks) {
        EXPECT_EQ(tracks("id").at(t), static_cast<double>(one.id));
        EXPECT_NEAR(tracks("x_m")[t], one.position_m.x(), 0.006);
        EXPECT_NEAR(tracks("vz_mps")[t], one.velocity_mps.z(), 0.006);
        const std::tuple<const char*, int, int> entries[] = {{"xx", 0, 0}, {"xy", 0, 1}, {"xz", 0, 2},
                                                             {"yy", 1, 1}, {"yz", 1, 2}, {"zz", 2, 2}};
        for (const auto& [name, i, j] : entries) EXPECT_NEAR(tracks(name)[t], one.covariance(i, j), 6e-5) << name;
        EXPECT_EQ(tracks("corrected")[t], one.corrected ? 1.0 : 0.0);
        EXPECT_EQ(tracks("detections")[t], static_cast<double>(one.num_detections));
        ++t;
      }
    }
  }
  EXPECT_EQ(detections("t_s").size(), d);
  EXPECT_EQ(tracks("id").size(), t);
  EXPECT_GT(d, 0U);
}

TEST_F(WholeReplay, WritesCompleteEvents) {
  json events = json::array();
  for (const ReadBlock& block : write({}, 10)) {
    if (block.about.contains("events"))
      events.insert(events.end(), block.about["events"].begin(), block.about["events"].end());
  }
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0]["kind"], "crash");
  EXPECT_NEAR(events[0]["t_s"].get<double>(), 0.07, 1e-9);
  EXPECT_EQ(events[0]["vehicle"], 1);
  EXPECT_EQ(events[0]["partner"], "trunk \"17\"");
  EXPECT_EQ(events[0]["position_m"].size(), 3U);
  EXPECT_EQ(events[1]["note"], "time is up");
}

std::string answer_to(const std::string& address, const std::string& request) {
  const std::size_t colon = address.find(':', 7);
  const int connection = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(connection, reinterpret_cast<sockaddr*>(&place), sizeof place), 0);
  send(connection, request.data(), request.size(), MSG_NOSIGNAL);
  std::string answer;
  char part[4096];
  for (ssize_t count = 0; (count = recv(connection, part, sizeof part, 0)) > 0;)
    answer.append(part, static_cast<std::size_t>(count));
  close(connection);
  return answer;
}

TEST(LiveServer, AnswersOnlyReadersWithItsAddress) {
  LiveServer server;
  const std::string& address = server.address();
  ASSERT_EQ(address.rfind("http://127.0.0.1:", 0), 0U);
  const std::string host = address.substr(7, address.find('/', 7) - 7), token = address.substr(address.find('/', 7));
  ASSERT_EQ(token.size(), 34U) << "32 digits between two strokes";
  EXPECT_NE(LiveServer().address().substr(address.size() - 33), token.substr(1));
  const auto get = [&](const std::string& path, const std::string& as = "", const std::string& method = "GET") {
    return answer_to(address, method + " " + path + " HTTP/1.1\r\nHost: " + (as.empty() ? host : as) + "\r\n\r\n");
  };
  const auto status = [](const std::string& answer) { return answer.substr(9, 3); };
  const std::string page = get(token);
  EXPECT_EQ(status(page), "200");
  EXPECT_NE(page.find(page_head(PageUse::kLive) + page_tail()), std::string::npos);
  EXPECT_NE(page.find("text/html"), std::string::npos);
  EXPECT_EQ(status(get("/")), "404");
  EXPECT_EQ(status(get(token + "other")), "404");
  EXPECT_EQ(status(get(token, "evil.example")), "403");
  EXPECT_EQ(status(get(token, "", "POST")), "405");
  EXPECT_EQ(status(get(token + "blocks/0")), "204");
  server.put("first");
  server.put("second");
  const std::string first = get(token + "blocks/0"), second = get(token + "blocks/1");
  EXPECT_EQ(status(first), "200");
  EXPECT_EQ(first.substr(first.find("\r\n\r\n") + 4), "first");
  EXPECT_EQ(second.substr(second.find("\r\n\r\n") + 4), "second");
  EXPECT_NE(first.find("Content-Length: 5\r\n"), std::string::npos);
  EXPECT_EQ(status(get(token + "blocks/2")), "204");
  EXPECT_EQ(status(get(token + "blocks/1x")), "404");
  EXPECT_EQ(status(get(token + "blocks/")), "404");
  EXPECT_EQ(status(get(token + "blocks/99999999999999999999999")), "404") << "no number of ours";
  // Long requests are read to their end, too long ones not at all.
  const auto padded = [&](std::size_t size) {
    std::string request = "GET " + token + " HTTP/1.1\r\nHost: " + host + "\r\nX: ";
    request += std::string(size - request.size() - 4, 'x') + "\r\n\r\n";
    return answer_to(address, request);
  };
  EXPECT_EQ(status(padded(5000)), "200");
  EXPECT_EQ(padded(9000), "");
}

TEST(LiveServer, WaitsOnlyForAnOpenPage) {
  {
    LiveServer unread;
    unread.put("last");
    unread.finish();  // at once, before any page request
  }
  LiveServer server;
  const std::string& address = server.address();
  const std::string host = address.substr(7, address.find('/', 7) - 7), token = address.substr(address.find('/', 7));
  const auto get = [&](int number) {
    return answer_to(address,
                     "GET " + token + "blocks/" + std::to_string(number) + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
  };
  server.put("first");
  get(0);
  server.put("last");
  std::atomic<bool> is_over = false;
  std::thread waiting([&] {
    server.finish();
    is_over = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(250));
  EXPECT_FALSE(is_over) << "the page has not had the last one";
  get(0);
  std::this_thread::sleep_for(std::chrono::milliseconds(250));
  EXPECT_FALSE(is_over) << "the page has requested an earlier block only";
  get(1);
  waiting.join();
  EXPECT_TRUE(is_over);
}

}  // namespace
}  // namespace swiftlet::sim
