// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/slam_map/slam_map_file.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <vector>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/byte_buffer.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

constexpr std::string_view kTitle = "Swiftlet map of SLAM\n";
constexpr std::size_t kHeaderBytes = kTitle.size() + sizeof(std::uint32_t) + 2 * sizeof(std::uint64_t);

/// FNV-1a (Fowler, Noll and Vo): detects damage, not tampering.
std::uint64_t checksum_of(std::string_view bytes) {
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001B3ULL;
  return hash;
}

/// Appends to a file's bytes. `Reader` has the same interface, so that one `visit` below serves both.
class Writer {
 public:
  explicit Writer(ByteBuffer& bytes) : bytes_(bytes) {}

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void operator()(const Number& number) { bytes_.put(number); }
  template <class Scalar, int kRows, int kCols>
  void operator()(const Eigen::Matrix<Scalar, kRows, kCols>& matrix) {
    for (int i = 0; i < matrix.size(); ++i) bytes_.put(matrix.data()[i]);
  }
  void operator()(const Pose& T) {
    (*this)(Matrix3(T.linear()));
    (*this)(Vector3(T.translation()));
  }
  void count(std::size_t size, std::size_t /*bytes_each*/) { bytes_.put(static_cast<std::uint64_t>(size)); }

 private:
  ByteBuffer& bytes_;
};

class Reader {
 public:
  Reader(std::string_view bytes, const std::filesystem::path& file) : bytes_(bytes), file_(file) {}

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void operator()(Number& number) {
    if (bytes_.size() < sizeof number) reject();
    std::memcpy(&number, bytes_.data(), sizeof number);
    bytes_.remove_prefix(sizeof number);
  }
  template <class Scalar, int kRows, int kCols>
  void operator()(Eigen::Matrix<Scalar, kRows, kCols>& matrix) {
    for (int i = 0; i < matrix.size(); ++i) (*this)(matrix.data()[i]);
  }
  void operator()(Pose& T) {
    Matrix3 R;
    Vector3 p;
    (*this)(R);
    (*this)(p);
    T.linear() = R;
    T.translation() = p;
  }
  /// Number of following elements. Checked against the remaining bytes before memory is allocated.
  std::size_t count(std::size_t bytes_each) {
    std::uint64_t size = 0;
    (*this)(size);
    if (size > bytes_.size() / bytes_each) reject();
    return static_cast<std::size_t>(size);
  }
  bool at_end() const { return bytes_.empty(); }
  [[noreturn]] void reject() const {
    throw InputError(file_.string() + ": is damaged: its counts do not fit its size");
  }

 private:
  std::string_view bytes_;
  const std::filesystem::path& file_;
};

// Fields of every record, for reading and writing.
void visit(auto& f, auto& v, const RelativeFactor*) {
  v(f.from), v(f.to), v(f.T_from_to), v(f.information), v(f.huber);
}
void visit(auto& f, auto& v, const PriorFactor*) { v(f.pose), v(f.T_world_pose), v(f.information); }
void visit(auto& f, auto& v, const GravityFactor*) { v(f.pose), v(f.up_body), v(f.sigma_rad); }
void visit(auto& f, auto& v, const PositionFactor*) {
  v(f.before), v(f.after), v(f.beta), v(f.p_world_m), v(f.weight_world_1_m), v(f.huber);
}
void visit(auto& n, auto& v, const SavedMap::Node*) { v(n.t), v(n.pose); }

template <class Record>
void write_all(std::span<const Record> records, Writer& write) {
  write.count(records.size(), 1);
  for (const Record& record : records) visit(record, write, static_cast<const Record*>(nullptr));
}

template <class Record>
Record read_one(Reader& read) {
  Record record;
  visit(record, read, static_cast<const Record*>(nullptr));
  return record;
}

constexpr std::size_t kMinRecord = 12;  // bytes of the smallest record
constexpr std::size_t kMinBlock = 77;   // bytes of a block of cells: its position, a flag and its free cells

template <class Factor>
void read_factors(Reader& read, PoseGraph& graph, std::vector<Factor>& factors) {
  factors.resize(read.count(kMinRecord));
  for (Factor& factor : factors) factor = read_one<Factor>(read);
  const auto known = [&](int pose) { return pose >= 0 && pose < graph.num_poses(); };
  for (const Factor& f : factors) {
    if constexpr (requires { f.from; }) {
      if (!known(f.from) || !known(f.to) || f.from == f.to) read.reject();
    } else if constexpr (requires { f.before; }) {
      if (!known(f.before) || !known(f.after)) read.reject();
    } else {
      if (!known(f.pose)) read.reject();
      if constexpr (requires { f.sigma_rad; }) {
        if (!(f.sigma_rad > 0.0)) read.reject();
      }
    }
    graph.add(f);
  }
}

void write_pieces(std::span<const MapPiece> pieces, Writer& write) {
  write.count(pieces.size(), 1);
  for (const MapPiece& piece : pieces) {
    const SubmapCells& cells = *piece.cells;
    write(piece.submap), write(piece.T_submap_cells), write(cells.edge_m());
    write.count(cells.num_blocks(), 1);
    for (int i = 0; i < static_cast<int>(cells.num_blocks()); ++i) {
      const SubmapCells::Bits* occupied = cells.occupied_of(i);
      write(cells.at(i));
      write(static_cast<std::uint8_t>(occupied != nullptr));
      for (const std::uint64_t word : cells.free_of(i)) write(word);
      if (occupied == nullptr) continue;
      for (const std::uint64_t word : *occupied) write(word);
    }
  }
}

void read_pieces(Reader& read, std::vector<MapPiece>& pieces) {
  constexpr int kFarthest = 1 << 19;  // blocks from the origin
  pieces.resize(read.count(kMinRecord));
  for (MapPiece& piece : pieces) {
    double edge_m = 0.0;
    read(piece.submap), read(piece.T_submap_cells), read(edge_m);
    if (!(edge_m > 0.0 && std::isfinite(edge_m))) read.reject();
    std::vector<CellBlock> blocks(read.count(kMinBlock));
    std::set<std::array<int, 3>> places;
    for (CellBlock& block : blocks) {
      std::uint8_t any_occupied = 0;
      read(block.at);
      read(any_occupied);
      for (std::uint64_t& word : block.free) read(word);
      if (any_occupied != 0) {
        for (std::uint64_t& word : block.occupied) read(word);
      }
      for (std::size_t z = 0; z < block.free.size(); ++z) {
        if ((block.free[z] & block.occupied[z]) != 0) read.reject();
      }
      if ((block.at.array().abs() > kFarthest).any()) read.reject();
      if (!places.insert({block.at.x(), block.at.y(), block.at.z()}).second) read.reject();
    }
    piece.cells = std::make_shared<const SubmapCells>(edge_m, blocks);
  }
}

SavedMap read_payload(Reader& read) {
  SavedMap map;
  read(map.voxel_m);
  const std::size_t num_poses = read.count(sizeof(double) * 12);
  for (std::size_t i = 0; i < num_poses; ++i) {
    Pose T = Pose::Identity();
    read(T);
    map.graph.add_pose(T);
  }
  std::vector<RelativeFactor> relatives;
  std::vector<PriorFactor> priors;
  std::vector<GravityFactor> gravities;
  std::vector<PositionFactor> positions;
  read_factors(read, map.graph, relatives);
  read_factors(read, map.graph, priors);
  read_factors(read, map.graph, gravities);
  read_factors(read, map.graph, positions);
  map.nodes.resize(read.count(kMinRecord));
  for (SavedMap::Node& node : map.nodes) node = read_one<SavedMap::Node>(read);
  map.submaps.resize(read.count(kMinRecord));
  for (SavedMap::Submap& submap : map.submaps) {
    read(submap.pose);
    submap.points_submap_m.resize(read.count(sizeof(float) * 3));
    for (Eigen::Vector3f& p : submap.points_submap_m) read(p);
  }
  read_pieces(read, map.pieces);
  if (!read.at_end()) read.reject();
  return map;
}

}  // namespace

std::string slam_map_content(const SavedMap& map) {
  ByteBuffer payload;
  Writer write(payload);
  write(map.voxel_m);
  write.count(static_cast<std::size_t>(map.graph.num_poses()), 1);
  for (int i = 0; i < map.graph.num_poses(); ++i) write(map.graph.pose(i));
  write_all(map.graph.relative_factors(), write);
  write_all(map.graph.prior_factors(), write);
  write_all(map.graph.gravity_factors(), write);
  write_all(map.graph.position_factors(), write);
  write_all(std::span<const SavedMap::Node>(map.nodes), write);
  write.count(map.submaps.size(), 1);
  for (const SavedMap::Submap& submap : map.submaps) {
    write(submap.pose);
    write.count(submap.points_submap_m.size(), 1);
    for (const Eigen::Vector3f& p : submap.points_submap_m) write(p);
  }
  write_pieces(map.pieces, write);
  const auto text_of = [](const ByteBuffer& buffer) {
    return std::string_view(reinterpret_cast<const char*>(buffer.bytes().data()), buffer.size());
  };
  ByteBuffer header;
  header.put_text(kTitle);
  header.put(kSlamMapVersion);
  header.put(static_cast<std::uint64_t>(payload.size()));
  header.put(checksum_of(text_of(payload)));
  return std::string(text_of(header)).append(text_of(payload));
}

SavedMap read_slam_map(const std::filesystem::path& file) {
  const std::string content = read_whole_file(file);
  const auto reject = [&](const std::string& reason) { throw InputError(file.string() + ": " + reason); };
  if (!content.starts_with(kTitle) || content.size() < kHeaderBytes) {
    reject("expected a map of Swiftlet's SLAM, which begins with its title");
  }
  Reader header(std::string_view(content).substr(kTitle.size()), file);
  std::uint32_t version = 0;
  std::uint64_t size = 0, checksum = 0;
  header(version);
  header(size);
  header(checksum);
  if (version != kSlamMapVersion) {
    reject("expected version " + std::to_string(kSlamMapVersion) + " of such maps, found version " +
           std::to_string(version));
  }
  const std::string_view payload = std::string_view(content).substr(kHeaderBytes);
  if (payload.size() != size) {
    reject("is damaged: expected " + std::to_string(size) + " bytes of data, found " + std::to_string(payload.size()));
  }
  if (checksum_of(payload) != checksum) reject("is damaged: its checksum does not fit its data");
  Reader read(payload, file);
  SavedMap map = read_payload(read);
  if (const std::string fault = fault_of(map); !fault.empty()) reject("is damaged: " + fault);
  return map;
}

bool is_slam_map_file(const std::filesystem::path& file) { return file.extension() == kSlamMapExtension; }

}  // namespace swiftlet::sim
