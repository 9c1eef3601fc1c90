// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

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

/// Can a target be seen at all? Leaves or the edge of the field of view may hide one for a while, and then silence
/// after silence says nothing more. Markov chain two of Musicki, Evans and Stankovic (1994): a target that exists is
/// seen or hidden, and changes between both.
struct Observability {
  double hidden = 0.0;  ///< probability, if the target exists

  /// @param to_hidden_per_s, to_seen_per_s  rates of the changes
  void predict(double dt_s, double to_hidden_per_s, double to_seen_per_s) {
    const double rate_per_s = to_hidden_per_s + to_seen_per_s, in_the_long_run = to_hidden_per_s / rate_per_s;
    hidden = in_the_long_run + (hidden - in_the_long_run) * elementary::exp(-rate_per_s * dt_s);
  }
  /// Likelihood ratio of what was measured for a target that may be hidden, of which it then tells nothing.
  /// @param if_seen  that for one which can be seen
  double weigh(double if_seen) {
    const double ratio = hidden + (1.0 - hidden) * if_seen;
    hidden /= ratio;
    return ratio;
  }
};

/// Is what flies there too small for a UAV, as a bird is? It returns fewer of the beams that meet it, and more often
/// none, than the smallest UAV would. Bayes' rule on the numbers of returns, which are negative binomial as above.
struct Smallness {
  static constexpr double kSurest = 6.0;  ///< log odds; so it is never too sure to learn better

  double log_odds = 0.0;  ///< of small against a UAV

  double probability() const { return 1.0 / (1.0 + elementary::exp(-log_odds)); }
  /// One sweep.
  /// @param hidden       probability that it could not be seen, so that nothing was returned
  /// @param small, least  shares of the beams that something small and the smallest UAV return
  void weigh(int num_returns, double num_shots, double hidden, double small, double least, double variation) {
    if (num_returns == 0) {
      const double none_small = ReturnRate{small, 1.0, variation}.none(num_shots);
      const double none_least = ReturnRate{least, 1.0, variation}.none(num_shots);
      log_odds += elementary::log((hidden + (1.0 - hidden) * none_small) / (hidden + (1.0 - hidden) * none_least));
    } else {
      const double apart_small = variation + small * num_shots, apart_least = variation + least * num_shots;
      log_odds += variation * elementary::log(apart_least / apart_small) +
                  num_returns * elementary::log(small * apart_least / (least * apart_small));
    }
    log_odds = std::clamp(log_odds, -kSurest, kSurest);
  }
};

/// @param likelihood_ratio  of what was measured, if the target exists over if it does not
inline double existence_after(double existence, double likelihood_ratio) {
  return existence * likelihood_ratio / (1.0 - existence + existence * likelihood_ratio);
}

}  // namespace swiftlet
