// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "swiftlet/core/base/elementary.hpp"

/// Probability of existence by Bayes' rule for a single target, as in integrated probabilistic data association
/// (Musicki, Evans and Stankovic, IEEE TAC 39(6), 1994). Equal to the Bernoulli filter (Ristic et al., IEEE TSP 61(13),
/// 2013).
namespace swiftlet {

/// [-] Limit of log odds that are summed over sweeps. Larger values need more sweeps to reverse an earlier decision.
inline constexpr double kMaxLogOdds = 6.0;

/// Return rate of a target: the share of beams on the target that are returned. It is learned, because neither size nor
/// surface of the target is known. From sweep to sweep it varies by a gamma distribution about its mean, because a
/// target turns. So the number of returns is negative binomial.
struct ReturnRate {
  double returns = 2.0;    ///< returns of the target so far; older sweeps fade
  double shots = 8.0;      ///< beams on the target so far
  double variation = 1.0;  ///< shape of the gamma distribution; 1: as wide as its mean, larger values: narrower

  double mean() const { return returns / shots; }
  /// Probability that num_shots beams on the target have no return: exp(-rate num_shots), averaged over the rates.
  double p_no_return(double num_shots) const {
    return elementary::pow(variation / (variation + mean() * num_shots), variation);
  }
  /// @param memory  weight of older sweeps, 0 to 1
  void update(int num_returns, double num_shots, double memory) {
    returns = memory * returns + num_returns;
    shots = memory * shots + num_shots;
  }
};

/// Probability that a target is hidden. Leaves or the edge of the field of view may hide a target for a while; further
/// sweeps without returns then carry no information. Markov chain two of Musicki, Evans and Stankovic (1994): an
/// existing target is visible or hidden, and changes between both.
struct Observability {
  double hidden = 0.0;  ///< probability of being hidden, given existence

  /// @param to_hidden_per_s, to_seen_per_s  transition rates
  void predict(double dt_s, double to_hidden_per_s, double to_seen_per_s) {
    const double rate_per_s = to_hidden_per_s + to_seen_per_s, stationary = to_hidden_per_s / rate_per_s;
    hidden = stationary + (hidden - stationary) * elementary::exp(-rate_per_s * dt_s);
  }
  /// Likelihood ratio of a measurement for a target that may be hidden; for a hidden target it is 1.
  /// @param if_seen  likelihood ratio for a visible target
  double weigh(double if_seen) {
    const double ratio = hidden + (1.0 - hidden) * if_seen;
    hidden /= ratio;
    return ratio;
  }
};

/// Probability that a flying object is too small for a UAV, such as a bird. It returns a smaller share of its beams
/// than the smallest UAV, and more sweeps have no return. Bayes' rule on the numbers of returns, which are negative
/// binomial as above.
struct Smallness {
  double log_odds = 0.0;  ///< log odds of a small object against a UAV

  double probability() const { return 1.0 / (1.0 + elementary::exp(-log_odds)); }
  /// Updates the log odds by one sweep.
  /// @param hidden       probability that the object was hidden, so that nothing was returned
  /// @param small, least  return rates of a small object and of the smallest UAV
  void weigh(int num_returns, double num_shots, double hidden, double small, double least, double variation) {
    if (num_returns == 0) {
      const double none_small = ReturnRate{small, 1.0, variation}.p_no_return(num_shots);
      const double none_least = ReturnRate{least, 1.0, variation}.p_no_return(num_shots);
      log_odds += elementary::log((hidden + (1.0 - hidden) * none_small) / (hidden + (1.0 - hidden) * none_least));
    } else {
      const double apart_small = variation + small * num_shots, apart_least = variation + least * num_shots;
      log_odds += variation * elementary::log(apart_least / apart_small) +
                  num_returns * elementary::log(small * apart_least / (least * apart_small));
    }
    log_odds = std::clamp(log_odds, -kMaxLogOdds, kMaxLogOdds);
  }
};

/// @param likelihood_ratio  likelihood of the measurement given existence over that given absence
inline double existence_after(double existence, double likelihood_ratio) {
  return existence * likelihood_ratio / (1.0 - existence + existence * likelihood_ratio);
}

}  // namespace swiftlet
