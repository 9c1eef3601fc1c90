// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/octomap/octomap_file.hpp"

#include <octomap/OcTree.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <locale>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {
namespace {

constexpr int kMiddle = 32768;  // key of the cell at the origin
constexpr int kDepth = 16;      // depth of the octree

/// Log-odds of a cell; empty for an unknown cell.
std::optional<float> log_odds_of(const MapVoxels& map, std::size_t i, const octomap::OcTree& usual) {
  if (map.log_odds) return map.value[i];
  if (map.state[i] >= map.occupied_from) return usual.getClampingThresMaxLog();
  if (map.state[i] == 0) return usual.getClampingThresMinLog();
  return std::nullopt;
}

bool key_of(const Eigen::Vector3f& center_local_m, double edge_m, octomap::OcTreeKey& key) {
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double cell = std::floor(center_local_m[axis] / edge_m) + kMiddle;
    if (!(cell >= 0.0 && cell < 2.0 * kMiddle)) return false;
    key[axis] = static_cast<octomap::key_type>(cell);
  }
  return true;
}

[[noreturn]] void reject(const std::filesystem::path& file, const char* reason) {
  throw InputError(file.string() + ": " + reason);
}

const char* title_of(OctomapFormat format) {
  return format == OctomapFormat::kBt ? "# Octomap OcTree binary file" : "# Octomap OcTree file";
}

struct Header {
  std::size_t num_nodes = 0;
  double edge_m = 0.0;
};

// The library's own reader prints its progress to the terminal and gives few details of errors.
Header read_header(std::istream& in, OctomapFormat format, const std::filesystem::path& file) {
  std::string line, id;
  std::getline(in, line);
  if (line.rfind(title_of(format), 0) != 0) reject(file, "expected an octree of OctoMap, which begins with its title");
  Header header;
  while (std::getline(in, line) && line != "data") {
    std::istringstream words(line);
    words.imbue(std::locale::classic());
    std::string key;
    words >> key;
    if (key == "id") words >> id;
    if (key == "size") words >> header.num_nodes;
    if (key == "res") words >> header.edge_m;
    if (words.fail() && !key.empty()) reject(file, "expected a header with id, size and res");
  }
  if (!in || id != "OcTree") reject(file, "expected a header with the id OcTree, which ends with the line 'data'");
  if (!(header.edge_m > 0.0 && std::isfinite(header.edge_m))) reject(file, "expected a resolution above 0");
  return header;
}

/// The library's readers continue past the end of the data and below the leaves until the stack overflows. Therefore
/// the nodes are counted first: each is a value and a byte of children (.ot), or two bits for each of its children
/// (.bt).
std::size_t count_nodes(const std::string& data, OctomapFormat format, const std::filesystem::path& file) {
  const std::size_t node_bytes = format == OctomapFormat::kBt ? 2 : sizeof(float) + 1;
  std::vector<int> depths = {0};  // depths of the pending nodes
  std::size_t count = 1, at = 0;
  while (!depths.empty()) {
    const int depth = depths.back();
    depths.pop_back();
    if (at + node_bytes > data.size()) reject(file, "ends before its data does");
    std::size_t children = 0, nodes_to_come = 0;
    if (format == OctomapFormat::kOt) {
      nodes_to_come = children = static_cast<std::size_t>(std::popcount(static_cast<unsigned char>(data[at + 4])));
    } else {
      const unsigned bits = static_cast<unsigned char>(data[at]) | static_cast<unsigned char>(data[at + 1]) << 8;
      for (int i = 0; i < 8; ++i) {
        const unsigned child = bits >> (2 * i) & 3U;  // 0 unknown, 1 and 2 leaves, 3 inner node
        children += child != 0;
        nodes_to_come += child == 3;
      }
    }
    if (children > 0 && depth == kDepth) reject(file, "expected a tree of 16 levels, found a deeper one");
    count += children;
    at += node_bytes;
    depths.insert(depths.end(), nodes_to_come, depth + 1);
  }
  return count;
}

double cells_across(unsigned depth) { return std::ldexp(1.0, kDepth - static_cast<int>(depth)); }

}  // namespace

std::string octomap_content(const MapVoxels& map, OctomapFormat format, const std::vector<std::string>& comments) {
  const octomap::OcTree usual(map.edge_m);
  octomap::OcTree tree(map.edge_m);
  tree.setClampingThresMin(1e-9);  // the library's default limits would clamp values of maps with other limits
  tree.setClampingThresMax(1.0 - 1e-9);
  octomap::OcTreeKey key;
  for (std::size_t i = 0; i < map.size(); ++i) {
    const std::optional<float> log_odds = log_odds_of(map, i, usual);
    if (log_odds && key_of(map.centers_local_m[i], map.edge_m, key)) tree.setNodeValue(key, *log_odds, true);
  }
  tree.updateInnerOccupancy();
  if (format == OctomapFormat::kBt) tree.toMaxLikelihood();
  tree.prune();
  // The header is written here because the library's function prints its progress to the terminal.
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(10);
  out << title_of(format) << "\n";
  for (const std::string& comment : comments) out << "# " << comment << "\n";
  out << "id OcTree\nsize " << tree.size() << "\nres " << map.edge_m << "\ndata\n";
  if (tree.size() > 0) format == OctomapFormat::kOt ? tree.writeData(out) : tree.writeBinaryData(out);
  return std::move(out).str();
}

bool is_octomap_file(const std::filesystem::path& file) {
  return file.extension() == ".bt" || file.extension() == ".ot";
}

OctomapCells read_octomap(const std::filesystem::path& file, const std::function<void(double)>& require_bytes) {
  std::ifstream in(file, std::ios::binary);
  if (!in) reject(file, "cannot be read");
  const OctomapFormat format = file.extension() == ".bt" ? OctomapFormat::kBt : OctomapFormat::kOt;
  const Header header = read_header(in, format, file);
  octomap::OcTree tree(header.edge_m);
  if (header.num_nodes > 0) {
    const std::string data((std::istreambuf_iterator<char>(in)), {});
    if (count_nodes(data, format, file) != header.num_nodes) reject(file, "expected as many nodes as its header says");
    std::istringstream nodes(data);
    format == OctomapFormat::kBt ? tree.readBinaryData(nodes) : tree.readData(nodes);
  }
  OctomapCells cells;
  cells.edge_m = header.edge_m;
  double count = 0.0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    count += std::pow(cells_across(leaf.getDepth()), 3);
  }
  if (require_bytes) require_bytes(count * sizeof(Eigen::Vector3f));
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    auto& centers_m = tree.isNodeOccupied(*leaf) ? cells.occupied_m : cells.free_m;
    const int across = static_cast<int>(cells_across(leaf.getDepth()));
    const octomap::OcTreeKey first = leaf.getIndexKey();
    for (int z = 0; z < across; ++z) {
      for (int y = 0; y < across; ++y) {
        for (int x = 0; x < across; ++x) {
          const auto center = [&](unsigned axis, int cell) {
            return static_cast<float>((first[axis] - kMiddle + cell + 0.5) * cells.edge_m);
          };
          centers_m.emplace_back(center(0, x), center(1, y), center(2, z));
        }
      }
    }
  }
  return cells;
}

}  // namespace swiftlet::sim
