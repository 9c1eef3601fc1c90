// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

/// Search for the pose of one submap in another, and its verification: for loop closures, relocalization in a saved
/// map, and closures with other vehicles.
struct ClosureConfig {
  // Candidate: search of the grid.
  /// [m] edge of a cell of the search grid. Larger cells are searched faster, and leave a larger error (up to one cell)
  /// to the alignment.
  double cell_m = 0.5;
  double range_max_m = 25.0;  ///< [m] points farther from the submap's center are ignored; more points cost memory
  int max_points = 400;       ///< [-] points of the newer submap in the search; its time is proportional to them
  int levels = 4;  ///< [-] levels of the search pyramid; the coarsest cells have an edge of 2^(levels - 1) cell_m
  /// [-] largest number of nodes of all searches for one submap; larger values find more closures and take longer
  int budget = 3000000;
  double search_radius_m = 8.0;      ///< [m] largest horizontal displacement that is searched; a guess narrows it
  double guess_yaw_error_deg = 8.0;  ///< [deg] largest heading error of a guess; without one all headings are searched
  double heading_similarity_min =
      0.6;                 ///< [-] similarity of the rotational histograms below which a heading is not searched
  double score_min = 0.5;  ///< [-] share of the points that must lie in occupied cells

  // Verification: fit to the surfaces of the older submap.
  /// [-] share of the newer submap that the older one must contain. Lower values accept less overlap.
  double overlap_min = 0.4;
  /// [-] share of the overlapping points that must lie on surfaces. Lower values accept changed surroundings.
  double near_min = 0.7;
  /// [-] without a guess, the tolerances 1 - overlap_min and 1 - near_min are multiplied by this: the defaults then
  /// require an overlap of 0.6 instead of 0.4, and 0.8 instead of 0.7 of it on surfaces. Smaller values reject more
  /// false closures, and more true ones.
  double unguided_tolerance = 2.0 / 3.0;

  // Verification: a rival is another pose that matches about as well. A closure with a rival is rejected as ambiguous.
  /// [-] another pose with at least this share of the best score is a rival; at 1 only one with an equal score
  double rival_score = 0.9;
  /// [-] the best other pose is aligned and compared by its fit if it has at least this share of the best score
  double rival_examined = 0.7;
  double rival_fit = 0.8;           ///< [-] a compared pose with at least this share of the best pose's fit is a rival
  double rival_distance_m = 1.5;    ///< [m] distance from which two poses are different places
  double rival_heading_deg = 20.0;  ///< [deg] heading difference from which poses at one place are different

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet
