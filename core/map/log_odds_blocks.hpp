// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "swiftlet/core/map/cell_block.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Log-odds of the cells in blocks around a vehicle. For cells that were never hit, the number of misses determines the
/// log-odds; it is counted in bit planes, 64 cells at a time. Only cells that were hit store a value. So a block of 512
/// cells of free space takes 320 bytes. A block is found in a table by its position modulo the size of the table.
class LogOddsBlocks {
 public:
  static constexpr int kSide = CellBlock::kSide;
  static constexpr int kCells = kSide * kSide * kSide;
  static constexpr int kMaxMisses = 7;  ///< largest number of misses that is counted in bits
  using Bits = CellBlock::Bits;
  /// Bit sets of cells: a word for each z, a byte for each y.
  struct alignas(64) Block {
    Bits misses_1{}, misses_2{}, misses_4{};  ///< miss count of cells that were never hit, in binary; 0: unknown
    Bits valued{};                            ///< cells with log-odds in the page
    Bits occupied{};

    std::uint64_t known(int z) const { return occupied[z] | valued[z] | misses_1[z] | misses_2[z] | misses_4[z]; }
    Bits known() const {
      Bits bits;
      for (int z = 0; z < kSide; ++z) bits[z] = known(z);
      return bits;
    }
    int misses(int z, int bit) const {
      const auto digit = [&](const Bits& bits) { return static_cast<int>(bits[z] >> bit & 1U); };
      return digit(misses_1) + 2 * digit(misses_2) + 4 * digit(misses_4);
    }
    /// Cells of a layer with this number of misses.
    std::uint64_t with_misses(int z, int count) const {
      return ((count & 1) != 0 ? misses_1[z] : ~misses_1[z]) & ((count & 2) != 0 ? misses_2[z] : ~misses_2[z]) &
             ((count & 4) != 0 ? misses_4[z] : ~misses_4[z]);
    }
    void count_misses(int z, std::uint64_t cells) {
      const std::uint64_t carry_2 = cells & misses_1[z], carry_4 = carry_2 & misses_2[z];
      misses_1[z] ^= cells;
      misses_2[z] ^= carry_2;
      misses_4[z] ^= carry_4;
    }
    CellState state(int z, int bit) const {
      if ((occupied[z] >> bit & 1U) != 0) return CellState::kOccupied;
      return (known(z) >> bit & 1U) != 0 ? CellState::kFree : CellState::kUnknown;
    }
  };
  struct Page {
    std::array<float, kCells> log_odds;
    std::array<std::uint32_t, kCells> scan;  ///< scan of the last hit
  };
  /// Properties of a block that are used without access to it.
  struct About {
    Cell at = Cell::Zero();
    std::uint32_t page = 0;  ///< index + 1; 0: none
    bool used = false;
    std::uint64_t changed = 0;  ///< revision of the last change of a state
  };

  /// Log-odds of a cell that was never hit, by number of misses.
  using AfterMisses = std::array<float, kMaxMisses + 1>;

  /// @param places_across  least size of the table along an axis
  LogOddsBlocks(double places_across, const AfterMisses& after_misses);

  std::size_t num_places() const { return places_.size(); }
  /// Table coordinate of a block coordinate.
  int wrapped(int block) const { return block & mask_; }
  std::size_t place_of(const Cell& block) const {
    return static_cast<std::size_t>((block.x() & mask_) | ((block.y() & mask_) | (block.z() & mask_) << bits_)
                                                              << bits_);
  }
  /// Index of the block in a place of the table; -1: none.
  int in_place_of(const Cell& block) const { return places_[place_of(block)]; }
  /// Index of a block; -1: none.
  int find(const Cell& block) const {
    const int i = in_place_of(block);
    return i >= 0 && abouts_[i].at == block ? i : -1;
  }
  /// Adds a block in a free place.
  int make(const Cell& block);
  void remove(int i);
  /// Converts cells of a layer from a count of misses to a log-odds value.
  void give_values(int i, int z, std::uint64_t cells);
  float log_odds(int i, int in_block) const;

  int size() const { return static_cast<int>(abouts_.size()); }  ///< greatest index + 1
  std::size_t num_used() const { return abouts_.size() - free_blocks_.size(); }
  About& about(int i) { return abouts_[i]; }
  const About& about(int i) const { return abouts_[i]; }
  Block& block(int i) { return chunks_[static_cast<std::size_t>(i) / kChunk][static_cast<std::size_t>(i) % kChunk]; }
  const Block& block(int i) const {
    return chunks_[static_cast<std::size_t>(i) / kChunk][static_cast<std::size_t>(i) % kChunk];
  }
  /// Page of a block that has one.
  Page& page(int i) { return *pages_[abouts_[i].page - 1]; }
  const Page& page(int i) const { return *pages_[abouts_[i].page - 1]; }

 private:
  static constexpr std::size_t kChunk = 1024;  // number of blocks per allocation

  Page& give_page(int i);

  AfterMisses after_misses_;
  int bits_ = 0, mask_ = 0;           // bits and mask of a block coordinate in the table
  std::vector<std::int32_t> places_;  // block index; -1: none
  std::vector<std::unique_ptr<Block[]>> chunks_;
  std::vector<About> abouts_;
  std::vector<int> free_blocks_;
  std::vector<std::unique_ptr<Page>> pages_;
  std::vector<std::uint32_t> free_pages_;
};

}  // namespace swiftlet
