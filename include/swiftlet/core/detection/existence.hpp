// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/elementary.hpp"

/// Does a target exist? Bayes' rule for a single one, as in integrated probabilistic data association (Musicki, Evans
/// and Stankovic, IEEE TAC 39(6), 1994). The Bernoulli filter has the same (Ristic et al., IEEE TSP 61(13), 2013).
namespace swiftlet {

/// How often a beam that meets a target is returned, and how many of a sweep's are. The rate of a target is learned,
/// because neither its size nor its surface is known. From sweep to sweep it varies by a gamma distribution about that,
/// because a target turns. So the number of returns is negative binomial.
struct ReturnRate {
  double returns = 2.0;    ///< of a target so far; older sweeps fade
  double shots = 8.0;      ///< beams that met it
  double variation = 1.0;  ///< shape of the gamma distribution: 1: as wide as its mean; more: narrower

  double mean() const { return returns / shots; }
  /// Probability that none of the beams of a sweep is returned: exp(-rate num_shots) in the mean over the rates.
  double none(double num_shots) const {
    return elementary::pow(variation / (variation + mean() * num_shots), variation);
  }
  /// @param memory  share that is kept of older sweeps, 0 to 1
  void update(int num_returns, double num_shots, double memory) {
    returns = memory * returns + num_returns;
    shots = memory * shots + num_shots;
  }
};

/// @param likelihood_ratio  of what was measured, if the target exists over if it does not
inline double existence_after(double existence, double likelihood_ratio) {
  return existence * likelihood_ratio / (1.0 - existence + existence * likelihood_ratio);
}

}  // namespace swiftlet
