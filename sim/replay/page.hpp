// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

/// The page around the blocks. Nothing that comes from a scenario ever stands in it as markup: names travel in the
/// blocks, and the page shows them as text.
namespace swiftlet::sim {

/// Everything before the first block. Its policy lets the browser run the page's own scripts, by their digests, and
/// nothing else.
std::string page_head();
/// One block as a text that no script can be.
std::string page_block(std::string_view packed);
/// Everything behind the last block.
std::string page_tail();

}  // namespace swiftlet::sim
